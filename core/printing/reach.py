# SPDX-License-Identifier: GPL-3.0-or-later
"""Which way the tool stands, and whether it meets what has been printed before."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Self

import numpy as np

from ..graphs import ragged_arange
from ..unit_vectors import unit_vectors
from .machine import Machine

# Tips per batch.
_BATCH = 512
# Radius of a sphere around a cube, over its side, and a little more for rounding.
_AROUND = (1 + 1e-9) * 3**0.5 / 2
# Of what is farther than this many steps, places that are a step apart will do.
_NEAR, _COARSE = 4.0, 1.0


def tilts(normals: np.ndarray) -> np.ndarray:
    """(n,) degrees between unit normals and upright."""
    return np.degrees(np.arccos(np.clip(normals[:, 2], -1, 1)))


def tool_axes(normals: np.ndarray, machine: Machine) -> np.ndarray:
    """(n, 3) unit vectors from the tip into the tool: upright, or along normals as far as the machine tilts."""
    upright = np.tile([0.0, 0.0, 1.0], (len(normals), 1))
    if not machine.turns:
        return upright
    level = unit_vectors(normals * [1, 1, 0])
    angles = np.radians(np.minimum(tilts(normals), machine.largest_tilt))[:, None]
    return np.cos(angles) * upright + np.sin(angles) * level


def collisions(points: np.ndarray, axes: np.ndarray, machine: Machine, step: float, slack: float) -> np.ndarray:
    """Where a tool meets what it has printed before: inside the cone that widens from its tip upwards.

    Parameters
    ----------
    points, axes : (n, 3) of the tip, in the order in which they are printed, and of the tool
    machine : with lengths in the points' unit
    step : between beads; of what is farther than four of them, places that are one apart are looked at
    slack : the tool does not meet material up to this height above the tip

    Returns (n,) the first place that it meets, -1 where it meets none.
    """
    met = np.full(len(points), -1)
    length, widens = machine.nozzle_length, np.tan(np.radians(machine.nozzle_angle))
    # The cone looks upwards from everywhere: below the highest place so far it may meet something.
    rises = np.maximum.accumulate(points[:, 2]) - points[:, 2]
    upwards = machine.nozzle_angle + (machine.largest_tilt if machine.turns else 0) < 90
    reaches = np.full(len(points), length)
    if not machine.turns:
        # Upright, it meets only what is higher by the slack, and nothing beyond the cone's rim at the highest place.
        reaches = np.minimum(np.hypot(rises, machine.nozzle_radius + rises * widens), length)
    waiting = np.flatnonzero(rises > (0 if machine.turns else slack)) if upwards else np.arange(len(points))
    near = min(_NEAR * step, length)
    everything = np.arange(len(points))
    for obstacles, reach in ((everything, near), (_thin_points(points, _COARSE * step), length)):
        cubes = _Cubes.of(points, obstacles, step)
        first = np.full(len(points), len(points))
        for part in np.array_split(waiting, max(1, len(waiting) // _BATCH)):
            far = np.minimum(reaches[part], reach)
            which, other = cubes.in_cones(points[part], axes[part], part, far, slack, machine)
            offsets = points[other] - points[part[which]]
            above = np.einsum("kx,kx->k", offsets, axes[part[which]])
            aside = np.linalg.norm(offsets - above[:, None] * axes[part[which]], axis=1)
            hit = (above > slack) & (above <= length) & (aside < machine.nozzle_radius + above * widens)
            hit &= np.square(offsets).sum(axis=1) <= far[which] ** 2
            np.minimum.at(first, part[which[hit]], other[hit])
        is_met = first < len(points)
        met[is_met] = first[is_met]
        waiting = waiting[(met[waiting] < 0) & (reaches[waiting] > reach)]
    return met


@dataclass(frozen=True)
class _Cubes:
    """Places in cubes, eight of which are in a cube twice as large, and so on.

    Attributes
    ----------
    levels : of each size of cubes, from the largest on: (c, 3) middles, (c,) smallest numbers of their places, and
        (c + 1,) where the cubes or places inside begin in the next level
    radii : of the spheres around the cubes of each level
    places : (k,) numbers of the places, in the order of the smallest cubes
    """

    levels: list[tuple[np.ndarray, np.ndarray, np.ndarray]]
    radii: list[float]
    places: np.ndarray

    @classmethod
    def of(cls, points: np.ndarray, places: np.ndarray, size: float) -> Self:
        """Cubes of a size, and larger ones, around those of (n, 3) points that have (k,) numbers."""
        low = points.min(axis=0, initial=np.inf)
        cubes = np.floor((points[places] - low) / size).astype(int)
        steps = range(0, max(int(cubes.max(initial=0)).bit_length(), 1))
        rows = [cubes >> step for step in reversed(steps)]
        order = np.lexsort(np.concatenate([row.T for row in rows])[::-1])
        places, rows = places[order], [row[order] for row in rows]
        begins, is_new = [], np.arange(len(places)) == 0
        for row in rows:
            is_new = is_new | np.append(False, (np.diff(row, axis=0) != 0).any(axis=1))[: len(is_new)]
            begins.append(np.flatnonzero(is_new))
        inside = [*(np.searchsorted(below, above) for above, below in pairwise(begins)), begins[-1]]
        counts = [*(len(below) for below in begins[1:]), len(places)]
        sizes = [size * 2**step for step in reversed(steps)]
        levels = [
            (low + wide * (row[begin] + 0.5), np.minimum.reduceat(places, begin), np.append(within, count))
            for wide, row, begin, within, count in zip(sizes, rows, begins, inside, counts, strict=True)
        ]
        radii = [_AROUND * wide for wide in sizes]
        return cls(levels, radii, places) if len(places) else cls([], [], places)

    def in_cones(
        self, tips: np.ndarray, axes: np.ndarray, numbers: np.ndarray, far: np.ndarray, slack: float, machine: Machine
    ) -> tuple[np.ndarray, np.ndarray]:
        """Find pairs of a tip, of (n, 3), and an earlier place, of a number below the tip's (n,) number: all that are
        in the tool's cone, higher than a slack and no farther than (n,) lengths, and some that are near it."""
        angle = np.radians(machine.nozzle_angle)
        which = np.arange(len(tips)) if self.levels else np.zeros(0, int)
        found = np.zeros(len(which), int)
        cubes = np.arange(len(self.levels[0][0])) if self.levels else found
        which, found = np.repeat(which, len(cubes)), np.tile(cubes, len(which))
        for (middles, earliest, begins), radius in zip(self.levels, self.radii, strict=True):
            offsets = middles[found] - tips[which]
            above = np.einsum("kx,kx->k", offsets, axes[which])
            aside = np.linalg.norm(offsets - above[:, None] * axes[which], axis=1)
            over = (aside - machine.nozzle_radius) * np.cos(angle) - above * np.sin(angle)
            near = (earliest[found] < numbers[which]) & (above > slack - radius) & (over < radius)
            near &= np.linalg.norm(offsets, axis=1) < far[which] + radius
            which, found = which[near], found[near]
            counts = begins[found + 1] - begins[found]
            row, place = ragged_arange(counts)
            which, found = which[row], begins[found][row] + place
        found = self.places[found]
        earlier = found < numbers[which]
        return which[earlier], found[earlier]


def _thin_points(points: np.ndarray, size: float) -> np.ndarray:
    """The first of the points in each cube of a size."""
    cubes = np.floor((points - points.min(axis=0)) / size).astype(int) if len(points) else np.zeros((0, 3), int)
    return np.unique(cubes, axis=0, return_index=True)[1]
