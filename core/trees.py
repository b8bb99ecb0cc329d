# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames that agree along spanning trees of a graph, found for all components at once."""

import numpy as np

from .connection import compose
from .graphs import walk_trees


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
    reached, previous, links = walk_trees(count, np.column_stack([tails, heads]), roots)
    block = transports.shape[1:]
    carried = np.ones(count + 1, complex) if not block else np.tile(np.eye(*block), (count + 1, 1, 1))
    backward = (heads[links] != reached).reshape(-1, *[1] * len(block))
    adjoints = np.conj(transports[links]).swapaxes(1, 2) if block else np.conj(transports[links])
    carried[reached] = np.where(backward, adjoints, transports[links])
    # The last node is the start of all paths. Each round doubles the length of the composed steps.
    before = np.full(count + 1, count)
    before[reached] = previous
    while (before < count).any():
        on_way = np.flatnonzero(before < count)
        carried[on_way] = compose(carried[on_way], carried[before[on_way]])
        before[on_way] = before[before[on_way]]
    return carried[:count]
