# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Distances along surfaces: exact for straight fronts, along the surface and not through space, nan where none are."""

import numpy as np
import pytest

from synch_fields.core.fields.guidance.fronts import front_distance

from .meshes import icosphere, square, together


def test_straight_fronts_are_exact():
    mesh = square(9, 7)
    x = mesh.vertices[:, 0]
    found = front_distance(mesh, x == x.min())
    np.testing.assert_allclose(found, x - x.min(), atol=1e-12)


def test_it_follows_the_surface():
    mesh = icosphere(4)
    start = np.argmax(mesh.vertices[:, 2])
    found = front_distance(mesh, np.arange(mesh.vertex_count) == start)
    angles = np.arccos(np.clip(mesh.vertices @ mesh.vertices[start], -1, 1))
    assert found[start] == 0
    np.testing.assert_allclose(found, angles, atol=1.5 * mesh.edge_lengths.mean())
    assert np.abs(found - angles).mean() < 0.04
    assert (found >= 2 * np.sin(angles / 2) - 1e-9).all()


def test_pieces_without_a_source_are_not_reached():
    one = icosphere(1)
    both = together(one, one)
    found = front_distance(both, np.arange(both.vertex_count) == 0)
    assert np.isfinite(found[: one.vertex_count]).all() and np.isnan(found[one.vertex_count :]).all()
    assert found[: one.vertex_count].max() == pytest.approx(np.pi, rel=0.2)
