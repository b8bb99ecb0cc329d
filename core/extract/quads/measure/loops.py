# SPDX-License-Identifier: GPL-3.0-or-later
"""Loops of a quad mesh: the rows of quads that one passes by leaving each through the side across."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....graphs import components
from ..trace.quad_mesh import QuadMesh

# Quads along a loop within which others cross it at one place.
NEAR = 16
# Loops are short up to this many times the root of the number of faces.
SHORT = 5.0


@dataclass(frozen=True)
class QuadLoops:
    """The loops, numbered from the longest on.

    Attributes
    ----------
    quads : QuadMesh
    corner_loops : (c,) loop that passes through the side from each corner to the next; -1 without a quad beside it
    lengths : (l,) quads that a loop passes, those twice where it crosses itself
    """

    quads: QuadMesh
    corner_loops: np.ndarray
    lengths: np.ndarray

    @cached_property
    def spirals(self):
        """(l,) bool: whether a loop passes a place more than twice.

        That is, whether another loop, or itself, crosses it three times within :data:`NEAR` quads.
        """
        result = np.zeros(len(self.lengths), bool)
        for crossed, is_closed in _walks(self):
            near = min(NEAR, len(crossed))
            if is_closed:
                crossed = np.append(crossed, crossed[: near - 1])
            order = np.argsort(crossed, kind="stable")
            again = (crossed[order[2:]] == crossed[order[:-2]]) & (order[2:] - order[:-2] < near)
            result[crossed[order[2:]][again]] = True
        return result

    @property
    def short_share(self):
        """The share of all passages of quads in loops of at most 5 sqrt(f) of f quads."""
        short = self.lengths <= SHORT * np.sqrt(len(self.quads.sizes))
        return float(self.lengths[short].sum() / max(self.lengths.sum(), 1))

    @property
    def figures(self):
        """For reports, as a dict of plain numbers."""
        return {
            "loops": len(self.lengths),
            "longest_loop": int(self.lengths.max(initial=0)),
            "spirals": int(self.spirals.sum()),
            "short_loop_share": self.short_share,
        }


def quad_loops(quads):
    """The :class:`QuadLoops` of a :class:`QuadMesh`; they end at faces of other than four sides."""
    edges = np.unique(np.sort(quads.half_edges, axis=1), axis=0, return_inverse=True)[1].reshape(-1)
    places = quads.starts[quads.sizes == 4][:, None] + np.arange(4)
    passes = edges[places].reshape(-1, 2, 2).transpose(0, 2, 1).reshape(-1, 2)
    # Edges that no loop passes have no quad beside them.
    passed = np.unique(passes)
    loops = np.full(edges.max(initial=-1) + 1, -1)
    loops[passed] = components(len(passed), np.searchsorted(passed, passes))
    lengths = np.bincount(loops[passes[:, 0]], minlength=loops.max(initial=-1) + 1)
    order = np.argsort(-lengths, kind="stable")
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return QuadLoops(quads, np.where(loops < 0, -1, np.append(rank, 0)[loops])[edges], lengths[order])


def _walks(loops):
    """For each loop the loops that it crosses, in order, and whether it closes."""
    quads = loops.quads
    starts, sizes = quads.starts[quads.corner_faces], quads.sizes[quads.corner_faces]
    places = np.arange(len(starts))
    opposite = np.where(sizes == 4, starts + (places - starts + 2) % 4, -1)
    across = twins(quads)
    # Where a walk that comes in through a corner's side comes in next; -1 where it ends.
    after = np.where(sizes == 4, across[opposite], -1)
    after[(after >= 0) & (sizes[after] != 4)] = -1
    comes = (sizes == 4) & ((across < 0) | (sizes[across] != 4))
    crossed = loops.corner_loops[quads.next_corners]
    seen = np.zeros(len(places), bool)
    for first in (*np.flatnonzero(comes), *np.flatnonzero(sizes == 4)):
        walk, corner = [], first
        while corner >= 0 and not seen[corner]:
            seen[corner] = seen[opposite[corner]] = True
            walk.append(corner)
            corner = after[corner]
        if walk:
            yield crossed[walk], corner == first


def twins(quads):
    """(c,) the corner whose side is the same edge the other way round; -1 at the boundary."""
    tails, heads = quads.half_edges.T
    count = len(quads.vertices)
    keys, opposite = tails * count + heads, heads * count + tails
    order = np.argsort(keys)
    found = np.minimum(np.searchsorted(keys[order], opposite), len(keys) - 1)
    found = order[found]
    return np.where(keys[found] == opposite, found, -1)
