# SPDX-License-Identifier: GPL-3.0-or-later
"""The flow around given vortex filaments, by Biot and Savart's law: a scene without a simulation."""

import numpy as np

from ..errors import SettingError

# Points times segments that are worked on at once.
CHUNK = 4_000_000
# Places and weights on 0..1 of Gauss and Legendre's rule along an edge.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)
SHARES, SHARE_WEIGHTS = 0.5 * (_NODES + 1), 0.5 * _WEIGHTS


def filament_velocity(places, curves, core):
    """(n, 3) velocity at (n, 3) places.

    Parameters
    ----------
    places : (n, 3)
    curves : pairs of (p, 3) points of a polyline, closed where the last is the first, and its circulation,
        counterclockwise seen from its head
    core : radius within which the vorticity is spread, in scene units

    Raises
    ------
    SettingError
        for a curve of a single point, or a core that is not positive
    """
    if not core > 0:
        raise SettingError(f"the core radius is {core}: give a positive length")
    velocity = np.zeros((len(places), 3))
    for points, circulation in curves:
        points = np.asarray(points, float)
        if len(points) < 2:
            raise SettingError("a filament has a single point: give it two at least")
        middles, segments = (points[1:] + points[:-1]) / 2, np.diff(points, axis=0)
        moments = np.cross(segments, middles)
        step = max(CHUNK // len(segments), 1)
        for start in range(0, len(places), step):
            chunk = places[start : start + step]
            squares = (chunk**2).sum(axis=1)[:, None] + (middles**2).sum(axis=1) - 2 * chunk @ middles.T + core**2
            kernel = 1 / (squares * np.sqrt(squares))
            induced = np.cross(kernel @ segments, chunk) - kernel @ moments
            velocity[start : start + step] += circulation / (4 * np.pi) * induced
    return velocity


def filament_integrals(grid, curves, core):
    """(e,) integral of that velocity along each edge of a grid of three dimensions, by Gauss's rule of four points.

    Parameters
    ----------
    grid : Grid
    curves, core : as :func:`filament_velocity`
    """
    axes = grid.edge_axes
    lengths = grid.spacing[axes]
    start = grid.places[grid.edges[:, 0]]
    total = np.zeros(len(axes))
    rows = np.arange(len(axes))
    for share, weight in zip(SHARES, SHARE_WEIGHTS, strict=True):
        places = start.copy()
        places[rows, axes] += share * lengths
        total += weight * filament_velocity(places, curves, core)[rows, axes]
    return total * lengths
