# SPDX-License-Identifier: GPL-3.0-or-later
"""Trees over the faces of a surface."""

import numpy as np
from mathutils.bvhtree import BVHTree


def surface_tree(vertices, faces):
    """A tree over (n, 3) vertices and faces for nearest points."""
    return BVHTree.FromPolygons(vertices.tolist(), [list(face) for face in faces], epsilon=0.0)


def nearest(tree, points):
    """(k, 3) nearest points of a tree's faces, and (k,) the faces."""
    found = [tree.find_nearest(point) for point in points.tolist()]
    places = np.array([place for place, _, _, _ in found], float).reshape(-1, 3)
    return places, np.array([face for _, _, face, _ in found], int)
