# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Edges turned where corners are straight: hexagons whose best cut is known, and meshes that it must leave alone."""

import numpy as np
import pytest

from synch_fields.core.extract.quads.measure.quality import corner_angles, quality
from synch_fields.core.extract.quads.repair.edge_flips import flip_edges
from synch_fields.core.extract.quads.trace.quad_mesh import QuadMesh

# Two squares beside each other, counterclockwise around both.
HEXAGON = np.array([(0, 0, 0), (1, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0), (0, 1, 0)], float)


def quads_of(places, faces):
    faces = np.asarray(faces)
    count = len(places)
    return QuadMesh(places, np.zeros(count, int), np.zeros((count, 3)), faces.ravel(), np.full(len(faces), 4))


def face_sets(quads):
    return {frozenset(face) for face in quads.corner_vertices.reshape(-1, 4).tolist()}


@pytest.mark.parametrize("cut", [0, 2])
@pytest.mark.parametrize("seed", [None, 1])
def test_a_hexagon_is_cut_into_its_two_squares(cut, seed):
    """Cut from corner to corner it has two straight corners; in any plane in space."""
    turn = np.eye(3) if seed is None else np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    ring = [(cut + k) % 6 for k in range(6)]
    quads = quads_of(HEXAGON @ turn.T, [ring[:4], [*ring[3:], ring[0]]])
    assert np.abs(corner_angles(quads) - 90).max() > 80
    found = flip_edges(quads, np.tile(turn[:, 2], (6, 1)))
    assert face_sets(found) == {frozenset((0, 1, 4, 5)), frozenset((1, 2, 3, 4))}
    np.testing.assert_allclose(corner_angles(found), 90, atol=1e-9)
    assert quality(found)["folds"] == 0


def test_an_edge_that_stays_is_not_turned():
    quads = quads_of(HEXAGON, [[0, 1, 2, 3], [3, 4, 5, 0]])
    found = flip_edges(quads, np.tile([0.0, 0, 1], (6, 1)), keep=[(3, 0)])
    assert face_sets(found) == face_sets(quads)


def test_meshes_without_straight_corners_stay_as_they_are():
    places = np.array([(x, y, 0) for y in range(5) for x in range(5)], float)
    places[:, :2] += 0.2 * np.random.default_rng(0).uniform(-1, 1, (25, 2))
    faces = [(k, k + 1, k + 6, k + 5) for k in range(19) if k % 5 < 4]
    quads = quads_of(places, faces)
    assert flip_edges(quads, np.tile([0.0, 0, 1], (25, 1))) is quads


def test_no_edge_is_doubled_and_no_vertex_is_lost():
    """A grid in which vertices were moved far: whatever is turned, it is a mesh of the same disk."""
    random = np.random.default_rng(3)
    faces = [(k, k + 1, k + 7, k + 6) for k in range(35) if k % 6 < 5 and k < 30]
    for _ in range(20):
        places = np.array([(x, y, 0) for y in range(6) for x in range(6)], float)
        places[:, :2] += 0.7 * random.uniform(-1, 1, (36, 2))
        quads = quads_of(places, faces)
        found = flip_edges(quads, np.tile([0.0, 0, 1], (36, 1)))
        assert not found.is_unsound.any() and found.euler_characteristic == 1 and len(found.vertices) == 36
        assert len(found.sizes) == len(quads.sizes) and found.edges[1].max() == 2
