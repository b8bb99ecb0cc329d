# SPDX-License-Identifier: GPL-3.0-or-later
"""Polylines: how long they are and may be, and what lies some way along them."""

import math

import numpy as np

from ..errors import SettingError

# A microsecond to some ten and some hundred bytes each.
MOST_PLACES = 1_000_000


def check_length(name, length, step):
    """Refuse curves along which there would be more than ``MOST_PLACES`` places.

    Parameters
    ----------
    name : what errors call them
    length : of all, scene units
    step : from one place to the next, scene units

    Raises
    ------
    SettingError
        for curves that are too long, or of no finite length
    """
    if not math.isfinite(length):
        raise SettingError(f"{name} has points without a finite place: set their coordinates, or delete them")
    if length > MOST_PLACES * step:
        raise SettingError(
            f"{name} has a length of {length:.3g}, and no more than {MOST_PLACES * step:.3g} can be followed along "
            "this mesh: delete the points that are far away from it"
        )


def beside(points, values, ways):
    """What a polyline carries some way before (negative) or behind each of its points.

    Open polylines keep what their ends carry; those that end where they begin go round.

    Parameters
    ----------
    points : (p, 3)
    values : (p, d) at the points
    ways : (w,) lengths along the polyline, at most its own

    Returns
    -------
    (w, p, d) values, linear between the points
    """
    along = ways_along(points)
    places, length = along, along[-1]
    if np.linalg.norm(points[-1] - points[0]) < 1e-6 * length:
        along = np.concatenate([along[:-1] - length, along, along[1:] + length])
        values = np.concatenate([values[:-1], values, values[1:]])
    return np.array([np.column_stack([np.interp(places + way, along, column) for column in values.T]) for way in ways])


def around(points, is_closed):
    """(p, 3) points of a polyline, of a closed one with the first again at the end."""
    return np.vstack([points, points[:1]]) if is_closed else points


def piece_lengths(points):
    """(p - 1,) between (p, 3) points, scene units."""
    return np.linalg.norm(np.diff(points, axis=0), axis=1)


def polyline_length(points):
    """Along (p, 3) points, scene units."""
    return float(piece_lengths(points).sum())


def ways_along(points):
    """(p,) from the first point of a polyline, (p, 3), to each, scene units."""
    return np.append(0, np.cumsum(piece_lengths(points)))


def places_at(points, ways):
    """(k, 3) some (k,) ways along a polyline, (p, 3)."""
    along = ways_along(points)
    return np.column_stack([np.interp(ways, along, column) for column in points.T])


def resample_polyline(points, step):
    """Points along a polyline, (p, 3), evenly spaced and at most a step apart."""
    length = polyline_length(points)
    return places_at(points, np.linspace(0, length, max(int(np.ceil(length / step)), 1) + 1))
