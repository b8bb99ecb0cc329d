# SPDX-License-Identifier: GPL-3.0-or-later
"""Prepares a pattern for tracing: no vertex lies on a line, and disclination triangles are split at their centres."""

from dataclasses import dataclass, replace

import numpy as np

from ...geometry import TriangleMesh
from ...interpolate import EdgePhases, disclination_centres, dislocation_numbers
from ...matchings import after_turns
from .levels import GRID, Levels

# Phases nearer to a line than this are moved off it, in units of pi.
ASIDE = 1e-7
# A vertex counts as the centre of a disclination if its phases differ by less than this, in units of pi.
SAME = 1e-5


@dataclass(frozen=True)
class PreparedPattern:
    """The mesh with its disclination triangles split at their centres, phases in units of pi.

    Attributes
    ----------
    mesh, phases : the mesh, centres after the given vertices, and phases on it
    parents : (m,) given triangle that each triangle is, or is a third of
    places : (m, 3, 3) barycentric coordinates of its corners in the parent
    fans : (m,) which third of its parent, -1 for whole triangles; the centre is the last corner of a third
    first_centre : the lowest vertex that is a centre
    turns : (c,) sum of the matchings around each centre (:meth:`EdgePhases.around`)
    """

    mesh: TriangleMesh
    phases: EdgePhases
    parents: np.ndarray
    places: np.ndarray
    fans: np.ndarray
    first_centre: int
    turns: np.ndarray


def move_off_lines(edge_phases: EdgePhases, levels: Levels = GRID, lines_outside: bool = True) -> EdgePhases:
    """Phases in units of pi, moved off the lines; lines on the boundary move all outside, or all inside."""
    mesh = edge_phases.mesh
    arguments, changes = edge_phases.arguments / np.pi, edge_phases.changes / np.pi
    i, j = mesh.edges.T
    inward = np.zeros_like(arguments)
    np.add.at(inward, i, changes)
    np.add.at(inward, j, -after_turns(changes, edge_phases.matchings))
    _look_across_lines(inward, edge_phases)
    nearest = levels.nearest(arguments)
    upward = (inward < 0) != lines_outside
    moved = np.where(np.abs(arguments - nearest) < ASIDE, nearest + np.where(upward, ASIDE, -ASIDE), arguments)
    by = moved - arguments
    changes = changes + after_turns(by[j], -edge_phases.matchings) - by[i]
    return EdgePhases(mesh, moved, changes, edge_phases.matchings)


def _look_across_lines(inward: np.ndarray, edge_phases: EdgePhases) -> None:
    """Where a phase is constant along a boundary edge, set its inward change (n, k) to the one across that triangle.

    At a concave corner of the boundary a vertex has neighbours on both sides of its lines, and their sum says little.
    """
    mesh = edge_phases.mesh
    half = np.flatnonzero(mesh.twins < 0)
    tails, heads, across = (mesh.triangles[half // 3, (half + k) % 3] for k in range(3))
    for ends, others in ((tails, heads), (heads, tails)):
        along, _ = edge_phases.between(ends, others)
        stays = np.abs(along) < np.pi * ASIDE
        inward[ends] = np.where(stays, edge_phases.between(ends, across)[0], inward[ends])


def prepare_pattern(phases: EdgePhases) -> PreparedPattern:
    """Split the triangles with a disclination at their centres; phases in units of pi.

    The phases have one value at such a centre, which all its turned copies share; the changes from the corners to it
    follow.
    """
    mesh = phases.mesh
    _, is_singular = dislocation_numbers(in_radians(phases), mesh.triangles)
    singular = np.flatnonzero(is_singular)
    centres = mesh.vertex_count + np.arange(len(singular))
    corners = mesh.triangles[singular]
    thirds = np.stack([corners, np.roll(corners, -1, axis=1), np.repeat(centres[:, None], 3, axis=1)], axis=2)
    whole = np.flatnonzero(~is_singular)
    split = TriangleMesh(
        np.concatenate([mesh.vertices, mesh.vertices[corners].mean(axis=1)]),
        np.concatenate([mesh.triangles[whole], thirds.reshape(-1, 3)]),
    )
    # The edges between given vertices keep their changes and matchings.
    changes, matched = np.zeros((len(split.edges), phases.phase_count)), np.zeros(len(split.edges), int)
    old = split.edges[:, 1] < mesh.vertex_count
    source = mesh.edges_between(*split.edges[old].T)
    changes[old], matched[old] = phases.changes[source], phases.matchings[source]
    # Changes from each corner to the centre, of the phases as the corner numbers them.
    values, turns = in_radians(phases).around(corners)
    at_centre = disclination_centres(values, turns) / np.pi
    turned = np.zeros(len(corners), int)  # matchings from the first corner to corner k
    for k in range(3):
        inwards = after_turns(at_centre - values[:, k] / np.pi, turned)
        changes[split.edges_between(corners[:, k], centres)] = inwards
        turned = turned + phases.between(corners[:, k], corners[:, (k + 1) % 3])[1]
    arguments = np.concatenate([phases.arguments, np.zeros((len(centres), phases.phase_count))])
    return PreparedPattern(
        split,
        EdgePhases(split, arguments, changes, matched),
        np.concatenate([whole, np.repeat(singular, 3)]),
        np.concatenate([np.tile(np.eye(3), (len(whole), 1, 1)), _places_of_thirds(values, at_centre)]),
        np.concatenate([np.full(len(whole), -1), np.tile(np.arange(3), len(singular))]),
        mesh.vertex_count,
        turns,
    )


def _places_of_thirds(values: np.ndarray, at_centre: np.ndarray) -> np.ndarray:
    """(3 c, 3, 3) barycentric coordinates of the thirds' corners; a centre is the triangle's middle, or a vertex."""
    apart = np.abs(values[:, :3] / np.pi - at_centre[:, None]).max(axis=2)
    nearest = apart.argmin(axis=1)
    at_vertex = apart[np.arange(len(apart)), nearest] < SAME
    centres = np.where(at_vertex[:, None], np.eye(3)[nearest], 1 / 3)
    first, second = (np.broadcast_to(np.roll(np.eye(3), -k, axis=0), (len(centres), 3, 3)) for k in range(2))
    return np.stack([first, second, np.repeat(centres[:, None], 3, axis=1)], axis=2).reshape(-1, 3, 3)


def in_radians(phases: EdgePhases) -> EdgePhases:
    """Convert phases in half turns to radians."""
    return replace(phases, arguments=np.pi * phases.arguments, changes=np.pi * phases.changes)
