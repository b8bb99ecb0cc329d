# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces drawn to rectangles: what is square already stays, what is not becomes it, folds open."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from synch_fields.core.extract.quads.features.chains import follow_features
from synch_fields.core.extract.quads.features.feature_lines import FeatureLines
from synch_fields.core.extract.quads.measure.quality import corner_angles, quality
from synch_fields.core.extract.quads.smooth import fitting
from synch_fields.core.extract.quads.smooth.fitting import fit_quads, keep_better, part_vertices, project_vertices
from synch_fields.core.extract.quads.trace.quad_mesh import QuadMesh, quad_mesh
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.barycentric import barycentric

from ...flat_crosses import plane_edge_phases
from ...meshes import square
from ...topology import face_vectors, on_rim

CELLS = 10


def grid():
    """The unit square in ten by ten squares, and whether a vertex is inside."""
    mesh = square(12)
    quads = quad_mesh(plane_edge_phases(mesh, 0, 2 / CELLS))
    assert (quads.sizes == 4).all() and len(quads.sizes) == CELLS**2
    return mesh, quads, ~on_rim(quads)


def moved(quads, which, by):
    vertices = quads.vertices.copy()
    vertices[which, :2] += by
    return type(quads)(vertices, quads.triangles, quads.weights, quads.corner_vertices, quads.sizes)


def test_squares_stay():
    mesh, quads, inside = grid()
    after = fit_quads(quads, mesh, inside, 5)
    np.testing.assert_allclose(after.vertices, quads.vertices, atol=1e-9)


def test_a_mesh_whose_vertices_move_has_the_same_edges_and_new_lengths():
    _, quads, inside = grid()
    edges, rim, lengths = quads.edges, quads.on_rim, quads.edge_lengths
    which = np.flatnonzero(inside)
    after = quads.moved(which, *(1.1 * quads.vertices[which], quads.triangles[which], quads.weights[which]))
    fresh = QuadMesh(*after.places, after.corner_vertices, after.sizes)
    for mesh in (after, fresh, pickle.loads(pickle.dumps(after))):
        assert all(np.array_equal(a, b) for a, b in zip(mesh.edges, edges, strict=True))
        assert np.array_equal(mesh.on_rim, rim) and np.array_equal(mesh.edge_lengths, fresh.edge_lengths)
    assert not np.array_equal(after.edge_lengths, lengths) and np.array_equal(quads.edge_lengths, lengths)


def test_squares_come_back_and_the_rim_stays():
    mesh, quads, inside = grid()
    random = np.random.default_rng(0)
    rough = moved(quads, inside, random.uniform(-0.3, 0.3, (inside.sum(), 2)) / CELLS)
    after = fit_quads(rough, mesh, inside, 60)
    np.testing.assert_array_equal(after.vertices[~inside], quads.vertices[~inside])
    assert np.abs(corner_angles(after) - 90).max() < 0.1 * np.abs(corner_angles(rough) - 90).max()
    assert np.linalg.norm(after.vertices - quads.vertices, axis=1).max() < 0.05 / CELLS


def test_vertices_to_which_a_corner_is_nearest_do_not_meet_there(monkeypatch):
    """The targets of two of them lie outside of the square, beyond the corner between its sides."""
    mesh, quads, inside = grid()
    beside = np.flatnonzero(np.abs(np.linalg.norm(quads.vertices, axis=1) - 1 / CELLS) < 1e-9)
    targets = quads.vertices[quads.corner_vertices] - np.isin(quads.corner_vertices, beside)[:, None] * [0.5, 0.5, 0]
    monkeypatch.setattr(fitting, "_target_corners", lambda *_: targets)
    free = np.isin(np.arange(len(quads.vertices)), beside)
    assert len(beside) == 2 and not inside[beside].any()
    after = fit_quads(quads, mesh, free, 1)
    np.testing.assert_allclose(after.vertices, quads.vertices, atol=1e-12)


@pytest.mark.parametrize("kept", ["neither", "first", "both"])
@pytest.mark.parametrize("place", [(0.5, 0.5), (0.5, 0.0)], ids=["inside", "rim"])
def test_vertices_at_one_place_are_moved_apart(place, kept):
    mesh, quads, _ = grid()
    first, second = np.argsort(np.linalg.norm(quads.vertices[:, :2] - place, axis=1), kind="stable")[:2]
    if place[1] == 0:
        second = np.flatnonzero(np.linalg.norm(quads.vertices[:, :2] - [0.6, 0.0], axis=1) < 1e-9)[0]
    stays = np.zeros(len(quads.vertices), bool)
    stays[{"neither": [], "first": [first], "both": [first, second]}[kept]] = True
    rough = quads.vertices.copy()
    rough[second] = rough[first]
    after = part_vertices(replace(quads, vertices=rough), mesh, stays)
    assert after.edge_lengths.min() > 0.2 / CELLS
    assert (np.linalg.norm(after.vertices - rough, axis=1) > 0).sum() == 1
    assert kept != "first" or (after.vertices[first] == rough[first]).all()
    assert (after.vertices[on_rim(quads), :2].min(axis=1) < 1e-9).sum() == (
        quads.vertices[on_rim(quads), :2].min(axis=1) < 1e-9
    ).sum()
    assert part_vertices(after, mesh, stays) is after


@pytest.mark.parametrize(("beyond", "folds"), [(0.0, 0), (1e-9, 0), (0.02, 1)])
def test_a_corner_on_a_straight_side_is_not_folded(beyond, folds):
    middle = np.array([1.0, beyond, 0.0])
    places = np.array([[0, 0, 0], middle, [2, 0, 0], [1, 3, 0]])
    quad = QuadMesh(places, np.zeros(4, int), np.zeros((4, 3)), np.arange(4), np.array([4]))
    assert quality(quad)["folds"] == folds


@pytest.mark.parametrize("far", [1.3, 1.8])
def test_what_has_turned_over_turns_back(far):
    mesh, quads, inside = grid()
    middle = np.linalg.norm(quads.vertices[:, :2] - 0.5, axis=1).argmin()
    folded = moved(quads, [middle], np.array([far, 0.2]) / CELLS)
    assert quality(folded)["folds"] > 0
    after = fit_quads(folded, mesh, inside, 30)
    assert quality(after)["folds"] == 0 and (face_vectors(after)[:, 2] > 0).all()
    assert corner_angles(after).max() < 100


def test_vertices_on_a_line_pass_neither_each_other_nor_its_ends():
    mesh, quads, _ = grid()
    quads, chains = follow_features(quads, FeatureLines.of(mesh, mesh.boundary_edges))
    side = np.flatnonzero((chains.lines >= 0) & (quads.vertices[:, 1] == 0))
    side = side[np.argsort(quads.vertices[side, 0])]
    assert len(side) == CELLS - 1
    wanted = quads.vertices[side[::-1]] + [2, 0, 0]
    for _ in range(30):
        quads = project_vertices(quads, mesh, chains.lines, chains, side, wanted)
    places = np.concatenate([[0], quads.vertices[side, 0], [1]])
    assert (np.diff(places) > 0.2 / CELLS).all() and (quads.vertices[side, 1] == 0).all()
    quads = project_vertices(quads, mesh, chains.lines, chains, side[:1], np.array([[0.01, 0, 0]]))
    assert quads.vertices[side[0], 0] < places[1]


def test_rectangles_that_the_rim_asks_for_are_kept():
    """Rows of one height each, of which the rim holds the ends: right angles, though no squares."""
    mesh, quads, inside = grid()
    vertices = quads.vertices.copy()
    vertices[:, 1] = vertices[:, 1] ** 2
    stretched = type(quads)(vertices, quads.triangles, quads.weights, quads.corner_vertices, quads.sizes)
    after = fit_quads(stretched, mesh, inside, 10)
    assert np.abs(corner_angles(after) - 90).max() < 4


def test_edges_are_without_length_compared_to_their_own_component():
    square_of = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float)
    large, small, cut = 1e3 * square_of, 1e-4 * square_of + 2e3, square_of + [3e3, 0, 0]
    cut[1] = cut[0] + [1e-6, 0, 0]
    places = np.concatenate([large, small, cut])
    quads = QuadMesh(places, np.zeros(12, int), np.ones((12, 3)) / 3, np.arange(12), np.full(3, 4))
    np.testing.assert_array_equal(quads.edges_without_length, [[8, 9]])


def tetrahedron_of_quads():
    """A tetrahedron, and three quads on each of its faces, between its corners, the middles of edges and the middle."""
    corners = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], float)
    triangles = np.array([(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)])
    mesh = TriangleMesh(corners, triangles)
    middles = 4 + mesh.triangle_edges
    at = [(middles[:, k - 1], triangles[:, k], middles[:, k], 10 + np.arange(4)) for k in range(3)]
    places = np.concatenate([corners, corners[mesh.edges].mean(axis=1), corners[triangles].mean(axis=1)])
    places, found = mesh.finder.nearest(places)
    faces = np.concatenate([np.column_stack(face) for face in at])
    return mesh, QuadMesh(places, found, barycentric(mesh, found, places), faces.ravel(), np.full(12, 4))


def test_components_that_fitting_makes_worse_stay_as_they_were():
    """Three quads on each face of a tetrahedron, whose corners are off by 30 degrees at most; rough squares beside them
    become better, and stay so."""
    mesh, quads = tetrahedron_of_quads()
    quads, chains = follow_features(quads, FeatureLines.of(mesh, np.arange(6)))
    assert np.abs(corner_angles(quads) - 90).reshape(-1, 4) == pytest.approx(np.tile([0.0, 30, 0, 30], (12, 1)))
    worse = fit_quads(quads, mesh, ~chains.fixed, 20, chains)
    assert worse.edge_lengths.min() < 0.9 * quads.edge_lengths.min()
    assert np.abs(corner_angles(worse) - 90).mean() > 1.1 * np.abs(corner_angles(quads) - 90).mean()
    np.testing.assert_array_equal(keep_better(worse, quads).vertices, quads.vertices)
    _, flat, inside = grid()
    rough = moved(flat, inside, np.random.default_rng(0).uniform(-0.3, 0.3, (inside.sum(), 2)) / CELLS)
    both = beside(quads, rough)
    after = keep_better(beside(worse, flat), both)
    np.testing.assert_array_equal(after.vertices, np.concatenate([quads.vertices, flat.vertices]))


def beside(first, second):
    """Two quad meshes in one, on surfaces that are not told."""
    count = len(first.vertices)
    names = ("vertices", "triangles", "weights", "sizes")
    arrays = {name: np.concatenate([getattr(first, name), getattr(second, name)]) for name in names}
    return QuadMesh(corner_vertices=np.append(first.corner_vertices, count + second.corner_vertices), **arrays)
