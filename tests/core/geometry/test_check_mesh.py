# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad meshes are refused in one line that names the element and the remedy; harmless ones pass."""

import numpy as np
import pytest

from synch_fields.core.errors import MeshError, SynchError
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.check import check_mesh, coarse_mesh, coarse_places, far_vertices, refuse_far_vertices

from ..meshes import EVERY, cube, honeycomb_sphere, icosphere, mixed_torus, quad_torus, shared_mesh, square, together


def refusal(mesh, faces=None):
    """The one line with which a mesh is refused."""
    with pytest.raises(MeshError) as caught:
        check_mesh(mesh, faces)
    text = str(caught.value)
    assert isinstance(caught.value, SynchError)
    assert text and "\n" not in text and ": " in text
    return text


def strip(count, twisted):
    """A closed band of quads around the z axis, with or without a half twist."""
    angle = np.arange(count) * 2 * np.pi / count
    tilt = angle / 2 if twisted else np.zeros(count)
    centre = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(count)])
    side = np.column_stack([np.cos(tilt) * np.cos(angle), np.cos(tilt) * np.sin(angle), np.sin(tilt)])
    low, high = list(range(count)), list(range(count, 2 * count))
    following_low, following_high = low[1:] + low[:1], high[1:] + high[:1]
    if twisted:
        following_low[-1], following_high[-1] = high[0], low[0]
    triangles = np.concatenate(
        [np.column_stack([low, following_low, following_high]), np.column_stack([low, following_high, high])]
    )
    return TriangleMesh(np.vstack([centre - 0.3 * side, centre + 0.3 * side]), triangles)


@pytest.mark.parametrize(("build", "characteristic"), EVERY)
def test_good_meshes_pass(build, characteristic):
    check_mesh(build())


@pytest.mark.parametrize("build", [quad_torus, mixed_torus, honeycomb_sphere])
def test_good_polygons_pass(build):
    mesh, polygons = build()
    check_mesh(mesh, polygons.triangle_faces)


@pytest.mark.parametrize("name", ["spot", "fertility", "bumpy-cube", "fandisk"])
def test_real_meshes_pass(name):
    check_mesh(shared_mesh(name))


def test_an_empty_mesh_is_refused():
    text = refusal(TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int)))
    assert "empty" in text and "add" in text


def test_a_mesh_without_faces_is_refused():
    text = refusal(TriangleMesh([[0, 0, 0], [1, 0, 0]], np.zeros((0, 3), int)))
    assert "no faces" in text and "fill" in text


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_position_that_is_no_number_is_refused(value):
    mesh = square(4)
    mesh.vertices[7, 1] = value
    text = refusal(mesh)
    assert "vertex 7 has no finite position" in text and "delete it" in text


def test_many_bad_vertices_are_counted():
    mesh = square(4)
    mesh.vertices[[3, 7, 9, 11, 20]] = np.nan
    assert "vertices 3, 7, 9 and 2 more have no finite position" in refusal(mesh)


def test_a_face_without_area_is_refused():
    mesh = square(4)
    mesh.vertices[12] = mesh.vertices[11]
    hit = np.flatnonzero((mesh.triangles == 11).any(1) & (mesh.triangles == 12).any(1))
    text = refusal(TriangleMesh(mesh.vertices, mesh.triangles))
    assert text.startswith(f"faces {hit[0]}, {hit[1]} have no area") and "Degenerate Dissolve" in text


def test_a_face_with_a_repeated_corner_is_refused():
    mesh = square(4)
    triangles = np.vstack([mesh.triangles, [0, 0, 1]])
    assert f"face {len(mesh.triangles)} has no area" in refusal(TriangleMesh(mesh.vertices, triangles))


def test_a_flat_triangle_inside_a_polygon_is_no_flat_face():
    # A square with a corner in the middle of one side, fanned from that corner's neighbour.
    points = [[0, 0, 0], [0.5, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    mesh = TriangleMesh(points, [[0, 1, 2], [0, 2, 3], [0, 3, 4]])
    check_mesh(mesh, [0, 0, 0])
    assert "face 0 has no area" in refusal(mesh)


def test_the_users_face_is_named():
    mesh, polygons = quad_torus()
    face = 17
    mesh.vertices[polygons.corner_vertices[4 * face : 4 * face + 4]] = mesh.vertices[polygons.corner_vertices[4 * face]]
    text = refusal(TriangleMesh(mesh.vertices, mesh.triangles), polygons.triangle_faces)
    assert text.startswith(f"face {face} has no area")


@pytest.mark.parametrize("order", [(0, 1, 2), (1, 2, 0), (2, 1, 0)])
def test_a_face_on_top_of_another_is_refused(order):
    mesh = square(4)
    doubled = np.vstack([mesh.triangles, mesh.triangles[5][list(order)]])
    text = refusal(TriangleMesh(mesh.vertices, doubled))
    assert f"face {len(mesh.triangles)} has the same corners as another face" in text and "Only Faces" in text


def test_an_edge_with_three_faces_is_refused():
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]]
    text = refusal(TriangleMesh(points, [[0, 1, 2], [1, 0, 3], [0, 1, 4]]))
    assert "the edge between vertices 0 and 1 has 3 faces" in text and "Non Manifold" in text


def test_faces_that_face_opposite_ways_are_refused():
    mesh = cube(3)
    turned = mesh.triangles.copy()
    turned[10] = turned[10][::-1]
    text = refusal(TriangleMesh(mesh.vertices, turned))
    assert "face opposite ways" in text and "Recalculate Outside" in text
    named = {int(word) for word in text.split("at the edge")[0].replace("faces", "").split() if word.isdigit()}
    assert 10 in named and len(named) == 2
    i, j = (int(word) for word in text.split("between vertices")[1].split("face")[0].split() if word.isdigit())
    assert {i, j} <= set(turned[10].tolist())


@pytest.mark.parametrize("count", [3, 12, 13])
def test_a_moebius_strip_is_refused_as_one_sided(count):
    text = refusal(strip(count, twisted=True))
    assert "one-sided" in text and "cut it open" in text and "edge between vertices" in text
    check_mesh(strip(count, twisted=False))


def test_faces_that_touch_at_a_point_are_refused():
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]]
    text = refusal(TriangleMesh(points, [[0, 1, 2], [0, 3, 4]]))
    assert "vertex 0 has faces that touch only at this point" in text and "rip" in text


def test_closed_pieces_that_touch_at_a_point_are_refused():
    ball = icosphere(1)
    mesh = together(ball, ball)
    joined = np.where(mesh.triangles == ball.vertex_count + 4, 2, mesh.triangles)
    text = refusal(TriangleMesh(mesh.vertices, joined))
    assert "vertex 2 has faces that touch only at this point" in text


def test_the_piece_is_named_where_there_are_several():
    mesh = together(square(4), square(4))
    mesh.vertices[30] = np.nan
    text = refusal(mesh)
    assert "vertex 30" in text and "in the piece of vertex 25, one of 2" in text


def test_loose_vertices_are_harmless():
    check_mesh(together(square(3), loose=3))


def test_needles_of_a_ten_trillionth_of_the_area_are_no_flat_faces():
    mesh = next(p.values[0] for p in EVERY if p.id == "slivers")()
    assert mesh.areas.min() < 1.1e-13 * mesh.areas.sum()
    check_mesh(mesh)


@pytest.mark.parametrize("mesh", [icosphere(3), square(12), cube(6)], ids=["ball", "square", "cube"])
@pytest.mark.parametrize("count", [1, 3])
def test_few_vertices_far_out_are_named(mesh, count):
    vertices = mesh.vertices.copy()
    vertices[7 : 7 + count] += [1e6, 2e7, 0]
    spiked = TriangleMesh(vertices, mesh.triangles)
    np.testing.assert_array_equal(far_vertices(vertices, spiked.edges), 7 + np.arange(count))
    line = "vertex 7 lies 2e.07 .*: delete it" if count == 1 else "vertices 7, 8, 9 lie 2e.07 .*: delete them"
    with pytest.raises(MeshError, match=line):
        refuse_far_vertices(spiked)


@pytest.mark.parametrize("shift", [0.0, 2.0**22, 1e7])
def test_an_object_far_out_is_not_blamed_on_single_vertices(shift):
    mesh = icosphere(3)
    vertices = mesh.vertices + [shift - 0.9, 0, 0]
    assert len(far_vertices(vertices, mesh.edges)) == 0
    refuse_far_vertices(TriangleMesh(vertices, mesh.triangles))
    assert ("move the object" in coarse_places(vertices, mesh.edges)) == (shift > 0)
    shifted = TriangleMesh(vertices, mesh.triangles)
    assert [coarse_mesh(shifted), coarse_mesh(shifted)] == 2 * [coarse_places(vertices, mesh.edges)]
