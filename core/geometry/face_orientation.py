# SPDX-License-Identifier: GPL-3.0-or-later
"""Consistent orientation of faces, as far as the surface is two-sided."""

import numpy as np

from ..gauge import balance
from ..graphs import components, walk_trees
from .triangle_mesh import TriangleMesh


def orient_faces(mesh: TriangleMesh, faces: np.ndarray, joins: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Choose the faces to turn over so that orientations agree, and the seams where they cannot.

    In each piece the larger share of the area keeps its orientation. A one-sided piece gets a seam: the given one, or
    one opposite to its first face, whichever is shorter.

    Parameters
    ----------
    faces : (m,) face of each triangle
    joins : (j, 2) half-edges across which triangles are joined

    Returns
    -------
    turned : (faces.max() + 1,) bool
    seam : (j,) bool, joins across which the orientations disagree
    """
    count = faces.max() + 1
    pairs = faces[joins // 3]
    signs = mesh.triangle_edge_signs.ravel()
    clash = signs[joins[:, 0]] == signs[joins[:, 1]]
    turned, balanced = balance(count, pairs, clash)
    pieces = components(count, pairs)
    if not balanced.all():
        kept = np.flatnonzero(~balanced[pairs[:, 0]])
        tree = kept[walk_trees(count, pairs[kept])[2]]
        along_tree = balance(count, pairs[tree], clash[tree])[0]
        lengths = mesh.edge_lengths[mesh.triangle_edges.ravel()[joins[:, 0]]]
        longer = lengths * clash - lengths * _find_clashes(clash, along_tree, pairs)
        shortened = np.bincount(pieces[pairs[:, 0]], longer, pieces.max() + 1) > 0
        turned |= along_tree & ~balanced & shortened[pieces]
    areas = np.bincount(faces, mesh.areas, count)
    turned ^= (np.bincount(pieces, np.where(turned, areas, -areas)) > 0)[pieces]
    turned[np.bincount(faces, minlength=count) == 0] = False
    return turned, _find_clashes(clash, turned, pairs)


def _find_clashes(clash: np.ndarray, turned: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    """Find the joins across which orientations disagree after faces are turned over, (j,) bool."""
    return clash ^ turned[pairs[:, 0]] ^ turned[pairs[:, 1]]
