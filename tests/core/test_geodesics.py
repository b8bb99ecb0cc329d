# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Geodesic distances and the guides that follow them: convergence, needles, pieces, real meshes."""

import numpy as np
import pytest

from synch_fields.core.fields.guidance.guides import distance_guide, geodesic_distance
from synch_fields.core.geometry import TriangleMesh

from .guides import misses
from .meshes import (
    annulus,
    disk,
    icosphere,
    shared_mesh,
    slivers,
    square,
    together,
)


def plane(n):
    mesh = square(n)
    middle = nearest(mesh, [0.5, 0.5, 0])
    return mesh, middle, np.linalg.norm(mesh.vertices - mesh.vertices[middle], axis=1)


def plane_side(n):
    mesh = square(n)
    return mesh, mesh.vertices[:, 0] == 0, mesh.vertices[:, 0]


def plane_sheared(n):
    mesh = square(n, split="BD")
    moved = mesh.vertices + np.outer(mesh.vertices[:, 1], [3, 0, 0])
    mesh = TriangleMesh(moved, mesh.triangles)
    middle = nearest(mesh, moved.mean(axis=0))
    return mesh, middle, np.linalg.norm(moved - moved[middle], axis=1)


def ring(n):
    mesh = annulus(1.0, 2.0, rings=n // 2, segments=3 * n)
    radius = np.linalg.norm(mesh.vertices, axis=1)
    return mesh, radius < 1 + 1e-9, radius - 1


def sphere(n):
    mesh = icosphere({16: 2, 32: 3, 64: 4}[n])
    pole = nearest(mesh, [0.3, 0.2, 0.9])
    return mesh, pole, np.arccos(np.clip(mesh.vertices @ mesh.vertices[pole][0], -1, 1))


# Mean errors at three finenesses, each half as coarse: a third above what was measured.
@pytest.mark.parametrize(
    ("build", "bounds"),
    [
        (plane, (0.014, 0.007, 0.0035)),
        (plane_side, (0.013, 0.009, 0.0065)),
        (plane_sheared, (0.0105, 0.0064, 0.0055)),
        (ring, (0.025, 0.015, 0.009)),
        (sphere, (0.052, 0.029, 0.0145)),
    ],
)
def test_distances_converge(build, bounds):
    errors = []
    for n in (16, 32, 64):
        mesh, sources, expected = build(n)
        distances = geodesic_distance(mesh, sources)
        np.testing.assert_array_equal(distances[sources], 0)
        errors.append(np.abs(distances - expected).mean())
    assert (np.array(errors) < bounds).all(), errors
    assert errors[2] < 0.65 * errors[0]


def test_needles_do_not_disturb_distances():
    fine, rough = icosphere(2), slivers()
    source = nearest(fine, [0, 0, 1])
    expected = geodesic_distance(fine, source)
    distances = geodesic_distance(rough, np.concatenate([source, np.zeros(6, bool)]))
    np.testing.assert_allclose(distances[: len(expected)], expected, atol=0.02)


def test_pieces_without_a_source_have_no_distance_and_no_weight():
    mesh = together(square(8), disk(), icosphere(2), loose=2)
    sources = np.zeros(mesh.vertex_count, bool)
    sources[[0, -1]] = True
    distances, guide = geodesic_distance(mesh, sources), distance_guide(mesh, sources)
    np.testing.assert_array_equal(np.flatnonzero(np.isfinite(distances)), np.arange(81))
    np.testing.assert_allclose(distances[:81], geodesic_distance(square(8), sources[:81]), rtol=1e-9, atol=1e-12)
    assert not guide.weights[81:].any()
    assert guide.weights.sum() == pytest.approx(1 / mesh.areas.sum(), rel=0.05)


def test_distances_run_along_meridians_and_circles():
    mesh, pole, expected = sphere(64)
    centre = mesh.vertices[pole][0]
    away = (expected > 0.2) & (expected < np.pi - 0.2)
    towards = distance_guide(mesh, pole)
    meridians = np.tile(-centre, (mesh.vertex_count, 1))
    assert misses(mesh, towards, meridians)[away].max() < 4
    # Grows away from the pole with the pole on the left of the contour.
    around = distance_guide(mesh, pole, contour=True)
    assert misses(mesh, around, np.cross(mesh.vertices, meridians))[away].max() < 4
    assert towards.weights[pole] < 0.1 * towards.weights.mean()
    assert towards.weights.sum() == pytest.approx(1, abs=0.03)


def test_distances_on_a_real_mesh_are_at_least_those_through_space():
    mesh = shared_mesh("spot")
    source = np.arange(mesh.vertex_count) == 0
    distances = geodesic_distance(mesh, source)
    straight = np.linalg.norm(mesh.vertices - mesh.vertices[0], axis=1)
    diagonal = np.linalg.norm(np.ptp(mesh.vertices, axis=0))
    assert (straight - distances).max() < 0.02 * diagonal
    i, j = mesh.edges.T
    slopes = np.abs(distances[i] - distances[j]) / mesh.edge_lengths
    assert slopes.max() < 1.3 and np.quantile(slopes, 0.95) < 1.1


def nearest(mesh, point):
    return np.arange(mesh.vertex_count) == np.argmin(np.linalg.norm(mesh.vertices - point, axis=1))
