# SPDX-License-Identifier: GPL-3.0-or-later
"""Disclinations of a pattern moved to the triangles in which their centres lie.

Around a disclination the phases come back turned about a point, its centre, a crossing of grid lines. The triangle in
which directions have it need not contain that point: seen from there, a side of the triangle passes the centre on its
wrong side, and quads would fold. The disclination then belongs beyond that side, whose phases are taken to go on around
the triangle's other two sides instead. Only those of index 1/4 are moved: around one of -1/4 a side may well be seen at
more than half a turn.
"""

from dataclasses import replace

import numpy as np

from ....interpolate import disclination_centres, dislocation_numbers
from ....matchings import after_turns

# Double areas in squares of pi that a third of the triangle may be turned over by: a centre on its rim stays.
FOLD = 1e-3
# How often phases turn on around a disclination of index 1/4 (:meth:`EdgePhases.around`).
POSITIVE = 3
# Triangles that a disclination passes at most.
FARTHEST = 30
# Phases this near to a line, in radians, are on it; a line along a side is not to be cut.
ON_LINE = 1e-5


def relocate_disclinations(edge_phases):
    """The same :class:`EdgePhases` but for changes and matchings of edges that disclinations have passed."""
    mesh = edge_phases.mesh
    _, torn = dislocation_numbers(edge_phases, mesh.triangles)
    waiting = np.flatnonzero(torn)
    been = [{int(triangle)} for triangle in waiting]
    for _ in range(FARTHEST):
        if len(waiting) == 0:
            break
        _, torn = dislocation_numbers(edge_phases, mesh.triangles)
        sides = _wrong_sides(edge_phases, waiting)
        beyond = mesh.twins[3 * waiting + np.maximum(sides, 0)]
        goes = (sides >= 0) & (beyond >= 0)
        goes[goes] &= ~torn[beyond[goes] // 3] & ~_along_line(edge_phases, waiting[goes], sides[goes])
        # One after the other: two of them may want to go to the same triangle.
        moved, place, taken = [], [], set()
        for k in np.flatnonzero(goes).tolist():
            there = int(beyond[k]) // 3
            if there not in been[k] and there not in taken:
                taken.add(there)
                been[k].add(there)
                moved.append(k)
                place.append(there)
        edge_phases = _phases_around(edge_phases, waiting[moved], sides[moved])
        waiting, been = np.array(place, int), [been[k] for k in moved]
    return edge_phases


def _wrong_sides(edge_phases, triangles):
    """(k,) side of triangles with a disclination of 1/4 that passes the centre on its wrong side, -1 for none."""
    values, turns = edge_phases.around(edge_phases.mesh.triangles[triangles])
    places = values - disclination_centres(values, turns)[:, None]
    areas = places[:, :3, 0] * places[:, 1:, 1] - places[:, :3, 1] * places[:, 1:, 0]
    worst = areas.argmin(axis=1)
    return np.where((turns == POSITIVE) & (areas[np.arange(len(worst)), worst] < -FOLD * np.pi**2), worst, -1)


def _ends(mesh, triangles, sides):
    """Vertices at the beginning and end of sides, and the one across."""
    corners = mesh.triangles[triangles]
    rows = np.arange(len(triangles))
    return (corners[rows, (sides + k) % 3] for k in range(3))


def _along_line(edge_phases, triangles, sides):
    """(k,) bool: whether a grid line runs along a side."""
    tails, heads, _ = _ends(edge_phases.mesh, triangles, sides)
    change, _ = edge_phases.between(tails, heads)
    phase = edge_phases.arguments[tails] / np.pi
    return ((np.abs(change) < ON_LINE) & (np.abs(phase - np.rint(phase)) < ON_LINE)).any(axis=1)


def _phases_around(edge_phases, triangles, sides):
    """The phases along sides as they are on the way around the rest of their triangles."""
    tails, heads, across = _ends(edge_phases.mesh, triangles, sides)
    first, turns = edge_phases.between(tails, across)
    second, rest = edge_phases.between(across, heads)
    change, matched = first + after_turns(second, -turns), turns + rest
    forward = tails < heads
    edges = edge_phases.mesh.edges_between(tails, heads)
    changes, matchings = edge_phases.changes.copy(), edge_phases.matchings.copy()
    changes[edges] = np.where(forward[:, None], change, -after_turns(change, matched))
    matchings[edges] = np.where(forward, matched, -matched) % (2 * edge_phases.phase_count)
    return replace(edge_phases, changes=changes, matchings=matchings)
