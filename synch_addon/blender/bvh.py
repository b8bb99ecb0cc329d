# SPDX-License-Identifier: GPL-3.0-or-later
"""Trees over the faces of a surface."""

from mathutils.bvhtree import BVHTree


def surface_tree(vertices, faces):
    """A tree over (n, 3) vertices and faces, in single precision."""
    return BVHTree.FromPolygons(vertices.tolist(), [list(face) for face in faces], epsilon=0.0)
