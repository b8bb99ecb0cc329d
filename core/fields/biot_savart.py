# SPDX-License-Identifier: GPL-3.0-or-later
"""The flow around given vortex filaments, by Biot and Savart's law: a scene without a simulation."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..errors import SettingError
from ..geometry.grid import Grid, box_grid

# Places times points in a chunk, which fits into a cache.
CHUNK = 250_000
# Places and weights on 0..1 of Gauss and Legendre's rule along an edge.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)
SHARES, SHARE_WEIGHTS = 0.5 * (_NODES + 1), 0.5 * _WEIGHTS
# Space around filaments, as a share of their longest side.
_MARGIN = 0.35


def filament_velocity(places: np.ndarray, curves: Sequence[tuple[ArrayLike, float]], core: float) -> np.ndarray:
    """(n, 3) velocity at (n, 3) places.

    Each segment from p to q is integrated in closed form: the integral of dy x (x - y) / (|x - y|^2 + core^2)^(3/2) is
    2 (P + Q) / (P Q ((P + Q)^2 - |q - p|^2)) (q - p) x (x - p), with P^2 = |x - p|^2 + core^2 and Q likewise for q.

    Raises :class:`SettingError` for a curve of a single point, or a core that is not positive.

    Parameters
    ----------
    curves : pairs of (p, 3) points of a polyline, closed where the last is the first, and its circulation,
        counterclockwise seen from its head
    core : radius within which the vorticity is spread, in scene units
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


def filament_integrals(grid: Grid, curves: Sequence[tuple[ArrayLike, float]], core: float) -> np.ndarray:
    """(e,) integrals of :func:`filament_velocity` along the edges of a 3D grid, by Gauss's rule of four points."""
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


def surrounding_grid(low: np.ndarray, high: np.ndarray, resolution: int) -> Grid:
    """A grid around filaments between two corners, (3,), with ``resolution`` nodes along its longest side."""
    margin = _MARGIN * (high - low).max()
    return box_grid(low - margin, high + margin, resolution)


@dataclass(frozen=True)
class FilamentCurves:
    """Vortex filaments in space, and the flow that they induce.

    Attributes
    ----------
    name : of their source
    curves : pairs of points and circulation, as in :func:`filament_velocity`
    core : radius over which their vorticity is spread, in cells of the grid
    warnings, noise : none
    """

    name: str
    curves: tuple[tuple[np.ndarray, float], ...]
    core: float
    warnings: tuple[str, ...] = ()
    noise = None

    def read(self) -> "FilamentCurves":
        """The flow, which needs no reading."""
        return self

    def grid(self, resolution: int) -> Grid:
        """A grid around the curves with ``resolution`` nodes along its longest side."""
        points = np.concatenate([points for points, _ in self.curves])
        return surrounding_grid(points.min(axis=0), points.max(axis=0), resolution)

    def integrals(self, grid: Grid) -> np.ndarray:
        """(e,) integrals of the velocity along the grid's edges."""
        return filament_integrals(grid, self.curves, self.core * grid.spacing[0])
