# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Edges, half-edges, pieces and boundaries of triangle meshes, against counting by hand."""

from collections import defaultdict

import numpy as np
import pytest

from synch_fields.core.geometry import TriangleMesh

from ..meshes import EVERY, annulus, cube, cylinder, icosphere, square, together, torus


def half_edges_by_pair(mesh):
    """Half-edges 3 t + k of every unordered pair of vertices."""
    pairs = defaultdict(list)
    for t, triangle in enumerate(mesh.triangles.tolist()):
        for k in range(3):
            pairs[tuple(sorted((triangle[k], triangle[(k + 1) % 3])))].append(3 * t + k)
    return pairs


@pytest.mark.parametrize(("build", "characteristic"), EVERY)
def test_edges_are_the_pairs_of_neighbouring_corners(build, characteristic):
    mesh = build()
    pairs = half_edges_by_pair(mesh)
    assert [tuple(e) for e in mesh.edges.tolist()] == sorted(pairs)
    assert mesh.edge_face_counts.tolist() == [len(pairs[p]) for p in sorted(pairs)]
    for edge, pair in enumerate(sorted(pairs)):
        for half in pairs[pair]:
            assert mesh.triangle_edges.ravel()[half] == edge
            runs_upwards = mesh.triangles.ravel()[half] == pair[0]
            assert mesh.triangle_edge_signs.ravel()[half] == (1 if runs_upwards else -1)
    lengths = [np.linalg.norm(mesh.vertices[i] - mesh.vertices[j]) for i, j in sorted(pairs)]
    np.testing.assert_allclose(mesh.edge_lengths, lengths, rtol=1e-14)


@pytest.mark.parametrize(("build", "characteristic"), EVERY)
def test_twins_are_the_same_edge_walked_the_other_way(build, characteristic):
    mesh = build()
    tails, heads = mesh.triangles.ravel(), np.roll(mesh.triangles, -1, axis=1).ravel()
    for halves in half_edges_by_pair(mesh).values():
        if len(halves) == 1:
            assert mesh.twins[halves[0]] == -1
        else:
            first, second = halves
            assert (mesh.twins[first], mesh.twins[second]) == (second, first)
            assert (tails[first], heads[first]) == (heads[second], tails[second])


@pytest.mark.parametrize(("build", "characteristic"), EVERY)
def test_euler_characteristic_counts_pieces_handles_and_holes(build, characteristic):
    assert build().euler_characteristic == characteristic


def test_boundaries_are_the_rims():
    mesh = annulus(inner=1, outer=2, rings=3, segments=20)
    radius = np.linalg.norm(mesh.vertices, axis=1)
    np.testing.assert_array_equal(mesh.boundary_vertices, (np.abs(radius - 1) < 1e-9) | (np.abs(radius - 2) < 1e-9))
    assert len(mesh.boundary_edges) == 40
    mesh = cylinder(segments=15, rows=4)
    assert len(mesh.boundary_edges) == 30 and mesh.boundary_vertices.sum() == 30
    mesh = square(5, 7)
    assert len(mesh.boundary_edges) == 24 and mesh.boundary_vertices.sum() == 24


def test_pieces_and_loose_vertices_are_told_apart():
    parts = [icosphere(1), torus(), cube(2)]
    mesh = together(*parts, loose=2)
    ends = np.cumsum([0] + [p.vertex_count for p in parts])
    for k in range(3):
        assert len(set(mesh.pieces[ends[k] : ends[k + 1]])) == 1
    assert len(set(mesh.pieces)) == 5
    assert mesh.loose_vertices.tolist() == [ends[3], ends[3] + 1]


@pytest.mark.parametrize(("build", "characteristic"), EVERY)
def test_a_fan_meets_every_corner_of_its_vertex(build, characteristic):
    mesh = build()
    corners = np.bincount(mesh.triangles.ravel(), minlength=mesh.vertex_count)
    np.testing.assert_array_equal(mesh.fan_corner_counts, corners)


def test_a_fan_misses_corners_where_faces_touch_at_a_point():
    bow_tie = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], [[0, 1, 2], [0, 3, 4]])
    assert bow_tie.fan_corner_counts.tolist() == [1, 1, 1, 1, 1]
