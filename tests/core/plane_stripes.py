# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Exact stripes in the plane."""

import numpy as np

from synch_fields.core.fields import given_directions
from synch_fields.core.fields.target_one_form import TargetOneForm


def plane_stripes(mesh, degrees, spacing, origin=(0.0, 0.0, 0.0), seed=0):
    """The exact stripes along a constant direction in the plane, of which a vertex knows either sign."""
    angles = np.radians(degrees) + np.pi * np.random.default_rng(seed).integers(0, 2, mesh.vertex_count)
    field = given_directions(mesh, 2, np.column_stack([np.cos(angles), np.sin(angles), 0 * angles]))
    away = mesh.vertices - origin
    waves = 2 * np.pi / spacing * (np.cos(angles) * away[:, 1] - np.sin(angles) * away[:, 0])
    return TargetOneForm.of(mesh, field, spacing).edge_phases(np.exp(1j * waves))
