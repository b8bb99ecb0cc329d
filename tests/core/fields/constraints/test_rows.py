# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows of the constraint list on flat and rotationally symmetric shapes, in closed form."""

import numpy as np
import pytest

from synch_fields.core.errors import ContradictionError, SettingError
from synch_fields.core.fields import DirectionWishes, Row, direction_field, stripe_pattern
from synch_fields.core.fields.constraints.lines import line_of_group, line_of_points
from synch_fields.core.fields.guidance.guides import distance_guide
from synch_fields.core.fields.patterns import PatternWishes, pattern_problem
from synch_fields.core.solve import Options

from ...direction_wishes import SPACING, along, boundary_row, chain, cosines
from ...meshes import annulus, disk, square


def strip(stripes, columns=30, symmetry=2, seed=0):
    """A rectangle as wide as a number of stripes, stripes along its short sides, and masks of these."""
    mesh = square(columns, 10, width=SPACING * stripes, height=0.5)
    x = mesh.vertices[:, 0]
    return mesh, along(mesh, (0, 1, 0), symmetry, seed), x < 1e-9, x > x.max() - 1e-9


# Directions


@pytest.mark.parametrize("symmetry", [1, 2, 4])
@pytest.mark.parametrize(("kind", "degrees"), [("along", 0), ("across", 90), ("angle", 30), ("angle", -75)])
def test_a_straight_line_sets_the_direction_of_a_plane(symmetry, kind, degrees):
    mesh = square(8)
    row = Row(chain(mesh, np.abs(mesh.vertices[:, 1] - 0.5) < 1e-9), kind, np.radians(degrees))
    field = direction_field(mesh, symmetry, DirectionWishes(rows=(row,)))
    assert field.solution.energy < 1e-12
    angles = np.arctan2(field.vectors[:, 1], field.vectors[:, 0])
    # A chain runs either way: for vectors one of two, the same all along.
    turns = (angles - np.radians(degrees)) * symmetry
    expected = np.exp(1j * turns[0]).round()
    assert expected == 1 or (symmetry == 1 and expected == -1)
    np.testing.assert_allclose(np.exp(1j * turns), expected, atol=1e-9)


def test_a_ring_inside_runs_one_way():
    mesh = annulus(1.0, 3.0, rings=4, segments=40)
    radius = np.linalg.norm(mesh.vertices, axis=1)
    line = chain(mesh, np.abs(radius - 2) < 1e-9)
    field = direction_field(mesh, 1, DirectionWishes(rows=(Row(line, "along"),)))
    around = np.cross([0, 0, 1], mesh.vertices) / radius[:, None]
    turning = np.einsum("ij,ij->i", field.vectors, around)
    np.testing.assert_allclose(turning, turning[0].round(), atol=1e-6)


def test_a_boundary_runs_with_the_face_on_its_left():
    mesh = disk(5, 24)
    line = boundary_row(mesh).line
    x, y = mesh.tangent_frames
    vectors = np.cos(line.angles)[:, None] * x[line.vertices] + np.sin(line.angles)[:, None] * y[line.vertices]
    around = np.cross([0, 0, 1], mesh.vertices[line.vertices])
    assert np.einsum("ij,ij->i", vectors, around).min() > 0.9


def test_a_soft_direction_goes_from_free_to_fixed():
    mesh = square(10)
    x = mesh.vertices[:, 0]
    left, right = Row(chain(mesh, x == 0), "along"), chain(mesh, x == 1)

    def misfit(weight):
        rows = (left, Row(right, "angle", np.pi / 3, weight))
        field = direction_field(mesh, 2, DirectionWishes(rows=rows), Options(target_gap=1e-5))
        wished = np.exp(2j * (np.pi / 2 + np.pi / 3))
        powers = np.exp(2j * np.arctan2(field.vectors[:, 1], field.vectors[:, 0]))
        return float((np.abs(powers - wished)[x == 1] ** 2).mean())

    misfits = [misfit(weight) for weight in (0, 0.1, 0.5, 2, 10, 100, 1e4)]
    assert misfits[0] == pytest.approx(abs(np.exp(2j * np.pi / 3) - 1) ** 2, rel=1e-6)  # free: all along the left side
    assert (np.diff(misfits) < 0).all()
    assert misfits[-1] < 1e-6
    # The quasi-harmonic turn by a = 2 pi / 3 - t costs a^2 (height over width 1), the penalty 2 w (1 - cos t).
    turns = np.linspace(0, 2 * np.pi / 3, 20001)
    for weight, found in ((0.5, misfits[2]), (2, misfits[3]), (10, misfits[4])):
        costs = (2 * np.pi / 3 - turns) ** 2 + weight * 2 * (1 - np.cos(turns))
        assert found == pytest.approx(2 * (1 - np.cos(turns[np.argmin(costs)])), rel=0.02)


@pytest.mark.parametrize("scale", [1.0, 50.0])
@pytest.mark.parametrize("columns", [8, 16, 32])
def test_a_weight_means_the_same_at_every_resolution_and_scale(columns, scale):
    mesh = square(columns, width=scale, height=scale)
    x = mesh.vertices[:, 0] / scale
    rows = (Row(chain(mesh, x < 1e-9), "along"), Row(chain(mesh, x > 1 - 1e-9), "angle", np.pi / 3, 2.0))
    field = direction_field(mesh, 2, DirectionWishes(rows=rows), Options(target_gap=1e-5))
    powers = np.exp(2j * np.arctan2(field.vectors[:, 1], field.vectors[:, 0]))
    found = np.angle(powers[x > 1 - 1e-9].mean() / powers[x < 1e-9].mean())
    turns = np.linspace(0, 2 * np.pi / 3, 20001)
    expected = turns[np.argmin(turns**2 + 4 * (1 - np.cos(2 * np.pi / 3 - turns)))]
    assert abs(found) == pytest.approx(expected, rel=3e-3)


# Phases


@pytest.mark.parametrize("symmetry", [1, 2])
@pytest.mark.parametrize("degrees", [0, 90, 180, 40])
def test_a_fixed_phase_shifts_the_stripes(symmetry, degrees):
    mesh, field, left, _ = strip(5.0, symmetry=symmetry, seed=3 if symmetry == 2 else None)
    value = np.radians(degrees)
    pattern = stripe_pattern(mesh, field, SPACING, [Row(chain(mesh, left), "phase", value)])
    assert pattern.solution.energy < 1e-12
    # The left side is a boundary and runs with the face on its left: lines grow inwards, vectors to their own left.
    growth = 1 if symmetry == 2 else -1
    expected = np.cos(value + growth * 2 * np.pi / SPACING * mesh.vertices[:, 0])
    np.testing.assert_allclose(cosines(pattern), expected, atol=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_a_phase_constant_along_each_side_is_free_on_it(seed):
    mesh, field, left, right = strip(5.3, seed=seed)
    both = Row(chain(mesh, left | right), "constant")
    pattern = stripe_pattern(mesh, field, SPACING, [both])
    assert pattern.solution.energy < 1e-12
    for side in (left, right):
        np.testing.assert_allclose(cosines(pattern)[side], cosines(pattern)[side][0], atol=1e-12)
    # One side fixed, the other follows at its distance; both fixed to what does not fit costs energy.
    fixed = Row(chain(mesh, left), "phase", 0.4)
    pattern = stripe_pattern(mesh, field, SPACING, [both, fixed])
    assert pattern.solution.energy < 1e-12
    np.testing.assert_allclose(cosines(pattern)[left], np.cos(0.4), atol=1e-12)
    np.testing.assert_allclose(cosines(pattern)[right], np.cos(0.4 + 2 * np.pi * 5.3), atol=1e-9)


@pytest.mark.parametrize("symmetry", [1, 2])
@pytest.mark.parametrize("spacing", [0.25, 0.11])
def test_rings_of_a_disk_with_a_hole_whose_rim_is_fixed(symmetry, spacing):
    mesh = annulus(0.2, 1.0, 24, 96)
    radius = np.linalg.norm(mesh.vertices, axis=1)
    rim = radius > 1 - 1e-9
    guide = distance_guide(mesh, rim, contour=True)
    field = direction_field(mesh, symmetry, DirectionWishes(guides=((guide, 1e3),)))
    pattern = stripe_pattern(mesh, field, spacing, [boundary_row(mesh, "phase", rim)])
    np.testing.assert_allclose(pattern.solution.phases[rim], 1, atol=1e-9)
    for ring in np.unique(radius.round(9)):
        values = cosines(pattern)[np.abs(radius - ring) < 1e-6]
        np.testing.assert_allclose(values, values[0], atol=1e-6)
    np.testing.assert_allclose(cosines(pattern), np.cos(2 * np.pi * (1 - radius) / spacing), atol=1e-3)


def test_rings_of_a_whole_disk():
    """The centre, where no direction is like the others, bends the rings around it a little."""
    mesh = disk(24, 96)
    radius = np.linalg.norm(mesh.vertices, axis=1)
    guide = distance_guide(mesh, radius > 1 - 1e-9, contour=True)
    field = direction_field(mesh, 2, DirectionWishes(guides=((guide, 1e4),)))
    pattern = stripe_pattern(mesh, field, 0.25, [boundary_row(mesh, "phase")])
    assert pattern.dislocations == [] and sum(d.index for d in field.disclinations) == 1
    outside = radius > 0.2
    np.testing.assert_allclose(cosines(pattern)[outside], np.cos(2 * np.pi * (1 - radius[outside]) / 0.25), atol=0.1)


def test_a_soft_phase_goes_from_free_to_fixed():
    mesh, field, left, right = strip(5.25)

    def misfit(weight):
        rows = [Row(chain(mesh, left), "phase"), Row(chain(mesh, right), "phase", 0.0, weight)]
        pattern = stripe_pattern(mesh, field, SPACING, rows, options=Options(target_gap=1e-5))
        return float((np.abs(pattern.solution.phases - 1)[right] ** 2).mean())

    misfits = [misfit(weight) for weight in (0, 0.05, 0.3, 2, 20, 1e4)]
    assert misfits[0] == pytest.approx(2, rel=1e-6)  # a quarter turn
    assert (np.diff(misfits) < 0).all() and misfits[-1] < 1e-6


def test_groups_of_points_edges_and_areas():
    mesh = square(8)
    x, y, _ = mesh.vertices.T
    field = along(mesh, (0, 1, 0))
    corner = (x == 0) & (y == 0)
    pattern = stripe_pattern(mesh, field, SPACING, [Row(line_of_group(mesh, corner), "phase", 0.3)])
    assert pattern.solution.energy < 1e-12
    assert pattern.solution.phases[corner][0] == pytest.approx(np.exp(0.3j))
    area = (x <= 0.5) & (y <= 0.5)
    line = line_of_group(mesh, area)
    np.testing.assert_array_equal(line.nodes, np.flatnonzero(area))
    assert np.unique(line.pieces).size == 1
    # The outline is a line of length 2, of which directions hold; the inside is an area of a quarter.
    assert line.node_lengths.sum() == pytest.approx(2 + 0.25)
    assert np.isnan(line.angles).sum() == area.sum()
    scattered = corner | ((x == 1) & (y == 1))
    assert len(np.unique(line_of_group(mesh, scattered).pieces)) == 2


@pytest.mark.parametrize(("kind", "degrees"), [("along", 0), ("across", 90), ("angle", 30)])
@pytest.mark.parametrize("weight", [None, 1e5])
def test_directions_hold_on_the_outline_of_an_area(kind, degrees, weight):
    mesh = square(8)
    row = Row(line_of_group(mesh, mesh.vertices[:, 1] <= 0.25), kind, np.radians(degrees), weight)
    field = direction_field(mesh, 4, DirectionWishes(rows=(row,)))
    angles = np.arctan2(field.vectors[:, 1], field.vectors[:, 0])
    on_line = np.isclose(mesh.vertices[:, 1], 0.25) & (np.abs(mesh.vertices[:, 0] - 0.5) < 0.4)
    expected = np.exp(4j * np.radians(degrees))
    np.testing.assert_allclose(np.exp(4j * angles[on_line]), expected, atol=1e-6 if weight is None else 1e-2)


def test_phases_at_points_leave_directions_alone():
    mesh = square(6)
    left = mesh.vertices[:, 0] == 0
    slanting = Row(chain(mesh, left), "angle", np.radians(30))
    points = Row(line_of_points(mesh, np.flatnonzero(left)), "phase")
    alone, both = (direction_field(mesh, 2, DirectionWishes(rows=rows)) for rows in ((slanting,), (slanting, points)))
    np.testing.assert_allclose(np.exp(2j * both.angles), np.exp(2j * alone.angles), atol=1e-9)


@pytest.mark.parametrize("kind", ["phase", "constant"])
def test_areas_do_not_depend_on_the_signs_of_a_line_field(kind):
    mesh = square(12)
    area = (np.abs(mesh.vertices[:, :2] - 0.5) < 0.2).all(axis=1)
    row = Row(line_of_group(mesh, area), kind, 2.2)
    energies = [
        stripe_pattern(mesh, along(mesh, (0.2, 1, 0), 2, seed), SPACING, [row]).solution.energy for seed in range(4)
    ]
    np.testing.assert_allclose(energies, energies[0], rtol=1e-2)


def test_phases_given_at_points_are_kept_in_the_sheet_of_their_vertex():
    mesh = square(10)
    field = along(mesh, (0, 1, 0), 2, seed=4)
    wave = np.random.default_rng(0).uniform(-3, 3, mesh.vertex_count)
    nodes = np.arange(0, mesh.vertex_count, 3)
    row = Row(line_of_points(mesh, nodes), "phase", wave[nodes])
    pattern = stripe_pattern(mesh, field, SPACING, [row])
    np.testing.assert_allclose(pattern.solution.phases[nodes], np.exp(1j * wave[nodes]), atol=1e-9)


# Contradictions and meetings


def test_along_and_across_on_the_same_edges_are_named():
    mesh = square(6)
    line = chain(mesh, mesh.vertices[:, 0] == 0)
    rows = (Row(line, "along", name="row A"), Row(line, "across", name="row B"))
    with pytest.raises(
        ContradictionError, match="row A and row B ask for different directions at vertices 0, 1, 2"
    ) as error:
        direction_field(mesh, 2, DirectionWishes(rows=rows))
    np.testing.assert_array_equal(error.value.vertices, line.nodes)
    direction_field(mesh, 4, DirectionWishes(rows=rows))  # a cross runs along and across


def test_lines_that_meet_at_an_angle_leave_the_corner_free():
    mesh = square(6)
    x, y, _ = mesh.vertices.T
    rows = (Row(chain(mesh, x == 0), "along"), Row(chain(mesh, y == 0), "along"))
    field = direction_field(mesh, 2, DirectionWishes(rows=rows))
    np.testing.assert_allclose(np.abs(field.vectors[(x == 0) & (y > 0), 1]), 1, atol=1e-9)
    np.testing.assert_allclose(np.abs(field.vectors[(y == 0) & (x > 0), 0]), 1, atol=1e-9)


def test_two_phases_at_one_vertex_are_named():
    mesh = square(6)
    x, y, _ = mesh.vertices.T
    rows = [Row(chain(mesh, x == 0), "phase", 0.0, name="row A"), Row(chain(mesh, y == 0), "phase", 1.0, name="row B")]
    with pytest.raises(ContradictionError, match="row A and row B fix vertex 0 to different phases") as error:
        pattern_problem(mesh, along(mesh, (0, 1, 0), 1), PatternWishes(SPACING, rows))
    np.testing.assert_array_equal(error.value.vertices, [0])


def test_a_constant_line_between_two_phases_is_refused():
    mesh = square(6)
    x, y, _ = mesh.vertices.T
    field = along(mesh, (0, 1, 0), 1)
    ends = [Row(line_of_group(mesh, (x == 0) & (y == side)), "phase", float(side)) for side in (0, 1)]
    line = Row(chain(mesh, x == 0), "constant", name="row C")
    with pytest.raises(ContradictionError, match="row C joins vertices 0, 6, for which different values") as error:
        pattern_problem(mesh, field, PatternWishes(SPACING, [*ends, line]))
    np.testing.assert_array_equal(error.value.vertices, [0, 6])


def test_constant_lines_that_cross_have_one_phase():
    mesh = square(6)
    x, y, _ = mesh.vertices.T
    rows = [Row(chain(mesh, mask), "constant") for mask in (x == 0.5, y == 0.5)]
    pattern = stripe_pattern(mesh, along(mesh, (0, 1, 0), 2, seed=1), SPACING, rows)
    values = cosines(pattern)[(x == 0.5) | (y == 0.5)]
    np.testing.assert_allclose(values, values[0], atol=1e-9)
    problem = pattern_problem(mesh, along(mesh, (0, 1, 0), 1), PatternWishes(SPACING, rows))
    assert len(problem.merged.nodes) == 12


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (dict(kind="around"), "'around': use one of along"),
        (dict(value=np.nan), "value of row A is nan"),
        (dict(weight=-1.0), "weight of row A is -1"),
        (dict(kind="constant", weight=1.0), "row A is soft"),
    ],
)
def test_rows_that_say_nothing_are_refused(change, message):
    mesh = square(2)
    arguments = dict(line=boundary_row(mesh).line, kind="along", name="row A") | change
    with pytest.raises(SettingError, match=message):
        Row(**arguments)


@pytest.mark.parametrize("kind", ["along", "phase"])
def test_a_weight_of_zero_is_no_wish(kind):
    mesh = square(6)
    row = Row(chain(mesh, mesh.vertices[:, 0] == 0), kind, weight=0.0)
    field = direction_field(mesh, 2, DirectionWishes(rows=(row,)))
    pattern = stripe_pattern(mesh, field, SPACING, [row] if row.is_of_phases else [])
    assert field.solution.energy < 1e-12 and pattern.solution.energy < 1e-12
    problem = pattern_problem(mesh, field, PatternWishes(SPACING, [row] if row.is_of_phases else []))
    assert len(problem.drawn.nodes) == len(problem.fixed.nodes) == 0
