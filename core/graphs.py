# SPDX-License-Identifier: GPL-3.0-or-later
"""What arrays lack: the connected components of a graph, counting within rows of different lengths, and pairs of what
is near."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components


def components(count, pairs):
    """Which nodes hang together.

    Parameters
    ----------
    count : int, nodes
    pairs : (e, 2) nodes that are joined, either way round, any number of times

    Returns
    -------
    (count,) int label of each node's component: from 0 up, in the order of their first nodes
    """
    pairs = np.asarray(pairs, int).reshape(-1, 2)
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(count, count))
    return connected_components(graph, directed=False)[1]


def ragged_arange(counts):
    """The places 0, 1 ... counts[k] - 1 of each row k, one row after the other.

    Parameters
    ----------
    counts : (k,) int, not negative

    Returns
    -------
    rows : (counts.sum(),) int, the row that each place is in
    places : (counts.sum(),) int
    """
    rows = np.repeat(np.arange(len(counts)), counts)
    return rows, np.arange(len(rows)) - (np.cumsum(counts) - counts)[rows]


def pairs_within(tree, points, reach):
    """Pairs of points and of places of a tree within reach of them.

    Parameters
    ----------
    tree : scipy.spatial.cKDTree
    points : (n, d)
    reach : a length, or (n,) one for each point

    Returns
    -------
    rows : (k,) int, ascending, the point of each pair
    places : (k,) int, that of the tree, ascending for each point
    """
    found = tree.query_ball_point(points, reach, return_sorted=True)
    rows, _ = ragged_arange(np.array([len(near) for near in found], int))
    return rows, np.concatenate([np.empty(0, int), *found]).astype(int)
