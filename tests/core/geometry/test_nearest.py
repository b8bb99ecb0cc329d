# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Nearest points of a triangle against rational numbers, and of many triangles against all one by one."""

import pickle
from fractions import Fraction

import numpy as np
import pytest

from synch_fields.core.errors import MeshError
from synch_fields.core.geometry import nearest
from synch_fields.core.geometry.barycentric import barycentric
from synch_fields.core.geometry.nearest import NearestTriangles, nearest_in_triangles

from ..meshes import EVERY, cube, icosphere, slivers

RANDOM = np.random.default_rng(5)


def exact_distances(points, corners):
    """Distances of (k, 3) points to triangles with (3, k, 3) corners, in rational numbers: to the edges, and to the
    plane where the point is above the triangle."""
    rational = np.vectorize(Fraction, otypes=[object])
    points, corners = rational(points), rational(corners)
    normals = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    within, ways = dot(normals, normals) > 0, []
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        edge = end - start
        squares = dot(edge, edge)
        share = dot(points - start, edge) / np.where(squares > 0, squares, 1)
        ways.append(points - start - np.clip(share, 0, 1)[:, None] * edge)
        within = within & (dot(np.cross(edge, points - start), normals) > 0)
    squares = np.min([dot(way, way) for way in ways], axis=0)
    heights = dot(points - corners[0], normals) ** 2 / np.where(within, dot(normals, normals), 1)
    return np.sqrt(np.where(within, heights, squares).astype(float))


def dot(u, v):
    return (u * v).sum(axis=-1)


def place_in(points, corners):
    shares = nearest_in_triangles(points, corners)
    assert shares.min() > -1e-15
    return np.einsum("...c,c...x->...x", shares, corners)


def assert_nearest(vertices, triangles, points):
    """Places as near as the nearest of all triangles one by one, on the triangle that is named."""
    places, found = NearestTriangles(vertices, triangles).nearest(points)
    corners = np.moveaxis(vertices[triangles], 1, 0)
    expected = [np.linalg.norm(point - place_in(point, corners), axis=1).min() for point in points]
    rounding = 1e-14 * max(np.abs(vertices).max(), np.abs(points).max())
    assert np.abs(np.linalg.norm(points - places, axis=1) - expected).max() < rounding
    assert np.abs(places - place_in(places, corners[:, found])).max() < rounding


def around(vertices, triangles, count=60):
    """Points at vertices, in triangles, near them, and far away."""
    chosen = RANDOM.integers(0, len(triangles), count)
    inside = np.einsum("pc,pcx->px", RANDOM.dirichlet(np.ones(3), count), vertices[triangles[chosen]])
    size = np.ptp(vertices, axis=0).max()
    box = vertices.mean(axis=0) + size * RANDOM.uniform(-1, 1, (count, 3))
    near = inside + 0.02 * size * RANDOM.normal(size=(count, 3))
    return np.concatenate([vertices[triangles[chosen, 0]], inside, near, box, 1000 * box])


@pytest.mark.parametrize(("build", "chi"), EVERY)
def test_nearest_points_of_meshes_are_those_of_all_triangles(build, chi):
    mesh = build()
    assert_nearest(mesh.vertices, mesh.triangles, around(mesh.vertices, mesh.triangles, 30))


def test_triangles_may_cross_and_be_single():
    vertices = RANDOM.normal(size=(200, 3))
    for count in (1, 2, 3, 4, 5, 17, 300):
        triangles = RANDOM.integers(0, len(vertices), (count, 3))
        assert_nearest(vertices, triangles, around(vertices, triangles))


@pytest.mark.parametrize("width", [1e-3, 1e-6, 1e-9, 1e-13, 1e-17, 0])
def test_needles_are_as_exact_as_others(width):
    start, along, across = RANDOM.normal(size=(3, 300, 3))
    share = RANDOM.uniform(-0.5, 1.5, (300, 1))
    vertices = np.concatenate([start, start + along, start + share * along + width * across])
    triangles = np.arange(900).reshape(3, 300).T
    assert_nearest(vertices, triangles, around(vertices, triangles))


@pytest.mark.parametrize("width", [1, 1e-2, 1e-4, 1e-6, 1e-9, 1e-13, 1e-17, 0])
def test_places_in_a_triangle_are_those_of_rational_numbers(width):
    start, along, across = RANDOM.normal(size=(3, 200, 3))
    share = RANDOM.uniform(-0.5, 1.5, (200, 1))
    corners = np.array([start, start + along, start + share * along + width * across])
    for apart in (1e-3, 1):
        points = start + RANDOM.uniform(-0.2, 1.2, (200, 1)) * along + apart * RANDOM.normal(size=(200, 3))
        expected = exact_distances(points, corners)
        for order in ([0, 1, 2], [2, 1, 0], [1, 0, 2]):
            ways = points - place_in(points, corners[order])
            np.testing.assert_allclose(np.linalg.norm(ways, axis=1), expected, rtol=0, atol=1e-13)


def test_triangles_of_a_point_or_a_segment_count():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [3, 0, 0], [0, 5, 0]], float)
    asked = NearestTriangles(vertices, [[3, 3, 3], [0, 1, 2], [1, 1, 2]])
    places, found = asked.nearest([[2, 1, 0], [-1, -1, 0], [0, 4, 1]])
    np.testing.assert_allclose(places, [[2, 0, 0], [0, 0, 0], [0, 5, 0]], atol=1e-15)
    np.testing.assert_array_equal(found, [1, 1, 0])


def test_huge_triangles_beside_tiny_ones_are_found():
    """The centre of the nearest is far away, and the centres of thousands of others are nearer."""
    tiny = icosphere(2)
    sizes = 10.0 ** RANDOM.uniform(-6, 0, 20)
    spread = [size * tiny.vertices + RANDOM.uniform(-2, 2, 3) for size in sizes]
    huge = RANDOM.normal(size=(60, 3)) * 10.0 ** RANDOM.uniform(0, 4, (20, 1)).repeat(3, axis=0)
    vertices = np.concatenate([*spread, huge])
    blocks = [tiny.triangles + k * tiny.vertex_count for k in range(20)]
    triangles = np.concatenate([*blocks, np.arange(60).reshape(-1, 3) + 20 * tiny.vertex_count])
    small = around(np.concatenate(spread), np.concatenate(blocks), 50)
    on = np.einsum("pc,pcx->px", RANDOM.dirichlet(np.ones(3), 20), huge.reshape(-1, 3, 3))
    assert_nearest(vertices, triangles, np.concatenate([small, on, on + RANDOM.normal(size=on.shape)]))


def test_the_first_triangle_counts_where_several_are_as_near():
    mesh = icosphere(3)
    first = np.full(mesh.vertex_count, mesh.triangle_count)
    np.minimum.at(first, mesh.triangles.ravel(), np.repeat(np.arange(mesh.triangle_count), 3))
    asked = NearestTriangles(mesh.vertices, mesh.triangles)
    np.testing.assert_array_equal(asked.nearest(mesh.vertices)[1], first)
    points = around(mesh.vertices, mesh.triangles)
    twice = NearestTriangles(mesh.vertices, np.concatenate([mesh.triangles, mesh.triangles]))
    np.testing.assert_array_equal(twice.nearest(points)[1], asked.nearest(points)[1])


def test_parts_that_are_looked_at_together_do_not_matter(monkeypatch):
    """The middle of a sphere, from which nothing can be ruled out, beside points that are near."""
    mesh = icosphere(3)
    points = np.concatenate([np.zeros((3, 3)), around(mesh.vertices, mesh.triangles)])
    expected = NearestTriangles(mesh.vertices, mesh.triangles).nearest(points)
    monkeypatch.setattr(nearest, "BATCH", 7)
    monkeypatch.setattr(nearest, "BRANCHES", 3)
    found = NearestTriangles(mesh.vertices, mesh.triangles).nearest(points)
    np.testing.assert_allclose(found[0][3:], expected[0][3:], atol=1e-15)
    np.testing.assert_array_equal(found[1][3:], expected[1][3:])
    apart = np.linalg.norm(found[0][:3], axis=1)
    np.testing.assert_allclose(apart, np.linalg.norm(mesh.vertices[mesh.triangles].mean(axis=1), axis=1).min())


def test_pickles_hold_the_arrays_and_answer_the_same():
    mesh = cube(4)
    asked, points = NearestTriangles(mesh.vertices, mesh.triangles), around(mesh.vertices, mesh.triangles)
    expected = asked.nearest(points)
    text = pickle.dumps(asked)
    assert len(text) < mesh.vertices.nbytes + mesh.triangles.nbytes + 1000
    for got, right in zip(pickle.loads(text).nearest(points), expected, strict=True):
        np.testing.assert_array_equal(got, right)


def test_no_points_have_no_places_and_no_triangles_are_refused():
    mesh = slivers()
    places, found = NearestTriangles(mesh.vertices, mesh.triangles).nearest(np.empty((0, 3)))
    assert places.shape == (0, 3)
    assert found.shape == (0,)
    with pytest.raises(MeshError, match="no faces"):
        NearestTriangles(mesh.vertices, np.empty((0, 3), int))


def test_the_nearest_point_that_looks_along_a_normal_is_on_that_side_of_a_sheet():
    """Two sheets at the same place, one of them turned over."""
    mesh = cube(4)
    both = np.concatenate([mesh.triangles, mesh.triangles[:, ::-1]])
    search = NearestTriangles(mesh.vertices, both)
    points = mesh.vertices[mesh.triangles].mean(axis=1) + RANDOM.normal(0, 0.01, (mesh.triangle_count, 3))
    plain, _ = search.nearest(points)
    for normals, is_first in ((mesh.face_normals, True), (-mesh.face_normals, False)):
        places, triangles = search.nearest_facing(points, normals)
        np.testing.assert_allclose(places, plain, atol=1e-12)
        assert ((triangles < mesh.triangle_count) == is_first).all()


def test_the_nearest_of_a_few_triangles_is_on_one_and_seldom_another():
    mesh = icosphere(4)
    points = np.random.default_rng(1).standard_normal((500, 3))
    points *= np.random.default_rng(2).uniform(0.95, 1.05, (500, 1)) / np.linalg.norm(points, axis=1, keepdims=True)
    places, triangles = mesh.finder.nearby(points)
    best, _ = mesh.finder.nearest(points)
    away, least = (np.linalg.norm(points - found, axis=1) for found in (places, best))
    assert (away >= least - 1e-12).all() and np.isclose(away, least, atol=1e-12).mean() > 0.99
    weights = barycentric(mesh, triangles, places)
    assert weights.min() > -1e-9
    np.testing.assert_allclose(
        np.einsum("nk,nkx->nx", weights, mesh.vertices[mesh.triangles[triangles]]), places, atol=1e-12
    )


def test_distances_up_to_enough_are_not_improved_beyond_it():
    mesh = icosphere(3)
    points = 1.5 * mesh.vertices + 0.1
    near, exact = (np.linalg.norm(points - mesh.finder.nearest(points, enough)[0], axis=1) for enough in (0.5, 0.0))
    assert (near >= exact - 1e-12).all()
    far = exact > 0.5
    assert 0 < far.sum() < len(points)
    np.testing.assert_allclose(near[far], exact[far])
    assert near[~far].max() <= 0.5 + 1e-12


def test_vertices_without_a_triangle_do_not_matter():
    """Even where they have no finite place."""
    mesh, points = icosphere(2), RANDOM.uniform(-1.5, 1.5, (300, 3))
    wanted = NearestTriangles(mesh.vertices, mesh.triangles).nearest(points)
    for loose in (1e30, np.inf, np.nan):
        found = NearestTriangles(np.vstack([mesh.vertices, np.full(3, loose)]), mesh.triangles).nearest(points)
        for one, other in zip(found, wanted, strict=True):
            np.testing.assert_array_equal(one, other)
