# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad meshes that are made their own mirror image: the half on the positive side and its reflection."""

from dataclasses import replace

import numpy as np
import pytest

from synch_fields.core.extract.quads.mirror import average_with_partners, mirror_half, partners
from synch_fields.core.extract.quads.trace.quad_mesh import QuadMesh
from synch_fields.core.geometry import TriangleMesh

from ...meshes import grid_quads, square, square_points

X = np.array([2.0, 0.0, 0.0])  # of any length


def sheet(columns, push=0.0):
    """Quads of a square of side 2 about the origin, the vertices on the negative side pushed along y."""
    points = square_points(columns, 4, 2.0, 2.0) - (1.0, 1.0, 0.0)
    points[:, 1] += np.where(points[:, 0] < -1e-9, push, 0)
    faces = grid_quads(columns, 4)
    nothing = np.zeros(len(points), int)
    return QuadMesh(points, nothing, np.zeros((len(points), 3)), faces.ravel(), np.full(len(faces), 4))


@pytest.fixture(scope="module")
def surface():
    mesh = square(6, 6, 2.0, 2.0)
    return TriangleMesh(mesh.vertices - (1.0, 1.0, 0.0), mesh.triangles)


def places(quads):
    return {tuple(place) for place in np.round(quads.vertices, 9) + 0.0}


@pytest.mark.parametrize("columns", [4, 5])
def test_the_result_is_its_own_mirror_image_with_the_positive_half_as_it_was(surface, columns):
    """With an odd number of columns, the plane passes through faces, which are joined of halves."""
    quads = sheet(columns, push=0.03)
    result = mirror_half(quads, surface, X)
    assert places(result) == {(-x, y, z) for x, y, z in places(result)} != places(quads)
    assert {p for p in places(result) if p[0] > 0} == {p for p in places(quads) if p[0] > 0}
    assert len(result.sizes) == len(quads.sizes) and set(result.sizes) == {4}
    assert result.is_simple and result.euler_characteristic == 1
    corners = surface.vertices[surface.triangles[result.triangles]]
    assert np.allclose(np.einsum("nk,nkx->nx", result.weights, corners), result.vertices, atol=1e-9)


def test_faces_keep_their_winding(surface):
    result = mirror_half(sheet(5, push=0.03), surface, X)
    corners = result.vertices[result.corner_vertices.reshape(-1, 4)]
    normals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    before = sheet(5).vertices[sheet(5).corner_vertices.reshape(-1, 4)]
    winding = np.cross(before[:, 2] - before[:, 0], before[:, 3] - before[:, 1])[0, 2]
    assert (normals[:, 2] * winding > 0).all()


def test_what_the_plane_does_not_halve_stays_as_it_is(surface):
    """All on the negative side; and a piece there that has no image, which would be lost."""
    quads = sheet(4)
    away = replace(quads, vertices=quads.vertices - (3.0, 0.0, 0.0))
    assert mirror_half(away, surface, X) is away
    there = len(quads.vertices)
    beside = replace(
        quads,
        vertices=np.concatenate([quads.vertices, quads.vertices - (5.0, 0.0, 0.0)]),
        corner_vertices=np.concatenate([quads.corner_vertices, quads.corner_vertices + there]),
        sizes=np.concatenate([quads.sizes, quads.sizes]),
    )
    assert mirror_half(beside, surface, X) is beside


def test_partners_are_each_others_images_or_none():
    quads = sheet(4, push=0.03)
    partner = partners(quads, X)
    assert (partner[partner] == np.arange(len(partner))).all()
    assert np.allclose(quads.vertices[partner, 0], -quads.vertices[:, 0])
    assert partners(replace(quads, vertices=quads.vertices + (0.2, 0.0, 0.0)), X) is None


def test_averages_are_their_own_mirror_image():
    quads = sheet(4, push=0.03)
    partner = partners(quads, X)
    moved = average_with_partners(quads.vertices, partner, X)
    assert np.allclose(moved[partner], moved * (-1, 1, 1))
    assert np.abs(moved - quads.vertices).max() == pytest.approx(0.015)
