# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Clebsch maps: known filaments are found, spheres are covered as often as there is vorticity."""

import re
from dataclasses import replace
from itertools import pairwise, product

import numpy as np
import pytest

from synch_fields.core.errors import Cancelled, SettingError
from synch_fields.core.extract.vortices.filaments import bilinear_zero, filaments, vortices
from synch_fields.core.fields.biot_savart import filament_integrals, filament_velocity
from synch_fields.core.fields.clebsch import circulations, clebsch_map, edge_integrals, quantum_for, spherical_map
from synch_fields.core.geometry.grid import Grid
from synch_fields.core.solve import Options

from ..flows import line_integrals, linking_number, rankine_velocity, ring_curve

BOX = Grid((16, 16, 11), spacing=1 / 15, origin=(-0.5, -0.5, -0.333))


def found_ring(curve, grid=BOX, quantum=2.0):
    return clebsch_map(grid, filament_integrals(grid, [(curve, 2.0)], 0.2 * grid.spacing[0]), quantum)


@pytest.mark.parametrize("normal", [0, 1, 2])
def test_a_ring_of_one_quantum_is_one_filament(normal):
    centre = np.array([0.01, -0.02, 0.013])
    grid = BOX if normal == 2 else Grid((14, 14, 14), spacing=1 / 13, origin=-0.5)
    found = found_ring(ring_curve(0.27, centre, normal), grid)
    assert set(np.unique(found.face_numbers)) == {-1, 0, 1}
    (line,) = filaments(found)
    assert line.is_closed and line.strength == 2.0
    away = line.points - centre
    across = away[:, [(normal + 1) % 3, (normal + 2) % 3]]
    assert np.abs(np.linalg.norm(across, axis=1) - 0.27).max() < 0.5 * grid.spacing[0]
    assert np.abs(away[:, normal]).max() < 0.5 * grid.spacing[0]
    turned = np.angle((across[:, 0] + 1j * across[:, 1]) * np.roll(across[:, 0] - 1j * across[:, 1], 1))
    assert turned.sum() == pytest.approx(2 * np.pi)  # in the direction of its vorticity


def test_a_straight_filament_on_a_grid_that_is_periodic_along_it():
    grid = Grid((17, 17, 8), spacing=1 / 16, origin=(-0.5, -0.5, 0), periodic=(False, False, True))
    found = clebsch_map(grid, line_integrals(grid, [0.03, -0.01]), 1.0)
    (line,) = filaments(found)
    (points,) = line.parts
    np.testing.assert_allclose(points[:, 2], np.arange(9) / 16, atol=1e-12)  # from one side of the period to the other
    assert line.is_closed and line.winding == (0, 0, 1) and not line.is_loop
    assert line.length == pytest.approx(0.5) and len(line.points) == 8
    assert np.abs(points[:, :2] - [0.03, -0.01]).max() < 0.5 / 16 and line.strength == 1.0
    (down,) = filaments(clebsch_map(grid, line_integrals(grid, [0.03, -0.01], -1.0), 1.0))
    np.testing.assert_allclose(down.parts[0][:, 2], np.arange(8, -1, -1) / 16, atol=1e-12)
    assert down.winding == (0, 0, -1)
    assert np.abs(found.face_numbers).sum() == 8


def test_an_open_filament_ends_on_the_boundary():
    grid = Grid((17, 17, 8), spacing=1 / 16, origin=(-0.5, -0.5, 0))
    (line,) = filaments(clebsch_map(grid, line_integrals(grid, [0.03, -0.01]), 1.0))
    assert not line.is_closed
    np.testing.assert_allclose(line.points[[0, -1], 2], [0, 7 / 16], atol=1e-12)  # upwards, as its vorticity


def test_a_ring_across_the_sides_of_a_periodic_grid():
    grid = Grid((12, 12, 10), spacing=1 / 12, periodic=True)
    box = grid.spacing * grid.shape
    centre = np.array([0.03, 0.52, 0.44])
    ring = ring_curve(0.27, centre, 2, segments=48)
    images = [(ring + box * shift, 1.0) for shift in product((-1, 0, 1), repeat=3)]
    found = clebsch_map(grid, filament_integrals(grid, images, 0.01), 1.0)
    assert set(np.unique(found.face_numbers)) == {-1, 0, 1}
    around = found.face_numbers[grid.cell_faces] * grid.outward
    assert not around.sum(axis=1).any()
    (line,) = filaments(found)
    assert line.is_loop and line.winding == (0, 0, 0) and len(line.parts) == 2  # cut where it leaves the box
    for part in line.parts:
        on_side = np.isclose(part[[0, -1], 0][:, None], [0, box[0]], atol=1e-12)
        assert on_side.any(axis=1).all() and (part >= -1e-12).all() and (part <= box + 1e-12).all()
    move = centre - line.points.mean(axis=0)
    assert (np.abs(move - box * np.rint(move / box)) < 0.5 / 12).all()
    away = line.points - line.points.mean(axis=0)  # in one piece
    assert np.abs(np.hypot(away[:, 0], away[:, 1]) - 0.27).max() < 0.5 / 12 and np.abs(away[:, 2]).max() < 0.5 / 12
    assert line.length == pytest.approx(2 * np.pi * 0.27, rel=0.15)
    lengths = sum(np.linalg.norm(np.diff(part, axis=0), axis=1).sum() for part in line.parts)
    assert lengths == pytest.approx(line.length, rel=1e-9)
    (even,) = filaments(found, 5)
    assert even.is_loop and 0.88 * line.length < even.length < line.length


@pytest.mark.parametrize("smoothing", [0, 5])
def test_filaments_that_go_around_a_periodic_box_say_how_often(smoothing):
    """Phases cos-like products of plane waves: their zeros are straight lines whose directions are known."""
    grid = Grid((12, 12, 12), spacing=1 / 12, periodic=True)
    x, y, z = (2 * np.pi * grid.places.T).tolist()
    x, y, z = np.array(x), np.array(y), np.array(z)
    quiet = clebsch_map(grid, np.zeros(len(grid.edges)), 1.0)
    # Zeros where sin(y - x) = 0 and sin(z + 0.3) = 0: four lines along (1, 1, 0), two of them back.
    shown = quiet.with_phases(_unit(np.sin(y - x - 0.2) + 1j * np.sin(z + 0.3)))
    lines = filaments(shown, smoothing)
    assert all(line.is_closed for line in lines)
    assert sorted(line.winding for line in lines) == [(-1, -1, 0)] * 2 + [(1, 1, 0)] * 2
    for line in lines:
        np.testing.assert_allclose(line.shift, line.winding)
        assert line.length == pytest.approx(np.sqrt(2), rel=0.02 if smoothing else 0.12)
        assert (np.concatenate(line.parts) > -0.03).all() and (np.concatenate(line.parts) < 1.03).all()
        ends = line.course[-1] - line.course[0]
        np.testing.assert_allclose(ends, line.shift, atol=1e-12)


def _unit(values):
    return values / np.abs(values)


@pytest.mark.parametrize("core", [0.1, 0.5, 1.0])
def test_vortices_lie_where_they_are_within_their_cells(core):
    """With a wind, and of either sense."""
    grid = Grid((12, 12), spacing=(1.0, 1.2), origin=(-5.5, -6.6))
    space = Grid((12, 12, 2), spacing=(1.0, 1.2, 1.0), origin=(-5.5, -6.6, 0))
    below = (space.edge_axes < 2) & (space.edges[:, 0] % 2 == 0)
    for x, y, circulation in ((-0.4, 0.0, 1), (0.2, 0.3, 1), (0.1, -0.35, -1), (0.4, 0.4, -1)):
        line = np.array([[x, y, -200.0], [x, y, 200.0]])
        integrals = filament_integrals(space, [(line, circulation)], core)[below]
        integrals += 0.05 * (grid.edge_axes == 0)
        _, places, strengths = vortices(clebsch_map(grid, integrals, 1.0))
        np.testing.assert_array_equal(strengths, [circulation])
        assert np.linalg.norm(places[0] - [x, y]) < 0.2


def test_smoothing_does_not_shrink_small_rings():
    grid = Grid((13, 12, 8), origin=(-6, -5.5, -3.4))
    for radius in (1.0, 2.0, 3.0):
        ring = ring_curve(radius, (0.1, 0.05, 0.07), 2)
        found = clebsch_map(grid, filament_integrals(grid, [(ring, 1.0)], 0.3), 1.0)
        (rough,), (even,) = filaments(found), filaments(found, 5)
        radii = [np.hypot(*(line.points - line.points.mean(axis=0))[:, :2].T).mean() for line in (rough, even)]
        assert abs(radii[1] - radii[0]) < 0.1
        assert 0.88 * rough.length < even.length < rough.length


def test_linked_rings_stay_linked():
    grid = Grid((18, 15, 15), spacing=1 / 17, origin=(-0.5, -0.41, -0.41))
    curves = ring_curve(0.22, (-0.11, 0, 0), 2), ring_curve(0.22, (0.11, 0, 0), 1)
    integrals = filament_integrals(grid, [(curve, 1.0) for curve in curves], 0.01)
    lines = filaments(clebsch_map(grid, integrals, 1.0))
    assert len(lines) == 2 and all(line.is_closed for line in lines)
    expected = round(linking_number(*(curve[:-1] for curve in curves)))
    assert abs(expected) == 1
    assert round(linking_number(lines[0].points, lines[1].points)) == expected


def test_a_filament_down_an_axis_counts_as_one_up_it():
    grid = Grid((9, 9, 6), spacing=1 / 8, origin=(-0.5, -0.5, 0))
    up, down = (line_integrals(grid, [0.03, -0.01], circulation) for circulation in (1.0, -1.0))
    assert quantum_for(grid, up, 2) == pytest.approx(0.5) == quantum_for(grid, down, 2)
    (line,) = filaments(clebsch_map(grid, down, 1.0))
    assert line.points[0, 2] > line.points[-1, 2]


def test_filaments_cancel_around_every_cell_for_any_phases():
    found = found_ring(ring_curve())
    random = np.random.default_rng(3)
    noisy = found.with_phases(np.exp(1j * random.uniform(-np.pi, np.pi, BOX.node_count)))
    around = noisy.face_numbers[BOX.cell_faces] * BOX.outward
    assert noisy.face_numbers.any() and not around.sum(axis=1).any()
    lines = filaments(noisy)
    on_side = lambda point: any(  # noqa: E731
        np.isclose(point[a], [BOX.origin[a], BOX.origin[a] + BOX.spacing[a] * (BOX.shape[a] - 1)]).any()
        for a in range(3)
    )
    assert all(line.is_closed or (on_side(line.points[0]) and on_side(line.points[-1])) for line in lines)
    passed = sum(len(line.points) * round(line.strength / 2.0) for line in lines)
    assert passed <= np.abs(noisy.face_numbers).sum()


def test_more_quanta_are_as_many_filaments():
    grid = Grid((20, 20, 12), spacing=1 / 19, origin=(-0.5, -0.5, -0.3))
    integrals = edge_integrals(grid, filament_velocity(grid.places, [(ring_curve(0.25), 4.0)], 0.08))
    for count in (1, 2, 4):
        quantum = quantum_for(grid, integrals, count)
        found = clebsch_map(grid, integrals, quantum)
        through = found.face_numbers[(grid.face_planes == [1, 2]).all(axis=1) & (grid.faces[:, 0] // (20 * 12) == 9)]
        assert np.abs(through[through > 0]).sum() == pytest.approx(count, abs=1)
        assert found.solution.lower_bound <= found.energy


def test_rounding_is_ordered_as_in_figure_5():
    integrals = edge_integrals(BOX, filament_velocity(BOX.places, [(ring_curve(0.3), 6.0)], 0.06))
    energies = [
        clebsch_map(BOX, integrals, 2.0, Options(method=method, rounding=rounding)).energy
        for method, rounding in (("spectral", "svd"), ("sdp", "svd"), ("sdp", "random"), ("sdp", "continuation"))
    ]
    for worse, better in pairwise(energies):
        assert better <= worse * (1 + 1e-8)


# Spherical maps


def rankine(count, shape=60):
    """Rigid rotation inside the unit disk, none outside (Figure 7), cut into a number of quanta."""
    grid = Grid((shape, shape), spacing=4 / (shape - 1), origin=-2)
    velocity = rankine_velocity(np.column_stack([grid.places, np.zeros(grid.node_count)]))[:, :2]
    return clebsch_map(grid, edge_integrals(grid, velocity), np.pi / count)


@pytest.mark.parametrize("count", [2, 4])
def test_the_sphere_is_covered_about_as_often_as_there_are_quanta(count):
    found = rankine(count)
    sphere = spherical_map(found)
    np.testing.assert_allclose(np.linalg.norm(sphere.lifted, axis=1), 1, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(sphere.sphere, axis=1), 1, atol=1e-12)
    assert found.solution.lower_bound * (1 - 1e-9) <= sphere.energy <= found.energy
    assert abs(sphere.face_areas.sum() - count) < 1.2
    _, places, strengths = vortices(found)
    assert (strengths > 0).all() and np.linalg.norm(places, axis=1).max() < 1.2


def test_every_vortex_lies_where_the_sphere_is_seen_from_behind():
    sphere = spherical_map(rankine(4))
    grid = sphere.found.grid
    covered = round(sphere.face_areas.sum())
    for point in ([1, 0, 0], [0, 1, 0], [-1, 1, 1], [0, 0, 1]):
        seen = sphere.seen_from(point)
        punctured = np.flatnonzero(seen.face_numbers)
        assert 0 <= covered - len(punctured) <= 1  # the flow leaves through the sides: the sphere is not covered evenly
        facing = sphere.sphere[grid.faces[punctured]].mean(axis=1) @ (np.array(point) / np.linalg.norm(point))
        assert (facing < -0.9).all()


def test_the_sphere_takes_no_more_time_than_the_limit_leaves_nor_than_the_gap_needs():
    found = rankine(4)
    sphere = spherical_map(found)
    fine = spherical_map(replace(found, options=Options(target_gap=1e-4)))
    # Of starts that go less far another one may look best.
    assert fine.energy <= sphere.energy <= 1.02 * fine.energy
    late = spherical_map(replace(found, options=Options(time_limit=1e-3)))  # which the map has taken
    first = found.solution.lifted[:, :2]
    np.testing.assert_allclose(late.lifted, first / np.linalg.norm(first, axis=1)[:, None], atol=1e-12)
    assert late.energy > sphere.energy and late.seconds < sphere.seconds


def test_a_rough_sphere_is_nearly_as_good_and_shows_the_same_vortices():
    found = rankine(4)
    rough, fine = spherical_map(found, is_rough=True), spherical_map(found)
    assert found.solution.lower_bound * (1 - 1e-6) <= rough.energy <= 1.02 * fine.energy
    np.testing.assert_allclose(np.linalg.norm(rough.lifted, axis=1), 1, atol=1e-12)
    for point in ([1, 0, 0], [0, 0, 1]):
        counts = [np.abs(sphere.seen_from(point).face_numbers).sum() for sphere in (rough, fine)]
        assert abs(counts[0] - counts[1]) <= 1 and min(counts) >= 2


def test_a_projection_is_that_of_the_lifted_rows():
    sphere = spherical_map(rankine(2, 20))
    seen = sphere.seen_from([0, 0, 1])
    np.testing.assert_allclose(seen.phases, sphere.lifted[:, 0] / np.abs(sphere.lifted[:, 0]), atol=1e-12)
    seen = sphere.seen_from([0, 0, -1])
    turn = seen.phases / (sphere.lifted[:, 1] / np.abs(sphere.lifted[:, 1]))
    np.testing.assert_allclose(turn, turn[0], atol=1e-9)


# Parts


def test_circulations_are_the_vorticity_of_rigid_rotation():
    grid = Grid((7, 9), spacing=(0.5, 0.25), origin=(-1, 2))
    velocity = np.column_stack([-grid.places[:, 1], grid.places[:, 0]])
    np.testing.assert_allclose(circulations(grid, edge_integrals(grid, velocity)), 2 * 0.5 * 0.25, atol=1e-12)


def test_zeros_of_bilinear_functions():
    random = np.random.default_rng(0)
    s, t = random.random((2, 200))
    ends = random.standard_normal((200, 3)) + 1j * random.standard_normal((200, 3))
    # The fourth corner makes the function vanish at (s, t).
    fourth = -((1 - s) * (1 - t) * ends[:, 0] + s * (1 - t) * ends[:, 1] + s * t * ends[:, 2]) / ((1 - s) * t)
    values = np.column_stack([ends, fourth])
    x, y = bilinear_zero(values)
    at = (
        (1 - x) * (1 - y) * values[:, 0]
        + x * (1 - y) * values[:, 1]
        + x * y * values[:, 2]
        + (1 - x) * y * values[:, 3]
    )
    assert np.abs(at).max() < 1e-8
    np.testing.assert_array_equal(bilinear_zero(np.ones((1, 4), complex)), [[0.5], [0.5]])


def test_filaments_too_weak_for_the_grid_are_refused_with_a_circulation_that_fits():
    """One per cent of a quantum would make millions of them, which no phase at the nodes tells apart."""
    integrals = filament_integrals(BOX, [(ring_curve(0.6), 2.0)], BOX.spacing[0])
    with pytest.raises(SettingError, match=r"too many for the grid, [\d.e+]+ for each of its faces") as caught:
        clebsch_map(BOX, integrals, 1e-6)
    fitting = float(re.search("circulation from ([0-9.e-]+) on", str(caught.value))[1])
    assert 0.48 < np.abs(circulations(BOX, integrals)).mean() / fitting <= 0.5
    assert filaments(clebsch_map(BOX, integrals, fitting, Options(method="spectral")))


def test_what_is_no_flow_is_refused():
    grid = Grid((5, 5, 5))
    with pytest.raises(SettingError, match="one vector a node"):
        edge_integrals(grid, np.zeros((125, 2)))
    velocity = np.zeros((125, 3))
    with pytest.raises(SettingError, match="no vorticity"):
        quantum_for(grid, edge_integrals(grid, velocity), 3)
    with pytest.raises(SettingError, match="circulation of a filament is 0"):
        clebsch_map(grid, np.zeros(len(grid.edges)), 0.0)
    velocity[[31, 40]] = np.nan
    with pytest.raises(SettingError, match=r"node \(1, 1, 1\) \(2 in all\) is not a number"):
        edge_integrals(grid, velocity)
    with pytest.raises(Cancelled):
        clebsch_map(BOX, np.ones(len(BOX.edges)), 1.0, callback=lambda stage, fraction: False)


def test_the_flow_around_a_ring_is_known_on_its_axis():
    points = np.column_stack([np.zeros((5, 2)), np.linspace(-1, 1, 5)])
    velocity = filament_velocity(points, [(ring_curve(0.4, segments=600), 3.0)], 1e-6)
    expected = 3.0 * 0.4**2 / (2 * (0.4**2 + points[:, 2] ** 2) ** 1.5)
    np.testing.assert_allclose(velocity, np.column_stack([np.zeros((5, 2)), expected]), atol=1e-4)


def test_segments_need_not_be_short():
    random = np.random.default_rng(4)
    places, corners = random.uniform(-1, 1, (40, 3)), random.uniform(-1, 1, (4, 3))
    places[:8] = corners[0] + np.linspace(0, 1, 8)[:, None] * (corners[1] - corners[0])  # on the filament itself
    shares = np.sort(random.random((3, 30)), axis=1)[:, :, None]
    parts = [(1 - t) * p + t * q for t, p, q in zip(shares, corners, corners[1:], strict=False)]
    finer = np.concatenate([part for k in range(3) for part in (corners[k : k + 1], parts[k])] + [corners[3:]])
    velocity = filament_velocity(places, [(corners, 2.0)], 0.1)
    np.testing.assert_allclose(filament_velocity(places, [(finer, 2.0)], 0.1), velocity, rtol=0, atol=1e-12)
    assert np.abs(velocity).max() > 0.5
    line = np.array([[0, 0, -1e4], [0, 0, 1e4]])
    at = np.column_stack([np.full(5, 0.1), np.zeros(5), np.linspace(-5, 5, 5)])
    expected = 3.0 / (2 * np.pi) * 0.1 / (0.1**2 + 0.02**2)
    np.testing.assert_allclose(
        filament_velocity(at, [(line, 3.0)], 0.02), np.tile([0, expected, 0], (5, 1)), atol=1e-3 * expected
    )


def test_the_circulation_along_a_loop_is_that_of_the_filament_through_it():
    integrals = filament_integrals(BOX, [(ring_curve(0.27), 2.0)], 1e-3)
    corner = BOX.places[BOX.faces[:, 0]]
    half = (BOX.face_planes == [1, 2]).all(axis=1) & (corner[:, 1] > 0)
    for layer in np.unique(corner[half & (np.abs(corner[:, 0]) < 0.05), 0]):
        through = circulations(BOX, integrals)[half & np.isclose(corner[:, 0], layer)]
        assert through.sum() == pytest.approx(-2.0, abs=0.25)
