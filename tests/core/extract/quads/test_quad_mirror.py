# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad meshes that are their own mirror image: made on one side of the planes and reflected."""

from dataclasses import replace

import numpy as np
import pytest

from synch_fields.core.defects import wrap
from synch_fields.core.extract.quads.mirror import MirrorSide, plane_edges, without_image
from synch_fields.core.extract.quads.trace.quad_mesh import QuadMesh
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.interpolate import EdgePhases

from ...meshes import square, torus

X, Y = np.eye(3)[:2]


def sheet(columns=8):
    """A square of side 2 about the origin."""
    mesh = square(columns, columns, 2.0, 2.0)
    return TriangleMesh(mesh.vertices - (1.0, 1.0, 0.0), mesh.triangles)


def grid_phases(mesh, lines, shift=0.0):
    """Phases whose grid lines are ``lines`` to a unit of length, moved along y, without a turn."""
    values = np.pi * lines * (mesh.vertices[:, :2] + [0, shift])
    i, j = mesh.edges.T
    return EdgePhases(mesh, values, values[j] - values[i], np.zeros(len(mesh.edges), int))


@pytest.mark.parametrize("units", [[X], [Y], [X, Y]])
@pytest.mark.parametrize("rounds", [0, 5])
def test_a_grid_on_one_side_becomes_the_whole_grid(units, rounds):
    mesh, units = sheet(), np.array(units)
    side = MirrorSide.of(mesh, units)
    assert side.mesh.areas.sum() == pytest.approx(4 / 2 ** len(units))
    quads = side.finish(side.trace(grid_phases(mesh, 4)), (), rounds, True)
    assert len(quads.sizes) == 64 and (quads.sizes == 4).all() and quads.euler_characteristic == 1
    np.testing.assert_allclose(quads.edge_lengths, 0.25, atol=1e-6)
    assert all(without_image(quads, unit) == 0 for unit in units)
    at = np.einsum("nk,nkx->nx", quads.weights, mesh.vertices[mesh.triangles[quads.triangles]])
    np.testing.assert_allclose(at, quads.vertices, atol=1e-9)
    corners = quads.vertices[quads.corner_vertices.reshape(-1, 4)]
    winding = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])[:, 2]
    assert (np.sign(winding) == np.sign(mesh.face_normals[0, 2])).all()


def test_planes_that_cross_triangles_divide_nothing():
    assert MirrorSide.of(sheet(7), np.array([X])) is None
    assert len(plane_edges(sheet(7), np.array([X]))) == 0
    assert MirrorSide.of(sheet(), np.empty((0, 3))) is None
    edges = plane_edges(sheet(), np.array([X]))
    assert len(edges) == 8 and (sheet().vertices[sheet().edges[edges], 0] == 0).all()


def test_an_edge_across_a_strip_between_two_lines_on_the_plane_is_halved():
    """A torus with two quads around its tube, one on each side of its plane, would have pairs with the same corners."""
    mesh, plane = torus(1.0, 0.4, 36, 12), np.array([0, 0, 1.0])
    side = MirrorSide.of(mesh, plane[None])
    x, y, z = mesh.vertices.T
    around = np.arctan2(np.abs(z), np.hypot(x, y) - 1)  # from 0 to pi on each side
    along = 3 * np.arctan2(y, x)
    i, j = mesh.edges.T
    changes = np.column_stack([around[j] - around[i], wrap(along[j] - along[i])])
    phases = EdgePhases(mesh, np.column_stack([around, along]), changes, np.zeros(len(mesh.edges), int))
    quads = side.trace(phases)
    assert set(quads.sizes) == {6} and len(quads.sizes) == 6
    whole = side.finish(quads, (), 0, True)
    assert not whole.is_unsound.any() and (whole.sizes == 4).all() and len(whole.sizes) == 24
    assert without_image(whole, plane) == 0 and whole.euler_characteristic == 0


def test_a_quad_alone_at_a_vertex_on_the_plane_is_joined_with_its_reflection():
    mesh = sheet()
    side = MirrorSide.of(mesh, np.array([X]))
    places = np.array([[0, 1, 0], [0, 0, 0], [0, -1, 0], [1, 0, 0.0]])
    _, triangles = side.mesh.finder.nearest(places)
    quads = QuadMesh(places, triangles, np.zeros((4, 3)), np.arange(4), np.array([4]))
    corners = side.mesh.vertices[side.mesh.triangles[triangles]]
    weights = (np.linalg.norm(corners - places[:, None], axis=2) < 1e-9).astype(float)
    whole = side.finish(replace(quads, weights=weights), (), 0, True)
    assert len(whole.sizes) == 1
    assert {tuple(place) for place in whole.vertices} == {(0, 1, 0), (-1, 0, 0), (0, -1, 0), (1, 0, 0)}


def test_two_quads_alone_at_neighbours_on_the_plane_become_one_with_their_reflections():
    """Both have the same corner off the plane, and the vertex between them has no edges but to it and its image."""
    side = MirrorSide.of(sheet(), np.array([X]))
    places = np.array([[0, y, 0] for y in (1, 0.5, 0, -0.5, -1)] + [[1, 0, 0.0]])
    _, triangles = side.mesh.finder.nearest(places)
    corners = side.mesh.vertices[side.mesh.triangles[triangles]]
    weights = (np.linalg.norm(corners - places[:, None], axis=2) < 1e-9).astype(float)
    quads = QuadMesh(places, triangles, weights, np.array([0, 1, 2, 5, 2, 3, 4, 5]), np.array([4, 4]))
    whole = side.finish(quads, (), 0, True)
    assert {tuple(place) for place in whole.vertices} == {(0, 1, 0), (-1, 0, 0), (0, -1, 0), (1, 0, 0)}
    assert len(whole.sizes) == 1 and without_image(whole, X) == 0


def test_vertices_without_an_image_are_counted():
    places = np.array([[-1, 0, 0], [1, 0, 0], [1, 1, 0], [-1, 1.1, 0]])
    quads = QuadMesh(places, None, None, np.arange(4), np.array([4]))
    assert (without_image(quads, X), without_image(quads, Y)) == (2, 2)
