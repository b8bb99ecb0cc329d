# SPDX-License-Identifier: GPL-3.0-or-later
"""Connected components of a graph, sums by label, ranges of different lengths, and pairs of nearby points."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree


def components(count: int, pairs: ArrayLike) -> np.ndarray:
    """Label the connected components of ``count`` nodes with (e, 2) edges, which may be repeated and run either way.

    Returns (count,) int labels, numbered from 0 in the order of the components' first nodes.
    """
    pairs = np.asarray(pairs, int).reshape(-1, 2)
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(count, count))
    return connected_components(graph, directed=False)[1]


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
    return rows, np.concatenate([np.empty(0, int), *found]).astype(int)
