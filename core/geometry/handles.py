# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles of a solid: changes along its edges that sum to 0 around triangles but are not differences of a function."""

import numpy as np
from scipy.sparse import csr_matrix

from ..graphs import components, ragged_arange, walk_trees
from .tet_mesh import TetMesh

# Combinations of changes vanish if their squares are below this share of the largest.
_NOTHING = 1e-9


def triangle_sums(mesh: TetMesh) -> csr_matrix:
    """Build the (f, e) matrix that sums changes of edges around triangles, in the order of increasing vertices."""
    a, b, c = mesh.faces.T
    columns = np.column_stack([mesh.edges_between(a, b), mesh.edges_between(b, c), mesh.edges_between(a, c)])
    starts = np.arange(0, columns.size + 1, 3)
    shape = (len(columns), len(mesh.edges))
    return csr_matrix((np.tile([1.0, 1.0, -1.0], len(columns)), columns.ravel(), starts), shape=shape)


def handle_changes(mesh: TetMesh, resting: np.ndarray) -> np.ndarray:
    """Compute changes that sum to 0 around all triangles and vanish at (e,) resting edges, one for each handle: (e, g).

    Every such change is a combination of these and the differences of a function that is constant along resting edges.

    Notes
    -----
    Without loss of generality the changes along a tree are zero. Triangles with two known sides give the third; without
    any, an edge becomes an unknown. Triangles whose sides are all known give the relations between unknowns.
    """
    sums = triangle_sums(mesh)
    known = resting | _tree_edges(mesh, resting)
    values, fresh = np.zeros((len(known), 0)), np.flatnonzero(known)
    beside = sums.T.tocsr()
    sides, signs = sums.indices.reshape(-1, 3), sums.data.reshape(-1, 3)
    while not known.all():
        if len(fresh) == 0:
            fresh = np.flatnonzero(~known)[:1]
            values = np.column_stack([values, np.zeros(len(known))])
            values[fresh, -1] = 1
            known[fresh] = True
        rows, places = ragged_arange(np.diff(beside.indptr)[fresh])
        triangles = np.unique(beside.indices[beside.indptr[fresh][rows] + places])
        triangles = triangles[known[sides[triangles]].sum(axis=1) == 2]
        last = np.argmin(known[sides[triangles]], axis=1)[:, None]
        fresh, first = np.unique(np.take_along_axis(sides[triangles], last, axis=1), return_index=True)
        triangles, last = triangles[first], last[first]
        own = np.take_along_axis(signs[triangles], last, axis=1)
        values[fresh] = -own * (sums[triangles] @ values)
        known[fresh] = True
    relations = sums @ values
    squares, combinations = np.linalg.eigh(relations.T @ relations)
    return values @ combinations[:, squares <= _NOTHING * max(1.0, squares.max(initial=0))]


def _tree_edges(mesh: TetMesh, resting: np.ndarray) -> np.ndarray:
    """Find the edges of a spanning tree of each component after the resting edges are contracted, (e,) bool."""
    count = mesh.vertex_count
    contracted = components(count, mesh.edges[resting])  # the vertex of the contracted graph for each vertex
    ends = np.sort(contracted[mesh.edges], axis=1)
    no_loops = np.flatnonzero(ends[:, 0] != ends[:, 1])
    result = np.zeros(len(ends), bool)
    result[no_loops[walk_trees(count, ends[no_loops])[2]]] = True
    return result
