# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames that agree along spanning trees of a graph, found for all components at once."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order

from .connection import compose


def along_trees(
    count: int, tails: np.ndarray, heads: np.ndarray, transports: np.ndarray, roots: np.ndarray
) -> np.ndarray:
    """Carry the unit frame from the roots along shortest paths.

    A field that fits all links of a component is the same in all these frames. Returns (count,) complex of unit modulus
    or (count, d, d): what takes the root's value to each node's; the identity where no root is connected.

    Parameters
    ----------
    tails, heads : (e,) nodes of the links, of ``count`` nodes
    transports : (e,) complex or (e, d, d), from tail to head; from head to tail their adjoints lead
    roots : (c,) one node of each component that has links
    """
    starts = np.full(len(roots), count)
    graph = coo_matrix(
        (np.ones(len(tails) + len(roots)), (np.append(tails, starts), np.append(heads, roots))),
        shape=(count + 1, count + 1),
    )
    _, before = breadth_first_order(graph.tocsr(), count, directed=False)
    before = before[:count].astype(int)
    reached = np.flatnonzero((before >= 0) & (before < count))
    before[(before < 0) | (before == count)] = count
    keys, links = np.unique(np.minimum(tails, heads) * count + np.maximum(tails, heads), return_index=True)
    sought = np.minimum(reached, before[reached]) * count + np.maximum(reached, before[reached])
    links = links[np.searchsorted(keys, sought)]
    block = transports.shape[1:]
    carried = np.ones(count + 1, complex) if not block else np.tile(np.eye(*block), (count + 1, 1, 1))
    backward = (heads[links] != reached).reshape(-1, *[1] * len(block))
    adjoints = np.conj(transports[links]).swapaxes(1, 2) if block else np.conj(transports[links])
    carried[reached] = np.where(backward, adjoints, transports[links])
    # The last node is the start of all paths. Each round doubles the length of the composed steps.
    before = np.append(before, count)
    while (before < count).any():
        on_way = np.flatnonzero(before < count)
        carried[on_way] = compose(carried[on_way], carried[before[on_way]])
        before[on_way] = before[before[on_way]]
    return carried[:count]
