# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces wound the same way, as far as a surface has two sides."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order

from ..gauge import balance
from ..graphs import components


def orient_faces(mesh, faces, joins):
    """Which faces to turn over so that windings agree, and where that cannot be.

    In each piece the larger share of the area keeps its winding. A one-sided piece disagrees with itself along a seam:
    where it was given one, or opposite to its first face, whichever is shorter.

    Parameters
    ----------
    mesh : TriangleMesh
    faces : (m,) face of each triangle
    joins : (j, 2) half-edges across which triangles are joined

    Returns
    -------
    turned : (faces.max() + 1,) bool
    seam : (j,) bool, joins across which the windings disagree
    """
    count = faces.max() + 1
    pairs = faces[joins // 3]
    signs = mesh.triangle_edge_signs.ravel()
    clash = signs[joins[:, 0]] == signs[joins[:, 1]]
    turned, balanced = balance(count, pairs, clash)
    pieces = components(count, pairs)
    if not balanced.all():
        tree = _tree(count, pairs, ~balanced)
        along_tree = balance(count, pairs[tree], clash[tree])[0]
        lengths = mesh.edge_lengths[mesh.triangle_edges.ravel()[joins[:, 0]]]
        longer = lengths * clash - lengths * _clashes(clash, along_tree, pairs)
        shortened = np.bincount(pieces[pairs[:, 0]], longer, pieces.max() + 1) > 0
        turned |= along_tree & ~balanced & shortened[pieces]
    areas = np.bincount(faces, mesh.areas, count)
    turned ^= (np.bincount(pieces, np.where(turned, areas, -areas)) > 0)[pieces]
    turned[np.bincount(faces, minlength=count) == 0] = False
    return turned, _clashes(clash, turned, pairs)


def _clashes(clash, turned, pairs):
    """(j,) bool: where windings disagree after some faces were turned over."""
    return clash ^ turned[pairs[:, 0]] ^ turned[pairs[:, 1]]


def _tree(count, pairs, chosen):
    """Indices of the pairs by which the chosen nodes, whole components, are reached from the first of each."""
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
