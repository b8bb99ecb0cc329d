# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad patterns on flat domains, where they are known in closed form, and what no choice of names may change."""

import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.fields import DirectionField, direction_field, given_directions, quad_pattern, stripe_pattern
from synch_fields.core.fields.patterns import PatternWishes, pattern_problem, untangle
from synch_fields.core.fields.target_one_form import TargetOneForm
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.polygons import Polygons
from synch_fields.core.interpolate import dislocation_numbers, evaluate
from synch_fields.core.solve import Options, solve

from ..flat_crosses import plane_crosses, plane_waves, products, random_turns, turned_crosses, turned_phases
from ..meshes import (
    CLOSED,
    FLAT,
    bent_square,
    double_torus,
    flat_torus,
    icosphere,
    renumbered,
    rounded_cube,
    shared_mesh,
    square,
    together,
    torus,
)


def sampled_products(pattern, count=300):
    """cos x cos y at random points of the faces, as a shader would find it; and the points."""
    mesh, polygons = pattern.mesh, Polygons.of_triangles(pattern.mesh)
    random = np.random.default_rng(1)
    triangles, weights = random.integers(0, mesh.triangle_count, count), random.dirichlet(np.ones(3), count)
    phases = [evaluate(part, polygons, triangles, weights) for part in pattern.on_faces(polygons)]
    points = np.einsum("ki,kix->kx", weights, mesh.vertices[mesh.triangles[triangles]])
    return np.cos(phases).prod(axis=0), points


def tilting(seed=4):
    """A rotation of space."""
    turn = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))[0]
    return turn * np.sign(np.linalg.det(turn))


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("degrees", [0, 25, 45])
@pytest.mark.parametrize(("build", "characteristic"), FLAT)
def test_a_constant_cross_on_a_flat_domain_has_the_exact_grid(build, characteristic, degrees, seed):
    mesh = build()
    _, angles = plane_crosses(mesh, degrees, seed)
    turn, spacing = tilting(), 0.41
    tilted = TriangleMesh(mesh.vertices @ turn.T, mesh.triangles)
    flat = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    pattern = quad_pattern(tilted, given_directions(tilted, 4, flat @ turn.T), spacing)
    assert pattern.solution.energy < 1e-12 and pattern.dislocations == []
    found, points = sampled_products(pattern)
    # The two phases of the first vertex are free, its axes and the spacing say the rest.
    start = pattern.vertex_phases[:1]
    waves = start + plane_waves(angles[:1], spacing, points @ turn - mesh.vertices[0])
    np.testing.assert_allclose(found, np.cos(waves).prod(axis=1), atol=1e-6)


@pytest.mark.parametrize("degrees", [0, 30, 60])
def test_two_spacings_give_a_grid_of_rectangles(degrees):
    """The first lies along the axis nearer to X."""
    mesh = square(10)
    field, _ = plane_crosses(mesh, degrees)
    pattern = quad_pattern(mesh, field, np.array([[0.25, 0.6]]))
    assert pattern.solution.energy < 1e-12 and pattern.dislocations == []
    found, points = sampled_products(pattern)
    first = np.radians(degrees if degrees < 45 else degrees - 90)
    axes = np.array([[np.cos(first), np.sin(first)], [-np.sin(first), np.cos(first)]])
    rates = 2 * np.pi / np.array([0.25, 0.6])
    # The offsets of both waves from what is found, a product of cosines being a sum of four waves.
    waves = rates * (points[:, :2] @ axes.T)
    basis = np.column_stack([f(waves[:, 0]) * g(waves[:, 1]) for f in (np.cos, np.sin) for g in (np.cos, np.sin)])
    weights, *_ = np.linalg.lstsq(basis, found, rcond=None)
    np.testing.assert_allclose(basis @ weights, found, atol=1e-6)
    assert np.linalg.norm(weights) == pytest.approx(1, abs=1e-6)


# The torus that is flat


def torus_crosses(mesh, axis, seed=0):
    return turned_crosses(DirectionField(mesh, 4, axis), random_turns(mesh, seed))


def test_a_flat_torus_is_flat():
    mesh, axis = flat_torus(1.0, 0.6)
    assert mesh.euler_characteristic == 0 and len(mesh.boundary_edges) == 0
    np.testing.assert_allclose(mesh.face_curvatures, 0, atol=1e-12)
    assert mesh.areas.sum() == pytest.approx(0.6)
    assert DirectionField(mesh, 4, axis).disclinations == []


@pytest.mark.parametrize("spacing", [0.2, 0.1])
def test_whole_periods_on_a_flat_torus_fit_exactly(spacing):
    mesh, axis = flat_torus(1.0, 0.6, columns=24, rows=16)
    pattern = quad_pattern(mesh, torus_crosses(mesh, axis), spacing)
    assert pattern.solution.energy < 1e-12 and pattern.dislocations == []


def test_two_spacings_fit_a_flat_torus_one_way_round():
    mesh, axis = flat_torus(1.0, 0.6, columns=24, rows=16)
    field = torus_crosses(mesh, axis)
    energies = [quad_pattern(mesh, field, np.array([s])).solution.energy for s in ((0.5, 0.3), (0.3, 0.5))]
    assert min(energies) < 1e-12 and max(energies) > 1


@pytest.mark.parametrize(("width", "height"), [(5.2, 3.0), (5.0, 2.85), (4.8, 3.15)])
def test_broken_periods_on_a_flat_torus_are_stretched_evenly(width, height):
    columns, rows = 36, 24
    mesh, axis = flat_torus(width, height, columns, rows)
    solution = quad_pattern(mesh, torus_crosses(mesh, axis), 1.0, options=Options(target_gap=1e-4)).solution
    # Every edge takes its share, in columns or rows, of what is missing to whole periods.
    i, j = mesh.edges.T
    across = (i // rows - j // rows + columns // 2) % columns - columns // 2
    up = (i % rows - j % rows + rows // 2) % rows - rows // 2
    expected = 0.0
    for steps, count, length in ((across, columns, width), (up, rows, height)):
        missing = 2 * np.pi * (length - round(length)) / count
        expected += (mesh.weights * 4 * np.sin(missing * steps / 2) ** 2).sum()
    assert expected > 0.1
    assert solution.energy == pytest.approx(expected, rel=1e-6)
    assert solution.lower_bound == pytest.approx(expected, rel=2e-4)


# Disclinations


@pytest.mark.parametrize("share", [0.0, 0.3, 0.6])
def test_a_rounded_cube_has_a_quarter_at_each_of_its_corners(share):
    mesh = rounded_cube(8, share)
    defects = direction_field(mesh, 4).disclinations
    assert [d.index for d in defects] == [0.25] * 8
    sides = np.abs(mesh.vertices).max(axis=1)[:, None]
    corners = np.flatnonzero((np.abs(mesh.vertices) > sides - 1e-9).all(axis=1))
    assert len(corners) == 8
    touched = [np.intersect1d(mesh.triangles[d.triangle], corners).tolist() for d in defects]
    assert sorted(touched) == [[corner] for corner in corners]


@pytest.mark.parametrize(("build", "characteristic"), CLOSED)
def test_a_pattern_is_torn_where_its_crosses_are(build, characteristic):
    mesh = build()
    field = direction_field(mesh, 4)
    assert sum(d.index for d in field.disclinations) == pytest.approx(characteristic, abs=1e-9)
    pattern = quad_pattern(mesh, field, spacing_of(mesh))
    numbers, torn = dislocation_numbers(pattern.edge_phases, mesh.triangles)
    odd = {d.triangle for d in field.disclinations if round(4 * d.index) % 4}
    assert set(np.flatnonzero(torn).tolist()) == odd
    assert len(pattern.dislocations) == np.count_nonzero(numbers)
    solution = pattern.solution
    assert solution.lower_bound <= solution.sdp_value * (1 + 1e-9) <= solution.energy * (1 + 2e-9)
    assert solution.lower_bound > 0
    assert solution.energy == pytest.approx(quad_energy(mesh, field, pattern), rel=1e-9)


def quad_energy(mesh, field, pattern):
    """What is missing on all edges that the problem is posed on, from the phase changes that the pattern takes."""
    growth = TargetOneForm.of(mesh, field, spacing_of(mesh)).on_solver_edges
    missing = growth.edge_phases(pattern.phases).changes - growth.changes
    return (growth.mesh.weights[:, None] * 4 * np.sin(missing / 2) ** 2).sum()


def spacing_of(mesh):
    return np.linalg.norm(np.ptp(mesh.vertices[mesh.triangles[:, 0]], axis=0)) / 6


@pytest.mark.parametrize("name", ["spot", pytest.param("fandisk", marks=pytest.mark.slow)])
def test_real_meshes_are_torn_by_their_characteristic(name):
    mesh = shared_mesh(name)
    field = direction_field(mesh, 4)
    assert sum(d.index for d in field.disclinations) == mesh.euler_characteristic
    pattern = quad_pattern(mesh, field, np.ptp(mesh.vertices, axis=0).max() / 12)
    _, torn = dislocation_numbers(pattern.edge_phases, mesh.triangles)
    odd = {d.triangle for d in field.disclinations if round(4 * d.index) % 4}
    assert set(np.flatnonzero(torn).tolist()) == odd
    assert 0 < pattern.solution.lower_bound <= pattern.solution.sdp_value <= pattern.solution.energy


# Names


SURFACES = [
    pytest.param(lambda: icosphere(2), id="icosphere"),
    pytest.param(torus, id="torus"),
    pytest.param(double_torus, id="double-torus"),
    pytest.param(bent_square, id="bent-square"),
]


def found_numbers(edge_phases):
    """(f, 2) sizes of the dislocations of each triangle, in whichever phase, and which are torn."""
    numbers, torn = dislocation_numbers(edge_phases, edge_phases.mesh.triangles)
    return np.sort(np.abs(numbers), axis=1), torn


@pytest.mark.parametrize("build", SURFACES)
def test_turned_representatives_change_nothing_but_names(build):
    mesh = build()
    field, turns, spacing = direction_field(mesh, 4), random_turns(mesh), spacing_of(mesh)
    other = turned_crosses(field, turns)
    pattern = quad_pattern(mesh, field, spacing)
    phases = turned_phases(pattern.solution.phases.reshape(-1, 2), turns).ravel()
    first, second = (pattern_problem(mesh, one, PatternWishes(spacing)) for one in (field, other))
    assert second.energy(phases) == pytest.approx(first.energy(pattern.solution.phases), rel=1e-9)
    np.testing.assert_allclose(products(phases), products(pattern.solution.phases), atol=1e-12)
    moved = TargetOneForm.of(mesh, other, spacing).edge_phases(phases)
    for old, new in zip(found_numbers(pattern.edge_phases), found_numbers(moved), strict=True):
        np.testing.assert_array_equal(new, old)
    again = quad_pattern(mesh, other, spacing).solution
    assert again.lower_bound == pytest.approx(pattern.solution.lower_bound, rel=2e-2)
    assert again.lower_bound <= pattern.solution.energy and pattern.solution.lower_bound <= again.energy


@pytest.mark.parametrize("kind", ["numbering", "motion", "size"])
@pytest.mark.parametrize("build", SURFACES[::3])
def test_a_quad_pattern_keeps_its_energy_and_defects(build, kind):
    mesh = build()
    vectors, spacing = direction_field(mesh, 4).vectors, spacing_of(mesh)
    field = given_directions(mesh, 4, vectors)
    pattern = quad_pattern(mesh, field, spacing)
    vertex, triangle, scale, other = np.arange(mesh.vertex_count), np.arange(mesh.triangle_count), 1.0, mesh
    if kind == "numbering":
        other, vertex, triangle = renumbered(mesh)
    elif kind == "motion":
        other, vectors = TriangleMesh(mesh.vertices @ tilting().T + [3, 0, -7], mesh.triangles), vectors @ tilting().T
    else:
        other, scale = TriangleMesh(37.5 * mesh.vertices, mesh.triangles), 37.5
    old = np.argsort(vertex)
    moved_field = given_directions(other, 4, vectors[old])
    phases = pattern.solution.phases.reshape(-1, 2)[old].ravel()
    problem = pattern_problem(other, moved_field, PatternWishes(scale * spacing))
    assert problem.energy(phases) == pytest.approx(pattern.solution.energy, rel=1e-9)
    moved = TargetOneForm.of(other, moved_field, scale * spacing).edge_phases(phases)
    for before, after in zip(found_numbers(pattern.edge_phases), found_numbers(moved), strict=True):
        np.testing.assert_array_equal(after[triangle], before)
    bound = solve(problem).lower_bound
    assert bound == pytest.approx(pattern.solution.lower_bound, rel=2e-2)


# Settings


def test_fields_of_other_symmetries_are_refused_both_ways():
    mesh = square(3)
    for symmetry in (1, 2):
        with pytest.raises(SettingError, match="quads need a cross field"):
            quad_pattern(mesh, direction_field(mesh, symmetry), 0.5)
    with pytest.raises(SettingError, match="vector or line"):
        stripe_pattern(mesh, direction_field(mesh, 4), 0.5)


@pytest.mark.parametrize(
    ("spacing", "message"),
    [
        (0.0, "the spacing is 0: give a positive length"),
        (np.array([[0.2, -0.1]]), r"the spacing is -0.1 at vertex 0 \(1 in all\)"),
        (np.array([[np.nan, 0.3]]), "the spacing is nan"),
        (np.array([[2.0, 3.0]]), r"the spacing 2 is larger than the object \(1.41421\)"),
    ],
)
def test_spacings_that_are_no_lengths_are_refused(spacing, message):
    mesh = square(4)
    with pytest.raises(SettingError, match=message):
        quad_pattern(mesh, plane_crosses(mesh)[0], spacing)


def test_pieces_and_loose_vertices_are_solved_side_by_side():
    parts = [square(6), bent_square(6), icosphere(1)]
    mesh = together(*parts, loose=2)
    vectors = np.concatenate([direction_field(part, 4).vectors for part in parts] + [np.ones((2, 3))])
    alone = [quad_pattern(part, given_directions(part, 4, direction_field(part, 4).vectors), 0.5) for part in parts]
    solution = quad_pattern(mesh, given_directions(mesh, 4, vectors), 0.5).solution
    assert solution.energy == pytest.approx(sum(p.solution.energy for p in alone), rel=0.1)
    assert solution.lower_bound == pytest.approx(sum(p.solution.lower_bound for p in alone), rel=2e-2)


def test_a_pair_of_dislocations_is_taken_out():
    """Phases in closed form in the plane, turned once around one place and back around another."""
    mesh, spacing = square(24), 0.25
    field, angles = given_directions(mesh, 4, np.tile([1.0, 0, 0], (mesh.vertex_count, 1))), np.zeros(mesh.vertex_count)
    pattern = quad_pattern(mesh, field, spacing, options=Options(method="first"), branching=0.0)
    exact = np.exp(1j * plane_waves(angles, spacing, mesh.vertices[:, :2]))
    z = mesh.vertices[:, 0] + 1j * mesh.vertices[:, 1]
    turns = (z - 0.31 - 0.42j) / (z - 0.67 - 0.58j)
    exact[:, 0] *= turns / np.abs(turns)
    torn = pattern.with_phases(exact.ravel())
    assert len(torn.dislocations) == 2
    whole = untangle(torn, Options())
    assert not whole.dislocations and whole.energy < 1e-3 * torn.energy
