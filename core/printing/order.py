# SPDX-License-Identifier: GPL-3.0-or-later
"""The order in which beads are laid: carrying layers first, in each layer the nearest bead next."""

import heapq

import numpy as np

from ..extract.lines.isolines import Isolines
from ..graphs import ragged_arange

# Share of a layer that lies on another one from which on that has to be there before.
_CARRIED = 0.02


def carrying_pairs(of: np.ndarray, lower: np.ndarray, count: int) -> np.ndarray:
    """(2, k) pairs of a layer and one below it, for layers that lie on it with more than a small share of their points.

    ``of`` has the layer of each point, ``lower`` the layer below it, negative without one.
    """
    pairs, numbers = np.unique(np.column_stack([of, lower]), axis=0, return_counts=True)
    shares = numbers / np.bincount(of, minlength=count)[pairs[:, 0]]
    kept = (pairs[:, 1] >= 0) & (shares > _CARRIED)
    return pairs[kept].T


def layer_order(count: int, carried: np.ndarray, carrying: np.ndarray) -> np.ndarray:
    """Sort layers topologically, so that each comes after those that carry it; of several, the lowest number first.

    (k,) ``carried`` layers lie upon the (k,) ``carrying`` ones. A cycle begins with its lowest number.
    """
    pairs = np.unique(np.array([carrying, carried], int).T.reshape(-1, 2), axis=0)
    pairs = pairs[pairs[:, 0] != pairs[:, 1]]
    above: list[list[int]] = [[] for _ in range(count)]
    for one, other in pairs.tolist():
        above[one].append(other)
    waiting = np.bincount(pairs[:, 1], minlength=count)
    free = [layer for layer in range(count) if not waiting[layer]]
    order, left = [], set(range(count))
    while left:
        layer = heapq.heappop(free) if free else min(left)
        if layer not in left:
            continue
        left.remove(layer)
        order.append(layer)
        for other in above[layer]:
            waiting[other] -= 1
            if waiting[other] == 0:
                heapq.heappush(free, other)
    return np.array(order, int)


def count_levels(order: np.ndarray, carried: np.ndarray, carrying: np.ndarray) -> np.ndarray:
    """(count,) the number of layers below each one; a layer without any has the level of the one printed before it.

    ``order`` is the result of :func:`layer_order`, the others are its parameters.
    """
    below: dict[int, list[int]] = {}
    for one, other in zip(carried.tolist(), carrying.tolist(), strict=True):
        below.setdefault(one, []).append(other)
    levels, done, last = np.zeros(len(order), int), np.zeros(len(order), bool), 0
    for layer in order.tolist():
        last = max((levels[other] + 1 for other in below.get(layer, []) if done[other]), default=last)
        levels[layer], done[layer] = last, True
    return levels


def order_lines(
    lines: Isolines, layers: np.ndarray, order: np.ndarray, back: np.ndarray | None = None
) -> tuple[Isolines, np.ndarray, np.ndarray]:
    """Sort lines by the order of their (l,) layers, in each layer the nearest next. Closed lines may begin anywhere,
    open ones at either end.

    With a (3,) direction ``back``, closed lines begin at their farthest point along it. Returns the lines, the (l,)
    index of each in the given lines, and the (n,) index of each point in the given points.
    """
    starts, closed, places = lines.starts, lines.closed, lines.points
    here = None
    chosen, runs = [], []
    for layer in order:
        left = np.flatnonzero(layers == layer)
        rows = [np.arange(starts[line], starts[line] + lines.sizes[line]) for line in left]
        # Places where each may begin: all of a closed line or its back, both ends of others.
        may = [
            row[[0, -1]] if not closed[line] else row if back is None else row[[(places[row] @ back).argmax()]]
            for line, row in zip(left, rows, strict=True)
        ]
        of = ragged_arange(np.array([len(one) for one in may], int))[0]
        doors = np.concatenate([*may, np.zeros(0, int)]).astype(int)
        free = np.ones(len(doors), bool)
        for _ in left:
            distances = np.where(free, 0.0 if here is None else np.linalg.norm(places[doors] - here, axis=1), np.inf)
            door = int(distances.argmin())
            number = of[door]
            free[of == number] = False
            row = rows[number]
            if closed[left[number]]:
                row = np.roll(row, -int(doors[door] - row[0]))
            elif doors[door] != row[0]:
                row = row[::-1]
            here = places[row[0] if closed[left[number]] else row[-1]]
            chosen.append(left[number])
            runs.append(row)
    taken = np.array(chosen, int)
    points = np.concatenate([*runs, np.zeros(0, int)]).astype(int)
    return lines.with_points(points, lines.sizes[taken], lines.ends[taken]), taken, points
