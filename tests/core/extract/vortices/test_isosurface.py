# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Isosurfaces on grids: spheres, planes and tori in closed form."""

import numpy as np
import pytest

from synch_fields.core.extract.vortices.tubes import isosurface, smooth_surface
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.check import check_mesh
from synch_fields.core.geometry.grid import Grid

BOX = Grid((21, 22, 23), spacing=0.1, origin=(-1, -1.05, -1.1))


def volume(mesh):
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6


def test_a_sphere_is_closed_and_faces_outwards():
    found = isosurface(BOX, -np.linalg.norm(BOX.places, axis=1), -0.7)
    check_mesh(found.mesh)
    assert len(found.mesh.boundary_edges) == 0 and found.mesh.euler_characteristic == 2
    assert volume(found.mesh) == pytest.approx(4 / 3 * np.pi * 0.7**3, rel=0.02)
    np.testing.assert_allclose(np.linalg.norm(found.mesh.vertices, axis=1), 0.7, atol=0.01)


def test_a_torus_has_one_handle():
    x, y, z = BOX.places.T
    found = isosurface(BOX, -np.hypot(np.hypot(x, y) - 0.6, z), -0.25)
    check_mesh(found.mesh)
    assert len(found.mesh.boundary_edges) == 0 and found.mesh.euler_characteristic == 0
    assert volume(found.mesh) == pytest.approx(2 * np.pi**2 * 0.6 * 0.25**2, rel=0.06)


@pytest.mark.parametrize("level", [0.0, 0.05, 0.123])
def test_a_plane_ends_at_the_sides_of_the_grid(level):
    """Also through nodes: they count as above."""
    found = isosurface(BOX, BOX.places[:, 0].copy(), level)
    assert found.mesh.euler_characteristic == 1
    np.testing.assert_allclose(found.mesh.vertices[:, 0], level, atol=1e-7)
    assert found.mesh.areas.sum() == pytest.approx(2.1 * 2.2, rel=1e-6)
    np.testing.assert_allclose(found.interpolated(BOX.places), found.mesh.vertices, atol=1e-12)


@pytest.mark.parametrize("periodic", [(False, False, True), (True, True, True)])
def test_a_tube_goes_on_to_the_end_of_the_period(periodic):
    grid = Grid((16, 18, 10), spacing=0.1, origin=(-0.8, -0.9, 0.3), periodic=periodic)
    found = isosurface(grid, -np.hypot(grid.places[:, 0], grid.places[:, 1]), -0.5)
    assert found.mesh.euler_characteristic == 0 and len(found.mesh.boundary_edges) > 0
    heights = found.mesh.vertices[:, 2]
    assert heights.min() == pytest.approx(0.3) and heights.max() == pytest.approx(1.3)
    assert found.mesh.areas.sum() == pytest.approx(2 * np.pi * 0.5 * 1.0, rel=0.02)
    np.testing.assert_allclose(np.linalg.norm(found.interpolated(grid.places[:, :2]), axis=1), 0.5, atol=0.01)


def test_a_tube_across_the_sides_is_cut_there():
    grid = Grid((16, 16, 10), spacing=0.1, periodic=True)
    across = np.abs(grid.places[:, :2] - 1.6 * np.round(grid.places[:, :2] / 1.6))  # to the nearest axis of the tubes
    found = isosurface(grid, -np.linalg.norm(across, axis=1), -0.5)
    assert found.mesh.areas.sum() == pytest.approx(2 * np.pi * 0.5 * 1.0, rel=0.02)


def test_nothing_is_found_where_there_is_nothing():
    found = isosurface(BOX, np.zeros(BOX.node_count), 1.0)
    assert found.mesh.triangle_count == 0


def test_evening_takes_the_cells_off_a_sphere_and_leaves_its_size():
    coarse = Grid((12, 12, 12), spacing=0.2, origin=-1.1)
    found = isosurface(coarse, -(np.linalg.norm(coarse.places, axis=1) ** 4), -(0.7**4))
    places = smooth_surface(found.mesh, found.mesh.vertices, 10)
    before, after = (np.linalg.norm(v, axis=1) for v in (found.mesh.vertices, places))
    assert after.std() < 0.65 * before.std()
    assert volume(TriangleMesh(places, found.mesh.triangles)) == pytest.approx(volume(found.mesh), rel=0.02)


@pytest.mark.parametrize("radius", [0.65, 0.71, 0.75])
def test_a_margin_keeps_slivers_from_folding(radius):
    """The sphere nearly touches nodes: around them faces turn inwards when they are evened, with a margin none does."""
    least = []
    for margin in (0, 0.25):
        found = isosurface(BOX, -np.linalg.norm(BOX.places, axis=1), -radius, margin)
        np.testing.assert_allclose(np.linalg.norm(found.mesh.vertices, axis=1), radius, atol=0.006)
        places = smooth_surface(found.mesh, found.mesh.vertices, 4)
        np.testing.assert_allclose(np.linalg.norm(places, axis=1), radius, atol=0.006)
        mesh = TriangleMesh(places, found.mesh.triangles)
        least.append(np.einsum("ij,ij->i", mesh.face_normals, places[mesh.triangles].mean(axis=1) / radius).min())
    assert least[0] < -0.9 and least[1] > 0.9


def test_a_margin_moves_vertices_within_a_plane_and_leaves_its_boundary():
    """On a slanted plane that nearly touches nodes; values that are constant across it are right at the vertices."""
    across = np.array([3.0, 1.0, 0.0]) / np.sqrt(10)
    exact, moved = (isosurface(BOX, BOX.places @ across, 0.001, margin) for margin in (0, 0.25))
    np.testing.assert_allclose(moved.mesh.vertices @ across, 0.001, atol=1e-9)
    edge = exact.mesh.boundary_vertices
    np.testing.assert_array_equal(moved.mesh.vertices[edge], exact.mesh.vertices[edge])
    assert moved.mesh.areas.min() > 2 * exact.mesh.areas.min()
    assert moved.mesh.areas.sum() == pytest.approx(exact.mesh.areas.sum(), rel=1e-9)
    # Heights do not change along the way onto the plane.
    np.testing.assert_allclose(moved.interpolated(BOX.places[:, 2]), moved.mesh.vertices[:, 2], atol=1e-9)


def test_evening_holds_the_boundary():
    found = isosurface(BOX, BOX.places[:, 0] + 0.01 * np.sin(40 * BOX.places[:, 1]), 0.03)
    edge = found.mesh.boundary_vertices
    places = smooth_surface(found.mesh, found.mesh.vertices, 5)
    np.testing.assert_array_equal(places[edge], found.mesh.vertices[edge])
    assert np.std(places[~edge, 0]) < 0.85 * np.std(found.mesh.vertices[~edge, 0])
