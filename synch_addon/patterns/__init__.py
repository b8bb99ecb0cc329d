# SPDX-License-Identifier: GPL-3.0-or-later
"""One field or pattern on one surface: read, written, kept, varied and turned into lines, reliefs and meshes."""
