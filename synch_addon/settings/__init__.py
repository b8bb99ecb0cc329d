# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of fields and patterns, as plain data and as Blender's properties."""
