# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces that look like others still do when those were split."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from synch_fields.core.geometry.manifold_repair import repair_mesh
from synch_fields.core.geometry.polygons import Polygons

from ..meshes import polygon_mesh

TURN = np.arange(6) * np.pi / 3
HEXAGON = np.column_stack([np.cos(TURN), np.sin(TURN), 0 * TURN])
POINTS = np.vstack([HEXAGON, [[2, 1, 0]], [[0, 3, 0]]])
# A hexagon and a triangle beside it.
SURFACE = [[0, 1, 2, 3, 4, 5], [0, 6, 1]]


def split(polygons, face, there=()):
    """All faces after one was replaced by its triangles, but for those that are there, and the old corners."""
    rows = np.flatnonzero(polygons.triangle_faces == face)
    pieces = [polygons.triangle_corners[row] for row in rows]
    pieces = [corners for corners in pieces if set(polygons.corner_vertices[corners].tolist()) not in there]
    runs = [np.arange(s, s + k) for s, k in zip(polygons.starts, polygons.sizes, strict=True)]
    old = [run for number, run in enumerate(runs) if number != face] + pieces
    corners = np.concatenate(old)
    given = [polygons.corner_vertices[run].tolist() for run in old]
    return polygon_mesh(POINTS, given)[1], corners


def solved(faces):
    mesh, polygons = polygon_mesh(POINTS, faces)
    return polygons, repair_mesh(mesh, polygons).polygons


@pytest.mark.parametrize("double", [[0, 1, 2, 3, 4, 5], [5, 4, 3, 2, 1, 0], [2, 3, 4, 5, 0, 1]])
def test_a_face_that_doubles_one_that_was_split_looks_like_its_triangles(double):
    given, found = solved([*SURFACE, double])
    after = found.after_split(*split(given, 0))
    assert after.drawn.tolist() == [True, False, True, True, True, True]
    surfaces = [{tuple(row) for row in np.sort(each.triangles, axis=1).tolist()} for each in (found, after)]
    assert surfaces[0] == surfaces[1]
    doubled = np.arange(after.starts[1], after.starts[1] + 6)
    assert after.drawn[after.corner_faces[after.alike[doubled]]].all()
    np.testing.assert_array_equal(after.corner_vertices[after.alike[doubled]], double)
    others = np.setdiff1d(np.arange(len(after.alike)), doubled)
    np.testing.assert_array_equal(after.alike[others], others)


@pytest.mark.parametrize("part", [[0, 2, 1], [1, 2, 0]])
def test_a_face_that_doubles_a_part_of_one_that_was_split_draws_it(part):
    """None can be there twice, so that this triangle is not made again."""
    given, found = solved([*SURFACE, part, part])
    assert found.drawn.tolist() == [True, True, False, False]
    after = found.after_split(*split(given, 0, there=[set(part)]))
    assert after.drawn.tolist() == [True, True, False, True, True, True]
    # Each triangle runs the same way around as before.
    ways = [{_turned(row) for row in each.triangles.tolist()} for each in (found, after)]
    assert ways[0] == ways[1]
    first, second = (np.arange(after.starts[k], after.starts[k] + 3) for k in (1, 2))
    np.testing.assert_array_equal(after.alike[second], first)


def _turned(row):
    first = row.index(min(row))
    return tuple(row[first:] + row[:first])


def test_faces_that_look_like_none_stay_alone():
    given, found = solved([*SURFACE, [0, 1, 2, 3, 4, 5], [6, 6, 7]])
    after = found.after_split(*split(given, 0))
    flat = np.arange(after.starts[2], after.starts[2] + 3)
    assert not after.drawn[2]
    np.testing.assert_array_equal(after.alike[flat], flat)


def test_a_surface_that_is_one_keeps_its_faces():
    _, polygons = polygon_mesh(POINTS, SURFACE)
    after = polygons.after_split(*split(polygons, 0))
    assert after.alike is None and isinstance(after, Polygons) and after.drawn.all()


@pytest.mark.parametrize("reverse", [False, True])
def test_rims_run_along_half_edges_of_triangles_whichever_way_these_run(reverse):
    _, polygons = polygon_mesh(POINTS, SURFACE)
    if reverse:
        polygons = replace(polygons, triangle_corners=polygons.triangle_corners[:, ::-1].copy())
    tails, heads = polygons.triangles.ravel(), np.roll(polygons.triangles, -1, axis=1).ravel()
    for start, size in zip(polygons.starts, polygons.sizes, strict=True):
        for corner in range(size):
            half = polygons.rim_half_edges[start + corner]
            ends = polygons.corner_vertices[[start + corner, start + (corner + 1) % size]]
            assert {tails[half], heads[half]} == set(ends.tolist())


def test_faces_without_triangles_have_no_half_edges_along_their_rims():
    _, polygons = polygon_mesh(POINTS, SURFACE)
    left = polygons.triangle_faces == 0
    polygons = replace(polygons, triangle_corners=polygons.triangle_corners[left], triangle_faces=np.zeros(4, int))
    assert (polygons.rim_half_edges[:6] >= 0).all() and (polygons.rim_half_edges[6:] == -1).all()


def test_steps_along_rims_reach_every_corner_of_a_face_but_its_start_in_turn():
    polygons, _ = solved([*SURFACE, [0, 5, 7]])
    walks = [[start] for start in polygons.starts.tolist()]
    for faces, corners in polygons.rim_steps:
        for face, corner in zip(faces.tolist(), corners.tolist(), strict=True):
            walks[face].append(corner)
    assert walks == [[*range(0, 6)], [*range(6, 9)], [*range(9, 12)]]


def test_faces_are_sent_without_what_the_other_process_computes_again():
    polygons, _ = solved(SURFACE)
    size = len(pickle.dumps(polygons))
    computed = polygons.rim_half_edges, polygons.rim_steps, polygons.triangles, polygons.corner_faces
    assert len(pickle.dumps(polygons)) == size
    sent = pickle.loads(pickle.dumps(polygons))
    np.testing.assert_array_equal(sent.rim_half_edges, computed[0])
    np.testing.assert_array_equal(sent.triangles, computed[2])
