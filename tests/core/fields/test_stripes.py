# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Stripes on flat domains, where direction, spacing and energy are known in closed form."""

import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.fields import direction_field, given_directions, stripe_pattern
from synch_fields.core.fields.target_one_form import TargetOneForm
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.polygons import Polygons
from synch_fields.core.interpolate import evaluate

from ..direction_wishes import boundary_row
from ..meshes import FLAT, square, subdivided, together


def tilted(mesh, seed=4):
    """The mesh turned in space, with the turn's matrix."""
    turn = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    return TriangleMesh(mesh.vertices @ turn.T, mesh.triangles), turn


def constant_field(mesh, turn, angle, symmetry, seed=0):
    """Direction at an angle in the plane; lines get a random sign at every vertex."""
    signs = (
        np.random.default_rng(seed).choice([-1, 1], mesh.vertex_count) if symmetry == 2 else np.ones(mesh.vertex_count)
    )
    return given_directions(mesh, symmetry, signs[:, None] * (turn @ [np.cos(angle), np.sin(angle), 0]))


def samples(mesh, count=200):
    """Random triangles, weights and the points that they are."""
    random = np.random.default_rng(1)
    triangles = random.integers(0, mesh.triangle_count, count)
    weights = random.dirichlet(np.ones(3), count)
    return triangles, weights, np.einsum("ki,kix->kx", weights, mesh.vertices[mesh.triangles[triangles]])


@pytest.mark.parametrize("symmetry", [1, 2])
@pytest.mark.parametrize("angle", [0.0, 0.7])
@pytest.mark.parametrize(("build", "characteristic"), FLAT)
def test_constant_stripes_on_flat_domains_are_perfect(build, characteristic, angle, symmetry):
    mesh, turn = tilted(build())
    spacing = 0.41
    pattern = stripe_pattern(mesh, constant_field(mesh, turn, angle, symmetry), spacing)
    assert pattern.solution.energy < 1e-12 and pattern.dislocations == []
    # The phase grows across the stripes, a quarter turn counterclockwise from them.
    across = turn @ [-np.sin(angle), np.cos(angle), 0]
    triangles, weights, points = samples(mesh)
    polygons = Polygons.of_triangles(mesh)
    (faces,) = pattern.on_faces(polygons)
    theta = evaluate(faces, polygons, triangles, weights)
    phase = 2 * np.pi / spacing * points @ across
    start = np.angle(pattern.solution.phases[0])
    candidates = []
    for sign in (1, -1) if symmetry == 2 else (1,):
        offset = start - sign * 2 * np.pi / spacing * mesh.vertices[0] @ across
        candidates.append(np.abs(np.cos(theta) - np.cos(sign * phase + offset)).max())
    assert min(candidates) < 1e-6


@pytest.mark.parametrize("spacing", [0.1, 0.3, 0.9])
def test_the_phase_is_linear_and_turns_once_per_spacing(spacing):
    mesh, turn = tilted(subdivided(square(8)))
    angle = 0.35
    pattern = stripe_pattern(mesh, constant_field(mesh, turn, angle, 1), spacing)
    changes = pattern.edge_phases.changes[:, 0]
    gradient, *_ = np.linalg.lstsq(mesh.edge_vectors, changes, rcond=None)
    np.testing.assert_allclose(mesh.edge_vectors @ gradient, changes, atol=1e-6)
    assert 2 * np.pi / np.linalg.norm(gradient) == pytest.approx(spacing, rel=1e-6)
    np.testing.assert_allclose(
        gradient / np.linalg.norm(gradient), turn @ [-np.sin(angle), np.cos(angle), 0], atol=1e-6
    )


@pytest.mark.parametrize("symmetry", [1, 2])
def test_asked_phase_changes_are_those_of_a_plane_wave(symmetry):
    mesh, turn = tilted(square(6))
    field = constant_field(mesh, turn, 0.8, symmetry)
    growth = TargetOneForm.of(mesh, field.turned(-np.pi / 2), 2 * np.pi / 3.0)
    i, j = mesh.edges.T
    # For the phase of the lower vertex, whose vector is the one that counts.
    asked = 3.0 * np.einsum("ij,ij->i", field.vectors[i], mesh.edge_vectors)
    np.testing.assert_allclose(growth.changes[:, 0], asked, atol=1e-9)
    np.testing.assert_array_equal(growth.matchings, np.einsum("ij,ij->i", field.vectors[i], field.vectors[j]) < 0)
    assert growth.matchings.any() == (symmetry == 2)
    # The transport ends in the sheet of the higher vertex.
    phases = np.exp(3j * np.einsum("ij,ij->i", field.vectors, mesh.vertices))
    assert growth.connection.energy(phases) < 1e-12


def strip(columns=30, stripes=5.0):
    """A rectangle as wide as a number of stripes of spacing 0.2, stripes along its short sides."""
    width = 0.2 * stripes
    mesh = square(columns, 10, width=width, height=0.5)
    field = given_directions(mesh, 1, np.tile([0.0, 1, 0], (mesh.vertex_count, 1)))
    sides = (mesh.vertices[:, 0] < 1e-9) | (mesh.vertices[:, 0] > width - 1e-9)
    return mesh, field, sides


@pytest.mark.parametrize("stripes", [1.0, 3.0, 5.0])
def test_a_strip_of_whole_stripes_keeps_them_on_both_sides(stripes):
    mesh, field, sides = strip(stripes=stripes)
    pattern = stripe_pattern(mesh, field, 0.2, [boundary_row(mesh, "phase", sides)])
    assert pattern.solution.energy < 1e-12
    np.testing.assert_allclose(pattern.solution.phases[sides], 1, atol=1e-9)
    expected = np.exp(-2j * np.pi / 0.2 * mesh.vertices[:, 0])
    np.testing.assert_allclose(pattern.solution.phases, expected, atol=1e-6)


@pytest.mark.parametrize("share", [0.25, -0.4])
def test_a_strip_of_broken_stripes_stretches_them_evenly(share):
    columns = 30
    mesh, field, sides = strip(columns, stripes=5 + share)
    pattern = stripe_pattern(mesh, field, 0.2, [boundary_row(mesh, "phase", sides)])
    np.testing.assert_allclose(pattern.solution.phases[sides], 1, atol=1e-9)
    # Every column takes the same part of what is missing to five whole stripes.
    steps = np.abs(mesh.edge_vectors[:, 0]) / (mesh.vertices[:, 0].max() / columns)
    expected = (mesh.weights * 4 * np.sin(np.pi * share * steps / columns) ** 2).sum()
    assert pattern.solution.energy == pytest.approx(expected, rel=1e-6)
    assert pattern.solution.lower_bound == pytest.approx(expected, rel=1.1e-2)
    spacing = mesh.vertices[:, 0].max() / 5
    expected = np.exp(-2j * np.pi * mesh.vertices[:, 0] / spacing)
    np.testing.assert_allclose(pattern.solution.phases, expected, atol=1e-4)


def test_phases_on_the_whole_boundary_are_kept():
    mesh = square(12)
    field = direction_field(mesh, 2)
    pattern = stripe_pattern(mesh, field, 0.3, [boundary_row(mesh, "phase")])
    np.testing.assert_allclose(pattern.solution.phases[mesh.boundary_vertices], 1, atol=1e-9)
    assert pattern.solution.energy > 1
    free = stripe_pattern(mesh, field, 0.3)
    assert free.solution.energy < 1e-12


@pytest.mark.parametrize("spacing", [0, -0.1, np.nan, np.inf])
def test_a_spacing_that_is_no_positive_length_is_refused(spacing):
    mesh = square(4)
    with pytest.raises(SettingError, match="give a positive length"):
        stripe_pattern(mesh, direction_field(mesh, 1), spacing)


def test_a_spacing_larger_than_the_object_is_refused():
    mesh = together(square(4), loose=1)  # the loose vertex is far away and does not count
    field = direction_field(mesh, 1)
    with pytest.raises(SettingError, match=r"1.5 is larger than the object \(1.41421\)"):
        stripe_pattern(mesh, field, 1.5)
    stripe_pattern(mesh, field, 1.4)


def test_crosses_are_refused():
    mesh = square(3)
    with pytest.raises(SettingError, match="vector or line"):
        stripe_pattern(mesh, direction_field(mesh, 4), 0.5)


def test_coarse_edges_are_counted():
    mesh = square(10, split="AC")
    field = given_directions(mesh, 1, np.tile([0.0, 1, 0], (mesh.vertex_count, 1)))
    crossing = np.abs(mesh.edge_vectors[:, 0]) > 1e-9
    assert TargetOneForm.of(mesh, field, 0.21).coarse_share == 0
    assert TargetOneForm.of(mesh, field, 0.19).coarse_share == pytest.approx(crossing.mean())
