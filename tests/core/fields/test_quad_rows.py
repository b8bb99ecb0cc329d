# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Phases of quads along boundaries and chains, in closed form on rectangles; mirrored quads."""

from itertools import product

import numpy as np
import pytest

from synch_fields.core.connection import circle_transports
from synch_fields.core.errors import ContradictionError
from synch_fields.core.fields import (
    DirectionWishes,
    Row,
    direction_field,
    given_directions,
    line_of_edges,
    quad_pattern,
)
from synch_fields.core.fields.constraints.lines import line_of_group, line_of_points
from synch_fields.core.fields.mirror import Mirror
from synch_fields.core.fields.patterns import PatternWishes, pattern_problem
from synch_fields.core.fields.target_one_form import TargetOneForm
from synch_fields.core.geometry.mirror import mirrored_vertices
from synch_fields.core.problem import Merged, Targets
from synch_fields.core.solve import Options, solve

from ..direction_wishes import boundary_row, chain
from ..flat_crosses import plane_crosses, products
from ..graphs import brute_force
from ..meshes import annulus, bent_square, grid_quads, polygon_mesh, square, square_points

TIGHT = Options(target_gap=1e-5)
# Sides of the unit square and the way in from there.
SIDES = {"left": (0, 0, (1, 0)), "right": (0, 1, (-1, 0)), "bottom": (1, 0, (0, 1)), "top": (1, 1, (0, -1))}


def on_side(mesh, name):
    axis, place, _ = SIDES[name]
    return np.abs(mesh.vertices[:, axis] - place) < 1e-9


def phases_towards(pattern, angles, way):
    """(n,) complex phase that grows most in a direction of the plane, in the sheet in which it does."""
    growing = angles[:, None] + np.pi / 2 * np.array([1, 2])
    rise = np.cos(growing) * way[0] + np.sin(growing) * way[1]
    own = np.abs(rise).argmax(axis=1)
    here = np.arange(len(angles)), own
    phases = pattern.solution.phases.reshape(-1, 2)[here]
    return np.where(rise[here] < 0, phases.conj(), phases)


def steps(mesh, axis, columns):
    """(e,) columns or rows that edges of a square span."""
    return np.rint(mesh.edge_vectors[:, axis] * columns)


# Fixed phases


@pytest.mark.parametrize("value", [0.0, np.pi / 2, np.pi, 2.0, -1.0])
@pytest.mark.parametrize("spacing", [0.24, 1 / 5.7])
def test_a_phase_on_the_whole_boundary_stretches_the_grid_evenly(spacing, value):
    """It grows inwards from every side: between two sides there is room for whole periods less value / pi."""
    columns = 14
    mesh = square(columns)
    field, angles = plane_crosses(mesh)
    pattern = quad_pattern(mesh, field, spacing, [boundary_row(mesh, "phase", value=value)], options=TIGHT)
    for name, (_, _, way) in SIDES.items():
        held = phases_towards(pattern, angles, way)[on_side(mesh, name)]
        np.testing.assert_allclose(held, np.exp(1j * value), atol=1e-9)
    whole = np.rint(1 / spacing + value / np.pi)
    missing = 2 * np.pi * (1 / spacing - (whole - value / np.pi)) / columns
    expected = sum((mesh.weights * 4 * np.sin(missing * steps(mesh, axis, columns) / 2) ** 2).sum() for axis in (0, 1))
    assert pattern.solution.energy == pytest.approx(expected, rel=1e-6, abs=1e-12)
    assert pattern.solution.lower_bound == pytest.approx(expected, rel=2e-5, abs=1e-12)
    waves = value + 2 * np.pi * (whole - value / np.pi) * mesh.vertices[:, :2]
    np.testing.assert_allclose(products(pattern.solution.phases), np.cos(waves).prod(axis=1), atol=1e-4)


def test_corners_have_both_phases_and_other_vertices_one():
    mesh = square(8)
    problem = pattern_problem(
        mesh, plane_crosses(mesh)[0], PatternWishes(0.25, [boundary_row(mesh, "phase", value=0.4)])
    )
    fixed = np.bincount(problem.fixed.nodes // 2, minlength=mesh.vertex_count)
    sides = sum(on_side(mesh, name).astype(int) for name in SIDES)
    np.testing.assert_array_equal(fixed, sides)
    assert sorted(np.unique(fixed)) == [0, 1, 2] and (fixed == 2).sum() == 4
    assert len(problem.merged.nodes) == len(problem.drawn.nodes) == 0


def test_sides_that_meet_may_have_different_phases():
    """No contradiction for crosses: the corner has one of each."""
    mesh = square(10)
    field, _ = plane_crosses(mesh)
    rows = [
        boundary_row(mesh, "phase", on_side(mesh, "left"), 0.3),
        boundary_row(mesh, "phase", on_side(mesh, "bottom"), 1.2),
    ]
    pattern = quad_pattern(mesh, field, 0.31, rows)
    assert pattern.solution.energy < 1e-12
    x, y, _ = 2 * np.pi / 0.31 * mesh.vertices.T
    np.testing.assert_allclose(products(pattern.solution.phases), np.cos(0.3 + x) * np.cos(1.2 + y), atol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_a_phase_along_a_chain_inside(seed):
    mesh = square(10)
    field, angles = plane_crosses(mesh, seed=seed)
    line = chain(mesh, np.abs(mesh.vertices[:, 0] - 0.5) < 1e-9)
    pattern = quad_pattern(mesh, field, 0.31, [Row(line, "phase", 0.9)])
    assert pattern.solution.energy < 1e-12
    assert len(pattern_problem(mesh, field, PatternWishes(0.31, [Row(line, "phase", 0.9)])).fixed.nodes) == 11
    along_x = phases_towards(pattern, angles, (1, 0))
    offset = np.angle(along_x[line.nodes[0]])
    assert abs(offset) == pytest.approx(0.9)  # it grows to the left of a chain that may run either way
    expected = np.exp(1j * (offset + 2 * np.pi / 0.31 * (mesh.vertices[:, 0] - 0.5)))
    np.testing.assert_allclose(along_x, expected, atol=1e-6)


def test_a_point_has_both_phases():
    mesh = square(8)
    field, _ = plane_crosses(mesh)
    values = np.array([0.5, -1.0, 2.0])
    nodes = np.array([3, 40, 77])
    pattern = quad_pattern(mesh, field, 0.25, [Row(line_of_points(mesh, nodes), "phase", values)])
    np.testing.assert_allclose(
        pattern.solution.phases.reshape(-1, 2)[nodes], np.exp(1j * values)[:, None].repeat(2, 1), atol=1e-9
    )


def test_phases_on_both_rims_of_a_ring_draw_circles():
    mesh = annulus(0.5, 1.5, rings=12, segments=72)
    radius = np.linalg.norm(mesh.vertices, axis=1)
    row = boundary_row(mesh, "phase")
    field = direction_field(mesh, 4, DirectionWishes(rows=(row,)))  # the row asks for its direction, too
    pattern = quad_pattern(mesh, field, 0.25, [row])
    rim = mesh.boundary_vertices
    closest = np.abs(pattern.solution.phases.reshape(-1, 2) - 1).min(axis=1)
    np.testing.assert_allclose(closest[rim], 0, atol=1e-9)
    rings = np.cos(2 * np.pi / 0.25 * radius)
    misses = np.abs(np.cos(pattern.vertex_phases) - rings[:, None]).min(axis=1)
    assert misses.max() < 0.05
    assert pattern.solution.lower_bound > 1  # spokes at even distances must fork or stretch


def test_a_soft_phase_goes_from_free_to_fixed():
    mesh = square(12)
    field, angles = plane_crosses(mesh)
    hard = boundary_row(mesh, "phase", on_side(mesh, "left"))

    def misfit(weight):
        soft = Row(boundary_row(mesh, "phase", on_side(mesh, "right")).line, "phase", 0.0, weight)
        pattern = quad_pattern(mesh, field, 1 / 4.25, [hard, soft], options=TIGHT)
        held = phases_towards(pattern, angles, (-1, 0))[on_side(mesh, "right")]
        left = phases_towards(pattern, angles, (1, 0))[on_side(mesh, "left")]
        np.testing.assert_allclose(left, 1, atol=1e-9)
        return float((np.abs(held - 1) ** 2).mean())

    misfits = [misfit(weight) for weight in (0, 0.1, 1, 10, 1e4)]
    assert misfits[0] == pytest.approx(2, rel=1e-6)  # a quarter turn
    assert (np.diff(misfits) < 0).all() and misfits[-1] < 1e-6
    # Stretching by a over a square costs a^2, the side 2 w (1 - cos(pi / 2 - a)) over its length of 1.
    turns = np.linspace(0, np.pi / 2, 20001)
    for weight, found in ((0.1, misfits[1]), (1, misfits[2]), (10, misfits[3])):
        stretch = turns[np.argmin(turns**2 + 2 * weight * (1 - np.cos(np.pi / 2 - turns)))]
        assert found == pytest.approx(2 * (1 - np.cos(np.pi / 2 - stretch)), rel=0.02)


# Constant phases


@pytest.mark.parametrize("seed", range(3))
def test_a_phase_constant_along_each_side_is_free_on_it(seed):
    mesh = square(10)
    field, angles = plane_crosses(mesh, seed=seed)
    pattern = quad_pattern(mesh, field, 0.31, [boundary_row(mesh, "constant")])
    assert pattern.solution.energy < 1e-12
    ends = []
    for name, (_, _, way) in SIDES.items():
        held = phases_towards(pattern, angles, way)[on_side(mesh, name)]
        np.testing.assert_allclose(held, held[0], atol=1e-9)
        ends.append(held[0])
    # What is free on one side is found on the other, 1 / 0.31 periods away.
    np.testing.assert_allclose(np.angle(ends[0] * ends[1] * np.exp(2j * np.pi / 0.31)), 0, atol=1e-6)
    np.testing.assert_allclose(np.angle(ends[2] * ends[3] * np.exp(2j * np.pi / 0.31)), 0, atol=1e-6)


@pytest.mark.parametrize("seed", range(2))
def test_a_constant_phase_straightens_a_slanting_grid(seed):
    mesh = square(12)
    field, angles = plane_crosses(mesh, degrees=6, seed=seed)
    row = boundary_row(mesh, "constant", on_side(mesh, "left"))
    free, held = (quad_pattern(mesh, field, 0.3, rows) for rows in ((), [row]))
    assert free.solution.energy < 1e-12 and held.solution.lower_bound > 0.1
    left = on_side(mesh, "left")
    assert np.ptp(phases_towards(free, angles, (1, 0))[left].real) > 0.5
    phases = phases_towards(held, angles, (1, 0))[left]
    np.testing.assert_allclose(phases, phases[0], atol=1e-9)
    problem = pattern_problem(mesh, field, PatternWishes(0.3, [row]))
    assert len(problem.merged.nodes) == 12 and len(np.unique(problem.merged.roots)) == 1


def test_one_fixed_vertex_of_a_constant_side_fixes_all_of_it():
    mesh = square(8)
    field, angles = plane_crosses(mesh)
    left = on_side(mesh, "left")
    corner = left & on_side(mesh, "bottom")
    rows = [boundary_row(mesh, "constant", left), Row(line_of_group(mesh, corner), "phase", 0.8)]
    pattern = quad_pattern(mesh, field, 0.25, rows)
    np.testing.assert_allclose(np.cos(np.angle(phases_towards(pattern, angles, (1, 0))[left])), np.cos(0.8), atol=1e-9)


@pytest.mark.parametrize("kind", ["phase", "constant"])
def test_rows_do_not_depend_on_representatives(kind):
    mesh = bent_square()
    field = direction_field(mesh, 4, DirectionWishes(rows=(boundary_row(mesh),)))
    angles = np.pi / 2 * np.random.default_rng(0).integers(0, 4, (3, mesh.vertex_count))
    bounds = [
        solve(
            pattern_problem(mesh, field.turned(turned), PatternWishes(0.21, [boundary_row(mesh, kind, value=0.6)])),
            TIGHT,
        ).lower_bound
        for turned in angles
    ]
    assert bounds[0] > 0.1
    np.testing.assert_allclose(bounds, bounds[0], rtol=2e-5)


# Contradictions


def test_two_phases_on_one_side_name_its_vertices():
    mesh = square(6)
    right = boundary_row(mesh, "phase", on_side(mesh, "right")).line
    rows = [Row(right, "phase", 0.0, name="row A"), Row(right, "phase", 1.0, name="row B")]
    with pytest.raises(ContradictionError, match="row A and row B fix vertices 42, 43, 44 and 4 more to diff") as error:
        pattern_problem(mesh, plane_crosses(mesh)[0], PatternWishes(0.3, rows))
    np.testing.assert_array_equal(error.value.vertices, np.flatnonzero(on_side(mesh, "right")))


def test_a_point_on_a_side_with_another_phase_is_named():
    mesh = square(6)
    point = Row(line_of_points(mesh, np.array([45])), "phase", 2.0, name="row P")
    side = boundary_row(mesh, "phase", on_side(mesh, "right"))
    with pytest.raises(ContradictionError, match="fix vertex 45 to different phases") as error:
        pattern_problem(mesh, plane_crosses(mesh)[0], PatternWishes(0.3, [side, point]))
    np.testing.assert_array_equal(error.value.vertices, [45])


def test_a_constant_side_between_two_phases_names_their_vertices():
    mesh = square(6)
    field, _ = plane_crosses(mesh)
    x, y, _ = mesh.vertices.T
    ends = [Row(line_of_group(mesh, (x == 1) & (y == side)), "phase", 0.5 + side) for side in (0, 1)]
    line = Row(chain(mesh, x == 1), "constant", name="row C")
    with pytest.raises(ContradictionError, match="row C joins vertices 42, 48, for which different values") as error:
        pattern_problem(mesh, field, PatternWishes(0.3, [*ends, line]))
    np.testing.assert_array_equal(error.value.vertices, [42, 48])


# Mirrors


def mirrored_sheet(bend=0.0):
    """A square around the origin whose diagonals are not mirrored; bent symmetrically in X and Y."""
    points = square_points(12, 12, 2.0, 2.0) - [1.0, 1.0, 0]
    points[:, 2] = bend * np.cos(2 * points[:, 0]) * np.cos(3 * points[:, 1] ** 2)
    mesh, polygons = polygon_mesh(points, grid_quads(12, 12).tolist())
    return mesh, [Mirror.of(mesh, mirrored_vertices(mesh, polygons, axis), axis) for axis in (0, 1)]


def assert_mirrored(solution, mirrors):
    for phases in solution.variations:
        for mirror in mirrors:
            values = products(phases)
            np.testing.assert_allclose(values[mirror.partner], values, atol=1e-9)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("axes", [(0,), (1,), (0, 1)])
@pytest.mark.parametrize("degrees", [0, 45])
def test_mirrored_grids_are_perfect_and_their_own_image(degrees, axes, seed):
    """A plane along the crosses leaves the phases where they are, one at 45 degrees exchanges them."""
    mesh, mirrors = mirrored_sheet()
    mirrors = [mirrors[axis] for axis in axes]
    field, _ = plane_crosses(mesh, degrees, seed)
    pattern = quad_pattern(mesh, field, 0.61, mirrors=mirrors)
    assert pattern.solution.energy < 1e-12 and pattern.dislocations == []
    assert_mirrored(pattern.solution, mirrors)
    free = quad_pattern(mesh, field, 0.61)
    values = products(free.solution.phases)
    assert max(np.abs(values[m.partner] - values).max() for m in mirrors) > 0.1


@pytest.mark.parametrize("axes", [(0,), (1,), (0, 1)])
@pytest.mark.parametrize("guide", ["along the boundary", "diagonal"])
def test_mirrored_quads_on_a_bent_sheet(guide, axes):
    mesh, mirrors = mirrored_sheet(0.4)
    mirrors = [mirrors[axis] for axis in axes]
    rows = (boundary_row(mesh) if guide != "diagonal" else Row(boundary_row(mesh).line, "angle", np.pi / 4),)
    field = direction_field(mesh, 4, DirectionWishes(rows=rows, mirrors=tuple(mirrors)))
    pattern = quad_pattern(mesh, field, 0.4, mirrors=mirrors)
    assert_mirrored(pattern.solution, mirrors)
    solution, free = pattern.solution, pattern_problem(mesh, field, PatternWishes(0.4))
    assert 0 < solution.lower_bound <= solution.energy
    assert free.energy(solution.phases) == pytest.approx(solution.energy, rel=1e-9)
    assert solution.energy >= solve(free).lower_bound


@pytest.mark.parametrize("degrees", [0, 45, 20])
def test_the_bound_holds_for_every_symmetric_choice(degrees):
    """Brute force on a handful of vertices around the mirror plane, of which each keeps what it may."""
    points = np.array([[-1.0, 0, 0], [0, -0.2, 0], [1, 0, 0], [-1, 1, 0.2], [0, 1, 0], [1, 1, 0.2]])
    mesh, polygons = polygon_mesh(points, [[0, 1, 4, 3], ([1, 2, 5, 4], 1)])
    mirror = Mirror.of(mesh, mirrored_vertices(mesh, polygons, 0), 0)
    angle = np.radians(degrees) * np.sign(points[:, 0] + (points[:, 0] == 0) * (degrees % 45 == 0))
    turns = np.pi / 2 * np.arange(6)
    vectors = np.column_stack([np.cos(angle + turns), np.sin(angle + turns), 0 * angle])
    field = given_directions(mesh, 4, vectors)
    spacing = np.array([0.5, 0.8, 0.5, 0.9, 0.45, 0.9])
    growth = TargetOneForm.of(mesh, field, spacing)
    links = mirror.phase_links(growth)
    alone = links.i == links.j
    assert alone.sum() == (0 if degrees == 45 else 4) and links.flips[alone].sum() == alone.sum() // 2
    merged = Merged(links.j[~alone], links.i[~alone], circle_transports(links.angles, links.flips)[~alone])
    kept = links.i[alone & links.flips]  # x = -x: 1 or -1
    best = min(
        brute_force(growth.connection, merged=merged, fixed=Targets(kept, np.array(signs, complex)))
        for signs in product((1, -1), repeat=len(kept))
    )
    options = Options(target_gap=1e-5, samples=32)
    solution = quad_pattern(mesh, field, spacing, mirrors=[mirror], options=options).solution
    assert best > 0.01
    assert solution.lower_bound <= best * (1 + 1e-9)
    assert best * (1 - 1e-9) <= solution.energy <= best * (1 + 1e-5)


def test_rows_on_one_side_of_the_mirror_hold_on_both():
    mesh, mirrors = mirrored_sheet()
    field, _ = plane_crosses(mesh)
    x = mesh.vertices[:, 0]
    line = line_of_edges(mesh, np.flatnonzero((np.abs(x - 0.5) < 1e-9)[mesh.edges].all(axis=1)))
    pattern = quad_pattern(mesh, field, 0.61, [Row(line, "phase", 0.7)], mirrors[:1])
    assert_mirrored(pattern.solution, mirrors[:1])
    held = np.abs(np.abs(x) - 0.5) < 1e-9
    misses = np.abs(np.cos(pattern.vertex_phases) - np.cos(0.7)).min(axis=1)
    np.testing.assert_allclose(misses[held], 0, atol=1e-9)
