# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines that a hand draws: taken apart where they jump, evened out, and left with the points that they need."""

import numpy as np

from .polylines import piece_lengths, ways_along


def parts(points, most):
    """A polyline taken apart where a piece is too long, as where the pointer passes from one limb to another.

    Parameters
    ----------
    points : (p, 3)
    most : (p - 1,) lengths that the pieces may have

    Returns
    -------
    list of (k, 3) with k > 1
    """
    return [part for part in np.split(points, np.flatnonzero(piece_lengths(points) > most) + 1) if len(part) > 1]


def smooth_polyline(points, times, shares=1.0):
    """A polyline whose points moved to the middle of themselves and their neighbours' middle, but for both ends.

    Parameters
    ----------
    points : (p, 3)
    times : how often
    shares : of that way, one or (p,) one for each point
    """
    points = np.array(points, float)
    shares = np.broadcast_to(shares, len(points))[1:-1, None]
    for _ in range(times):
        points[1:-1] += shares * (0.25 * points[:-2] + 0.5 * points[1:-1] + 0.25 * points[2:] - points[1:-1])
    return points


def simplify_polyline(points, tolerance, longest):
    """Which points of a polyline to keep so that those left out lie near the pieces between these.

    Points are added where the line is farthest off, until none is (Ramer 1972; Douglas and Peucker 1973), and where
    pieces would be too long.

    Parameters
    ----------
    points : (p, 3), p > 1
    tolerance : how far off a point may be left out
    longest : how long a piece may be, along the polyline, unless there is no point between its ends

    Returns
    -------
    (k,) ascending, with both ends
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


def _distances(points, start, end):
    """(k,) from points to the straight piece between two."""
    way = end - start
    share = np.clip((points - start) @ way / max(way @ way, np.finfo(float).tiny), 0, 1)
    return np.linalg.norm(points - start - share[:, None] * way, axis=1)
