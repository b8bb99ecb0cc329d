# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Signed distance to triangle surfaces against closed forms, brute force and winding numbers."""

import pickle

import numpy as np
import pytest

from synch_fields.core.errors import MeshError
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.filling.surface_distance import SurfaceDistance
from synch_fields.core.geometry.nearest import nearest_in_triangles

from ...meshes import CLOSED, bent_square, bumpy_torus, cube, icosphere, octahedron, together
from ...solids import box_distance, shell


def scattered(mesh, count=400, seed=0):
    """Points in the box around a mesh, near its vertices, and on it."""
    random = np.random.default_rng(seed)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    box = random.uniform(low - 0.3, high + 0.3, (count, 3))
    near = mesh.vertices[random.integers(0, mesh.vertex_count, count)] + random.normal(size=(count, 3)) * 0.02
    return np.concatenate([box, near])


def winding_numbers(mesh, points):
    """(k,) 1 inside and 0 outside, from the solid angles of the triangles (Van Oosterom and Strackee 1983)."""
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] - points[:, None] for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=2) for v in (a, b, c))
    volume = np.einsum("ptx,ptx->pt", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("ptx,ptx->pt", u, v) for u, v in ((a, b), (b, c), (c, a)))
    return np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb).sum(axis=1) / (2 * np.pi)


def test_nearest_points_of_triangles_are_nearest():
    random = np.random.default_rng(3)
    points, corners = random.normal(size=(2000, 3)) * 2, random.normal(size=(3, 2000, 3))
    shares = nearest_in_triangles(points, corners)
    assert shares.min() >= 0
    np.testing.assert_allclose(shares.sum(axis=1), 1)
    inner = (shares > 0).sum(axis=1)
    assert min(np.bincount(inner)[1:]) > 100
    nearest = np.einsum("pk,kpx->px", shares, corners)
    offset = points - nearest
    # Nearest in a convex set: no corner lies beyond the plane through the nearest point across the offset.
    beyond = np.einsum("px,kpx->kp", offset, corners - nearest)
    assert beyond.max() < 1e-12


def test_distance_to_a_cube_is_that_of_the_formula():
    """Twelve large triangles: sharp edges and corners, all of whose sides have to be told."""
    for cuts in (1, 3):
        mesh = cube(cuts)
        points = np.random.default_rng(1).uniform(-1, 2, (2000, 3))
        expected = box_distance(points, (0, 0, 0), (1, 1, 1))
        np.testing.assert_allclose(SurfaceDistance(mesh)(points), expected, atol=1e-12)


@pytest.mark.parametrize(("build", "chi"), [p for p in CLOSED if p.id != "slivers"])
def test_distances_are_those_of_all_triangles_and_signs_those_of_the_winding(build, chi):
    mesh = build()
    points = scattered(mesh)
    shares = nearest_in_triangles(points[:, None], np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)[:, None])
    nearest = np.einsum("ptk,tkx->ptx", shares, mesh.vertices[mesh.triangles])
    distances = np.linalg.norm(nearest - points[:, None], axis=2).min(axis=1)
    signed = SurfaceDistance(mesh)(points)
    np.testing.assert_allclose(np.abs(signed), distances, atol=1e-12)
    clear = distances > 1e-9
    np.testing.assert_array_equal(signed[clear] < 0, winding_numbers(mesh, points)[clear] > 0.5)


def test_the_centre_of_a_ball_is_told_from_all_sides():
    distance = SurfaceDistance(icosphere(4))
    assert distance(np.zeros((1, 3)))[0] == pytest.approx(-1, abs=3e-3)
    assert distance(np.array([[50.0, 0, 0]]))[0] == pytest.approx(49, abs=1e-2)
    assert distance(np.zeros((0, 3))).shape == (0,)


@pytest.mark.parametrize(
    ("heights", "tip", "spread"),
    [
        pytest.param((0.05, 0.05, 3.0), (0, 0, 3.0), (3e-5, 3e-5, 1e-3), id="needle"),
        pytest.param((1.0, 1.0, 0.02), (0.5, 0.5, 0), (1e-3, 1e-3, 1e-5), id="rim"),
    ],
)
def test_beside_sharp_tips_and_rims_the_sign_is_right(heights, tip, spread):
    """The faces there look to all sides, and the normal of one of them misleads."""
    mesh = octahedron(heights)
    # Skewed, so that the nearest piece of a triangle need not lie on the side of the point.
    skew = np.array([[1, 0, 0], [0.1, 1, 0], [0.01, 0.02, 1]])
    mesh = TriangleMesh(mesh.vertices @ skew, mesh.triangles)
    points = (np.array(tip) + np.random.default_rng(4).normal(size=(2000, 3)) * spread) @ skew
    heights_above = (points[:, None] - mesh.vertices[mesh.triangles[:, 0]]) * mesh.face_normals
    inside = heights_above.sum(axis=2).max(axis=1) < 0
    assert 50 < inside.sum() < 1900
    np.testing.assert_array_equal(SurfaceDistance(mesh)(points) < 0, inside)


def test_a_cavity_is_outside():
    mesh = shell(0.5, 1.0, subdivisions=3, layers=1).boundary_surface[0]
    radii = np.array([0.0, 0.3, 0.47, 0.53, 0.75, 0.97, 1.03])
    signed = SurfaceDistance(mesh)(radii[:, None] * [[0.6, 0.0, 0.8]])
    np.testing.assert_array_equal(signed < 0, (radii > 0.5) & (radii < 1))


def test_measures_and_faces_turned_round():
    mesh = cube(2)
    turned = TriangleMesh(mesh.vertices + 7, mesh.triangles[:, ::-1])
    for surface in (SurfaceDistance(mesh), SurfaceDistance(turned)):
        assert surface.volume == pytest.approx(1)
        assert surface.area == pytest.approx(6)
    np.testing.assert_allclose(SurfaceDistance(turned).bounds, [[7] * 3, [8] * 3])
    points = scattered(mesh)
    np.testing.assert_allclose(SurfaceDistance(turned)(points + 7), SurfaceDistance(mesh)(points), atol=1e-12)


@pytest.mark.parametrize("turned", [(), (1,), (0, 1), (2,), (0, 3), (0, 1, 2, 3)])
def test_shells_in_one_another_are_cavities_and_islands_whichever_way_they_look(turned):
    """A cube, in it a cavity, in this an island, and another cube beside them."""
    shells = []
    for number, (centre, side) in enumerate(((0, 2), (0.1, 1), (0.1, 0.5), (3, 1))):
        part = cube(1)
        triangles = part.triangles[:, ::-1] if number in turned else part.triangles
        shells.append(TriangleMesh((part.vertices - 0.5) * side + [centre - 5 * number, 0, 0], triangles))
    distance = SurfaceDistance(together(*shells))
    assert distance.volume == pytest.approx(8 - 1 + 0.125 + 1)
    points = np.random.default_rng(2).uniform([-1.5, -1.5, -1.5], [4, 1.5, 1.5], (2000, 3))
    outer, cavity, island, beside = (
        box_distance(points - [centre, 0, 0], (-side / 2,) * 3, (side / 2,) * 3) < 0
        for centre, side in ((0, 2), (0.1, 1), (0.1, 0.5), (3, 1))
    )
    np.testing.assert_array_equal(distance(points) < 0, outer & ~cavity | island | beside)


def test_open_and_broken_surfaces_are_refused():
    with pytest.raises(MeshError, match=r"the edge between vertices .* one face only") as caught:
        SurfaceDistance(together(cube(2), bent_square(3)))
    assert caught.value.vertices.min() >= cube(2).vertex_count
    triangles = cube(2).triangles.copy()
    triangles[0] = triangles[0][::-1]
    with pytest.raises(MeshError, match="face opposite ways"):
        SurfaceDistance(TriangleMesh(cube(2).vertices, triangles))


def test_a_distance_measures_the_same_in_another_process():
    mesh = bumpy_torus(20)
    distance, points = SurfaceDistance(mesh), scattered(mesh)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(distance))(points), distance(points))
