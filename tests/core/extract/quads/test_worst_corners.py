# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad corners brought nearer to right angles, on the surface, with all else left alone."""

from dataclasses import replace

import numpy as np
import pytest

from synch_fields.core.extract.quads.measure.quality import corner_angles, quality
from synch_fields.core.extract.quads.smooth.patches import Ground, Patches
from synch_fields.core.extract.quads.smooth.worst_corners import move_worst_corners
from synch_fields.core.extract.quads.trace.quad_mesh import QuadMesh, quad_mesh
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.nearest import NearestTriangles

from ...flat_crosses import plane_edge_phases
from ...meshes import square
from ...topology import on_rim

CELLS = 10


def grid(height=None):
    """The unit square, raised by a height, in ten by ten squares, and whether a vertex is inside."""
    flat = square(20)
    quads = quad_mesh(plane_edge_phases(flat, 0, 2 / CELLS))
    mesh = flat if height is None else TriangleMesh(raised(flat.vertices, height), flat.triangles)
    places = np.einsum("nk,nkx->nx", quads.weights, mesh.vertices[mesh.triangles[quads.triangles]])
    return mesh, replace(quads, vertices=places), ~on_rim(quads)


def raised(places, height):
    return np.column_stack([places[:, :2], height(places[:, 0])])


def moved(quads, which, by):
    vertices = quads.vertices.copy()
    vertices[which] += by
    return replace(quads, vertices=vertices)


def worst(quads):
    return np.abs(corner_angles(quads) - 90).max()


def middle_of(quads):
    return np.linalg.norm(quads.vertices[:, :2] - 0.5, axis=1).argmin()


@pytest.mark.parametrize("measure", [Patches.norms, Patches.means])
def test_gradient_is_the_slope_of_the_norms(measure):
    random = np.random.default_rng(3)
    mesh, quads, inside = grid()
    quads = moved(quads, inside, 0.2 / CELLS * random.normal(size=(inside.sum(), 3)))
    patches = Patches.of(quads, Ground.of(mesh, quads), np.flatnonzero(inside)[:20])
    way = random.normal(size=quads.vertices.shape)
    step = 1e-6 / CELLS
    ahead, behind = (measure(patches, quads.vertices + sign * step * way)[0].sum() for sign in (1, -1))
    assert (way * measure(patches, quads.vertices)[-1]).sum() == pytest.approx((ahead - behind) / (2 * step), rel=1e-5)


@pytest.mark.parametrize("far", [0.6, 0.8])
def test_a_bad_corner_is_levelled_and_what_is_far_stays(far):
    mesh, quads, inside = grid()
    bad = moved(quads, middle_of(quads), [far / CELLS, 0.1 / CELLS, 0])
    after = move_worst_corners(bad, mesh, inside)
    assert worst(bad) > 45 and worst(after) < 20 and quality(after)["folds"] == 0
    stays = np.linalg.norm(quads.vertices[:, :2] - 0.5, axis=1) > 4 / CELLS
    np.testing.assert_array_equal(after.vertices[stays | ~inside], bad.vertices[stays | ~inside])
    at = np.einsum("nk,nkx->nx", after.weights, mesh.vertices[mesh.triangles[after.triangles]])
    moves = (after.vertices != bad.vertices).any(axis=1)
    np.testing.assert_allclose(after.vertices[moves], at[moves], atol=1e-12)


def test_good_corners_stay():
    mesh, quads, inside = grid()
    random = np.random.default_rng(0)
    rough = moved(
        quads, inside, np.column_stack([random.uniform(-0.1, 0.1, (inside.sum(), 2)) / CELLS, np.zeros(inside.sum())])
    )
    assert worst(rough) < 25
    np.testing.assert_array_equal(move_worst_corners(rough, mesh, inside).vertices, rough.vertices)


def test_faces_stay_at_the_ridge():
    """Sliding along a ridge, not off it."""
    mesh, quads, inside = grid(lambda x: -np.abs(x - 0.5))
    bad = moved(quads, middle_of(quads), [0, 0.9 / CELLS, 0])
    after = move_worst_corners(bad, mesh, inside)
    assert worst(bad) > 30 and worst(after) < 20
    ridge = np.column_stack([np.full(201, 0.5), np.linspace(0, 1, 201), np.zeros(201)])
    assert distances(after, ridge).max() < 0.1 / CELLS


def distances(quads, points):
    """(p,) of points from a quad mesh's faces, cut from corner to corner."""
    corners = quads.corner_vertices.reshape(-1, 4)
    triangles = np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])
    return np.linalg.norm(NearestTriangles(quads.vertices, triangles).nearest(points)[0] - points, axis=1)


def test_a_hexagon_of_regular_corners_is_good():
    turns = np.pi / 3 * np.arange(6)
    mesh = square(4)
    places = np.column_stack([0.5 + 0.3 * np.cos(turns), 0.5 + 0.3 * np.sin(turns), np.zeros(6)])
    _, triangles = NearestTriangles(mesh.vertices, mesh.triangles).nearest(places)
    face = QuadMesh(places, triangles, np.full((6, 3), 1 / 3), np.arange(6), np.array([6]))
    np.testing.assert_array_equal(move_worst_corners(face, mesh, np.ones(6, bool)).vertices, places)
