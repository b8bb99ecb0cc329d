# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Intrinsic Delaunay triangulations: no negative cotangent, and still the same surface."""

import numpy as np
import pytest

from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.intrinsic_delaunay import intrinsic_delaunay, side_angles

from .meshes import EVERY, bent_square, cylinder, icosphere, shared_mesh, slivers, square


def sheared(mesh, shear=3.0):
    """Moved along x by z and y: edges become badly chosen diagonals."""
    moved = mesh.vertices.copy()
    moved[:, 0] += shear * moved[:, 1] + 0.5 * shear * moved[:, 2]
    return TriangleMesh(moved, mesh.triangles)


SHEARED = [
    pytest.param(lambda: sheared(square(12, split="BD")), id="square"),
    pytest.param(lambda: sheared(bent_square(12)), id="bent-square"),
    pytest.param(lambda: sheared(icosphere(3)), id="ellipsoid"),
    pytest.param(lambda: sheared(cylinder()), id="cylinder"),
    pytest.param(slivers, id="slivers"),
]


def cotangents_of_edges(triangles, lengths):
    """Cotangent sums by length and ends, as far as these tell the edges apart."""
    angles = np.maximum(side_angles(lengths), 1e-12)
    opposite = np.roll(1 / np.tan(angles), 1, axis=1).ravel()
    ends = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    keys = np.column_stack([ends, np.round(lengths.ravel() / lengths.mean(), 7)])
    unique, place, counts = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
    return np.bincount(place.reshape(-1), opposite), counts, unique


@pytest.mark.parametrize("build", SHEARED)
def test_no_inner_edge_has_a_negative_cotangent_sum(build):
    mesh = build()
    before, _, _ = cotangents_of_edges(mesh.triangles, mesh.edge_lengths[mesh.triangle_edges])
    after, counts, _ = cotangents_of_edges(*intrinsic_delaunay(mesh))
    assert (before < -0.1).any()
    assert (after[counts == 2] > -1e-3).all()


@pytest.mark.parametrize("build", SHEARED)
def test_the_surface_stays_the_same(build):
    """Its area, the angle around every vertex and its boundary."""
    mesh = build()
    triangles, lengths = intrinsic_delaunay(mesh)
    angles = side_angles(lengths)
    areas = 0.5 * lengths[:, 0] * lengths[:, 2] * np.sin(angles[:, 0])
    assert areas.sum() == pytest.approx(mesh.areas.sum(), rel=1e-4)
    around = [np.bincount(t.ravel(), a.ravel()) for t, a in ((triangles, angles), (mesh.triangles, mesh.corner_angles))]
    np.testing.assert_allclose(*around, atol=0.01)
    _, counts, keys = cotangents_of_edges(triangles, lengths)
    rim = keys[counts == 1][:, :2].astype(int)
    np.testing.assert_array_equal(rim, mesh.edges[mesh.boundary_edges])


@pytest.mark.parametrize(("build", "characteristic"), EVERY)
def test_sides_give_the_angles_of_the_mesh(build, characteristic):
    mesh = build()
    if mesh.areas.min() > 1e-6 * mesh.areas.mean():
        angles = side_angles(mesh.edge_lengths[mesh.triangle_edges])
        np.testing.assert_allclose(angles, mesh.corner_angles, atol=1e-7)


def test_a_good_mesh_is_left_as_it_is():
    mesh = icosphere(3)
    triangles, lengths = intrinsic_delaunay(mesh)
    np.testing.assert_array_equal(triangles, mesh.triangles)
    np.testing.assert_array_equal(lengths, mesh.edge_lengths[mesh.triangle_edges])


def test_a_needle_on_the_boundary_gets_an_area():
    mesh = TriangleMesh([[0, 0, 0], [1, 0, 0], [0.5, 1e-11, 0], [0.5, 1, 0]], [[0, 1, 2], [1, 3, 2], [3, 0, 2]])
    assert mesh.corner_angles.min() < 1e-10
    triangles, lengths = intrinsic_delaunay(mesh)
    assert side_angles(lengths).min() > 1e-4
    np.testing.assert_allclose(lengths, mesh.edge_lengths[mesh.triangle_edges], atol=1e-5)
    np.testing.assert_array_equal(triangles, mesh.triangles)


def test_a_real_mesh_becomes_delaunay():
    mesh = shared_mesh("fandisk")
    after, counts, _ = cotangents_of_edges(*intrinsic_delaunay(mesh))
    assert (after[counts == 2] > -1e-3).all()
