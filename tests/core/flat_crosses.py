# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Crosses on flat domains with their quad patterns in closed form, and sheets exchanged by hand (Eq. 7)."""

import numpy as np
from scipy.spatial import Delaunay

from synch_fields.core.fields import DirectionField, given_directions
from synch_fields.core.fields.target_one_form import TargetOneForm
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.interpolate import EdgePhases


def random_turns(mesh, seed=0):
    """(n,) quarter turns."""
    return np.random.default_rng(seed).integers(0, 4, mesh.vertex_count)


def plane_crosses(mesh, degrees=0.0, seed=0):
    """A constant cross in the plane, of which a vertex knows any of the four directions; and (n,) angles of those."""
    angles = np.radians(degrees) + np.pi / 2 * random_turns(mesh, seed)
    return given_directions(mesh, 4, np.column_stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))])), angles


def turned_crosses(field, turns):
    """The same crosses, of which the vertices know the direction that is (n,) quarter turns further on."""
    return DirectionField(field.mesh, 4, field.angles + np.pi / 2 * turns)


def turned_phases(phases, turns):
    """(n, 2) complex phases in sheets that are (n,) quarter turns further on: (x, y) -> (y, conj x) for each."""
    x, y = phases.T
    sheets = np.array([[x, y], [y, x.conj()], [x.conj(), y.conj()], [y.conj(), x]])
    return sheets[turns % 4, :, np.arange(len(turns))]


def plane_waves(angles, spacing, points):
    """(n, 2) radians at points in the plane, for the phases of crosses at (n,) angles: they grow at a quarter turn
    and at half a turn from there, once around in the length of a spacing, from the origin."""
    growing = angles[:, None] + np.pi / 2 * np.array([1, 2])
    along = np.cos(growing) * points[:, :1] + np.sin(growing) * points[:, 1:2]
    return 2 * np.pi / spacing * along


def plane_edge_phases(mesh, degrees, spacing, origin=(0.0, 0.0, 0.0), seed=0):
    """The exact quad pattern of a constant cross in the plane, with a vertex of its grid at the origin."""
    field, angles = plane_crosses(mesh, degrees, seed)
    phases = np.exp(1j * plane_waves(angles, spacing, mesh.vertices - origin))
    return TargetOneForm.of(mesh, field, spacing).edge_phases(phases.ravel())


def random_edge_phases(mesh, field, spacing, seed=0):
    """Random phases, whose triangles are full of dislocations of both phases."""
    growth = TargetOneForm.of(mesh, field, spacing)
    phases = np.exp(1j * np.random.default_rng(seed).uniform(-np.pi, np.pi, len(growth.masses)))
    return growth.edge_phases(phases)


def products(phases):
    """(n,) cos x cos y of complex phases, two a vertex."""
    return phases.reshape(-1, 2).real.prod(axis=1)


def cone(quadrants, cells=3.4, rings=9, side=None, seed=0):
    """The exact grid on a cone made of quarters of the plane: phases walked by hand on a disk, with a vertex of the
    grid at the tip, in a triangle near the middle, and about ``cells`` cells from there to the rim.

    Around a disclination of index 1/4 are three quadrants, around one of -1/4 five. With a ``side`` (0, 1, 2) the
    disclination is not in the triangle of the tip but in the one on that side of it: the edge between them is taken
    to pass the tip on the other side.
    """
    random = np.random.default_rng(seed)
    sizes = 5 * np.arange(rings) + 1
    radius = np.repeat(np.arange(rings) / (rings - 1), sizes)
    angle = np.concatenate([2 * np.pi / s * (np.arange(s) + 0.5 * k) for k, s in enumerate(sizes)])
    points = radius * np.exp(1j * angle)
    points += 0.15 / rings * (radius < 1) * np.exp(1j * random.uniform(0, 2 * np.pi, len(points)))
    mesh = TriangleMesh(np.column_stack([points.real, points.imag, 0 * radius]), _triangulated(points))
    home = int(np.abs(points[mesh.triangles].mean(axis=1)).argmin())
    tip = points[mesh.triangles[home]] @ random.dirichlet([4, 4, 4])
    radius, angle = np.abs(points - tip), np.angle(points - tip)
    i, j = mesh.edges.T
    around = np.round((angle[j] - angle[i]) / (2 * np.pi))
    if side is not None:
        edge = mesh.triangle_edges[home, side]
        passed = angle[j[edge]] - angle[i[edge]] - 2 * np.pi * around[edge]
        around[edge] += np.sign(passed)
    unrolled = np.pi * cells * radius * np.exp(0.25j * quadrants * angle)
    step = np.pi * cells * radius[j] * np.exp(0.25j * quadrants * (angle[j] - 2 * np.pi * around)) - unrolled[i]
    # (x, y) -> (y, -x) is a product with -i; beyond the start of the angles a vertex knows other phases.
    turns = random_turns(mesh, seed)
    sheets = (-1j) ** turns
    as_pairs = [np.column_stack([z.real, z.imag]) for z in (sheets * unrolled, sheets[i] * step)]
    return EdgePhases(mesh, *as_pairs, (turns[j] - turns[i] - quadrants * around.astype(int)) % 4)


def _triangulated(points):
    return Delaunay(np.column_stack([points.real, points.imag])).simplices


def random_crosses(mesh, seed=0):
    """Crosses full of disclinations of all indices."""
    return given_directions(mesh, 4, np.random.default_rng(seed).standard_normal((mesh.vertex_count, 3)))
