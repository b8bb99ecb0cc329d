# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Calmed changes against closed forms, a dense solution of the least squares, and what must not change them."""

import numpy as np
import pytest
from scipy.linalg import null_space
from scipy.sparse import csr_matrix

from synch_fields.core.connection import circle_transports, levi_civita
from synch_fields.core.errors import SettingError
from synch_fields.core.fields import DirectionField, DirectionWishes, curl_removal, direction_field, given_directions
from synch_fields.core.fields.curl_removal import (
    SMALLEST_WEIGHT,
    Circulation,
    check_share,
    keep_factors,
    remove_holonomy,
    remove_varying,
    surface_circulation,
)
from synch_fields.core.fields.directions import LARGEST_RATIO, direction_problem
from synch_fields.core.fields.patterns import PatternWishes, pattern_problem, quad_pattern, stripe_pattern
from synch_fields.core.fields.target_one_form import TargetOneForm
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.interpolate import EdgePhases, dislocation_numbers
from synch_fields.core.problem import Merged, Targets

from ..direction_wishes import boundary_row, on_boundary
from ..flat_crosses import random_turns, turned_crosses
from ..meshes import (
    annulus,
    bent_square,
    bumpy_torus,
    cylinder,
    disk,
    double_torus,
    flat_torus,
    icosphere,
    square,
    together,
    torus,
)
from .test_invariance import Change

TURN = 2 * np.pi
SURFACES = [
    pytest.param(lambda: icosphere(2), id="icosphere"),
    pytest.param(torus, id="torus"),
    pytest.param(double_torus, id="double-torus"),
    pytest.param(bent_square, id="bent-square"),
    pytest.param(lambda: together(icosphere(1), bent_square(5), loose=2), id="pieces"),
]


def free():
    return Targets.none(), Merged.none()


def holonomy(growth):
    """Sums around the triangles that keep their sheet, by walking around them."""
    zero = np.zeros((growth.mesh.vertex_count, growth.phase_count))
    values, turns = EdgePhases(growth.mesh, zero, growth.changes, growth.matchings).around(growth.mesh.triangles)
    return values[turns == 0, 3]


def around_axis(mesh):
    """Unit vectors around the z axis."""
    x, y, _ = mesh.vertices.T
    vectors = np.column_stack([-y, x, np.zeros_like(x)])
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def growing_around(mesh, rates):
    """The growth of one phase around the z axis at (n,) rates."""
    field = given_directions(mesh, 1, around_axis(mesh)).turned(-np.pi / 2)
    return TargetOneForm.of(mesh, field, TURN / rates)


@pytest.mark.parametrize("symmetry", [1, 2, 4])
@pytest.mark.parametrize("build", SURFACES)
def test_the_holonomy_that_is_left_is_the_rest_of_what_was_asked(build, symmetry):
    mesh = build()
    field = turned_crosses(direction_field(mesh, symmetry), random_turns(mesh))
    spacing = np.random.default_rng(1).uniform(0.1, 0.3, mesh.vertex_count)
    growth = TargetOneForm.of(mesh, field, spacing)
    assert np.abs(holonomy(growth)).max() > 0.1
    for share in (0.25, 1.0):
        calmed = growth.remove_curl(share, *free())
        np.testing.assert_allclose(holonomy(calmed), (1 - share) * holonomy(growth), atol=1e-10)
    same = growth.remove_curl(0.0, *free())
    np.testing.assert_array_equal(same.connection.transports, growth.connection.transports)


@pytest.mark.parametrize("build", SURFACES[:4])
def test_curvature_is_evened_out_and_its_total_stays_where_there_is_no_boundary(build):
    mesh = build()
    problem = direction_problem(mesh, 1, DirectionWishes(singularities=0.25))
    turns = np.angle(problem.connection.transports)
    left = (mesh.triangle_edge_signs * turns[mesh.triangle_edges]).sum(axis=1)
    mean = 0.0 if mesh.boundary_vertices.any() else TURN * mesh.euler_characteristic * mesh.areas / mesh.areas.sum()
    expected = 0.25 * mesh.face_curvatures + 0.75 * mean
    np.testing.assert_allclose((left - expected + np.pi) % TURN - np.pi, 0, atol=1e-10)


@pytest.mark.parametrize("symmetry", [2, 4])
@pytest.mark.parametrize("build", [lambda: icosphere(1), lambda: torus(around=8, across=6), lambda: bent_square(4)])
def test_no_other_changes_with_that_holonomy_are_nearer(build, symmetry):
    """Against the normal equations, dense; on the torus also the part around the handles stays."""
    mesh = build()
    growth = TargetOneForm.of(mesh, turned_crosses(direction_field(mesh, symmetry), random_turns(mesh)), 0.5)
    count = growth.phase_count
    circulation, _ = surface_circulation(mesh, growth.matchings, count)
    weights = np.maximum(np.repeat(mesh.weights, count), SMALLEST_WEIGHT)
    dense, asked = circulation.matrix.toarray(), growth.changes.ravel()
    kernel = null_space(dense)
    # The nearest changes without holonomy, by weighted least squares over all of these.
    root = np.sqrt(weights)[:, None]
    coordinates = np.linalg.lstsq(root * kernel, root[:, 0] * asked, rcond=None)[0]
    calmed = growth.remove_curl(1.0, *free())
    np.testing.assert_allclose(calmed.changes.ravel(), kernel @ coordinates, atol=1e-9)


@pytest.mark.parametrize("symmetry", [2, 4])
@pytest.mark.parametrize("build", SURFACES)
def test_turns_for_candidates_are_about_those_that_calm(build, symmetry):
    mesh = build()
    growth = TargetOneForm.of(mesh, turned_crosses(direction_field(mesh, symmetry), random_turns(mesh)), 0.5)
    exact = growth.remove_curl(1.0, *free()).correction.ravel()
    turns = growth.curl_removing_turns(*free())
    rough = np.where(growth._flips, -turns, turns)
    weights = np.repeat(mesh.weights, growth.phase_count)
    assert weights @ (rough - exact) ** 2 <= 0.1 * (weights @ exact**2)


def test_on_a_flat_torus_a_wave_is_left_alone_and_a_shear_loses_its_wind():
    """Rates 2 pi (3 + sin(2 pi y)) along x: what has no curl and the same mean is the constant 6 pi."""
    mesh, along = flat_torus(columns=32, rows=32)
    field = DirectionField(mesh, 1, along - np.pi / 2)
    plain = TargetOneForm.of(mesh, field, 1 / 3)
    assert np.abs(plain.remove_curl(1.0, *free()).changes - plain.changes).max() < 1e-10
    y = np.arange(mesh.vertex_count) % 32 / 32
    rates = TURN * (3 + np.sin(TURN * y))
    calmed = TargetOneForm.of(mesh, field, TURN / rates).remove_curl(1.0, *free())
    np.testing.assert_allclose(calmed.changes, plain.changes, atol=5e-4)


def test_a_cylinder_whose_spacing_grows_along_it_gets_the_mean_rate():
    """Closed changes around it have one rate c; the integral of (a + b z - c)^2 is least at the mean."""
    mesh = cylinder(radius=1.0, height=2.0, segments=48, rows=16)
    z = mesh.vertices[:, 2] - mesh.vertices[:, 2].min()
    growth = growing_around(mesh, 3.0 + 2.0 * z)
    calmed = growth.remove_curl(1.0, *free())
    plain = growing_around(mesh, np.full(mesh.vertex_count, 5.0))
    np.testing.assert_allclose(calmed.changes, plain.changes, atol=1e-3)
    around = plain.changes > 0.5
    assert (growth.changes[around] / calmed.changes[around]).min() == pytest.approx(3 / 5, rel=1e-2)


@pytest.mark.parametrize("rings", [8, 16])
def test_spokes_on_an_annulus_keep_their_number_at_every_radius(rings):
    """A rate q everywhere; closed changes are k / r, and the integral of (q - k / r)^2 r dr is least at
    k = q (R - r) / ln(R / r)."""
    inner, outer, q = 1.0, 2.0, 20.0
    mesh = annulus(inner, outer, rings, 6 * rings)
    growth = growing_around(mesh, np.full(mesh.vertex_count, q))
    calmed = growth.remove_curl(1.0, *free())
    k = q * (outer - inner) / np.log(outer / inner)
    turned = np.angle(np.exp(1j * np.arctan2(*mesh.vertices[:, 1::-1].T))[mesh.edges])
    turned = np.diff(turned, axis=1)
    turned = (turned + np.pi) % TURN - np.pi
    np.testing.assert_allclose(calmed.changes, k * turned, atol=q * inner * 2 / rings**2)


def test_the_curvature_of_a_sphere_is_even_already():
    mesh = icosphere(4)
    problem = direction_problem(mesh, 1, DirectionWishes(singularities=0.0))
    change = np.angle(problem.connection.transports * circle_transports(-levi_civita(mesh, 1)))
    assert np.abs(change).max() < 2e-3


def test_quads_on_a_cap_without_disclinations_are_those_of_the_stereographic_projection():
    """Lengths on the sphere over those in the plane are as 1 + cos(colatitude)."""
    mesh = disk(rings=16, segments=64)
    r, turn = np.hypot(*mesh.vertices[:, :2].T), np.arctan2(*mesh.vertices[:, 1::-1].T)
    cap = TriangleMesh(np.column_stack([np.sin(r) * np.cos(turn), np.sin(r) * np.sin(turn), np.cos(r)]), mesh.triangles)
    field = direction_field(cap, 4, DirectionWishes(singularities=0.0))
    assert field.disclinations == []
    expected = 1 + np.cos(r)
    ratio = field.scale / expected
    assert np.ptp(ratio) < 0.03 * ratio.mean()
    assert np.ptp(expected) > 0.25 * expected.mean()
    # As many quads as without: the integral of 1 / scale^2 is the area.
    assert np.average(field.scale**-2.0, weights=cap.vertex_masses) == pytest.approx(1)


@pytest.mark.parametrize("seed", range(2))
def test_pieces_are_flattened_each_on_its_own(seed):
    sphere = icosphere(3)
    lump = TriangleMesh(sphere.vertices * [1, 1, 3], sphere.triangles)
    order = np.random.default_rng(seed).permutation(sphere.triangle_count)
    both = together(icosphere(2), TriangleMesh(lump.vertices, lump.triangles[order]))
    wishes = DirectionWishes(singularities=0.0)
    found = direction_field(both, 4, wishes).scale
    for piece, count in enumerate(np.bincount(both.pieces)):
        own = found[both.pieces == piece]
        masses = both.vertex_masses[both.pieces == piece]
        assert len(own) == count
        assert np.average(own**-2.0, weights=masses) == pytest.approx(1)
        assert 1.05 < own.max() / own.min() <= LARGEST_RATIO * (1 + 1e-9)


@pytest.mark.parametrize("kind", ["numbering", "motion", "size"])
def test_numbering_position_and_size_do_not_matter(kind):
    mesh = bumpy_torus(8)
    field = given_directions(mesh, 2, around_axis(mesh))
    change = Change(mesh, kind, 1)
    phases = np.exp(1j * np.random.default_rng(0).uniform(-np.pi, np.pi, mesh.vertex_count))
    before = pattern_problem(mesh, field, PatternWishes(0.15, branching=0.5))
    after = pattern_problem(change.new, change.field(field), PatternWishes(0.15 * change.scale, branching=0.5))
    assert after.energy(change.phases(phases)) == pytest.approx(before.energy(phases), rel=1e-9)
    asked = pattern_problem(mesh, field, PatternWishes(0.15))
    assert before.energy(phases) != pytest.approx(asked.energy(phases), rel=1e-3)


def test_a_finer_mesh_has_as_many_dislocations_and_they_fall_as_the_share():
    """Spokes around an axis of an ellipsoid: some seventy are asked for."""
    counts = []
    for subdivisions in (3, 4):
        sphere = icosphere(subdivisions)
        mesh = TriangleMesh(sphere.vertices * [1, 0.8, 1.3], sphere.triangles)
        vectors = np.cross(mesh.vertex_normals, np.cross(mesh.vertices, [0.3, 0.2, 1.0]))
        field = given_directions(mesh, 2, vectors)
        counts.append([len(stripe_pattern(mesh, field, 0.15, branching=b).dislocations) for b in (1.0, 0.5, 0.0)])
    coarse, fine = np.array(counts)
    assert np.abs(coarse - fine).max() <= 0.1 * fine.max()
    assert fine[1] == pytest.approx(fine[0] / 2, rel=0.2)
    assert fine[2] == 0


def test_which_direction_stands_for_a_cross_does_not_matter():
    mesh = icosphere(3)
    field = direction_field(mesh, 4)
    energies = []
    for turned in (field, turned_crosses(field, random_turns(mesh))):
        growth = TargetOneForm.of(mesh, turned, 0.3)
        calmed = growth.remove_curl(0.7, *free())
        energies.append(np.sort(np.abs(calmed.changes).ravel()))
    np.testing.assert_allclose(energies[0], energies[1], atol=1e-9)


@pytest.mark.parametrize("symmetry", [2, 4])
def test_no_dislocation_is_left_without_branching(symmetry):
    """Where directions alone force dozens."""
    mesh = icosphere(3)
    field = direction_field(mesh, symmetry)
    solve_pattern = stripe_pattern if symmetry == 2 else quad_pattern
    counts = [len(solve_pattern(mesh, field, 0.2, branching=share).dislocations) for share in (1.0, 0.5, 0.0)]
    assert counts[0] > counts[1] >= counts[2] == 0
    assert TargetOneForm.of(mesh, field, 0.2).forced_dislocations > 10


@pytest.mark.parametrize("symmetry", [1, 2, 4])
@pytest.mark.parametrize(
    ("build", "fewest"), [(lambda: double_torus(2), 2), (lambda: bumpy_torus(8), 0), (lambda: icosphere(3), 2)]
)
def test_no_more_disclinations_than_topology_asks_for(build, fewest, symmetry):
    mesh = build()
    field = direction_field(mesh, symmetry, DirectionWishes(singularities=0.0))
    assert len(field.disclinations) == symmetry * fewest
    assert all(abs(defect.index) == 1 / symmetry for defect in field.disclinations)


def test_directions_along_the_boundary_are_kept_and_their_turns_count():
    """On a disk with crosses along its rim four quarter disclinations are left, however flat it is made."""
    mesh = disk(rings=10, segments=40)
    wishes = on_boundary(mesh)
    free_field = direction_field(mesh, 4, wishes)
    field = direction_field(mesh, 4, DirectionWishes(rows=wishes.rows, singularities=0.0))
    rim = mesh.boundary_vertices
    np.testing.assert_allclose(np.exp(4j * field.angles[rim]), np.exp(4j * free_field.angles[rim]), atol=1e-9)
    assert sorted(defect.index for defect in field.disclinations) == [0.25] * 4
    # What the rim turns through is spread over the area: nothing else could be done.
    problem = direction_problem(mesh, 4, DirectionWishes(rows=wishes.rows, singularities=0.0))
    turns = np.angle(problem.connection.transports)
    left = (mesh.triangle_edge_signs * turns[mesh.triangle_edges]).sum(axis=1)
    expected = 4 * TURN * mesh.areas / mesh.areas.sum()
    np.testing.assert_allclose((left - expected + np.pi) % TURN - np.pi, 0, atol=1e-9)


def test_a_phase_held_on_the_boundary_stays_and_enters_the_closed_form():
    """Stripes along the rim of a disk with a hole, at a rate that varies around: no dislocation, all rims on lines."""
    mesh = annulus(1.0, 2.0, 10, 60)
    field = given_directions(mesh, 1, around_axis(mesh))
    x = mesh.vertices[:, 0]
    spacing = 0.2 * (1 + 0.3 * x / 2)
    rows = [boundary_row(mesh, "phase")]
    problem = pattern_problem(mesh, field, PatternWishes(spacing, rows, branching=0.0))
    rim = mesh.boundary_vertices[mesh.edges].all(axis=1)
    np.testing.assert_allclose(np.angle(problem.connection.transports[rim]), 0, atol=1e-9)
    pattern = stripe_pattern(mesh, field, spacing, rows, branching=0.0)
    np.testing.assert_allclose(pattern.phases[mesh.boundary_vertices], 1, atol=1e-9)
    numbers, _ = dislocation_numbers(pattern.edge_phases, mesh.triangles)
    assert not numbers.any()


@pytest.mark.parametrize("share", [-0.1, 1.1, np.nan, True, "half"])
def test_a_share_out_of_range_is_refused(share):
    mesh = square(4)
    field = given_directions(mesh, 2, np.tile([1.0, 0, 0], (mesh.vertex_count, 1)))
    with pytest.raises(SettingError, match=r"branching is .* give a share from 0 to 1"):
        pattern_problem(mesh, field, PatternWishes(0.2, branching=share))
    with pytest.raises(SettingError, match=r"singularities is .* give a share from 0 to 1"):
        direction_problem(mesh, 2, DirectionWishes(singularities=share))


def test_a_share_may_be_a_number_of_numpy():
    check_share(np.float32(0.5), "branching")


def test_on_a_closed_piece_without_area_what_stays_is_spread_evenly():
    """Two triangles on the same three changes, which leave them in opposite directions, and no area."""
    matrix = csr_matrix(np.array([[1.0, 1.0, 1.0], [-1.0, -1.0, -1.0]]))
    found = remove_holonomy(Circulation(matrix, np.zeros(2)), np.array([3.0, 1.0]), np.ones(3))
    np.testing.assert_allclose(matrix @ found.correction, [-1, 1], atol=1e-9)


def test_the_part_of_a_holonomy_that_varies_fast_is_told_from_the_rest():
    """On a sphere, of radius 1, every triangle has curvature in proportion to its area, and one has more of it."""
    mesh = icosphere(3)
    circulation, _ = surface_circulation(mesh, np.zeros(len(mesh.edges), int))
    even, spot = mesh.areas.copy(), np.zeros(mesh.triangle_count)
    spot[7] = 1.0

    def part(holonomy, length):
        return -circulation.matrix @ remove_varying(circulation, holonomy, mesh.weights, length)

    np.testing.assert_allclose(part(even, 10.0), 0, atol=1e-7)
    assert np.abs(part(even + spot, 1e-6)).max() < 1e-3
    np.testing.assert_allclose(part(even + spot, 1e3), spot - mesh.areas / mesh.areas.sum(), atol=1e-3)
    for length in (0.1, 0.5):
        assert part(spot, length).sum() == pytest.approx(0, abs=1e-7)
        laplacian = circulation.matrix @ np.diag(1 / mesh.weights) @ circulation.matrix.T
        smooth = np.linalg.solve(np.diag(mesh.areas) + length**2 * laplacian, spot)
        np.testing.assert_allclose(part(spot, length), spot - mesh.areas * smooth, atol=1e-9)


@pytest.mark.parametrize("scale", [2.0**-23, 2.0**-10, 2.0**10])
def test_what_varies_over_less_than_a_length_does_not_depend_on_the_scale(scale):
    def correction(scale):
        mesh = TriangleMesh(scale * icosphere(2).vertices * [1.0, 0.8, 0.6], icosphere(2).triangles)
        circulation, _ = surface_circulation(mesh, np.zeros(len(mesh.edges), int))
        holonomy = np.random.default_rng(0).standard_normal(mesh.triangle_count)
        return remove_varying(circulation, holonomy, mesh.weights, 0.1 * scale)

    np.testing.assert_allclose(correction(scale), correction(1.0), rtol=1e-9, atol=1e-12)


def test_bumps_finer_than_a_detail_make_no_disclinations():
    mesh = icosphere(4)
    bumps = np.prod(np.sin(12 * mesh.vertices), axis=1, keepdims=True)
    mesh = TriangleMesh(mesh.vertices * (1 + 0.2 * bumps), mesh.triangles)
    counts = [len(direction_field(mesh, 4, DirectionWishes(detail=detail)).disclinations) for detail in (0.0, 0.3)]
    assert counts[0] > counts[1] == 8


def test_factors_are_kept_only_for_as_long_as_they_are_asked_for(monkeypatch):
    mesh, made = icosphere(2), []
    circulation, _ = surface_circulation(mesh, np.zeros(len(mesh.edges), int))
    holonomies = np.random.default_rng(0).standard_normal((2, mesh.triangle_count))
    factorize = curl_removal.factorize
    monkeypatch.setattr(curl_removal, "factorize", lambda *a, **k: made.append(a) or factorize(*a, **k))
    alone = [remove_holonomy(circulation, holonomy, mesh.weights).correction for holonomy in holonomies]
    with keep_factors():
        kept = [remove_holonomy(circulation, holonomy, mesh.weights).correction for holonomy in holonomies]
        other = remove_holonomy(circulation, holonomies[0], 2 * mesh.weights).correction
    assert len(made) == 4
    np.testing.assert_array_equal(kept, alone)
    np.testing.assert_allclose(other, alone[0], atol=1e-9)
