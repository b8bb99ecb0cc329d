# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Areas, angles, masses and cotangent weights against element-by-element assembly."""

import warnings

import numpy as np
import pytest

from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.intrinsic_delaunay import WEIGHT_RANGE

from ..meshes import BOUNDED, CLOSED, EVERY, icosphere, slivers, square, together


def stiffness(mesh):
    """Dense matrix of the integrals of grad f_i . grad f_j over the hat functions, triangle by triangle."""
    total = np.zeros((mesh.vertex_count, mesh.vertex_count))
    for corners in mesh.triangles:
        sides = np.roll(mesh.vertices[corners], 1, axis=0) - np.roll(mesh.vertices[corners], -1, axis=0)
        double_area = np.linalg.norm(np.cross(sides[0], sides[1]))
        # A hat's gradient is its opposite side turned by 90 degrees, over twice the area.
        total[np.ix_(corners, corners)] += sides @ sides.T / (2 * double_area)
    return total


def heron(mesh):
    a, b, c = np.moveaxis(
        np.linalg.norm(mesh.vertices[mesh.triangles] - mesh.vertices[np.roll(mesh.triangles, 1, 1)], axis=2), 1, 0
    )
    half = (a + b + c) / 2
    return np.sqrt(half * (half - a) * (half - b) * (half - c))


@pytest.mark.parametrize(("build", "characteristic"), EVERY)
def test_weights_are_those_of_linear_finite_elements(build, characteristic):
    mesh = build()
    i, j = mesh.edges.T
    expected = np.clip(-stiffness(mesh)[i, j], *WEIGHT_RANGE)
    np.testing.assert_allclose(mesh.weights, expected, rtol=1e-7, atol=1e-10)
    assert (mesh.weights > 0).all()


def test_slivers_reach_both_ends_of_the_range_of_weights():
    weights = slivers().weights
    assert weights.min() == WEIGHT_RANGE[0] and weights.max() == WEIGHT_RANGE[1]
    assert np.isfinite(weights).all()


@pytest.mark.parametrize(("build", "characteristic"), [p for p in EVERY if p.id != "slivers"])
def test_areas_and_angles(build, characteristic):
    mesh = build()
    np.testing.assert_allclose(mesh.areas, heron(mesh), rtol=1e-10)
    np.testing.assert_allclose(mesh.corner_angles.sum(axis=1), np.pi, rtol=1e-12)
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    cosines = np.einsum("ij,ij->i", b - a, c - a) / np.linalg.norm(b - a, axis=1) / np.linalg.norm(c - a, axis=1)
    np.testing.assert_allclose(np.cos(mesh.corner_angles[:, 0]), cosines, atol=1e-12)


@pytest.mark.parametrize(("build", "characteristic"), EVERY)
def test_masses_share_out_the_area(build, characteristic):
    mesh = build()
    expected = np.zeros(mesh.vertex_count)
    for t, corners in enumerate(mesh.triangles):
        expected[corners] += mesh.areas[t] / 3
    used = expected > 1e-9 * expected.mean()
    np.testing.assert_allclose(mesh.vertex_masses[used], expected[used], rtol=1e-12)
    assert (mesh.vertex_masses > 0).all()


def test_normals_point_outwards_and_are_unit():
    mesh = icosphere(3)
    np.testing.assert_allclose(mesh.vertex_normals, mesh.vertices, atol=5e-3)
    np.testing.assert_allclose(np.linalg.norm(mesh.vertex_normals, axis=1), 1, rtol=1e-12)
    np.testing.assert_allclose(square().vertex_normals, np.tile([0.0, 0, 1], (81, 1)), atol=1e-12)


@pytest.mark.parametrize(("build", "characteristic"), CLOSED + BOUNDED)
def test_weights_do_not_change_with_size(build, characteristic):
    mesh = build()
    larger = TriangleMesh(1000 * mesh.vertices, mesh.triangles)
    np.testing.assert_allclose(larger.weights, mesh.weights, rtol=1e-6)
    np.testing.assert_allclose(larger.vertex_masses, 1e6 * mesh.vertex_masses, rtol=1e-9)


def test_loose_vertices_have_a_little_mass():
    mesh = together(square(3), loose=1)
    assert 0 < mesh.vertex_masses[-1] < 1e-6 * mesh.vertex_masses[0]


def test_weights_are_numbers_where_a_polygon_has_a_triangle_without_area():
    """Two corners of a quad in one place: of the triangle between them two cotangents are larger than any number."""
    mesh = TriangleMesh(np.array([[0, 2, 0], [0, 0, 1], [0, 0, 0], [0, 0, 0]], float), [[0, 1, 2], [0, 2, 3]])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert np.isfinite(mesh.weights).all()
    assert mesh.weights[mesh.edges_between(np.array([1]), np.array([2]))] == pytest.approx(1.0)
