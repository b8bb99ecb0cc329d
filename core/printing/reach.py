# SPDX-License-Identifier: GPL-3.0-or-later
"""Which way the tool stands, and whether it meets what has been printed before."""

import numpy as np
from scipy.spatial import cKDTree

from ..graphs import pairs_within
from ..unit_vectors import unit_vectors
from .machine import Machine

# Places that are looked at together.
_BATCH = 1024
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
        tree = cKDTree(points[obstacles])
        for part in np.array_split(waiting, max(1, len(waiting) // _BATCH)):
            which, other = pairs_within(tree, points[part], np.minimum(reaches[part], reach))
            other = obstacles[other]
            earlier = other < part[which]
            which, other = which[earlier], other[earlier]
            offsets = points[other] - points[part[which]]
            above = np.einsum("kx,kx->k", offsets, axes[part[which]])
            aside = np.linalg.norm(offsets - above[:, None] * axes[part[which]], axis=1)
            wide = machine.nozzle_radius + above * widens
            hit = (above > slack) & (above <= length) & (aside < wide)
            # Of several assignments the last one stays: the one that was printed first.
            order = np.argsort(-other[hit], kind="stable")
            met[part[which[hit]][order]] = other[hit][order]
        waiting = waiting[(met[waiting] < 0) & (reaches[waiting] > reach)]
    return met


def _thin_points(points: np.ndarray, size: float) -> np.ndarray:
    """The first of the points in each cube of a size."""
    cubes = np.floor((points - points.min(axis=0)) / size).astype(int) if len(points) else np.zeros((0, 3), int)
    return np.unique(cubes, axis=0, return_index=True)[1]
