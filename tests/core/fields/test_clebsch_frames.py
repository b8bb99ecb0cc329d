# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Clebsch maps of a flow that moves: filaments follow, for less work, and nothing turns that need not."""

from contextlib import contextmanager
from itertools import pairwise

import numpy as np
import pytest

from synch_fields.core.algebra.products import SharedRows
from synch_fields.core.extract.vortices.filaments import filaments
from synch_fields.core.fields.biot_savart import filament_velocity
from synch_fields.core.fields.clebsch import clebsch_map, edge_integrals, spherical_map
from synch_fields.core.fields.clebsch_frames import advance_phases, potential, solve_next_map, solve_next_sphere
from synch_fields.core.geometry.grid import Grid
from synch_fields.core.solve import Options

from ..flows import ring_curve

GRID = Grid((24, 24, 18), spacing=1 / 23, origin=(-0.5, -0.5, -0.37))
OPTIONS = Options(target_gap=0.03)
FRAMES = [(-0.1 + 0.05 * k, 0.25 + 0.01 * k) for k in range(2)]


def integrals(height, radius):
    """Of a ring, about a cell higher in each frame."""
    curve = ring_curve(radius, (0.01, 0.0, height))
    return edge_integrals(GRID, filament_velocity(GRID.places, [(curve, 2.0)], 0.07))


@contextmanager
def counted_products():
    """A list that gets the numbers multiplied in sparse products: on all levels, by metrics, and while rounding."""
    work, multiply = [], SharedRows.__matmul__

    def counting(matrix, columns):
        work.append(matrix.matrix.nnz * (columns.size // len(columns)))
        return multiply(matrix, columns)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(SharedRows, "__matmul__", counting)
        yield work


@pytest.fixture(scope="module")
def frames():
    """The frames one after the other, and each by itself, with the work that each took."""
    first = clebsch_map(GRID, integrals(*FRAMES[0]), 1.0, OPTIONS)
    warm, cold = [(first, 0)], []
    for frame in FRAMES[1:]:
        with counted_products() as work:
            warm.append((solve_next_map(warm[-1][0], integrals(*frame), OPTIONS), sum(work)))
        with counted_products() as work:
            cold.append((clebsch_map(GRID, integrals(*frame), 1.0, OPTIONS), sum(work)))
    return warm, cold


def test_the_filament_follows_a_moving_ring(frames):
    for (found, _), (height, radius) in zip(frames[0], FRAMES, strict=True):
        (line,) = filaments(found)
        assert line.is_closed and line.strength == 1.0
        away = line.points - [0.01, 0, height]
        assert np.abs(away[:, 2]).max() < 0.75 * GRID.spacing[0]
        assert np.linalg.norm(away[:, :2], axis=1).mean() == pytest.approx(radius, abs=0.5 * GRID.spacing[0])


def test_a_frame_from_the_one_before_takes_fewer_products_and_is_as_good(frames):
    warm, cold = frames
    for (found, work), (alone, work_alone) in zip(warm[1:], cold, strict=True):
        assert 0 < work < 0.7 * work_alone
        assert found.solution.lower_bound <= found.energy <= 1.05 * alone.energy


@pytest.mark.parametrize("periodic", [(False, False, False), (True, False, True), (True, True, True)])
def test_the_potential_is_the_least_squares_one(periodic):
    grid = Grid((5, 6, 4), (0.1, 0.2, 0.3), periodic=periodic)
    random = np.random.default_rng(1)
    given = random.normal(size=len(grid.edges))
    i, j = grid.edges.T
    slopes = np.zeros((len(given), grid.node_count))
    slopes[np.arange(len(given)), j], slopes[np.arange(len(given)), i] = 1, -1
    roots = np.sqrt(grid.weights)
    best, *_ = np.linalg.lstsq(roots[:, None] * slopes, roots * given, rcond=None)
    np.testing.assert_allclose(slopes @ potential(grid, given), slopes @ best, atol=1e-12)


def test_a_wind_without_vorticity_changes_neither_filaments_nor_the_sphere(frames):
    first = frames[0][0][0]
    wind = edge_integrals(GRID, np.tile([7.0, -3.0, 2.0], (GRID.node_count, 1)))
    with counted_products() as work:
        blown = solve_next_map(first, first.integrals + wind, OPTIONS)
    assert sum(work) < frames[0][1][1]
    np.testing.assert_array_equal(blown.face_numbers, first.face_numbers)
    assert blown.energy == pytest.approx(first.energy, rel=1e-3)
    before = spherical_map(first)
    np.testing.assert_allclose(solve_next_sphere(before, blown).sphere, before.sphere, atol=0.02)


def test_phases_are_turned_to_those_before(frames):
    for (before, _), (found, _) in pairwise(frames[0]):
        agreement = np.vdot(before.phases * advance_phases(before, found.integrals), found.phases)
        assert agreement.real > 0 and abs(agreement.imag) < 1e-9 * abs(agreement)


def test_the_sphere_hardly_moves_where_the_flow_does_not(frames):
    (first, _), (second, _) = frames[0][:2]
    before = spherical_map(first)
    same = solve_next_sphere(before, first)
    np.testing.assert_allclose(same.sphere, before.sphere, atol=0.02)
    assert same.energy <= before.energy * (1 + 1e-6)
    turned = type(before)(first, before.lifted @ np.array([[0.6, 0.8], [-0.8, 0.6]]), before.energy, 0.0)
    assert np.abs(turned.sphere - before.sphere).max() > 0.5
    np.testing.assert_allclose(solve_next_sphere(turned, first).sphere, turned.sphere, atol=0.02)
    moved = solve_next_sphere(before, second)
    assert second.solution.lower_bound * (1 - 1e-6) <= moved.energy <= second.energy
    change = np.linalg.norm(moved.sphere - before.sphere, axis=1)
    apart = np.linalg.norm(spherical_map(second).sphere - before.sphere, axis=1)
    assert change.mean() < 0.3 and change.mean() <= apart.mean() + 0.01
