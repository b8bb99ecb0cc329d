# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Beads inside of others, where sheets of layers end beside one another or lie on themselves."""

import numpy as np
from scipy.spatial import cKDTree

from ..extract.lines.isolines import Isolines
from ..graphs import pairs_within, ragged_arange

# Pieces of beads that are looked at are as long as this share of the distance of lines.
_PIECE = 0.25
# A tip is inside where it is this far below the top and from the sides, in half heights and half widths.
_INSIDE = 0.1
# Pieces that are looked at together.
_BATCH = 4096


def divide_lines(lines: Isolines, points: np.ndarray, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Places at most a size apart along lines: (k,) the point that each comes after, and (k, 3)."""
    ways = points[lines.next] - points
    counts = np.maximum(np.ceil(np.linalg.norm(ways, axis=1) / size).astype(int), 1)
    piece, place = ragged_arange(counts)
    return piece, points[piece] + (place / counts[piece])[:, None] * ways[piece]


def inside_earlier(
    lines: Isolines, tips: np.ndarray, normals: np.ndarray, widths: np.ndarray, heights: np.ndarray, step: float
) -> np.ndarray:
    """(n,) bool: points whose tip is inside the bead of an earlier line, which has been printed there.

    A bead is a box below its tip, along its normal.

    Parameters
    ----------
    lines : Isolines in the order in which they are printed
    tips, normals : (n, 3) at their points
    widths, heights : (n,) of the beads
    step : distance of lines
    """
    piece, places = divide_lines(lines, tips, _PIECE * step)
    middles = places - heights[piece, None] / 2 * normals[piece]
    numbers = lines.numbers
    reaches = np.hypot(widths, heights)[piece] / 2
    tree, points, others = cKDTree(tips), [], []
    for part in np.array_split(np.arange(len(piece)), len(piece) // _BATCH + 1):
        which, point = pairs_within(tree, middles[part], reaches[part])
        which = part[which]
        other = piece[which]
        away = tips[point] - middles[which]
        up = np.einsum("kx,kx->k", away, normals[other])
        aside = np.linalg.norm(away - up[:, None] * normals[other], axis=1)
        is_inside = (numbers[other] < numbers[point]) & (np.abs(up) < (1 - _INSIDE) * heights[other] / 2)
        is_inside &= aside < (1 - _INSIDE) * widths[other] / 2
        points.append(point[is_inside])
        others.append(other[is_inside])
    order = np.argsort(np.concatenate(points), kind="stable")
    result = np.zeros(len(tips), bool)
    # A bead that is itself left out fills nothing.
    for point, other in zip(
        np.concatenate(points)[order].tolist(), np.concatenate(others)[order].tolist(), strict=True
    ):
        result[point] |= not result[other]
    return result
