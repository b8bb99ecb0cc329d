# SPDX-License-Identifier: GPL-3.0-or-later
"""The flow around given vortex filaments, by Biot and Savart's law: a scene without a simulation."""

from dataclasses import dataclass

import numpy as np

from ..errors import SettingError
from ..geometry.grid import box_grid

# Places times points that are worked on at once: what a cache holds.
CHUNK = 250_000
# Places and weights on 0..1 of Gauss and Legendre's rule along an edge.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)
SHARES, SHARE_WEIGHTS = 0.5 * (_NODES + 1), 0.5 * _WEIGHTS
# Space around filaments, as a share of their longest side.
_MARGIN = 0.35


def filament_velocity(places, curves, core):
    """(n, 3) velocity at (n, 3) places.

    Each segment from p to q counts in closed form: the integral of dy x (x - y) / (|x - y|^2 + core^2)^(3/2) along it
    is 2 (P + Q) / (P Q ((P + Q)^2 - |q - p|^2)) (q - p) x (x - p), with P^2 = |x - p|^2 + core^2 and Q so from q.

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
        segments = np.diff(points, axis=0)
        moments, squared_lengths = np.cross(segments, points[:-1]), (segments**2).sum(axis=1)
        step = max(CHUNK // len(points), 1)
        for start in range(0, len(places), step):
            chunk = places[start : start + step]
            squares = (chunk**2).sum(axis=1)[:, None] + (points**2).sum(axis=1) - 2 * chunk @ points.T
            away = np.sqrt(np.maximum(squares, 0) + core**2)
            sums = away[:, :-1] + away[:, 1:]
            spread = np.maximum(sums**2 - squared_lengths, 4 * core**2)  # it is never less, but for rounding
            kernel = 2 * sums / (away[:, :-1] * away[:, 1:] * spread)
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


def surrounding_grid(low, high, resolution):
    """A grid around filaments whose lowest and highest corner are given, with so many nodes along its longest side."""
    margin = _MARGIN * (high - low).max()
    return box_grid(low - margin, high + margin, resolution)


@dataclass(frozen=True)
class FilamentCurves:
    """Vortex filaments in space, and the flow that they induce around them.

    Attributes
    ----------
    name : of what they were read from
    curves : pairs of points and circulation, as :func:`filament_velocity` has them
    core : radius over which their vorticity is spread, in cells of the grid
    warnings, noise : none
    """

    name: str
    curves: tuple[tuple[np.ndarray, float], ...]
    core: float
    warnings: tuple[str, ...] = ()
    noise = None

    def read(self):
        """The flow: these, as nothing is left to be read."""
        return self

    def grid(self, resolution):
        """A grid around the curves with so many nodes along its longest side."""
        points = np.concatenate([points for points, _ in self.curves])
        return surrounding_grid(points.min(axis=0), points.max(axis=0), resolution)

    def integrals(self, grid):
        """(e,) of the velocity along the grid's edges."""
        return filament_integrals(grid, self.curves, self.core * grid.spacing[0])
