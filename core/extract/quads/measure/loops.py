# SPDX-License-Identifier: GPL-3.0-or-later
"""Loops (polychords) of a quad mesh: strips of quads in which each is left through the side opposite to the entry."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....graphs import components, inverse, label_rows
from ..trace.quad_mesh import QuadMesh

# Crossings within this many quads along a loop count as one place.
NEAR = 16
# Loops up to this multiple of the square root of the number of faces are short.
SHORT = 5.0


@dataclass(frozen=True)
class QuadLoops:
    """The loops, the longest first.

    Attributes
    ----------
    corner_loops : (c,) loop that crosses the side from each corner to the next; -1 for a side without a quad
    lengths : (l,) number of quads of each loop, counted twice where it crosses itself
    """

    quads: QuadMesh
    corner_loops: np.ndarray
    lengths: np.ndarray

    @cached_property
    def spirals(self) -> np.ndarray:
        """(l,) bool: loops that a loop crosses three times within :data:`NEAR` quads."""
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
    def short_share(self) -> float:
        """Share of short loops in the sum of all lengths."""
        short = self.lengths <= SHORT * np.sqrt(len(self.quads.sizes))
        return float(self.lengths[short].sum() / max(self.lengths.sum(), 1))

    @property
    def figures(self) -> dict[str, float]:
        """Numbers for reports."""
        return {
            "loops": len(self.lengths),
            "longest_loop": int(self.lengths.max(initial=0)),
            "spirals": int(self.spirals.sum()),
            "short_loop_share": self.short_share,
        }


def quad_loops(quads: QuadMesh) -> QuadLoops:
    """The loops of a quad mesh; they end at faces that are not quads."""
    edges = label_rows(np.sort(quads.half_edges, axis=1))
    places = quads.starts[quads.sizes == 4][:, None] + np.arange(4)
    passes = edges[places].reshape(-1, 2, 2).transpose(0, 2, 1).reshape(-1, 2)
    # Edges without a quad have no loop.
    passed = np.unique(passes)
    loops = np.full(edges.max(initial=-1) + 1, -1)
    loops[passed] = components(len(passed), np.searchsorted(passed, passes))
    lengths = np.bincount(loops[passes[:, 0]], minlength=loops.max(initial=-1) + 1)
    order = np.argsort(-lengths, kind="stable")
    return QuadLoops(quads, np.where(loops < 0, -1, np.append(inverse(order), 0)[loops])[edges], lengths[order])


def _walks(loops: QuadLoops) -> Iterator[tuple[np.ndarray, bool]]:
    """For each loop, the loops that it crosses, in order, and whether it is closed."""
    quads = loops.quads
    starts, sizes = quads.starts[quads.corner_faces], quads.sizes[quads.corner_faces]
    places = np.arange(len(starts))
    opposite = np.where(sizes == 4, starts + (places - starts + 2) % 4, -1)
    across = twins(quads)
    # The corner whose side a walk enters next, after the side of a corner; -1 at an end.
    after = np.where(sizes == 4, across[opposite], -1)
    after[(after >= 0) & (sizes[after] != 4)] = -1
    begins = (sizes == 4) & ((across < 0) | (sizes[across] != 4))
    crossed = loops.corner_loops[quads.next_corners]
    seen = np.zeros(len(places), bool)
    for first in (*np.flatnonzero(begins), *np.flatnonzero(sizes == 4)):
        walk, corner = [], first
        while corner >= 0 and not seen[corner]:
            seen[corner] = seen[opposite[corner]] = True
            walk.append(corner)
            corner = after[corner]
        if walk:
            yield crossed[walk], corner == first


def twins(quads: QuadMesh) -> np.ndarray:
    """(c,) the corner with the opposite half-edge; -1 at the boundary."""
    tails, heads = quads.half_edges.T
    count = len(quads.vertices)
    keys, opposite = tails * count + heads, heads * count + tails
    order = np.argsort(keys)
    found = order[np.minimum(np.searchsorted(keys[order], opposite), len(keys) - 1)]
    return np.where(keys[found] == opposite, found, -1)
