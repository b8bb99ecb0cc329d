# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers of a solid as surfaces, their dislocation curves, tool paths and voxels."""
