# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces that are no quads, made quads with the quads between them."""

import numpy as np
import pytest

from synch_fields.core.extract.quads.repair.all_quads import all_quads
from synch_fields.core.extract.quads.trace.quad_mesh import QuadMesh
from synch_fields.core.geometry import TriangleMesh

from ...meshes import grid_quads, square_points
from ...topology import euler, face_vectors, is_surface

# What the meshes here lie on.
PLANE = TriangleMesh(np.array([[-9.0, -9, 0], [99, -9, 0], [99, 99, 0], [-9, 99, 0]]), np.array([[0, 1, 2], [0, 2, 3]]))


def mesh_of(points, faces):
    return QuadMesh(
        np.asarray(points, float),
        np.zeros(len(points), int),
        np.full((len(points), 3), 1 / 3),
        np.concatenate([np.asarray(face) for face in faces]),
        np.array([len(face) for face in faces]),
    )


def grid(columns=6, rows=5):
    return square_points(columns, rows, columns, rows), [list(face) for face in grid_quads(columns, rows)]


def slipped(length):
    """A grid in which one side of a row of quads has slipped by a vertex: a triangle, quads askew and a pentagon."""
    points, faces = grid(8, 3)
    across = 4
    first = 1 * across + 1
    row = [faces.index([k, k + across, k + across + 1, k + 1]) for k in first + across * np.arange(length + 2)]
    bottom = [first + across * k for k in range(length + 3)]
    top = [k + 1 for k in bottom]
    made = [[bottom[0], bottom[1], top[0]]]
    made += [[bottom[k], bottom[k + 1], top[k], top[k - 1]] for k in range(1, length + 1)]
    made += [[bottom[length + 1], bottom[length + 2], top[length + 2], top[length + 1], top[length]]]
    return points, [face for k, face in enumerate(faces) if k not in row] + made


@pytest.mark.parametrize("length", range(5))
def test_a_triangle_and_a_pentagon_become_quads(length):
    points, faces = slipped(length)
    before = mesh_of(points, faces)
    assert sorted(np.unique(before.sizes)) == [3, 4, 5] and is_surface(before)
    after, _ = all_quads(before, PLANE)
    assert (after.sizes == 4).all() and is_surface(after) and euler(after) == 1
    np.testing.assert_array_equal(after.vertices, before.vertices)
    # The row is as it was before it slipped: all faces are unit squares again.
    np.testing.assert_allclose(face_vectors(after)[:, 2], 1, atol=1e-12)


def test_a_hexagon_falls_into_two_and_quads_stay_bit_for_bit():
    points, faces = grid()
    joined = [*faces[0], *[k for k in faces[5] if k not in faces[0]]]
    hexagon = [faces[0][0], faces[0][1], *faces[5][1:3], faces[0][2], faces[0][3]]
    assert set(hexagon) == set(joined)
    before = mesh_of(points, [hexagon, *(face for k, face in enumerate(faces) if k not in (0, 5))])
    after, _ = all_quads(before, PLANE)
    assert len(after.sizes) == len(faces) and (after.sizes == 4).all()
    whole = mesh_of(points, faces)
    assert all_quads(whole, PLANE)[0] is whole
    assert {frozenset(e) for e in after.edges[0].tolist()} == {frozenset(e) for e in whole.edges[0].tolist()}


def test_a_lonely_odd_face_takes_a_vertex_from_the_boundary():
    points, faces = grid()
    before = mesh_of(points, [faces[0][:3], *faces[1:]])
    after, _ = all_quads(before, PLANE)
    assert (after.sizes == 4).all() and is_surface(after) and euler(after) == 1
    assert len(after.vertices) == len(points) + 1
    area = face_vectors(before)[:, 2].sum()
    assert face_vectors(after)[:, 2].sum() == pytest.approx(area) and (face_vectors(after)[:, 2] > 0).all()
    corners = PLANE.vertices[PLANE.triangles[after.triangles[-1]]]
    np.testing.assert_allclose(after.weights[-1] @ corners, after.vertices[-1], atol=1e-12)


def test_an_edge_of_no_length_is_not_halved():
    """A triangle whose edge on the boundary has no length takes its vertex from another edge of the boundary."""
    points = [(0, 0, 0), (1e-9, 0, 0), (0.5, 1, 0), (-0.5, 1, 0), (1.5, 0, 0), (1.5, 1, 0)]
    before = mesh_of(points, [(0, 1, 2), (0, 2, 3), (1, 4, 5, 2)])
    after, _ = all_quads(before, PLANE)
    made = after.vertices[len(points) :]
    assert (np.linalg.norm(made, axis=1) > 0.1).all()


def test_an_edge_that_stays_is_halved_where_the_way_between_odd_faces_crosses_it():
    points, faces = grid(2, 3)
    before = mesh_of(points, [faces[0][1:], *faces[1:-1], np.delete(faces[-1], 2)])
    assert sorted(before.sizes) == [3, 3, 4, 4, 4, 4]
    after, _ = all_quads(before, PLANE, [(4, 5), (5, 6), (6, 7)])
    assert (after.sizes == 4).all() and is_surface(after) and euler(after) == 1
    begin, end = np.moveaxis(after.vertices[after.edges[0]], 1, 0)
    on_line = np.isclose(begin[:, 0], 1) & np.isclose(end[:, 0], 1)
    assert np.linalg.norm(end - begin, axis=1)[on_line].sum() == pytest.approx(3) and on_line.sum() == 4


def test_without_such_edges_the_faces_between_are_cut_as_one():
    points, faces = grid(2, 3)
    before = mesh_of(points, [faces[0][1:], *faces[1:-1], np.delete(faces[-1], 2)])
    after, _ = all_quads(before, PLANE)
    assert (after.sizes == 4).all() and len(after.vertices) == len(points) - 2


def test_a_halved_edge_keeps_its_length_where_the_surface_on_its_side_ends_at_a_corner():
    below, above = [[0, -9, 0], [0, 9, 0]], [[1, 9, 0.2], [1, -9, 0.2]]
    surface = TriangleMesh(
        np.array([[-9.0, -9, 0], [-9, 9, 0], *below, *above]),
        np.array([[0, 2, 3], [0, 3, 1], [2, 3, 4], [2, 4, 5]]),
    )
    assert surface.face_normals[0, 2] > 0 > surface.face_normals[2, 2]
    ends = [[0, 0, 0], [1, 0, 0.2]]
    quads, _ = all_quads(mesh_of([*ends, [0.5, 1, 0.1], [0.5, -1, 0.1]], [[0, 1, 2], [1, 0, 3]]), surface, [(0, 1)])
    assert (quads.sizes == 4).all()
    np.testing.assert_allclose(quads.vertices[4], np.mean(ends, axis=0), atol=1e-12)
