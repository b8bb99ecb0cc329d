# SPDX-License-Identifier: GPL-3.0-or-later
"""Doors to Blender's data, which decide nothing: meshes, attributes, curves, files and volumes as arrays."""
