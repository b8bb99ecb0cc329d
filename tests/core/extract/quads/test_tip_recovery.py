# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces climb to tips that they cut off, and all else stays."""

from dataclasses import replace

import numpy as np
import pytest

from synch_fields.core.extract.quads.measure.quality import corner_angles, quality
from synch_fields.core.extract.quads.repair.tip_recovery import WORST, recover_tips
from synch_fields.core.extract.quads.trace.quad_mesh import quad_mesh
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.nearest import NearestTriangles

from ...flat_crosses import plane_edge_phases
from ...meshes import square
from ...topology import on_rim

CELLS = 10


def horned(height, centre):
    """The square in ten by ten squares with a cone, not wider than one and a half of them, and whether a vertex is
    inside."""
    flat = square(60)
    quads = quad_mesh(plane_edge_phases(flat, 0, 2 / CELLS))
    far = np.linalg.norm(flat.vertices[:, :2] - centre, axis=1)
    vertices = flat.vertices + np.outer(height * np.maximum(1 - far / 0.09, 0), [0, 0, 1])
    mesh = TriangleMesh(vertices, flat.triangles)
    places = np.einsum("nk,nkx->nx", quads.weights, vertices[mesh.triangles[quads.triangles]])
    return mesh, replace(quads, vertices=places), ~on_rim(quads)


def farthest(quads, mesh):
    """Distance of the surface's vertices from faces that are cut from corner to corner, the nearer way."""
    corners = quads.corner_vertices.reshape(-1, 4)
    cuts = [corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]], [corners[:, [0, 1, 3]], corners[:, [1, 2, 3]]]
    found = [NearestTriangles(quads.vertices, np.concatenate(cut)).nearest(mesh.vertices)[0] for cut in cuts]
    return min(np.linalg.norm(places - mesh.vertices, axis=1).max() for places in found)


@pytest.mark.parametrize("height", [0.15, 0.2])
def test_a_face_that_cuts_a_tip_off_climbs_to_it(height):
    mesh, quads, inside = horned(height, [0.55, 0.55])
    after = recover_tips(quads, mesh, inside)
    assert farthest(quads, mesh) > 0.5 / CELLS
    assert farthest(after, mesh) < 0.75 * farthest(quads, mesh)
    assert np.abs(corner_angles(after) - 90).max() <= WORST and quality(after)["folds"] == 0
    at = np.einsum("nk,nkx->nx", after.weights, mesh.vertices[mesh.triangles[after.triangles]])
    np.testing.assert_allclose(after.vertices, at, atol=1e-12)
    stays = np.linalg.norm(quads.vertices[:, :2] - 0.55, axis=1) > 5 / CELLS
    np.testing.assert_array_equal(after.vertices[stays | ~inside], quads.vertices[stays | ~inside])


def test_nothing_moves_where_no_tip_is_cut_off():
    mesh, quads, inside = horned(0.04, [0.55, 0.55])
    np.testing.assert_array_equal(recover_tips(quads, mesh, inside).vertices, quads.vertices)


def test_what_is_held_stays():
    mesh, quads, inside = horned(0.15, [0.55, 0.55])
    np.testing.assert_array_equal(recover_tips(quads, mesh, np.zeros_like(inside)).vertices, quads.vertices)
