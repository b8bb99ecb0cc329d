# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where layers of a solid are to go: harmonic functions, distances, axes, vectors and curves in closed form."""

import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.fields.guidance.potentials import extend_harmonically, harmonic_function, potential
from synch_fields.core.fields.guidance.solid_distance import solid_distance
from synch_fields.core.fields.guidance.solids import (
    axis_directions,
    curve_vectors,
    extend_directions,
    vector_directions,
)
from synch_fields.core.geometry.tet_mesh import TetMesh

from ...layered_solids import bent_bar, block, gradient_directions, shell

# Below and above the size from which the equations are solved by multigrid.
SIZES = [(6, 5, 6), (16, 15, 17)]


def degrees_between(found, expected):
    return np.degrees(np.arccos(np.clip(np.einsum("nx,nx->n", found, expected), -1, 1)))


def without(mesh, removed):
    """The tetrahedra that do not lie in a region of space, and their vertices."""
    tets = mesh.tets[~removed(mesh.vertices[mesh.tets].mean(axis=1))]
    used, tets = np.unique(tets, return_inverse=True)
    return TetMesh(mesh.vertices[used], tets.reshape(-1, 4))


def two_blocks():
    one, other = block((2, 2, 2)), block((3, 2, 2))
    vertices = np.concatenate([one.vertices, other.vertices + [3, 0, 0], [[9.0, 9, 9]]])
    return TetMesh(vertices, np.concatenate([one.tets, other.tets + one.vertex_count])), one.vertex_count


# Harmonic functions and potentials


@pytest.mark.parametrize("counts", SIZES)
def test_between_two_ends_of_a_block_the_harmonic_function_is_linear(counts):
    mesh = block(counts, (1, 1, 2), jitter=0.15)
    z = mesh.vertices[:, 2]
    found = harmonic_function(mesh, z == 0, z == 2)
    np.testing.assert_allclose(found, z / 2, atol=1e-9)
    directions = gradient_directions(mesh, harmonic_function(mesh, z == 0, z == 2))
    np.testing.assert_allclose(directions, np.tile([0, 0, 1.0], (mesh.vertex_count, 1)), atol=1e-7)


def test_between_two_spheres_it_is_one_over_the_radius():
    errors, tilts = [], []
    for subdivisions in (1, 2):
        mesh = shell(np.linspace(1, 2, 5), subdivisions)
        radius = np.linalg.norm(mesh.vertices, axis=1)
        found = harmonic_function(mesh, radius < 1.01, radius > 1.99)
        errors.append(np.abs(found - (2 - 2 / radius)).max())
        directions = gradient_directions(mesh, harmonic_function(mesh, radius < 1.01, radius > 1.99))
        tilts.append(degrees_between(directions, mesh.vertices / radius[:, None]).max())
    assert errors[0] < 0.01 and errors[1] < 0.7 * errors[0]
    assert tilts[0] < 10 and tilts[1] < 0.7 * tilts[0]


@pytest.mark.parametrize("counts", SIZES)
def test_a_potential_is_found_from_its_changes(counts):
    mesh = block(counts, jitter=0.2)
    values = np.random.default_rng(0).standard_normal(mesh.vertex_count)
    i, j = mesh.edges.T
    np.testing.assert_allclose(potential(mesh, values[j] - values[i]), values - values.min(), atol=1e-7)


def test_the_potential_nearest_to_changes_is_that_of_least_squares():
    mesh, first = two_blocks()
    changes = np.random.default_rng(1).standard_normal(len(mesh.edges))
    scale = np.sqrt(mesh.weights)
    i, j = mesh.edges.T
    matrix = np.zeros((len(mesh.edges), mesh.vertex_count))
    rows = np.arange(len(i))
    matrix[rows, j], matrix[rows, i] = scale, -scale
    expected = np.linalg.lstsq(matrix, scale * changes, rcond=None)[0]
    found = potential(mesh, changes)
    for part in (slice(0, first), slice(first, mesh.vertex_count - 1)):
        np.testing.assert_allclose(found[part], expected[part] - expected[part].min(), atol=1e-9)


def test_pieces_that_no_value_reaches_have_none():
    mesh, first = two_blocks()
    known = mesh.vertices[:, 0] == 0
    found = extend_harmonically(mesh, known, np.full(known.sum(), 0.7))
    np.testing.assert_allclose(found[:first], 0.7, atol=1e-12)
    assert np.isnan(found[first:]).all()
    directions = gradient_directions(mesh, harmonic_function(mesh, known, mesh.vertices[:, 0] == 1))
    np.testing.assert_allclose(directions[:first], np.tile([1.0, 0, 0], (first, 1)), atol=1e-9)
    assert not directions[first:].any()


# Distances


def test_the_distance_to_a_plane_is_exact():
    mesh = block((7, 6, 8), (1, 1, 3), jitter=0.2)
    z = mesh.vertices[:, 2]
    np.testing.assert_allclose(solid_distance(mesh, z == 0), z, atol=1e-4)
    directions = gradient_directions(mesh, solid_distance(mesh, z == 0))
    assert degrees_between(directions, np.tile([0, 0, 1.0], (mesh.vertex_count, 1))).max() < 0.1


def test_the_distance_to_a_point_converges():
    errors = []
    for count in (6, 12):
        mesh = block((count,) * 3)
        found = solid_distance(mesh, np.linalg.norm(mesh.vertices, axis=1) < 1e-9)
        exact = np.linalg.norm(mesh.vertices, axis=1)
        assert (found > exact - 1e-9).all()
        errors.append(np.abs(found - exact).max())
    assert errors[0] < 0.06 and errors[1] < 0.7 * errors[0]


def test_the_shortest_way_goes_around_corners():
    mesh = without(block((12, 12, 2), (2, 2, 0.3)), lambda p: (p[:, 0] < 1.5) & (np.abs(p[:, 1] - 1) < 0.3))
    x, y, _ = mesh.vertices.T
    found = solid_distance(mesh, y == 0)
    behind = (y > 1.3) & (x < 1.5 - 1e-9)
    assert behind.sum() > 100
    # Around the bar: up along its end, then on to the place behind it.
    upper = y[behind] - 4 / 3
    exact = 4 / 3 + np.hypot(1.5 - x[behind], upper)
    assert np.abs(found[behind] - exact).max() < 0.12 and (found[behind] > y[behind] + 0.02).mean() > 0.9


def test_distances_of_several_sources_are_those_of_the_nearest():
    mesh = block((6, 6, 6), jitter=0.2)
    z, x = mesh.vertices[:, 2], mesh.vertices[:, 0]
    both = solid_distance(mesh, (z == 0) | (x == 1))
    one = np.minimum(solid_distance(mesh, z == 0), solid_distance(mesh, x == 1))
    assert (both <= one + 1e-4).all() and np.abs(both - one).mean() < 0.01
    mesh, first = two_blocks()
    reached = solid_distance(mesh, mesh.vertices[:, 2] == 1)
    assert np.isfinite(reached[:-1]).all() and np.isnan(reached[-1])
    assert np.isnan(solid_distance(mesh, np.arange(mesh.vertex_count) < 3)[first:]).all()


# Axes, vectors and curves


def test_directions_are_units():
    mesh, around = bent_bar((4, 8, 3), 1, 2, 2.0, 0.5)
    np.testing.assert_allclose(axis_directions(mesh, (3, 0, -4)), np.tile([0.6, 0, -0.8], (mesh.vertex_count, 1)))
    np.testing.assert_allclose(vector_directions(mesh, 7 * around), around, atol=1e-12)


@pytest.mark.parametrize("counts", SIZES)
def test_vectors_are_extended_where_there_are_none(counts):
    mesh = block(counts)
    x = mesh.vertices[:, 0]
    vectors = np.zeros_like(mesh.vertices)
    vectors[x == 0], vectors[x == 1] = [0, 0, 2], [0, 5, 0]
    found = vector_directions(mesh, vectors)
    expected = np.column_stack([0 * x, x, 1 - x])
    np.testing.assert_allclose(found, expected / np.linalg.norm(expected, axis=1)[:, None], atol=1e-8)


def test_gradients_at_vertices_are_means_over_the_volume():
    mesh = block((3, 3, 3), jitter=0.3)
    values = np.random.default_rng(2).standard_normal(mesh.vertex_count)
    sums = np.zeros_like(mesh.vertices)
    for tet in mesh.tets:
        edges = mesh.vertices[tet[1:]] - mesh.vertices[tet[0]]
        slope = np.linalg.solve(edges, values[tet[1:]] - values[tet[0]])
        sums[tet] += slope * np.linalg.det(edges)
    expected = sums / np.linalg.norm(sums, axis=1)[:, None]
    np.testing.assert_allclose(gradient_directions(mesh, values), expected, atol=1e-9)


def test_on_a_ridge_of_the_guiding_values_directions_are_those_beside_it_or_none():
    mesh = block((6, 6, 6))
    x = mesh.vertices[:, 0]
    found = gradient_directions(mesh, np.minimum(x, 0.5))
    # Beyond the ridge nothing slopes, and the direction before it goes on.
    np.testing.assert_allclose(found, np.tile([1.0, 0, 0], (mesh.vertex_count, 1)), atol=1e-9)
    found = gradient_directions(mesh, -np.abs(x - 0.5))
    sloping = np.abs(x - 0.5) > 0.1
    np.testing.assert_allclose(found[sloping, 0], np.sign(0.5 - x[sloping]), atol=1e-9)
    lengths = np.linalg.norm(found, axis=1)
    assert (np.isclose(lengths, 1) | (lengths == 0)).all()


def test_layers_go_along_a_curve_or_lie_around_it():
    mesh, around = bent_bar((4, 24, 4), 1, 1.4, np.pi / 2, 0.4)
    turn = np.linspace(0, np.pi / 2, 60)
    arc = np.column_stack([1.2 * np.cos(turn), 1.2 * np.sin(turn), 0.2 + 0 * turn])
    assert degrees_between(extend_directions(mesh, curve_vectors(mesh, [arc])), around).max() < 4
    away = mesh.vertices - [0, 0, 0.2]
    radius = np.hypot(away[:, 0], away[:, 1])[:, None]
    away = np.column_stack([away[:, :2] * (1 - 1.2 / radius), away[:, 2]])
    distance = np.linalg.norm(away, axis=1)
    off = distance > 0.05
    found = extend_directions(mesh, curve_vectors(mesh, [arc], across=True))
    assert degrees_between(found[off], away[off] / distance[off, None]).max() < 4
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1)


def test_two_curves_share_the_solid():
    mesh = block((8, 8, 2), (1, 1, 0.2))
    lines = [np.array([[0.0, 0, 0.1], [0, 1, 0.1]]), np.array([[1.0, 0, 0.1], [1, 1, 0.1]])]
    found = extend_directions(mesh, curve_vectors(mesh, lines, across=True))
    x, z = mesh.vertices[:, 0], mesh.vertices[:, 2]
    apart = np.column_stack([np.where(x < 0.5, x, x - 1), 0 * x, z - 0.1])
    clear = np.abs(x - 0.5) > 0.05
    clear &= np.linalg.norm(apart, axis=1) > 0.05
    expected = apart[clear] / np.linalg.norm(apart[clear], axis=1)[:, None]
    np.testing.assert_allclose(found[clear], expected, atol=1e-9)


def test_a_curve_that_goes_far_away_is_refused():
    """Its places would take gigabytes."""
    with pytest.raises(SettingError, match=r"the guiding curve has a length of 1e.06, and no more than .* delete the"):
        curve_vectors(block((4, 4, 4)), [np.array([[0.0, 0, 0.5], [1, 0, 0.5], [1e6, 0, 0]])])


# What cannot be


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda m, none: harmonic_function(m, none, ~none), "low group"),
        (lambda m, none: harmonic_function(m, ~none, ~none), "both groups"),
        (lambda m, none: harmonic_function(m, none[:3], ~none), "shape"),
        (lambda m, none: solid_distance(m, none), "sources"),
        (lambda m, none: solid_distance(m, none[:3]), "shape"),
        (lambda m, none: gradient_directions(m, np.full(len(none), 3.3)), "same all over"),
        (lambda m, none: gradient_directions(m, np.zeros(4)), "shape"),
        (lambda m, none: gradient_directions(m, solid_distance(m, ~none)), "same all over"),
        (lambda m, none: axis_directions(m, (0, 0, 0)), "no direction"),
        (lambda m, none: vector_directions(m, 0 * m.vertices), "zero"),
        (lambda m, none: vector_directions(m, m.vertices[:3]), "shape"),
        (lambda m, none: vector_directions(m, m.vertices * np.nan), "not finite"),
        (lambda m, none: curve_vectors(m, []), "no length"),
        (lambda m, none: curve_vectors(m, [np.zeros((5, 3))]), "no length"),
        (lambda m, none: curve_vectors(m, [np.zeros((1, 3))]), "curve 0"),
    ],
)
def test_guidance_that_says_nothing_is_refused(call, words):
    mesh = block((2, 2, 2))
    with pytest.raises(SettingError, match=words):
        call(mesh, np.zeros(mesh.vertex_count, bool))
