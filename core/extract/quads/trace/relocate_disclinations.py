# SPDX-License-Identifier: GPL-3.0-or-later
"""Moves disclinations of a pattern to the triangles in which their centres lie.

Around a disclination the phases return rotated about its centre, a crossing of grid lines. The triangle with the
disclination of the directions need not contain that point: then one side of the triangle passes the centre on the wrong
side, and quads would fold. The disclination is moved across that side, by replacing the phase changes along the side by
those around the triangle's other two sides. Only disclinations of index 1/4 are moved: around one of -1/4, the angle of
a side seen from the centre may exceed half a turn.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ....geometry import TriangleMesh
from ....interpolate import EdgePhases, disclination_centres, dislocation_numbers
from ....matchings import after_turns

# A third of the triangle may be turned over by this double area, in squares of pi: a centre on the rim stays.
FOLD = 1e-3
# Sum of the matchings around a disclination of index 1/4 (:meth:`EdgePhases.around`).
POSITIVE = 3
# Most triangles that a disclination is moved across.
FARTHEST = 30
# Phases this near to a line, in radians, lie on it; a side along a line is not crossed.
ON_LINE = 1e-5


def relocate_disclinations(edge_phases: EdgePhases) -> EdgePhases:
    """The phases with disclinations relocated, by other changes and matchings on the edges that they cross."""
    mesh = edge_phases.mesh
    _, torn = dislocation_numbers(edge_phases, mesh.triangles)
    waiting = np.flatnonzero(torn)
    visited = [{int(triangle)} for triangle in waiting]
    for _ in range(FARTHEST):
        if len(waiting) == 0:
            break
        _, torn = dislocation_numbers(edge_phases, mesh.triangles)
        sides = _wrong_sides(edge_phases, waiting)
        beyond = mesh.twins[3 * waiting + np.maximum(sides, 0)]
        goes = (sides >= 0) & (beyond >= 0)
        goes[goes] &= ~torn[beyond[goes] // 3] & ~_along_line(edge_phases, waiting[goes], sides[goes])
        # A loop, because two of them may be headed for the same triangle.
        moved: list[int] = []
        places: list[int] = []
        for k in np.flatnonzero(goes).tolist():
            there = int(beyond[k]) // 3
            if there not in visited[k] and there not in places:
                visited[k].add(there)
                moved.append(k)
                places.append(there)
        edge_phases = _phases_around(edge_phases, waiting[moved], sides[moved])
        waiting, visited = np.array(places, int), [visited[k] for k in moved]
    return edge_phases


def _wrong_sides(edge_phases: EdgePhases, triangles: np.ndarray) -> np.ndarray:
    """(k,) side of triangles with a disclination of 1/4 that passes the centre on the wrong side, -1 for none."""
    values, turns = edge_phases.around(edge_phases.mesh.triangles[triangles])
    places = values - disclination_centres(values, turns)[:, None]
    areas = places[:, :3, 0] * places[:, 1:, 1] - places[:, :3, 1] * places[:, 1:, 0]
    worst = areas.argmin(axis=1)
    return np.where((turns == POSITIVE) & (areas[np.arange(len(worst)), worst] < -FOLD * np.pi**2), worst, -1)


def _ends(mesh: TriangleMesh, triangles: np.ndarray, sides: np.ndarray) -> Iterator[np.ndarray]:
    """Vertices at the tails and heads of sides, and those opposite."""
    corners = mesh.triangles[triangles]
    rows = np.arange(len(triangles))
    return (corners[rows, (sides + k) % 3] for k in range(3))


def _along_line(edge_phases: EdgePhases, triangles: np.ndarray, sides: np.ndarray) -> np.ndarray:
    """(k,) bool: whether a grid line runs along a side."""
    tails, heads, _ = _ends(edge_phases.mesh, triangles, sides)
    change, _ = edge_phases.between(tails, heads)
    phase = edge_phases.arguments[tails] / np.pi
    return ((np.abs(change) < ON_LINE) & (np.abs(phase - np.rint(phase)) < ON_LINE)).any(axis=1)


def _phases_around(edge_phases: EdgePhases, triangles: np.ndarray, sides: np.ndarray) -> EdgePhases:
    """The phases with the changes along sides replaced by those around the other two sides of their triangles."""
    tails, heads, across = _ends(edge_phases.mesh, triangles, sides)
    # The change to the third corner and the change from there to the head. At the third corner, phases may be exchanged
    # or reversed; turned back, both changes are changes of the tail's phases.
    first, turns = edge_phases.between(tails, across)
    second, rest = edge_phases.between(across, heads)
    change, matched = first + after_turns(second, -turns), turns + rest
    forward = tails < heads
    edges = edge_phases.mesh.edges_between(tails, heads)
    changes, matchings = edge_phases.changes.copy(), edge_phases.matchings.copy()
    changes[edges] = np.where(forward[:, None], change, -after_turns(change, matched))
    matchings[edges] = np.where(forward, matched, -matched) % (2 * edge_phases.phase_count)
    return replace(edge_phases, changes=changes, matchings=matchings)
