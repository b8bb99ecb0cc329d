# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The door for new meshes and curves: sound arrays go through, others are refused before Blender sees them."""

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SynchError
from synch_fields.synch_addon.blender.new_geometry import add_spline, fill_mesh, new_mesh

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])

WRONG = {
    "one corner": (SQUARE, [0, 1, 2, 3], [3, 1]),
    "two corners": (SQUARE, [0, 1, 2, 3, 0], [3, 2]),
    "no corners": (SQUARE, [0, 1, 2], [3, 0]),
    "a vertex twice": (SQUARE, [[0, 1, 2], [0, 1, 0]], None),
    "a vertex twice in a row": (SQUARE, [[0, 0, 1, 2]], None),
    "a vertex twice, apart": (SQUARE, [[0, 1, 2, 1]], None),
    "beyond the last vertex": (SQUARE, [[0, 1, 4]], None),
    "below the first vertex": (SQUARE, [[0, 1, -1]], None),
    "more corners than sizes": (SQUARE, [0, 1, 2, 3], [3]),
    "fewer corners than sizes": (SQUARE, [0, 1, 2], [4]),
    "not a number": (SQUARE * [1, np.nan, 1], [[0, 1, 2]], None),
    "infinite": (SQUARE + [0, 0, np.inf], [[0, 1, 2]], None),
    "too large for single precision": (SQUARE * 1e39, [[0, 1, 2]], None),
    "not finite at a loose vertex": (np.vstack([SQUARE, [0, 0, np.nan]]), [[0, 1, 2]], None),
}


def faces_of(data):
    return [tuple(polygon.vertices) for polygon in data.polygons]


def test_sound_faces_of_several_sizes_go_through():
    points = np.vstack([SQUARE, [[2, 0.5, 0]]])
    data = new_mesh("Sound", points, [0, 1, 2, 3, 1, 4, 2], [4, 3])
    assert faces_of(data) == [(0, 1, 2, 3), (1, 4, 2)] and len(data.edges) == 6
    np.testing.assert_array_equal([vertex.co for vertex in data.vertices], points)
    assert not data.validate() and not any(polygon.use_smooth for polygon in data.polygons)
    assert all(polygon.use_smooth for polygon in new_mesh("Smooth", points, [[0, 1, 2]], smooth=True).polygons)


def test_a_mesh_may_be_empty_or_have_vertices_alone():
    assert len(new_mesh("Empty").vertices) == 0
    data = new_mesh("Points", SQUARE)
    assert len(data.vertices) == 4 and not data.polygons


@pytest.mark.parametrize("name", WRONG)
def test_what_would_end_blender_is_refused_in_one_line_and_nothing_is_made(name):
    before = list(bpy.data.meshes)
    with pytest.raises(SynchError, match=r"internal fault made .* for Wrong: nothing was written") as caught:
        new_mesh("Wrong", *WRONG[name])
    assert "\n" not in str(caught.value) and list(bpy.data.meshes) == before


@pytest.mark.parametrize("name", WRONG)
def test_a_mesh_that_is_filled_anew_stays_as_it_was_where_that_is_refused(name):
    data = new_mesh("Wrong", SQUARE, [[0, 1, 2, 3]])
    with pytest.raises(SynchError, match="internal fault"):
        fill_mesh(data, *WRONG[name])
    assert faces_of(data) == [(0, 1, 2, 3)] and len(data.vertices) == 4
    fill_mesh(data, SQUARE[:3], [[0, 1, 2]])
    assert faces_of(data) == [(0, 1, 2)] and len(data.vertices) == 3


@pytest.mark.parametrize("kind", ["POLY", "NURBS", "BEZIER"])
def test_splines_have_finite_points(kind):
    data = bpy.data.curves.new("Lines", "CURVE")
    spline = add_spline(data, SQUARE, kind, is_closed=True)
    points = spline.bezier_points if kind == "BEZIER" else spline.points
    np.testing.assert_array_equal([point.co[:3] for point in points], SQUARE)
    assert spline.use_cyclic_u
    for wrong in (SQUARE * np.nan, np.empty((0, 3)), SQUARE + 1e39):
        with pytest.raises(SynchError, match="internal fault"):
            add_spline(data, wrong, kind)
    assert len(data.splines) == 1
