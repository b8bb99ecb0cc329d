# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Quads reconnected around bad corners: hexagons whose best cut is known, spoilt grids, and meshes to leave alone."""

from dataclasses import replace

import numpy as np
import pytest

from synch_fields.core.extract.quads.features.chains import follow_features
from synch_fields.core.extract.quads.features.feature_lines import FeatureLines
from synch_fields.core.extract.quads.measure.quality import corner_angles, quality, worst_deviations
from synch_fields.core.extract.quads.repair.bad_corners import BAD, mend_bad_corners
from synch_fields.core.extract.quads.repair.reconnections import Patch
from synch_fields.core.extract.quads.smooth.fitting import fit_quads
from synch_fields.core.extract.quads.trace.quad_mesh import QuadMesh, quad_mesh
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.barycentric import barycentric

from ...flat_crosses import plane_edge_phases
from ...meshes import square
from ...topology import euler, on_rim

# Two squares beside each other, counterclockwise around both.
HEXAGON = np.array([(0, 0, 0), (1, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0), (0, 1, 0)], float)
CELLS = 10


def on_surface(mesh, places, faces):
    """Quads with vertices at the points of a surface that are nearest to places."""
    places, triangles = mesh.finder.nearest(places)
    weights = barycentric(mesh, triangles, places)
    return QuadMesh(places, triangles, weights, np.ravel(faces), np.full(len(faces), 4))


def corners_of(quads):
    return quads.corner_vertices.reshape(-1, 4)


def face_sets(quads):
    return {frozenset(face) for face in corners_of(quads).tolist()}


def grid():
    mesh = square(20)
    return mesh, quad_mesh(plane_edge_phases(mesh, 0, 2 / CELLS))


def at(quads, x, y):
    return int(np.linalg.norm(quads.vertices[:, :2] - [x, y], axis=1).argmin())


def flipped(quads, middle):
    """The quads with the edge at a place turned by one corner of the hexagon around it."""
    edges, _ = quads.edges
    a, b = edges[np.linalg.norm(quads.vertices[edges].mean(axis=1)[:, :2] - middle, axis=1).argmin()]
    faces = corners_of(quads).copy()
    first, second = np.flatnonzero(np.isin(faces, [a, b]).sum(axis=1) == 2)
    corners = faces[first].tolist()
    a, b = (a, b) if corners[(corners.index(a) + 1) % 4] == b else (b, a)
    ring = [
        np.roll(faces[face], -faces[face].tolist().index(start)).tolist() for face, start in ((first, b), (second, a))
    ]
    hexagon = [*ring[0], *ring[1][1:3]]
    faces[first], faces[second] = hexagon[1:5], [*hexagon[4:], *hexagon[:2]]
    return replace(quads, corner_vertices=faces.ravel())


@pytest.mark.parametrize("seed", [None, 1])
@pytest.mark.parametrize("cut", [0, 2])
def test_a_hexagon_is_cut_into_its_two_squares(cut, seed):
    """Cut from corner to corner it has two straight corners; in any plane in space."""
    turn = np.eye(3) if seed is None else np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    ring = [(cut + k) % 6 for k in range(6)]
    surface = TriangleMesh(HEXAGON @ turn.T, [(0, 1, 4), (0, 4, 5), (1, 2, 3), (1, 3, 4)])
    quads = on_surface(surface, HEXAGON @ turn.T, [ring[:4], [*ring[3:], ring[0]]])
    assert np.abs(corner_angles(quads) - 90).max() > 80
    found, kept = mend_bad_corners(quads, surface, np.arange(6) == ring[0])
    assert face_sets(found) == {frozenset((0, 1, 4, 5)), frozenset((1, 2, 3, 4))} and len(kept) == 6
    np.testing.assert_allclose(corner_angles(found), 90, atol=1e-9)
    assert quality(found)["folds"] == 0


def test_edges_between_held_vertices_stay_and_no_new_edge_joins_vertices_apart():
    faces = np.array([[0, 1, 2, 3], [3, 4, 5, 0]])
    nothing = np.zeros(6, bool)
    patch = Patch(faces, np.array([3, 2, 2, 3, 2, 2]), ~nothing, np.full(6, -1), nothing, nothing)

    def new_edges(patch):
        return {tuple(sorted(set(way.faces[0].tolist()) & set(way.faces[1].tolist()))) for way in patch.reconnected(0)}

    assert new_edges(patch) == {(1, 4), (2, 5)}
    assert new_edges(replace(patch, held=~nothing)) == set()
    assert new_edges(replace(patch, apart=np.isin(np.arange(6), [1, 4]))) == {(2, 5)}


@pytest.mark.parametrize("middle", [(0.35, 0.5), (0.5, 0.65)])
def test_a_grid_with_a_turned_edge_comes_back(middle):
    mesh, quads = grid()
    spoilt = flipped(quads, middle)
    assert quality(spoilt)["irregular_vertices"] == 4 and worst_deviations(spoilt).max() > BAD
    found, kept = mend_bad_corners(spoilt, mesh, ~on_rim(quads))
    assert quality(found)["irregular_vertices"] == 0 and len(kept) == len(quads.vertices)
    np.testing.assert_allclose(found.vertices, quads.vertices, atol=0.2 / CELLS)
    np.testing.assert_allclose(corner_angles(found), 90, atol=20)


def line_patch(valence):
    """Three quads: vertices 0, 1, 2 are on a line, and 1 has one quad with a straight corner above and two below."""
    faces = np.array([[0, 1, 2, 3], [1, 0, 4, 5], [2, 1, 5, 6]])
    lines = np.array([0, 0, 0, -1, -1, -1, -1])
    nothing = np.zeros(7, bool)
    return Patch(faces, np.array([5, valence, 5, 4, 4, 4, 4]), nothing, lines, nothing, nothing)


def test_the_middle_of_a_halved_edge_goes_with_the_quad_that_has_a_straight_corner_there():
    whole = line_patch(3)
    (collapsed,) = [way for way in whole.reconnected(0) if len(way.faces) == 1]
    assert [set(face) for face in collapsed.faces.tolist()] == [{0, 4, 5, 6}]
    np.testing.assert_array_equal(collapsed.valences, [7, 0, 0, 3, 4, 3, 4])  # 0 stands for 2, too
    # Elsewhere edges begin at 1: merging 0 and 2 would leave an edge of the line hanging.
    assert all(way.valences[0] and way.valences[2] for way in line_patch(5).reconnected(0))


def test_no_collapse_takes_a_vertex_whose_line_leads_through_the_collapsed_quad():
    """The line leads from 0, which stays, over 1 to 4: with 1 both of its edges would be gone."""
    faces = np.array([[0, 1, 2, 3], [1, 0, 5, 4], [2, 1, 4, 6]])
    nothing = np.zeros(7, bool)
    patch = Patch(faces, np.array([5, 3, 5, 5, 5, 5, 5]), nothing, np.full(7, -1), nothing, nothing)

    def taken(patch):
        return [way.valences[1] == 0 for way in patch.reconnected(0)]

    assert any(taken(patch))
    on_line = replace(patch, lines=np.array([0, 0, -1, -1, 0, -1, -1]))
    assert taken(on_line) and not any(taken(on_line))
    assert not any(taken(replace(on_line, held=np.arange(7) == 0)))


def test_meshes_without_bad_corners_stay_as_they_are():
    mesh, quads = grid()
    shaken = quads.vertices.copy()
    shaken[~on_rim(quads), :2] += 0.02 * np.random.default_rng(0).uniform(-1, 1, ((~on_rim(quads)).sum(), 2))
    quads = on_surface(mesh, shaken, corners_of(quads))
    found, kept = mend_bad_corners(quads, mesh, ~on_rim(quads))
    assert found is quads
    np.testing.assert_array_equal(kept, np.arange(len(quads.vertices)))


@pytest.mark.parametrize("with_line", [False, True])
def test_spoilt_grids_stay_meshes_of_the_same_disk_with_their_lines_and_get_better(with_line):
    mesh, quads = grid()
    rim = on_rim(quads)
    middle = np.flatnonzero(np.abs(mesh.vertices[:, 1] - 0.5) < 1e-9)
    line = np.column_stack([middle[:-1], middle[1:]])
    line = line[np.abs(mesh.vertices[line[:, 0], 0] - mesh.vertices[line[:, 1], 0]) < 0.06]
    features = FeatureLines.of(mesh, mesh.edges_between(*line.T))
    random = np.random.default_rng(3)
    gains = []
    for _ in range(2):
        spoilt = quads
        for _ in range(3):
            spoilt = flipped(spoilt, random.choice([(0.25, 0.3), (0.65, 0.8), (0.75, 0.3), (0.35, 0.7)]))
        shaken = spoilt.vertices.copy()
        moves = ~rim & (np.abs(shaken[:, 1] - 0.5) > 1e-6)
        shaken[moves, :2] += 0.04 * random.uniform(-1, 1, (moves.sum(), 2))
        spoilt = on_surface(mesh, shaken, corners_of(spoilt))
        chains = None
        if with_line:
            spoilt, chains = follow_features(spoilt, features)
        free = ~rim if chains is None else ~rim & ~chains.fixed
        found, kept = mend_bad_corners(spoilt, mesh, free, chains)
        assert not found.is_unsound.any() and euler(found) == 1 and found.edges[1].max() == 2
        before, after = worst_deviations(spoilt), worst_deviations(found)
        assert after.max() <= before.max() + 1e-9
        gains.append((before > BAD).sum() - (after > BAD).sum())
        if with_line:
            assert len(chains.of_vertices(kept).edges(found)) == len(chains.edges(spoilt)) == CELLS
    assert np.mean(gains) >= 1


def test_irregular_vertices_are_joined_where_no_corner_is_bad():
    mesh, quads = grid()
    free = ~on_rim(quads)
    spoilt = fit_quads(flipped(quads, (0.35, 0.5)), mesh, free, 40)
    assert quality(spoilt)["irregular_vertices"] == 4 and worst_deviations(spoilt).max() < BAD
    found, _ = mend_bad_corners(spoilt, mesh, free)
    assert quality(found)["irregular_vertices"] == 0
    np.testing.assert_allclose(corner_angles(found), 90, atol=20)


def test_what_is_mended_in_one_place_does_not_depend_on_other_places():
    mesh, quads = grid()
    free, first = ~on_rim(quads), flipped(quads, (0.25, 0.3))
    alone, _ = mend_bad_corners(first, mesh, free)
    both, _ = mend_bad_corners(flipped(first, (0.75, 0.7)), mesh, free)
    assert quality(both)["irregular_vertices"] == 0
    near = quads.vertices[:, :2].sum(axis=1) < 0.9
    np.testing.assert_array_equal(both.vertices[near], alone.vertices[near])
