# SPDX-License-Identifier: GPL-3.0-or-later
"""Connected components and trees of a graph, look-ups, sums by label, ranges of different lengths, nearby points."""

from collections.abc import Iterator
from itertools import chain

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import breadth_first_order, connected_components
from scipy.spatial import cKDTree


def components(count: int, pairs: ArrayLike) -> np.ndarray:
    """Label the connected components of ``count`` nodes with (e, 2) edges, which may be repeated and run either way.

    Returns (count,) int labels, numbered from 0 in the order of the components' first nodes.
    """
    pairs = np.asarray(pairs, int).reshape(-1, 2)
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(count, count))
    return connected_components(graph, directed=False)[1]


def walk_trees(
    count: int, pairs: np.ndarray, roots: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Walk along shortest paths, breadth first, from a root of each component of ``count`` nodes with (e, 2) edges.

    The roots are the components' first nodes unless given. Returns the (k,) other nodes that are reached in their
    order, the node before each, and the edge between the two, the first one of several.
    """
    if roots is None:
        roots = np.unique(components(count, pairs), return_index=True)[1]
    starts = np.column_stack([np.full(len(roots), count), roots])  # from an added node to all roots
    tails, heads = np.concatenate([pairs, starts]).T
    graph = coo_matrix((np.ones(len(tails)), (tails, heads)), shape=(count + 1, count + 1)).tocsr()
    nodes, before = breadth_first_order(graph, count, directed=False)
    nodes = nodes[before[nodes] < count][1:].astype(int)
    before = before[nodes].astype(int)
    return nodes, before, find(pair_keys(pairs, count), pair_keys(np.column_stack([before, nodes]), count))


def pair_keys(pairs: np.ndarray, count: int) -> np.ndarray:
    """Number (..., 2) pairs of ``count`` nodes, the same whichever way they run."""
    first, second = np.moveaxis(np.asarray(pairs, np.int64), -1, 0)  # keys do not fit into the 32 bits of some indices
    return np.minimum(first, second) * count + np.maximum(first, second)


def find(keys: np.ndarray, asked: np.ndarray) -> np.ndarray:
    """Find the first place of each asked integer, of any shape, among (k,) keys, -1 where it is not there."""
    if len(keys) == 0:
        return np.full(asked.shape, -1)
    order = np.argsort(keys, kind="stable")
    found = order[np.minimum(np.searchsorted(keys, asked, sorter=order), len(order) - 1)]
    return np.where(keys[found] == asked, found, -1)


def label_rows(rows: np.ndarray) -> np.ndarray:
    """Number (n, k) rows of integers from 0 up, equal ones alike, in their lexicographic order.

    Several times as fast as :func:`numpy.unique` of rows, which compares bytes.
    """
    labels = np.zeros(len(rows), np.int64)
    for column in rows.T if len(rows) else ():
        span = int(np.ptp(column)) + 1
        labels = np.unique(labels * span + (column - column.min()), return_inverse=True)[1].reshape(-1)
    return labels


def inverse(order: np.ndarray) -> np.ndarray:
    """Invert a permutation, (n,)."""
    result = np.empty_like(order)
    result[order] = np.arange(len(order))
    return result


def fronts(pattern: csr_matrix, node: int) -> tuple[np.ndarray, np.ndarray]:
    """List the (k,) nodes that can be reached from a node, the nearest first; those d edges away are in places
    ``ends[d]`` to ``ends[d + 1]`` of the list. Returns list and ends."""
    order, before = breadth_first_order(pattern, node)
    place = np.empty(pattern.shape[0], int)
    place[order] = np.arange(len(order))
    # The position of each node's predecessor in the order; the end of a front gives the end of the next.
    behind = place[before[order[1:]]]
    ends = [0, 1]
    while ends[-1] < len(order):
        ends.append(1 + int(np.searchsorted(behind, ends[-1])))
    return order, np.array(ends)


def take_loops(following: dict[int, int]) -> Iterator[list[int]]:
    """Take the loops out of a table of the node that follows each node, which is empty in the end."""
    while following:
        first, node = following.popitem()
        loop = [first]
        while node != first:
            loop.append(node)
            node = following.pop(node)
        yield loop


def sum_by(labels: np.ndarray, values: np.ndarray, count: int = 0) -> np.ndarray:
    """Sum (k,) real or complex values, or (k, d) real ones, of each label; at least ``count`` sums."""
    if np.iscomplexobj(values):
        return np.bincount(labels, values.real, count) + 1j * np.bincount(labels, values.imag, count)
    if values.ndim == 1:
        return np.bincount(labels, values, count)
    return np.column_stack([np.bincount(labels, column, count) for column in values.T])


def ragged_arange(counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Concatenate 0, 1 ... n - 1 for each n of (k,) counts; returns the row of each entry, and the entries."""
    rows = np.repeat(np.arange(len(counts)), counts)
    return rows, np.arange(len(rows)) - (np.cumsum(counts) - counts)[rows]


def pairs_within(tree: cKDTree, points: np.ndarray, reach: float | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Find the points of a tree within reach, one length or (n,), of (n, d) points: (k,) the given point and (k,) the
    point of the tree of each pair, ascending."""
    found = tree.query_ball_point(points, reach, return_sorted=True)
    rows, _ = ragged_arange(np.array([len(near) for near in found], int))
    return rows, np.fromiter(chain.from_iterable(found), int, len(rows))
