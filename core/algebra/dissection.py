# SPDX-License-Identifier: GPL-3.0-or-later
"""Orders of elimination by nested dissection (George 1973), for symmetric matrices whose rows lie in space.

Rows get places from their distances in the graph to a few landmarks. Groups of rows are halved across their longest
extent, and the fewest rows that separate both halves (Koenig 1931) are eliminated after these.
"""

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import maximum_bipartite_matching

from ..graphs import fronts, ragged_arange
from .coarsening import hubs

# Groups of no more rows are not halved.
_LEAF = 160
_LANDMARKS, _DIMENSIONS = 9, 3


def dissect(matrix: csr_matrix) -> np.ndarray:
    """Number the block of each row, (n,), in the order in which blocks are eliminated; hubs are in the last one."""
    count = matrix.shape[0]
    if count == 0:
        return np.empty(0, int)
    tails, heads = np.repeat(np.arange(count), np.diff(matrix.indptr)), matrix.indices
    last = hubs(matrix)
    places, tails, heads = _places(matrix, np.flatnonzero(~last)), tails[tails < heads], heads[tails < heads]
    # The halves of group g are 2 g and 2 g + 1. A row that separates them stays in the block of the group.
    group, waiting, depth = np.ones(count, np.int64), ~last, 0
    while True:
        waiting &= np.bincount(group[waiting], minlength=int(group.max(initial=0)) + 1)[group] > _LEAF
        rows = np.flatnonzero(waiting)
        if not len(rows):
            break
        side = np.zeros(count, bool)
        side[rows] = _upper_halves(places[rows], group[rows])
        inside = waiting[tails] & waiting[heads] & (group[tails] == group[heads])
        tails, heads = tails[inside], heads[inside]
        cut = side[tails] != side[heads]
        ends = np.column_stack([tails[cut], heads[cut]])
        ends = np.where(side[ends[:, :1]], ends[:, ::-1], ends)
        waiting[_cover(ends)] = False
        group[waiting] = 2 * group[waiting] + side[waiting]
        depth += 1
    # Postorder of the tree of groups: both halves before the rows that separate them.
    levels = np.frexp(group.astype(float))[1] - 1
    keys = ((group + 1) << (depth - levels)) * (depth + 2) - levels
    keys[last] = keys.max(initial=0) + 1
    return np.unique(keys, return_inverse=True)[1]


def _places(matrix: csr_matrix, rows: np.ndarray) -> np.ndarray:
    """(n, 3) places whose distances are about those in the graph of some rows; landmark scaling (de Silva and
    Tenenbaum 2004)."""
    places = np.zeros((matrix.shape[0], _DIMENSIONS))
    if not len(rows):
        return places
    pattern = csr_matrix((np.ones(matrix.nnz, np.int8), matrix.indices, matrix.indptr), shape=matrix.shape)
    if len(rows) < matrix.shape[0]:
        pattern = pattern[rows][:, rows]
    distances: list[np.ndarray] = []
    landmarks = [int(_distances(pattern, 0).argmax())]
    while len(distances) < _LANDMARKS:
        distances.append(_distances(pattern, landmarks[-1]))
        landmarks.append(int(np.min(distances, axis=0).argmax()))
    squares = np.square(distances)
    between = squares[:, landmarks[:-1]]
    centred = between - between.mean(axis=0)
    values, vectors = np.linalg.eigh((centred.mean(axis=1, keepdims=True) - centred) / 2)
    largest, directions = values[-_DIMENSIONS:], vectors[:, -_DIMENSIONS:]
    scaled = directions / np.sqrt(np.maximum(largest, 1e-9 * max(largest[-1], 1)))
    places[rows] = (between.mean(axis=1) - squares.T) @ scaled / 2
    return places


def _distances(pattern: csr_matrix, node: int) -> np.ndarray:
    """(n,) number of edges from a node to each; for nodes that cannot be reached, one more than the largest."""
    order, ends = fronts(pattern, node)
    result = np.full(pattern.shape[0], float(len(ends) - 1))
    result[order] = np.repeat(np.arange(len(ends) - 1), np.diff(ends))
    return result


def _upper_halves(places: np.ndarray, groups: np.ndarray) -> np.ndarray:
    """(k,) bool: rows in the upper half of their group, along its longest extent."""
    label = np.unique(groups, return_inverse=True)[1]
    sizes = np.bincount(label)
    starts, sorted_places = np.cumsum(sizes) - sizes, places[np.argsort(label, kind="stable")]
    extents = np.maximum.reduceat(sorted_places, starts) - np.minimum.reduceat(sorted_places, starts)
    order = np.lexsort((places[np.arange(len(places)), extents.argmax(axis=1)[label]], label))
    place = np.empty(len(order), int)
    place[order] = ragged_arange(sizes)[1]
    return place >= (sizes // 2)[label]


def _cover(pairs: np.ndarray) -> np.ndarray:
    """(k,) the fewest rows that meet all edges, (e, 2), between two sides."""
    (left, tails), (right, heads) = (np.unique(column, return_inverse=True) for column in pairs.T)
    graph = csr_matrix((np.ones(len(tails), np.int8), (tails, heads)), shape=(len(left), len(right)))
    mates = maximum_bipartite_matching(graph, perm_type="column")
    partners = np.full(len(right), -1)
    partners[mates[mates >= 0]] = np.flatnonzero(mates >= 0)
    # Koenig: the cover is the unreached rows of the left and the reached ones of the right, by alternating paths.
    reached, seen = mates < 0, np.zeros(len(right), bool)
    while True:
        new = np.zeros(len(right), bool)
        new[heads[reached[tails]]] = True
        new &= ~seen
        if not new.any():
            return np.concatenate([left[~reached], right[seen]])
        seen |= new
        reached[partners[new]] = True
