# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Crosses on flat domains with their quad patterns in closed form, and sheets exchanged by hand (Eq. 7)."""

import numpy as np

from synch_fields.core.fields import DirectionField, given_directions
from synch_fields.core.fields.growth import Growth


def random_turns(mesh, seed=0):
    """(n,) quarter turns."""
    return np.random.default_rng(seed).integers(0, 4, mesh.vertex_count)


def plane_crosses(mesh, degrees=0.0, seed=0):
    """A constant cross in the plane, of which each vertex knows any of the four directions; and (n,) angles of these."""
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
    return Growth.of(mesh, field, spacing).edge_phases(phases.ravel())


def random_edge_phases(mesh, field, spacing, seed=0):
    """Random phases, whose triangles are full of dislocations of both phases."""
    growth = Growth.of(mesh, field, spacing)
    phases = np.exp(1j * np.random.default_rng(seed).uniform(-np.pi, np.pi, len(growth.masses)))
    return growth.edge_phases(phases)


def products(phases):
    """(n,) cos x cos y of complex phases, two a vertex."""
    return phases.reshape(-1, 2).real.prod(axis=1)
