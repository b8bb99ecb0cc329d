# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sources of guidance against closed forms: slopes, axes, curvature, distances, and their blend by brute force."""

import re

import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.fields.guidance.curvature import principal_directions
from synch_fields.core.fields.guidance.fronts import front_distance
from synch_fields.core.fields.guidance.guides import (
    Guide,
    axis_guide,
    blend_guides,
    curvature_guide,
    distance_guide,
    gradient_guide,
    vectors_guide,
)
from synch_fields.core.geometry import TriangleMesh

from ...guide_errors import in_space, misses
from ...meshes import EVERY, FLAT, bent_square, bumpy_torus, cylinder, disk, icosphere, square, together


def used(mesh):
    return np.setdiff1d(np.arange(mesh.vertex_count), mesh.loose_vertices)


def turn(seed):
    q = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))[0]
    return q * np.sign(np.linalg.det(q))


# Slopes


@pytest.mark.parametrize(("build", "characteristic"), FLAT)
def test_a_linear_function_gives_its_direction_exactly(build, characteristic):
    mesh = build()
    rotation = turn(3)
    tilted = TriangleMesh(mesh.vertices @ rotation.T + [3, 1, 2], mesh.triangles)
    slope = np.array([1, -2, 0]) / np.sqrt(5)
    values = 1e3 + 7 * mesh.vertices @ slope
    for contour, expected in ((False, slope), (True, [2 / np.sqrt(5), 1 / np.sqrt(5), 0])):
        guide = gradient_guide(tilted, values, contour=contour)
        np.testing.assert_allclose(in_space(tilted, guide), np.tile(rotation @ expected, (len(values), 1)), atol=1e-9)
        np.testing.assert_allclose(guide.weights, mesh.vertex_masses / mesh.areas.sum(), rtol=1e-9)


def test_values_at_corners_may_jump_between_triangles():
    mesh = bent_square(8)
    values = np.sin(mesh.vertices @ [1, 2, 0.5])
    jumps = np.random.default_rng(0).standard_normal((mesh.triangle_count, 1))
    smooth, seamed = gradient_guide(mesh, values), gradient_guide(mesh, values[mesh.triangles] + jumps)
    np.testing.assert_allclose(np.exp(1j * seamed.angles), np.exp(1j * smooth.angles), atol=1e-9)
    np.testing.assert_allclose(seamed.weights, smooth.weights, rtol=1e-9)


def test_a_round_hill_gives_radii_and_nothing_on_its_top():
    mesh = disk(12, 48)
    radius = np.linalg.norm(mesh.vertices, axis=1)
    downhill = gradient_guide(mesh, -(radius**2))
    centre = radius < 1e-9
    assert downhill.weights[centre] == 0
    assert misses(mesh, downhill, -mesh.vertices)[~centre].max() < 1e-6
    around = gradient_guide(mesh, radius**2, contour=True)
    assert misses(mesh, around, np.cross([0, 0, 1], mesh.vertices))[~centre].max() < 1e-6


def test_height_on_a_sphere_gives_meridians_more_exactly_on_finer_meshes():
    worst, totals = [], []
    for subdivisions in (2, 3, 4):
        mesh = icosphere(subdivisions)
        tilt = turn(1) @ [0, 0, 1]
        guide = gradient_guide(mesh, mesh.vertices @ tilt)
        away = np.abs(mesh.vertices @ tilt) < 0.95
        worst.append(misses(mesh, guide, np.tile(tilt, (mesh.vertex_count, 1)))[away].max())
        totals.append(guide.weights.sum())
    assert worst[0] < 6 and worst[1] < 0.7 * worst[0] and worst[2] < 0.7 * worst[1]
    # All the sphere but its poles; the same on every mesh.
    np.testing.assert_allclose(totals, 1, atol=0.03)


def test_height_on_a_cylinder_gives_its_axis_and_its_circles():
    mesh = cylinder()
    axis = np.tile([0.0, 0, 1], (mesh.vertex_count, 1))
    assert misses(mesh, gradient_guide(mesh, mesh.vertices[:, 2]), axis).max() < 0.1
    circles = np.cross(mesh.vertices * [1, 1, 0], axis)
    assert misses(mesh, gradient_guide(mesh, mesh.vertices[:, 2], contour=True), circles).max() < 0.1


def test_flat_parts_and_ridges_have_no_weight_and_faint_slopes_little():
    # An odd number of columns: as much of every vertex's faces on its left as on its right.
    mesh = square(15)
    x = mesh.vertices[:, 0] - 7 / 15
    half = gradient_guide(mesh, np.maximum(x, 0))
    assert not half.weights[x < -1e-9].any()
    assert half.weights.sum() == pytest.approx(8 / 15, abs=0.04)
    ridge = gradient_guide(mesh, np.abs(x))
    inside = ~mesh.boundary_vertices
    assert ridge.weights[inside & (np.abs(x) < 1e-9)].max() < 1e-9
    assert ridge.weights.sum() == pytest.approx(14 / 15, abs=0.01)
    for slope in (0.01, 0.03, 0.2):
        guide = gradient_guide(mesh, np.where(x > 0, x, slope * x))
        strength = min(slope / (0.1 * (8 / 15 + slope * 7 / 15)), 1)
        left = x < -0.1
        expected = mesh.vertex_masses[left] * strength**2 * (3 - 2 * strength)
        np.testing.assert_allclose(guide.weights[left], expected, rtol=1e-9)


# Axes and vectors


def test_an_axis_on_a_sphere_counts_by_the_squared_sine():
    for subdivisions in (2, 3, 4):
        mesh = icosphere(subdivisions)
        axis = turn(2) @ [0, 0, 1]
        guide = axis_guide(mesh, 5 * axis)
        # The mean of sin^2 over a sphere.
        assert guide.weights.sum() == pytest.approx(2 / 3, abs=0.01)
        tangential = np.linalg.norm(np.cross(mesh.vertex_normals, axis), axis=1)
        np.testing.assert_allclose(guide.weights, mesh.vertex_masses / mesh.areas.sum() * tangential**2, rtol=1e-9)
        away = tangential > 0.1
        assert misses(mesh, guide, np.tile(axis, (mesh.vertex_count, 1)))[away].max() < 1e-6


def test_an_axis_along_the_normal_has_no_weight_there():
    mesh = together(square(3), cylinder(), loose=1)
    guide = axis_guide(mesh, [0, 0, 2])
    np.testing.assert_array_equal(guide.weights[:16], 0)
    assert (guide.weights[16:-1] > 0).all() and guide.weights[-1] == 0
    # Not even by rounding.
    rotation = turn(5)
    tilted = TriangleMesh(mesh.vertices @ rotation.T, mesh.triangles)
    np.testing.assert_array_equal(axis_guide(tilted, rotation @ [0, 0, 2]).weights[:16], 0)


def test_lengths_of_vectors_do_not_count_and_zero_asks_for_nothing():
    mesh = bent_square(6)
    random = np.random.default_rng(4)
    vectors = random.standard_normal((mesh.vertex_count, 3))
    vectors[[3, 8]] = 0
    guide = vectors_guide(mesh, vectors)
    stretched = vectors_guide(mesh, vectors * random.uniform(0.1, 10, (mesh.vertex_count, 1)))
    np.testing.assert_array_equal(np.flatnonzero(guide.weights == 0), [3, 8])
    np.testing.assert_allclose(stretched.weights, guide.weights, rtol=1e-9)
    np.testing.assert_allclose(np.exp(1j * stretched.angles), np.exp(1j * guide.angles), atol=1e-9)
    assert misses(mesh, guide, vectors)[guide.weights > 0].max() < 1e-4


@pytest.mark.parametrize("largest", [True, False])
def test_curvature_is_that_of_the_principal_directions(largest):
    mesh = bumpy_torus(10)
    guide = curvature_guide(mesh, largest=largest)
    for symmetry in (2, 4):
        powers, weights = principal_directions(mesh, symmetry, largest=largest)
        np.testing.assert_allclose(np.exp(1j * symmetry * guide.angles), powers, atol=1e-9)
        np.testing.assert_array_equal(guide.weights, weights)


# What all have in common


def every_guide(mesh, rotation=None):
    rotation = np.eye(3) if rotation is None else rotation
    local = mesh.vertices @ rotation
    local = (local - local[used(mesh)].min(axis=0)) / np.ptp(local[used(mesh)])
    start = np.zeros(mesh.vertex_count, bool)
    for piece in np.unique(mesh.pieces[used(mesh)]):
        start[np.where(mesh.pieces == piece, local[:, 0] + 0.1 * local[:, 1], np.inf).argmin()] = True
    values = np.sin(3 * local[:, 0]) + local[:, 1] ** 2 + local[:, 2]
    return {
        "gradient": gradient_guide(mesh, values),
        "axis": axis_guide(mesh, rotation @ [1, 2, 3]),
        "vectors": vectors_guide(mesh, np.cross(local, [1, 0, 2]) @ rotation.T + rotation @ [0, 0, 1]),
        "distance": distance_guide(mesh, start),
    }


@pytest.mark.parametrize(("build", "characteristic"), EVERY)
def test_weights_are_shares_of_the_area(build, characteristic):
    mesh = build()
    for name, guide in every_guide(mesh).items():
        assert np.isfinite(guide.angles).all(), name
        assert (guide.weights >= 0).all() and (guide.weights <= mesh.vertex_masses / mesh.areas.sum()).all(), name
        assert not guide.weights[mesh.loose_vertices].any(), name
        assert 0.1 < guide.weights.sum() <= 1 + 1e-9, name


@pytest.mark.parametrize("build", [bent_square, lambda: bumpy_torus(8), cylinder, lambda: icosphere(2)])
def test_numbering_place_and_size_do_not_matter(build):
    mesh = build()
    random = np.random.default_rng(6)
    # The names' order decides which of two equal diagonals is taken: distances want a mesh without such ties.
    mesh = TriangleMesh(mesh.vertices + 0.01 * random.standard_normal(mesh.vertices.shape), mesh.triangles)
    rotation, names = turn(6), random.permutation(mesh.vertex_count)
    rolled = (np.arange(3) + random.integers(0, 3, (mesh.triangle_count, 1))) % 3
    vertices = np.empty_like(mesh.vertices)
    vertices[names] = 37.5 * mesh.vertices @ rotation.T
    triangles = random.permutation(np.take_along_axis(names[mesh.triangles], rolled, axis=1))
    changed = TriangleMesh(vertices, triangles)
    before, after = every_guide(mesh), every_guide(changed, rotation)
    for name in before:
        np.testing.assert_allclose(after[name].weights[names], before[name].weights, rtol=1e-6, atol=1e-12)
        sure = before[name].weights > 1e-6
        moved = in_space(mesh, before[name]) @ rotation.T
        np.testing.assert_allclose(in_space(changed, after[name])[names][sure], moved[sure], atol=1e-6)


@pytest.mark.parametrize("build", [bent_square, lambda: bumpy_torus(8), lambda: icosphere(1)])
def test_mirrored_surfaces_have_mirrored_slopes(build):
    mesh = build()
    values = np.sin(mesh.vertices @ [2, 1, 3])
    mirrored = TriangleMesh(mesh.vertices * [-1, 1, 1], mesh.triangles[:, ::-1])
    before, after = gradient_guide(mesh, values), gradient_guide(mirrored, values)
    np.testing.assert_allclose(after.weights, before.weights, rtol=1e-9)
    sure = before.weights > 1e-6
    np.testing.assert_allclose((in_space(mirrored, after) * [-1, 1, 1])[sure], in_space(mesh, before)[sure], atol=1e-9)


# Blending


@pytest.mark.parametrize("symmetry", [1, 2, 4])
def test_a_blend_is_the_sum_of_the_wishes_up_to_a_constant(symmetry):
    random = np.random.default_rng(symmetry)
    guides = [Guide(random.uniform(-4, 4, 30), random.uniform(0, 1, 30)) for _ in range(3)]
    shares = [0.5, 2.0, 0.0]
    values, weights = blend_guides(guides, shares, symmetry)
    np.testing.assert_allclose(np.abs(values), 1, rtol=1e-12)
    phases = np.exp(1j * random.uniform(-4, 4, (50, 30)))
    summed = sum(
        share * guide.weights * np.abs(phases - np.exp(1j * symmetry * guide.angles)) ** 2
        for share, guide in zip(shares, guides, strict=True)
    )
    constant = summed - weights * np.abs(phases - values) ** 2
    expected = 2 * (sum(s * g.weights for s, g in zip(shares, guides, strict=True)) - weights)
    np.testing.assert_allclose(constant, np.tile(expected, (50, 1)), atol=1e-12)


def test_guides_that_cancel_leave_nothing():
    there = Guide(np.array([0.3, 0.3, 0.3]), np.array([0.2, 0.1, 0.0]))
    back = Guide(there.angles + np.pi / 2, np.array([0.2, 0.2, 0.0]))
    values, weights = blend_guides([there, back], [1, 1], 2)
    np.testing.assert_allclose(weights, [0, 0.1, 0], atol=1e-15)
    assert weights[0] == 0
    np.testing.assert_allclose(values, [1, -np.exp(0.6j), 1], atol=1e-12)
    np.testing.assert_allclose(blend_guides([there, back], [1, 1], 4)[1], [0.4, 0.3, 0], atol=1e-15)


# Refusals

MESH = square(3)
ONE = Guide(np.zeros(16), np.ones(16))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: gradient_guide(MESH, np.zeros(5)), "shape (5,): give one to each of the 16 vertices"),
        (lambda: gradient_guide(MESH, np.full(16, 3.7)), "the same all over: give them a slope"),
        (lambda: gradient_guide(MESH, np.where(np.arange(16) % 3, 0.3, 0.1 + 0.2)), "the same all over"),
        (lambda: gradient_guide(MESH, np.arange(18)[:, None] + np.zeros(3)), "the same all over: give them a slope"),
        (lambda: gradient_guide(MESH, [np.nan, *range(15)]), "the value of vertex 0 is not a finite number: set it"),
        (
            lambda: gradient_guide(MESH, np.where(np.eye(18, 3, -4) > 0, np.inf, 0)),
            "the value of triangles 4, 5, 6 is not a finite number",
        ),
        (lambda: axis_guide(MESH, [0, 0, 0]), "the axis [0.0, 0.0, 0.0] has no direction: give three"),
        (lambda: axis_guide(MESH, [1, np.nan, 0]), "has no direction: give three finite numbers"),
        (lambda: axis_guide(MESH, [1, 2]), "has no direction: give three finite numbers"),
        (lambda: axis_guide(MESH, [0, 0, -3]), "points straight out of the surface everywhere: tilt it"),
        (lambda: vectors_guide(MESH, np.ones((4, 3))), "shape (4, 3) where (16, 3) is needed: give one vector"),
        (lambda: vectors_guide(MESH, np.full((16, 3), np.inf)), "vector of vertices 0, 1, 2 and 13 more is not"),
        (lambda: vectors_guide(MESH, np.tile([0, 0, 1.0], (16, 1))), "every guidance vector is zero or points"),
        (lambda: distance_guide(MESH, np.zeros(16)), "no vertex with a face is in the group of sources: add"),
        (lambda: distance_guide(MESH, np.ones(16)), "every vertex is at distance 0: leave at least one out"),
        (lambda: front_distance(MESH, np.ones(3)), "shape (3,) and the mesh has 16 vertices: give one truth value"),
        (
            lambda: front_distance(together(MESH, loose=1), np.arange(17) == 16),
            "no vertex with a face is in the group of sources",
        ),
        (lambda: blend_guides([], [], 2), "there are no guides to blend: give at least one"),
        (
            lambda: blend_guides([ONE], [1, 2], 2),
            "the shares [1.0, 2.0] do not fit 1 guides: give each a finite number",
        ),
        (lambda: blend_guides([ONE], [-1], 2), "the shares [-1.0] do not fit 1 guides"),
        (lambda: blend_guides([ONE], [np.inf], 2), "the shares [inf] do not fit 1 guides"),
        (lambda: blend_guides([ONE, Guide(np.zeros(3), np.ones(3))], [1, 1], 2), "belong to meshes of different size"),
    ],
)
def test_what_cannot_guide_is_refused_in_one_line(call, message):
    with pytest.raises(SettingError, match=re.escape(message)) as caught:
        call()
    assert "\n" not in str(caught.value)
