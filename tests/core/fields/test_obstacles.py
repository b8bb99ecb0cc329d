# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Flows around obstacles: the phase goes around them without a filament, and filaments end at them."""

import numpy as np
import pytest

from synch_fields.core.extract.vortices.filaments import filaments
from synch_fields.core.extract.vortices.tubes import vortex_tubes
from synch_fields.core.fields.biot_savart import filament_integrals
from synch_fields.core.fields.clebsch import clebsch_map, mean_circulation, spherical_map
from synch_fields.core.geometry.grid import Grid
from synch_fields.core.geometry.squares import grid_squares

from ..flows import line_integrals

SHAPE, SPACING, ORIGIN = (17, 17, 9), 1 / 16, (-0.5, -0.5, 0.0)
PLAIN = Grid(SHAPE, SPACING, ORIGIN)
LINE = np.array([0.03, -0.01])


def with_obstacle(chosen, grid=PLAIN):
    """The grid with an obstacle at the nodes whose places are chosen."""
    solid = chosen(*grid.places.T).reshape(grid.shape)
    return Grid(grid.shape, grid.spacing, grid.origin, grid.periodic, solid)


def pillar(x, y, z):
    return np.hypot(x, y) < 0.2


@pytest.mark.parametrize("circulation", [2.0, -1.0])
def test_around_a_pillar_whole_quanta_need_no_filament(circulation):
    """No vorticity but in the pillar: without it the same flow has filaments there."""
    grid = with_obstacle(pillar)
    integrals = line_integrals(grid, LINE, circulation)
    found = clebsch_map(grid, integrals, 1.0)
    assert filaments(found) == [] and found.solution.energy < 1e-9 * found.problem.connection.weights.sum()
    assert mean_circulation(grid, integrals) < 1e-12
    # Around a loop of nodes about the pillar the phase turns as often as there are quanta.
    loop = [(4, k) for k in range(4, 12)] + [(k, 12) for k in range(4, 12)]
    loop += [(12, k) for k in range(12, 4, -1)] + [(k, 4) for k in range(12, 4, -1)]
    phases = found.phases[[grid.numbers[i, j, 3] for i, j in loop]]
    turned = np.angle(np.roll(phases, -1) / phases).sum() / (2 * np.pi)
    assert abs(turned) == pytest.approx(abs(circulation))
    assert sum(abs(line.strength) for line in filaments(clebsch_map(PLAIN, integrals, 1.0))) == abs(circulation)


def test_half_a_quantum_around_a_pillar_cannot_be_kept():
    grid = with_obstacle(pillar)
    found = clebsch_map(grid, line_integrals(grid, LINE, 0.5), 1.0)
    assert found.solution.lower_bound > 0.1 and found.energy >= found.solution.lower_bound


def test_below_a_lid_the_map_is_that_of_the_smaller_grid():
    lid = PLAIN.shape[2] - 3
    grid = with_obstacle(lambda x, y, z: z > (lid - 0.5) * SPACING)
    smaller = Grid((*SHAPE[:2], lid), SPACING, ORIGIN)
    found, expected = (clebsch_map(g, line_integrals(g, LINE), 1.0) for g in (grid, smaller))
    assert found.energy == pytest.approx(expected.energy, rel=1e-4)
    (line,), (other,) = filaments(found), filaments(expected)
    np.testing.assert_allclose(line.points, other.points, atol=1e-3)
    assert line.points[-1, 2] == pytest.approx((lid - 1) * SPACING)


def test_a_filament_ends_at_an_obstacle_and_goes_on_behind_it():
    """A plate across the line: two pieces, from the floor to the plate, and from the plate to the lid."""
    grid = with_obstacle(lambda x, y, z: np.isclose(z, 4 * SPACING) & (np.hypot(x, y) < 0.3))
    found = clebsch_map(grid, line_integrals(grid, LINE), 1.0)
    lines = sorted(filaments(found), key=lambda line: line.points[0, 2])
    assert [line.is_closed for line in lines] == [False, False]
    ends = [(line.points[0, 2] / SPACING, line.points[-1, 2] / SPACING) for line in lines]
    np.testing.assert_allclose(ends, [(0, 3), (5, 8)], atol=1e-9)
    for line in lines:
        assert np.abs(line.points[:, :2] - LINE).max() < 0.5 * SPACING


def test_tubes_keep_out_of_obstacles():
    grid = with_obstacle(lambda x, y, z: np.isclose(z, 4 * SPACING) & (np.hypot(x, y) < 0.3))
    axis = np.array([[0.03, -0.01, -3.0], [0.03, -0.01, 3.0]])
    found = clebsch_map(grid, filament_integrals(grid, [(axis, 4.0)], 3 * SPACING), 1.0)
    tubes = vortex_tubes(spherical_map(found), None, 60.0, 0)
    assert len(tubes.triangles)
    heights = tubes.vertices[np.hypot(*tubes.vertices[:, :2].T) < 0.15, 2] / SPACING
    assert len(heights) and not ((heights > 3 + 1e-9) & (heights < 5 - 1e-9)).any()


def test_an_obstacle_in_a_plane_is_a_hole_of_its_mesh():
    solid = np.zeros((5, 6), bool)
    solid[2, 3] = True
    squares = grid_squares(Grid((5, 6), solid=solid))
    assert len(squares.polygons.starts) == 20 - 4
    assert not (squares.polygons.corner_vertices == 2 * 6 + 3).any()
    assert squares.mesh.euler_characteristic == 0  # a ring
