# SPDX-License-Identifier: GPL-3.0-or-later
"""Consistent orientation of faces, as far as the surface is two-sided."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order

from ..gauge import balance
from ..graphs import components
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
        tree = _spanning_pairs(count, pairs, ~balanced)
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


def _spanning_pairs(count: int, pairs: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Select the pairs of spanning trees of the chosen nodes, which are whole components."""
    first = np.unique(components(count, pairs)[chosen], return_index=True)[1]
    roots = np.flatnonzero(chosen)[first]
    kept = np.flatnonzero(chosen[pairs[:, 0]])
    rows = np.concatenate([pairs[kept, 0], np.full(len(roots), count)])
    columns = np.concatenate([pairs[kept, 1], roots])
    graph = coo_array((np.ones(len(rows)), (rows, columns)), shape=(count + 1,) * 2).tocsr()
    before = breadth_first_order(graph, count, directed=False)[1]
    low, high = np.sort(pairs[kept], axis=1).T
    reached = np.flatnonzero((before >= 0) & (before < count))
    asked = np.minimum(reached, before[reached]) * count + np.maximum(reached, before[reached])
    known, where = np.unique(low * count + high, return_index=True)
    return kept[where[np.searchsorted(known, asked)]]
