# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of beads that are left out: inside of earlier ones, and ends that cannot be reached through these.

There are such parts where sheets of curved layers run into one another. A bead is a box below its tip, along the tool.
"""

from collections.abc import Iterator

import numpy as np
from scipy.spatial import cKDTree

from ..extract.lines.isolines import Isolines
from ..geometry.polylines import divide_pieces
from ..graphs import pairs_within

# Pieces of beads that are looked at are as long as this share of the distance of lines.
_PIECE = 0.25
# A place is inside where it is this far from the top and the sides, in half heights and half widths.
_INSIDE = 0.1
# Where the tip is on its way to and from the end of a bead, in distances of lines along the tool.
_WAY = np.arange(1, 33) / 16
# Points per batch.
_BATCH = 4096


def find_overlaps(
    lines: Isolines, tips: np.ndarray, tools: np.ndarray, widths: np.ndarray, heights: np.ndarray, step: float
) -> np.ndarray:
    """(n,) bool: points to leave out: those without a height, those whose tip is inside an earlier bead, and ends of
    the rest that the tip, which comes along the tool, reaches only through an earlier bead.

    Lines, a step apart, are in the order in which they are printed; at their points are the tips and unit vectors from
    these into the tool, (n, 3), and the (n,) widths and heights of the beads.
    """
    piece, tops = divide_pieces(tips, tips[lines.next], _PIECE * step)
    middles, numbers = tops - heights[piece, None] / 2 * tools[piece], lines.numbers
    tree, reach = cKDTree(middles), float(np.hypot(widths, heights).max(initial=0)) / 2
    steps = np.linalg.norm(tips[lines.next] - tips, axis=1)
    # A line of one point has no length, and nothing of it is behind.
    along, lengths = lines.sum_before(steps), np.maximum(np.bincount(numbers, steps), np.finfo(float).tiny)[numbers]

    def pairs(points: np.ndarray, places: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Each pair of a point and an earlier one whose bead contains the first one's place, in order of the first.

        On its own line, the earlier one is more than a width behind.
        """
        for part in np.array_split(np.arange(len(points)), len(points) // _BATCH + 1):
            row, near = pairs_within(tree, places[part], reach)
            row, other = part[row], piece[near]
            away = places[row] - middles[near]
            up = np.einsum("kx,kx->k", away, tools[other])
            aside = np.linalg.norm(away - up[:, None] * tools[other], axis=1)
            point = points[row]
            is_earlier = numbers[other] < numbers[point]
            behind = along[point] - along[other]
            around = np.mod(behind, lengths[point])  # closed lines may begin anywhere
            behind = np.where(lines.closed[numbers[point]], np.minimum(around, lengths[point] - around), behind)
            is_earlier |= (numbers[other] == numbers[point]) & (behind > widths[other])
            is_inside = is_earlier & (2 * np.abs(up) < (1 - _INSIDE) * heights[other])
            is_inside &= 2 * aside < (1 - _INSIDE) * widths[other]
            yield point[is_inside], other[is_inside]

    result = heights <= 0
    # A bead that is left out fills no space and blocks no way.
    for found in pairs(np.arange(len(tips)), tips):
        for point, other in zip(*(one.tolist() for one in found), strict=True):
            result[point] |= not result[other]
    is_tried = np.zeros(len(tips), bool)
    while True:
        ends = _ends(lines, ~result)
        ends = np.repeat(ends[~is_tried[ends]], len(_WAY))
        is_tried[ends] = True
        ways = np.tile(_WAY * step, len(ends) // len(_WAY))[:, None] * tools[ends]
        barred = [point[~result[other]] for point, other in pairs(ends, tips[ends] + ways)]
        if not any(len(some) for some in barred):
            return result
        result[np.concatenate(barred)] = True


def _ends(lines: Isolines, kept: np.ndarray) -> np.ndarray:
    """Points at which the (n,) kept parts of lines begin and end, and where closed lines begin."""
    following, before = lines.next, lines.previous
    is_end = ~kept[before] | ~kept[following] | (following == np.arange(len(kept)))
    is_end[lines.starts] = True
    return np.flatnonzero(kept & is_end)
