# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Wishes that several tests ask for."""

import numpy as np

from synch_fields.core.fields import DirectionWishes, Row, boundary_line, given_directions, line_of_edges
from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.fields.guidance.guides import curvature_guide


def boundary_row(mesh, kind="along", vertices=None, value=0.0):
    return Row(boundary_line(mesh, vertices), kind, value)


def on_boundary(mesh, kind="along", vertices=None):
    """Directions along or across the boundary."""
    return DirectionWishes(rows=(boundary_row(mesh, kind, vertices),))


def along_curvature(mesh, largest=True):
    return DirectionWishes(guides=((curvature_guide(mesh, largest), 1.0),))


def bordered_problem(mesh, symmetry):
    """Directions that run along the boundary."""
    return direction_problem(mesh, symmetry, on_boundary(mesh))


SPACING = 0.2


def chain(mesh, vertices):
    """The line over all edges with both ends in a mask."""
    return line_of_edges(mesh, np.flatnonzero(vertices[mesh.edges].all(axis=1)))


def along(mesh, vector, symmetry=2, seed=None):
    """A constant field; with a seed, lines whose representatives point either way."""
    vectors = np.tile(np.array(vector, float), (mesh.vertex_count, 1))
    if seed is not None:
        vectors *= np.random.default_rng(seed).choice([-1, 1], mesh.vertex_count)[:, None]
    return given_directions(mesh, symmetry, vectors)


def cosines(pattern):
    return np.cos(np.angle(pattern.solution.phases))
