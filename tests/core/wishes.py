# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Wishes that several tests ask for."""

from synch_fields.core.fields import DirectionWishes, Row, boundary_line
from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.fields.guidance import curvature_guide


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
