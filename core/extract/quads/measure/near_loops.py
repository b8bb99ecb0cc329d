# SPDX-License-Identifier: GPL-3.0-or-later
"""Walks straight over quads that come back beside their beginning: loops that are closed, and that nearly are."""

from dataclasses import dataclass

import numpy as np

from ....graphs import components
from .loops import twins

# Quads of a walk at least; how many quads beside its beginning it may end.
SHORTEST, ASIDE = 4, 8


@dataclass(frozen=True)
class NearLoops:
    """Classes of walks that run beside each other without an irregular vertex between them.

    Attributes
    ----------
    walks : for each class, (v,) vertices from one of its beginnings straight on, and then sideways back to it
    steps, asides : (l,) quads straight on, and quads sideways
    quads : (l,) how many quads lie on walks of the class: what a closed class has in short loops
    """

    walks: list[np.ndarray]
    steps: np.ndarray
    asides: np.ndarray
    quads: np.ndarray


def near_loops(quads, longest):
    """The :class:`NearLoops` of a quad mesh, of ``longest`` quads at most; walks end at faces of other than four sides.

    A walk is at a corner when it enters the corner's face through the side from this corner to the next.
    """
    ahead, right, left = _neighbours(quads)
    last = len(ahead) - 1
    tails = np.append(quads.corner_vertices, -1)
    beside = _places_beside(right, left)
    # A walk and the same one backwards are one: of a face's four directions two begin walks.
    starts = (quads.starts[quads.sizes == 4][:, None] + np.arange(2)).ravel()
    at, singular = starts.copy(), quads.is_irregular
    edges, counts = quads.edges
    singular[edges[counts == 1]] = True
    # How many irregular vertices a walk has passed, and places where it has left the walk on its right.
    passed, apart = np.zeros((2, len(starts)), int)
    singular, parts = np.append(singular, False), ahead[right] != right[ahead]
    found = []
    for step in range(1, longest + 1):
        passed += singular[tails[at]]
        apart += parts[at]
        at = ahead[at]
        if step < SHORTEST:
            continue
        for aside, places in beside.items():
            met = np.flatnonzero((at == places[starts]) & (at != last))
            same = np.ones_like(met)
            found.append(np.column_stack([met, step * same, aside * same, passed[met], apart[met]]))
    rows = np.concatenate([np.empty((0, 5), int), *found])
    # The shortest walk from each beginning to each place beside it.
    _, first = np.unique(rows[:, [0, 2]], axis=0, return_index=True)
    rows = rows[first]
    return _classes(starts, rows, ahead, right, left, tails)


def _neighbours(quads):
    """(c + 1,) corners straight on and to both sides of each; the last number stands for none."""
    starts, sizes = quads.starts[quads.corner_faces], quads.sizes[quads.corner_faces]
    places, none = np.arange(len(starts)), len(starts)
    is_quad = np.append(sizes == 4, False)
    across = twins(quads)
    twin = np.append(np.where(across < 0, none, across), none)

    def turned(corners, by):
        inside = corners < none
        base = starts[np.where(inside, corners, 0)]
        return np.where(is_quad[corners] & inside, base + (corners - base + by) % 4, none)

    every = np.append(places, none)
    ahead = twin[turned(every, 2)]
    right, left = turned(twin[turned(every, 1)], 1), turned(twin[turned(every, 3)], 3)
    return tuple(np.where(is_quad[found], found, none) for found in (ahead, right, left))


def _places_beside(right, left):
    """The corners so many quads to the right of each, to the left where the number is negative."""
    every = np.arange(len(right))
    result = {0: every}
    for way, sign in ((right, 1), (left, -1)):
        at = every
        for aside in range(1, ASIDE + 1):
            at = way[at]
            result[sign * aside] = at
    return result


def _classes(starts, rows, ahead, right, left, tails):
    """Walks of as many quads, as far aside, that stay beside each other, as one class."""
    order = np.lexsort((rows[:, 0], abs(rows[:, 2]), rows[:, 1]))
    rows = rows[order]
    count = len(starts)
    kinds = np.unique(np.column_stack([rows[:, 1], abs(rows[:, 2])]), axis=0, return_inverse=True)[1].ravel()
    keys = kinds * count + rows[:, 0]
    # Corners 2 and 3 of a quad enter it from the other side: the walk backwards from corners 0 and 1.
    number = np.full(len(ahead), -1)
    number[starts] = np.arange(count)
    number[starts[0::2] + 2] = np.arange(0, count, 2)
    number[starts[0::2] + 3] = np.arange(1, count, 2)
    pairs = []
    for way, stays in ((ahead, np.ones(len(rows), bool)), (right, rows[:, 4] == 0)):
        other = number[way[starts[rows[:, 0]]]]
        wanted = np.where((other < 0) | ~stays, -1, kinds * count + other)
        place = np.minimum(np.searchsorted(keys, wanted), max(len(keys) - 1, 0))
        same = (wanted >= 0) & (keys[place] == wanted) if len(keys) else np.zeros(0, bool)
        pairs.append(np.column_stack([np.flatnonzero(same), place[same]]))
    labels = components(len(rows), np.concatenate(pairs)) if len(rows) else np.zeros(0, int)
    sizes = np.bincount(labels)
    # The walk of a class that passes the fewest irregular vertices.
    first = np.lexsort((np.arange(len(rows)), rows[:, 3], labels))
    first = first[np.unique(labels[first], return_index=True)[1]]
    walks = [_walk(starts[start], steps, aside, ahead, right, left, tails) for start, steps, aside, *_ in rows[first]]
    return NearLoops(walks, rows[first, 1], abs(rows[first, 2]), sizes)


def _walk(corner, steps, aside, ahead, right, left, tails):
    """(v,) vertices of a walk straight on, and then sideways back to the corner."""
    corners = [corner]
    for _ in range(steps):
        corners.append(ahead[corners[-1]])
    back = left if aside > 0 else right
    for _ in range(abs(aside)):
        corners.append(back[corners[-1]])
    return tails[corners]
