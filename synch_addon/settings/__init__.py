# SPDX-License-Identifier: GPL-3.0-or-later
"""What a user can set for fields and patterns: as plain data, and as Blender's properties."""
