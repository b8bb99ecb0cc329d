# SPDX-License-Identifier: GPL-3.0-or-later
"""Straight walks over quads that return beside their start: closed loops, and loops that nearly close."""

from dataclasses import dataclass

import numpy as np

from ....graphs import components, label_rows
from ..trace.quad_mesh import QuadMesh
from .loops import twins

# Fewest quads of a walk, and most quads between its end and its start.
SHORTEST, ASIDE = 4, 8


@dataclass(frozen=True)
class NearLoops:
    """Classes of walks that run side by side without an irregular vertex between them.

    Attributes
    ----------
    walks : for each class, (v,) vertices of one walk straight on and then sideways back to its start
    steps, asides : (l,) number of quads straight on, and sideways
    quads : (l,) number of quads on walks of the class: what a closed class has in short loops
    """

    walks: list[np.ndarray]
    steps: np.ndarray
    asides: np.ndarray
    quads: np.ndarray


def near_loops(quads: QuadMesh, longest: int) -> NearLoops:
    """The near loops of at most ``longest`` quads; walks end at faces that are not quads.

    A walk is at a corner when it enters the corner's face through the side from this corner to the next.
    """
    ahead, right, left = _neighbours(quads)
    last = len(ahead) - 1
    tails = np.append(quads.corner_vertices, -1)
    beside = _places_beside(right, left)
    # A walk and its reverse are the same: walks start in two of a face's four directions.
    starts = (quads.starts[quads.sizes == 4][:, None] + np.arange(2)).ravel()
    at, singular = starts.copy(), quads.is_irregular
    edges, counts = quads.edges
    singular[edges[counts == 1]] = True
    # Numbers of irregular vertices that a walk has passed, and of places where it has left the walk on its right.
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
    # Rows: start, quads straight on, quads aside, irregular vertices passed, places apart from the walk on the right.
    rows = np.concatenate([np.empty((0, 5), int), *found])
    # The shortest walk from each start to each place beside it.
    _, first = np.unique(rows[:, [0, 2]], axis=0, return_index=True)
    rows = rows[first]
    return _classes(starts, rows, ahead, right, left, tails)


def _neighbours(quads: QuadMesh) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(c + 1,) corners straight on, to the right and to the left of each; the last index stands for none."""
    starts, sizes = quads.starts[quads.corner_faces], quads.sizes[quads.corner_faces]
    places, none = np.arange(len(starts)), len(starts)
    is_quad = np.append(sizes == 4, False)
    across = twins(quads)
    twin = np.append(np.where(across < 0, none, across), none)

    def turned(corners: np.ndarray, by: int) -> np.ndarray:
        inside = corners < none
        base = starts[np.where(inside, corners, 0)]
        return np.where(is_quad[corners] & inside, base + (corners - base + by) % 4, none)

    every = np.append(places, none)
    ahead = twin[turned(every, 2)]
    right, left = turned(twin[turned(every, 1)], 1), turned(twin[turned(every, 3)], 3)
    ahead, right, left = (np.where(is_quad[found], found, none) for found in (ahead, right, left))
    return ahead, right, left


def _places_beside(right: np.ndarray, left: np.ndarray) -> dict[int, np.ndarray]:
    """For each number of quads to the right, negative to the left, the (c + 1,) corners there."""
    every = np.arange(len(right))
    result = {0: every}
    for way, sign in ((right, 1), (left, -1)):
        at = every
        for aside in range(1, ASIDE + 1):
            at = way[at]
            result[sign * aside] = at
    return result


def _classes(
    starts: np.ndarray, rows: np.ndarray, ahead: np.ndarray, right: np.ndarray, left: np.ndarray, tails: np.ndarray
) -> NearLoops:
    """Group walks of the same length and shift that lie side by side, and represent each group by one; rows as in
    :func:`near_loops`."""
    order = np.lexsort((rows[:, 0], abs(rows[:, 2]), rows[:, 1]))
    rows = rows[order]
    count = len(starts)
    kinds = label_rows(np.column_stack([rows[:, 1], abs(rows[:, 2])]))
    keys = kinds * count + rows[:, 0]
    # Walks at corners 2 and 3 of a quad are the reverses of those at corners 0 and 1.
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
    # Each class is represented by the walk with the fewest irregular vertices.
    first = np.lexsort((np.arange(len(rows)), rows[:, 3], labels))
    first = first[np.unique(labels[first], return_index=True)[1]]
    walks = [_walk(starts[start], steps, aside, ahead, right, left, tails) for start, steps, aside, *_ in rows[first]]
    return NearLoops(walks, rows[first, 1], abs(rows[first, 2]), sizes)


def _walk(
    corner: int, steps: int, aside: int, ahead: np.ndarray, right: np.ndarray, left: np.ndarray, tails: np.ndarray
) -> np.ndarray:
    """(v,) vertices of a walk straight on and then sideways back to the corner."""
    corners = [corner]
    for _ in range(steps):
        corners.append(ahead[corners[-1]])
    back = left if aside > 0 else right
    for _ in range(abs(aside)):
        corners.append(back[corners[-1]])
    return tails[corners]
