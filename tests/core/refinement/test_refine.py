# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A finer copy has the same surface, short edges, and knows where it lies on the mesh that it was made of."""

import numpy as np
import pytest

from synch_fields.core.errors import AsymmetryError, SettingError
from synch_fields.core.geometry import TriangleMesh, check_mesh
from synch_fields.core.geometry.mesh_input import ObjectMesh
from synch_fields.core.geometry.mirror import mirrored_vertices
from synch_fields.core.geometry.polygons import Polygons
from synch_fields.core.refinement import TooFineError, bound_surface, division, refine

from ..meshes import icosphere, octahedron, rounded_cube, subdivided

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
QUADS = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])


def edges_of(faces):
    """(e, 2) of faces that all have as many corners."""
    return np.unique(np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1), axis=0)


def refined(vertices, faces, longest, axes=(), stretch=None, may_replace=False):
    faces = np.asarray(faces)
    count, size = faces.shape
    starts, last = size * np.arange(count), np.arange(2, size)
    fans = np.stack([np.zeros_like(last), last - 1, last], axis=1)
    corners = (starts[:, None, None] + fans).reshape(-1, 3)
    owners = np.repeat(np.arange(count), size - 2)
    polygons = Polygons(faces.ravel(), starts, np.full(count, size), corners, owners)
    read = ObjectMesh("mesh", np.asarray(vertices, float), polygons, np.eye(3) if stretch is None else stretch)
    return refine(read, edges_of(faces), longest, axes, may_replace)


def as_mesh(bound):
    return TriangleMesh(bound.vertices, bound.corner_vertices.reshape(-1, 3))


@pytest.fixture(scope="module")
def cube():
    return refined(CUBE, QUADS, 0.1)


def test_a_cube_is_the_same_closed_cube_with_short_edges(cube):
    mesh = as_mesh(cube)
    check_mesh(mesh)
    assert len(mesh.boundary_edges) == 0 and mesh.euler_characteristic == 2
    assert mesh.areas.sum() == pytest.approx(6)
    assert mesh.edge_lengths.max() <= 0.1
    assert np.array_equal(cube.vertices[:8], CUBE)


def test_vertices_and_corners_lie_where_their_parents_say(cube):
    assert cube.weights.sum(axis=1) == pytest.approx(1)
    np.testing.assert_allclose(np.einsum("vk,vkx->vx", cube.weights, CUBE[cube.parents]), cube.vertices, atol=1e-15)
    at_corners = np.einsum("ck,ckx->cx", cube.corner_weights, CUBE[QUADS.ravel()[cube.corner_parents]])
    np.testing.assert_allclose(at_corners, cube.vertices[cube.corner_vertices], atol=1e-15)
    assert np.array_equal(cube.corner_parents // 4, np.repeat(cube.face_source, 3)[:, None].repeat(3, axis=1))


def test_edges_of_the_object_are_covered_by_edges_on_them(cube):
    ends = cube.vertices[cube.edge_vertices]
    lengths = np.bincount(cube.edge_source, np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1))
    assert lengths == pytest.approx(np.ones(12))
    line = CUBE[edges_of(QUADS)[cube.edge_source]]
    along = (line[:, 1] - line[:, 0])[:, None]
    assert np.abs(np.cross(ends - line[:, :1], along)).max() < 1e-15


def test_lengths_are_measured_as_stretched():
    bound = refined(CUBE, QUADS, 1.0, stretch=np.diag([4.0, 1.0, 1.0]))
    lengths = np.linalg.norm(
        np.diff(bound.vertices[edges_of(bound.corner_vertices.reshape(-1, 3))], axis=1)[:, 0], axis=1
    )
    assert TriangleMesh(bound.vertices * [4, 1, 1], bound.corner_vertices.reshape(-1, 3)).edge_lengths.max() <= 1
    assert lengths.max() > 0.5


def test_faces_with_short_edges_stay_as_they_are():
    strip = np.array([[0, 0, 0], [1, 0, 0], [11, 0, 0], [0, 1, 0], [1, 1, 0], [11, 1, 0]], float)
    bound = refined(strip, [[0, 1, 4, 3], [1, 2, 5, 4]], 2.0)
    assert np.array_equal(bound.corner_vertices[:4], [0, 1, 4, 3])
    assert np.array_equal(bound.corner_parents[:4, 0], np.arange(4))
    assert len(bound.starts) > 8 and np.array_equal(bound.face_source, np.sort(bound.face_source))
    sizes = np.diff(bound.starts, append=len(bound.corner_vertices))
    assert np.array_equal(np.unique(sizes), [3, 4])


@pytest.mark.parametrize("noise", [0.0, 1e-9])
def test_triangles_that_share_no_vertex_become_one_surface(noise):
    mesh = as_mesh(refined(CUBE, QUADS, 0.5))
    soup = mesh.vertices[mesh.triangles].reshape(-1, 3) * np.array([1, -1, 1]) + 0.0
    soup = soup + noise * np.random.default_rng(0).normal(size=soup.shape)
    soup[soup == 0] *= -1
    bound = refined(soup, np.arange(len(soup)).reshape(-1, 3), 2.0)
    assert bound.welded == len(soup) - mesh.vertex_count
    assert len(bound.vertices) == mesh.vertex_count and len(bound.starts) == mesh.triangle_count
    assert len(as_mesh(bound).boundary_edges) == 0


def test_closed_bodies_that_touch_are_not_joined():
    both = np.concatenate([CUBE, CUBE + [1, 0, 0]])
    bound = refined(both, np.concatenate([QUADS, QUADS + 8]), 2.0)
    assert bound.welded == 0 and len(bound.vertices) == 16


def side_of_cube(axis, end, parts):
    """Corners of the squares that a side of the cube is divided into, (parts², 4, 3), with normals to the outside."""
    steps = np.arange(parts) / parts
    squares = (np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 1, 2)) + CUBE[[0, 2, 6, 4], :2] / parts
    squares = np.insert(squares, 2, end, axis=2)
    return np.roll(squares if end == 0 else squares[:, ::-1], axis, axis=2)


@pytest.mark.parametrize("longest", [0.3, 2.0])
@pytest.mark.parametrize("share_vertices", [True, False])
def test_vertices_on_edges_of_other_faces_close_the_surface(longest, share_vertices):
    sides = [side_of_cube(axis, end, 1 + 2 * axis + end) for axis in range(3) for end in range(2)]
    places = np.concatenate(sides).reshape(-1, 3)
    faces = np.arange(len(places)).reshape(-1, 4)
    if share_vertices:
        places, numbers = np.unique(places.round(9), axis=0, return_inverse=True)
        faces = numbers.reshape(faces.shape)
    bound = refined(places, faces, longest)
    sizes = np.diff(bound.starts, append=len(bound.corner_vertices))
    polygons = np.split(bound.corner_vertices, bound.starts[1:])
    mesh = TriangleMesh(bound.vertices, [face[[0, k - 1, k]] for face in polygons for k in range(2, len(face))])
    check_mesh(mesh)
    assert len(mesh.boundary_edges) == 0 and mesh.euler_characteristic == 2 and set(sizes) <= {3, 4}
    assert mesh.areas.sum() == pytest.approx(6)
    assert bound.welded > 0
    at_corners = np.einsum("ck,ckx->cx", bound.corner_weights, places[faces.ravel()[bound.corner_parents]])
    np.testing.assert_allclose(at_corners, bound.vertices[bound.corner_vertices], atol=1e-8)


@pytest.mark.parametrize("high", [1e-9, 3e-6])
@pytest.mark.parametrize("beside", [1, 9])
def test_slivers_between_vertices_on_a_line_leave_no_gap(high, beside):
    triangles = QUADS[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
    on_edge = np.array([[high, high, 1 / 3], [high, high, 2 / 3]])  # from vertex 0 to vertex 1
    whole = (np.sort(triangles) == [0, 1, 5]).all(axis=1)
    assert whole.sum() == 1
    fans = [[8, 0, 5], [9, 8, 5], [1, 9, 5], [0, 8, 1], [8, 9, 1]]
    far = CUBE * beside + 2  # another cube, so that the gaps are a small part of the whole
    both = np.concatenate([CUBE, on_edge, far]), np.concatenate([triangles[~whole], fans, triangles + 10])
    mesh = as_mesh(refined(*both, 0.3))
    check_mesh(mesh)
    assert len(mesh.boundary_edges) == 0 and mesh.euler_characteristic == 4
    assert mesh.areas.sum() == pytest.approx(6 + 6 * beside**2)
    assert mesh.areas.min() > 1e-5


def test_vertices_on_edges_that_close_nothing_split_nothing():
    sheet = [[0, 0, 0], [4, 0, 0], [4, 1, 0], [0, 1, 0], [2, 0, 0], [1, -1, 0], [3, -1, 0]]
    needle = [[0, 5, 0], [4, 5, 0], [2, 5 + 2e-5, 0]]
    bound = refined(sheet + needle, [[0, 1, 2], [0, 2, 3], [4, 5, 6], [7, 8, 9]], 9.0)
    assert bound.welded == 0 and len(bound.starts) == 4 and len(bound.vertices) == 10


def test_a_hole_stays_open_where_nothing_lies_on_its_other_side():
    bound = refined(CUBE, QUADS[:5], 0.3)
    assert bound.welded == 0
    assert len(as_mesh(bound).boundary_edges) == 4 * 4


@pytest.mark.parametrize("reach", [30.0, 1e3, 1e6, 1e9])
@pytest.mark.parametrize("ball", [icosphere(3), subdivided(octahedron()), rounded_cube(8)], ids=["20", "8", "6"])
def test_needles_become_strips_of_few_triangles(ball, reach):
    vertices = ball.vertices.copy()
    vertices[0] *= reach
    spiked, longest = TriangleMesh(vertices, ball.triangles), reach / 700
    bound = refined(vertices, ball.triangles, longest)
    mesh = as_mesh(bound)
    check_mesh(mesh)
    assert len(mesh.boundary_edges) == 0 and mesh.euler_characteristic == ball.euler_characteristic
    assert mesh.edge_lengths.max() <= longest
    areas = np.bincount(bound.face_source, mesh.areas)
    np.testing.assert_allclose(areas, spiked.areas, rtol=1e-6)
    normals = np.cross(*(vertices[ball.triangles[:, k]] - vertices[ball.triangles[:, 0]] for k in (1, 2)))
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    sides = np.einsum("fx,fx->f", np.cross(b - a, c - a), normals[bound.face_source])
    assert sides.min() > 0
    parts = np.ceil(spiked.edge_lengths / longest)[spiked.triangle_edges]
    assert (np.bincount(bound.face_source) <= 8 * (parts.sum(axis=1) + parts.prod(axis=1) / parts.max(axis=1))).all()


def test_too_many_triangles_are_refused_with_a_length_that_works(monkeypatch):
    monkeypatch.setattr(bound_surface, "MOST_TRIANGLES", 1000)
    with pytest.raises(TooFineError, match=r"edges of at most 0.05 .* ask for edges of 0\.[0-9]+") as error:
        refined(CUBE, QUADS, 0.05)
    assert 100 < len(refined(CUBE, QUADS, 0.05 * error.value.factor).starts) <= 1000


def test_the_length_that_works_works_as_it_is_rounded(monkeypatch):
    """1.25^12 times this length is a little more than 1/32: rounded to the nearest, edges would be halved once more."""
    monkeypatch.setattr(bound_surface, "MOST_TRIANGLES", 1000)
    triangle = np.array([[0, 0, 0], [1, 0, 0], [0.5, np.sqrt(0.75), 0]])
    with pytest.raises(TooFineError) as error:
        refined(triangle, np.array([[0, 1, 2]]), 0.0021748106244646043)
    refined(triangle, np.array([[0, 1, 2]]), float(str(error.value).split("edges of ")[-1]))


def test_edges_far_too_fine_are_refused_before_triangles_are_made(monkeypatch):
    made, halved = [], division._halve_edges

    def count_triangles(*arguments):
        found = halved(*arguments)
        made.append(len(found[1]) + len(found[2]))
        return found

    monkeypatch.setattr(division, "_halve_edges", count_triangles)
    monkeypatch.setattr(bound_surface, "MOST_TRIANGLES", 10_000)
    spiked = np.vstack([CUBE[:-1], 1e9 * CUBE[-1:]])
    with pytest.raises(TooFineError):
        refined(spiked, QUADS, 1.0)
    assert sum(made) < 40_000


def slanted_block():
    """A block with edges on the plane X = 0 and faces across Y = 0."""
    x, y = np.meshgrid([-2.0, -1.0, 0.0, 1.0, 2.0], [-1.5, 1.5], indexing="ij")
    rings = np.stack([np.stack([x, y, np.full_like(x, z) - 0.1 * x**2], axis=-1) for z in (0.0, 1.0)])
    number = np.arange(20).reshape(2, 5, 2)
    faces = [[number[0, k, 0], number[0, k, 1], number[0, k + 1, 1], number[0, k + 1, 0]] for k in range(4)]
    faces += [[number[1, k, 0], number[1, k + 1, 0], number[1, k + 1, 1], number[1, k, 1]] for k in range(4)]
    faces += [[number[0, k, 0], number[0, k + 1, 0], number[1, k + 1, 0], number[1, k, 0]] for k in range(4)]
    faces += [[number[0, k + 1, 1], number[0, k, 1], number[1, k, 1], number[1, k + 1, 1]] for k in range(4)]
    faces += [[number[0, 0, 1], number[0, 0, 0], number[1, 0, 0], number[1, 0, 1]]]
    faces += [[number[0, 4, 0], number[0, 4, 1], number[1, 4, 1], number[1, 4, 0]]]
    return rings.reshape(-1, 3), np.array(faces)


@pytest.mark.parametrize("longest", [0.11, 0.3, 1.7, 9.0])
@pytest.mark.parametrize("axes", [(0,), (1,), (0, 1)], ids=["X", "Y", "XY"])
@pytest.mark.parametrize("noise", [0.0, 1e-6])
def test_a_mirrored_surface_is_its_own_mirror_image(axes, longest, noise):
    """Vertices on the plane may lie a little beside it, as where the object's scale comes from a rotated matrix."""
    vertices, faces = slanted_block()
    vertices[vertices[:, 0] == 0, 0] = noise
    bound = refined(vertices, faces, longest, axes=axes)
    sizes = np.diff(bound.starts, append=len(bound.corner_vertices))
    fans = np.concatenate(
        [[[k, k + i, k + i + 1] for i in range(1, size - 1)] for k, size in zip(bound.starts, sizes, strict=True)]
    )
    of_fans = np.repeat(np.arange(len(sizes)), sizes - 2)
    mesh = TriangleMesh(bound.vertices, bound.corner_vertices[fans])
    polygons = Polygons(bound.corner_vertices, bound.starts, sizes, fans, of_fans)
    for axis in axes:
        partner = mirrored_vertices(mesh, polygons, axis)
        mirror = np.where(np.arange(3) == axis, -1, 1)
        np.testing.assert_allclose(mesh.vertices[partner], mesh.vertices * mirror, atol=1e-14 + 2 * noise)
    check_mesh(mesh)
    assert mesh.euler_characteristic == 2 and mesh.areas.sum() == pytest.approx(surface_area(vertices, faces))
    volume = np.einsum("ij,ij->i", mesh.vertices[mesh.triangles[:, 0]], mesh.face_normals * mesh.areas[:, None]).sum()
    assert volume > 0, "faces look outward"
    if longest < 1:
        assert mesh.edge_lengths.max() <= longest + noise
    np.testing.assert_allclose(np.einsum("vk,vkx->vx", bound.weights, vertices[bound.parents]), bound.vertices)
    at_corners = np.einsum("ck,ckx->cx", bound.corner_weights, vertices[faces.ravel()[bound.corner_parents]])
    np.testing.assert_allclose(at_corners, bound.vertices[bound.corner_vertices], atol=1e-14)
    of_corners = np.repeat(bound.face_source, sizes)
    assert (bound.corner_parents // 4 == of_corners[:, None]).all()
    ends = bound.vertices[bound.edge_vertices]
    lengths = np.bincount(bound.edge_source, np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1))
    own = vertices[edges_of(faces)]
    assert lengths == pytest.approx(np.linalg.norm(own[:, 0] - own[:, 1], axis=1))


def surface_area(vertices, faces):
    """Of planar quads."""
    a, b, c, d = np.moveaxis(vertices[faces], 1, 0)
    return 0.5 * np.linalg.norm(np.cross(c - a, d - b), axis=1).sum()


def test_a_mesh_that_is_not_symmetric_is_refused_by_its_own_vertices():
    bent = CUBE - 0.5
    bent[3] += 0.2
    with pytest.raises(AsymmetryError) as error:
        refined(bent, QUADS, 0.1, axes=(1,))
    assert 3 in error.value.vertices and max(error.value.vertices) < 8


def rotated_ball(level):
    """A sphere whose triangles have no mirror images."""
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    return icosphere(level).vertices @ turn.T * np.sign(np.linalg.det(turn)), icosphere(level).triangles


@pytest.mark.parametrize("axes", [(0,), (2,), (0, 1), (0, 1, 2)])
def test_the_positive_side_replaces_another_one_with_other_triangles(axes):
    vertices, triangles = rotated_ball(3)
    with pytest.raises(AsymmetryError):
        refined(vertices, triangles, 0.1, axes)
    bound = refined(vertices, triangles, 0.1, axes, may_replace=True)
    mesh = as_mesh(bound)
    check_mesh(mesh)
    assert len(mesh.boundary_edges) == 0 and mesh.euler_characteristic == 2
    whole = TriangleMesh(vertices, triangles)
    assert mesh.areas.sum() == pytest.approx(whole.areas.sum(), rel=0.01) and mesh.edge_lengths.max() <= 0.1
    for axis in axes:
        mirrored_vertices(mesh, Polygons.of_triangles(mesh), axis)
    # Each side lies where its parents say; that which was replaced nearly.
    chord = 1 - np.linalg.norm(whole.vertices[whole.triangles].mean(axis=1), axis=1).min()
    at_corners = np.einsum("ck,ckx->cx", bound.corner_weights, vertices[triangles.ravel()[bound.corner_parents]])
    away = np.linalg.norm(at_corners - bound.vertices[bound.corner_vertices], axis=1)
    is_kept = (bound.vertices[bound.corner_vertices][:, list(axes)] > 0.2).all(axis=1)
    assert away[is_kept].max() < 1e-12 and away.max() < 0.5 * whole.edge_lengths.max()
    assert bound.corner_weights.min() > -1e-15 and bound.corner_weights.sum(axis=1) == pytest.approx(1)
    assert (bound.corner_parents // 3 == bound.face_source.repeat(3)[:, None]).all()
    assert 0 < bound.apart < 2 * chord


def test_what_replaces_the_other_side_says_how_far_it_was():
    bent = CUBE - 0.5
    bent[3] -= [0.2, 0, 0]  # at negative X
    bound = refined(bent, QUADS, 0.3, axes=(0,), may_replace=True)
    mesh = as_mesh(bound)
    assert mesh.euler_characteristic == 2 and mesh.areas.sum() == pytest.approx(6)
    assert bound.apart == pytest.approx(0.2)


def test_a_wall_in_the_mirror_plane_is_not_kept_between_both_sides():
    mesh = as_mesh(refined(CUBE, QUADS, 0.3, axes=(0,), may_replace=True))
    check_mesh(mesh)
    assert np.ptp(mesh.vertices, axis=0) == pytest.approx([2, 1, 1])
    assert mesh.euler_characteristic == 2 and mesh.areas.sum() == pytest.approx(10)
    with pytest.raises(SettingError, match="nothing of the mesh is on the positive side of the mirror in X"):
        refined(CUBE - [1, 0, 0], QUADS, 0.3, axes=(0,), may_replace=True)


def test_faces_in_the_mirror_plane_stay():
    block, faces = slanted_block()
    fin = np.array([[0.0, 3, 0], [0, 5, 0], [0, 5, 2], [0, 3, 2]])
    bound = refined(np.vstack([block, fin]), np.vstack([faces, len(block) + np.arange(4)]), 0.5, axes=(0,))
    on_fin = bound.face_source == len(faces)
    mesh = as_mesh(bound)
    assert mesh.areas[on_fin].sum() == pytest.approx(4) and on_fin.sum() >= 32
    assert mesh.areas.sum() == pytest.approx(4 + surface_area(block, faces))
