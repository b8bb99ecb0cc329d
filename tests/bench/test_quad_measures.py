# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of quad meshes, on faces for which they are known."""

from itertools import product

import numpy as np
import pytest

from synch_fields.bench.quad_measures import figures, quad_mesh_of
from synch_fields.core.extract.quads.measure.quality import corner_angles
from synch_fields.core.geometry import TriangleMesh

SIDES = 6


def flat(height=0.0, sides=SIDES):
    """Squares of a unit square at a height: vertices and (f, 4) faces."""
    x, y = (a.ravel() for a in np.meshgrid(*2 * [np.linspace(0, 1, sides + 1)], indexing="ij"))
    vertex = np.arange((sides + 1) ** 2).reshape(sides + 1, -1)
    a, b, c, d = (vertex[i : i + sides, j : j + sides].ravel() for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))
    return np.column_stack([x, y, np.full(x.size, height)]), np.column_stack([a, b, c, d])


def triangles(faces):
    return np.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]])


def quads(vertices, faces):
    return quad_mesh_of(vertices, faces.ravel(), np.full(len(faces), 4))


def test_the_same_squares_are_at_no_distance_and_right():
    vertices, faces = flat()
    row = figures(quads(vertices, faces), TriangleMesh(vertices, triangles(faces)))
    assert row["distance"] == pytest.approx(0, abs=1e-12) and row["turned_faces"] == row["other_faces"] == 0
    assert row["angle_deviation"] == pytest.approx(0, abs=1e-9) and row["quad_share"] == 1
    assert row["faces"] == SIDES**2 and row["irregular_vertices"] == 0


@pytest.mark.parametrize("height", [0.2, -0.05])
def test_the_distance_is_that_of_parallel_planes(height):
    vertices, faces = flat()
    below = TriangleMesh(*[vertices, triangles(faces)])
    row = figures(quads(*flat(height)), below)
    assert row["distance"] == pytest.approx(abs(height), abs=1e-12)


def test_a_part_that_is_missing_counts():
    """Half of the sheet: the other half ends 1/2 away, which only the way back sees."""
    vertices, faces = flat()
    left = faces[vertices[faces].mean(axis=1)[:, 0] < 0.5]
    row = figures(quads(vertices, left), TriangleMesh(vertices, triangles(faces)))
    assert row["distance"] == pytest.approx(0.5)


def test_the_middle_of_a_wide_face_counts():
    """The tip of a tent is 0.3 above the middle of the one square below it."""
    tent = TriangleMesh(
        [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 0.5, 0.3)], [(k, (k + 1) % 4, 4) for k in range(4)]
    )
    one = quads(tent.vertices[:4], np.array([[0, 1, 2, 3]]))
    assert figures(one, tent)["distance"] == pytest.approx(0.3)


def test_loose_vertices_do_not_count():
    vertices, faces = flat()
    loose = np.concatenate([[(9, 9, 9)], vertices, [(5, 5, 5)]])
    given = TriangleMesh(vertices, triangles(faces))
    assert figures(quads(loose, faces + 1), given) == figures(quads(vertices, faces), given)


def test_faces_that_look_the_other_way_are_counted():
    vertices, faces = flat()
    turned = np.concatenate([faces[:5][:, ::-1], faces[5:]])
    assert figures(quads(vertices, turned), TriangleMesh(vertices, triangles(faces)))["turned_faces"] == 5


@pytest.mark.parametrize("pull", [0.1, 0.35])
def test_angles_go_on_over_180_degrees(pull):
    """A square whose corner is pulled in along its diagonal is a dart; against the triangle's formula."""
    corners = np.array([(0, 0, 0), (1, 0, 0), (1 - pull * 2, 1 - pull * 2, 0), (0, 1, 0)], float)
    turn = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))[0]
    found = corner_angles(quads(corners @ turn.T, np.array([[0, 1, 2, 3]])))
    half = np.degrees(np.arctan2(1 - 2 * pull, 2 * pull))
    np.testing.assert_allclose(found, [90, half, 360 - 90 - 2 * half, half], atol=1e-9)
    assert (found[2] > 180) == (pull > 0.25)


def test_every_vertex_of_a_cube_of_squares_is_irregular():
    corners = np.array(list(product((0.0, 1.0), repeat=3)))
    faces = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
    row = figures(quads(corners, faces), TriangleMesh(corners, triangles(faces)))
    assert row["irregular_vertices"] == 8 and row["euler_characteristic"] == row["given_characteristic"] == 2
    assert row["closed"] and row["given_closed"] and row["turned_faces"] == 0
    assert row["distance"] == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize(("faces", "expected"), [([(0, 1, 4, 5), (1, 2, 3, 4)], 0), ([(0, 1, 2, 3), (3, 4, 5, 0)], 4)])
def test_vertices_on_the_boundary_are_irregular_by_their_angle(faces, expected):
    """Two squares beside each other, and the same rectangle cut from corner to corner: two faces at two corners, and
    one at the middles of its long sides."""
    corners = np.array([(0, 0, 0), (1, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0), (0, 1, 0)], float)
    given = TriangleMesh(corners, [(0, 1, 5), (1, 4, 5), (1, 2, 4), (2, 3, 4)])
    row = figures(quads(corners, np.array(faces)), given)
    assert row["irregular_on_rim"] == expected and row["irregular_vertices"] == 0
    assert row["short_loop_share"] == 1
