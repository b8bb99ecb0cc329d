# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Clebsch maps of a flow that moves: filaments follow, for less work, and nothing turns that need not."""

from itertools import pairwise

import numpy as np
import pytest

from synch_fields.core.extract.filaments import filaments
from synch_fields.core.fields.biot_savart import filament_velocity
from synch_fields.core.fields.clebsch import clebsch_map, edge_integrals, spherical_map
from synch_fields.core.fields.clebsch_frames import following_map, following_sphere
from synch_fields.core.geometry.grid import Grid
from synch_fields.core.solve import Options

from .flows import ring_curve

GRID = Grid((20, 20, 16), spacing=1 / 19, origin=(-0.5, -0.5, -0.39))
OPTIONS = Options(target_gap=0.03)
FRAMES = [(-0.1 + 0.05 * k, 0.25 + 0.01 * k) for k in range(4)]


def integrals(height, radius):
    """Of a ring, about a cell higher in each frame."""
    curve = ring_curve(radius, (0.01, 0.0, height))
    return edge_integrals(GRID, filament_velocity(GRID.places, [(curve, 2.0)], 0.07))


@pytest.fixture(scope="module")
def frames():
    """The frames one after the other, and each by itself."""
    first = clebsch_map(GRID, integrals(*FRAMES[0]), 1.0, OPTIONS)
    warm, cold = [first], []
    for frame in FRAMES[1:]:
        warm.append(following_map(warm[-1], integrals(*frame), OPTIONS))
        cold.append(clebsch_map(GRID, integrals(*frame), 1.0, OPTIONS))
    return warm, cold


def test_the_filament_follows_a_moving_ring(frames):
    for found, (height, radius) in zip(frames[0], FRAMES, strict=True):
        (line,) = filaments(found)
        assert line.is_closed and line.strength == 1.0
        away = line.points - [0.01, 0, height]
        assert np.abs(away[:, 2]).max() < 0.75 * GRID.spacing[0]
        assert np.linalg.norm(away[:, :2], axis=1).mean() == pytest.approx(radius, abs=0.5 * GRID.spacing[0])


def test_a_frame_from_the_one_before_takes_fewer_products_and_is_as_good(frames):
    warm, cold = frames
    for found, alone in zip(warm[1:], cold, strict=True):
        assert found.solution.products < alone.solution.products
        assert found.energy <= 1.02 * alone.energy
        assert found.solution.sdp_value <= found.energy


def test_phases_are_turned_to_those_before(frames):
    warm, _ = frames
    for before, found in pairwise(warm):
        agreement = np.vdot(before.phases, found.phases)
        assert agreement.real > 0 and abs(agreement.imag) < 1e-9 * abs(agreement)


def test_the_sphere_hardly_moves_where_the_flow_does_not(frames):
    first, second = frames[0][:2]
    before = spherical_map(first)
    same = following_sphere(before, first)
    np.testing.assert_allclose(same.sphere, before.sphere, atol=0.02)
    assert same.energy <= before.energy * (1 + 1e-6)
    turned = type(before)(first, before.lifted @ np.array([[0.6, 0.8], [-0.8, 0.6]]), before.energy)
    assert np.abs(turned.sphere - before.sphere).max() > 0.5
    np.testing.assert_allclose(following_sphere(turned, first).sphere, turned.sphere, atol=0.02)
    moved = following_sphere(before, second)
    assert second.solution.lower_bound * (1 - 1e-6) <= moved.energy <= second.energy
    change = np.linalg.norm(moved.sphere - before.sphere, axis=1)
    apart = np.linalg.norm(spherical_map(second).sphere - before.sphere, axis=1)
    assert change.mean() < 0.3 and change.mean() <= apart.mean() + 0.01
