# SPDX-License-Identifier: GPL-3.0-or-later
"""Hand-drawn lines: split at jumps, smoothed and simplified."""

import numpy as np
from numpy.typing import ArrayLike

from .polylines import piece_lengths, ways_along


def parts(points: np.ndarray, most: np.ndarray) -> list[np.ndarray]:
    """Split a polyline, (p, 3), at segments longer than allowed, (p - 1,), as where the pointer jumps to another limb.

    Returns the parts, (k, 3) each, with k > 1.
    """
    return [part for part in np.split(points, np.flatnonzero(piece_lengths(points) > most) + 1) if len(part) > 1]


def smooth_polyline(points: np.ndarray, times: int, shares: ArrayLike = 1.0) -> np.ndarray:
    """Smooth a polyline, (p, 3), except its ends: each step moves a point halfway to its neighbours' midpoint.

    ``shares``, one or (p,), scale the steps.
    """
    points = np.array(points, float)
    inner = np.broadcast_to(shares, len(points))[1:-1, None]
    for _ in range(times):
        points[1:-1] += inner * (0.25 * points[:-2] + 0.5 * points[1:-1] + 0.25 * points[2:] - points[1:-1])
    return points


def simplify_polyline(points: np.ndarray, tolerance: float, longest: float) -> np.ndarray:
    """Select (k,) points of a polyline, (p, 3) with p > 1, ascending and with both ends, so that the others lie within
    the tolerance of the segments between.

    Points are added where the line is farthest off (Ramer 1972; Douglas and Peucker 1973), and where a segment would
    replace more than the longest piece of the polyline.
    """
    along = ways_along(points)
    kept, open_pieces = {0, len(points) - 1}, [(0, len(points) - 1)]
    while open_pieces:
        first, last = open_pieces.pop()
        if last - first < 2:
            continue
        off = _distances(points[first + 1 : last], points[first], points[last])
        middle = first + 1 + int(off.argmax())
        if off.max() <= tolerance:
            if along[last] - along[first] <= longest:
                continue
            middle = int(np.searchsorted(along, (along[first] + along[last]) / 2))
            middle = min(max(middle, first + 1), last - 1)
        kept.add(middle)
        open_pieces += [(first, middle), (middle, last)]
    return np.array(sorted(kept))


def _distances(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Compute (k,) distances of points to the segment between two."""
    way = end - start
    share = np.clip((points - start) @ way / max(way @ way, np.finfo(float).tiny), 0, 1)
    return np.linalg.norm(points - start - share[:, None] * way, axis=1)
