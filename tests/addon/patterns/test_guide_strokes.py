# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Guide strokes: curves of an object that its constraint list holds, and what patterns make of them."""

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from synch_fields.core.errors import SynchError
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender.strokes import polylines
from synch_fields.synch_addon.patterns import guide_strokes
from synch_fields.synch_addon.settings.constraint_list import stored_constraints

from ..run_commands import undo_and_redo
from ..scenes import add_curve, attribute, directions, places, snapshot, sphere

# Knots on the unit sphere, away from its edges' directions.
TURNS = np.linspace(0.0, 1.6, 9)
LEVEL = 0.4 * np.sin(2 * TURNS)
LINE = np.column_stack([np.cos(TURNS) * np.cos(LEVEL), np.sin(TURNS) * np.cos(LEVEL), np.sin(LEVEL)])


def keys(obj):
    return [(stroke.key, stroke.wish) for stroke in guide_strokes.strokes_of(obj)]


def test_strokes_of_a_wish_and_a_strength_share_a_curve_and_a_row():
    obj = sphere()
    guide_strokes.add(obj, [LINE], "ALONG", None)
    guide_strokes.add(obj, [-LINE, LINE[::-1]], "ALONG", None)
    guide_strokes.add(obj, [LINE], "PHASE", 2.5)
    guide_strokes.add(obj, [LINE], "ALONG", 2.5)
    rows = [(row.what, row.soft, row.weight, row.curve.name) for row in obj.synch.constraints]
    name = obj.name
    assert [row[:2] for row in rows] == [("ALONG", False), ("PHASE", True), ("ALONG", True)]
    assert rows[1][2] == rows[2][2] == 2.5
    assert keys(obj)[:3] == [((f"{name} Along", number), "ALONG") for number in range(3)]
    (collection,) = {group.name for row in obj.synch.constraints for group in row.curve.users_collection}
    assert collection == f"{name} Strokes" and len(keys(obj)) == 5
    assert [row.weight for row in stored_constraints(obj)] == [None, 2.5, 2.5]


def test_the_line_through_the_knots_is_the_line_that_is_read():
    """What is drawn over the view is what Blender makes of the splines."""
    obj = sphere()
    guide_strokes.add(obj, [LINE], "ALONG", None)
    bpy.context.view_layer.update()
    (stroke,) = guide_strokes.strokes_of(obj)
    (line,) = polylines(bpy.data.objects[stroke.curve])
    np.testing.assert_allclose(stroke.points, line, atol=1e-6)
    for knot in LINE:
        assert np.linalg.norm(stroke.points - knot, axis=1).min() < 1e-6


@pytest.mark.parametrize("spline", ["POLY", "NURBS"])
def test_splines_of_other_kinds_count_by_their_points(spline):
    obj = sphere()
    guide_strokes.add(obj, [LINE], "ALONG", None)
    data = obj.synch.constraints[0].curve.data
    data.splines.new(spline).points.add(2)
    for point, place in zip(data.splines[1].points, LINE[:3], strict=True):
        point.co = (*place, 1.0)
    assert keys(obj) == [(("Icosphere Along", number), "ALONG") for number in range(2)]
    np.testing.assert_allclose(guide_strokes.strokes_of(obj)[1].points, LINE[:3], atol=1e-6)


def test_strokes_go_where_the_object_goes_and_others_follow_the_curve_that_was_moved():
    obj = sphere()
    guide_strokes.add(obj, [LINE], "ALONG", None)
    obj.matrix_world = Matrix.Translation((3, 1, 2)) @ Matrix.Rotation(1.0, 4, "X") @ Matrix.Diagonal((1, 2, 3, 1))
    bpy.context.view_layer.update()
    curve = obj.synch.constraints[0].curve
    np.testing.assert_allclose(curve.matrix_world, obj.matrix_world, atol=1e-6)
    curve.location.x += 0.25
    guide_strokes.add(obj, [-LINE], "ALONG", None)
    first, second = guide_strokes.strokes_of(obj)
    np.testing.assert_allclose(first.points[[0, -1]], LINE[[0, -1]] + (0.25, 0, 0), atol=1e-6)
    np.testing.assert_allclose(second.points[[0, -1]], -LINE[[0, -1]], atol=1e-6)


def test_a_stroke_gets_other_points_and_the_others_stay():
    obj = sphere()
    guide_strokes.add(obj, [LINE, -LINE, LINE[::-1]], "ACROSS", None)
    before = {stroke.key[1]: stroke.points for stroke in guide_strokes.strokes_of(obj)}
    guide_strokes.replace(obj, {("Icosphere Across", 1): 0.5 * LINE[:2]})
    found = [stroke.points for stroke in guide_strokes.strokes_of(obj)]
    np.testing.assert_array_equal(found[0], before[0])
    np.testing.assert_array_equal(found[1], before[2])
    np.testing.assert_allclose(found[2][[0, -1]], 0.5 * LINE[:2], atol=1e-6)


def test_the_last_stroke_takes_its_row_its_curve_and_its_collection_with_it():
    obj = sphere()
    foreign = add_curve(LINE.tolist(), "Foreign")
    row = obj.synch.constraints.add()
    row.where, row.curve = "CURVE", foreign
    before = snapshot()
    guide_strokes.add(obj, [LINE, -LINE], "ALONG", None)
    guide_strokes.add(obj, [LINE], "PHASE", None)
    guide_strokes.remove(obj, [("Icosphere Along", 0)])
    assert keys(obj) == [(("Icosphere Along", 0), "ALONG"), (("Icosphere Stripes", 0), "PHASE")]
    guide_strokes.remove(obj, [key for key, _ in keys(obj)])
    assert keys(obj) == [] and snapshot() == before
    assert [row.curve for row in obj.synch.constraints] == [foreign]


def test_a_copy_of_the_object_draws_into_a_curve_of_its_own():
    obj = sphere()
    guide_strokes.add(obj, [LINE], "ALONG", None)
    copy = obj.copy()
    bpy.context.collection.objects.link(copy)
    assert keys(copy) == [] and len(copy.synch.constraints) == 1
    guide_strokes.add(copy, [-LINE], "ALONG", None)
    assert len(keys(obj)) == len(keys(copy)) == 1 and len(copy.synch.constraints) == 2


def test_what_fails_leaves_nothing(monkeypatch):
    obj = sphere()
    guide_strokes.add(obj, [LINE], "ALONG", None)
    before, strokes = snapshot(), keys(obj)
    monkeypatch.setattr(guide_strokes, "_strokes_changed", lambda curve: 1 / 0)
    for work in (
        lambda: guide_strokes.add(obj, [LINE], "ALONG", None),
        lambda: guide_strokes.add(obj, [LINE], "ACROSS", None),
        lambda: guide_strokes.replace(obj, {("Icosphere Along", 0): -LINE}),
    ):
        with pytest.raises(ZeroDivisionError):
            work()
        assert snapshot() == before and keys(obj) == strokes


def test_undo_and_redo_of_a_stroke():
    obj = sphere()
    name = obj.name

    def work():
        guide_strokes.add(bpy.data.objects[name], [LINE], "ALONG", None)
        return {"FINISHED"}

    def see():
        return [(stroke.key, stroke.points.tolist()) for stroke in guide_strokes.strokes_of(bpy.data.objects[name])]

    undo_and_redo(work, see)


def beside_the_stroke(obj):
    """Vertices near the inner part of LINE, the unit tangents of it there, and how far away it is."""
    turns = np.linspace(TURNS[0], TURNS[-1], 400)
    level = 0.4 * np.sin(2 * turns)
    line = np.column_stack([np.cos(turns) * np.cos(level), np.sin(turns) * np.cos(level), np.sin(level)])
    tangents = np.gradient(line, axis=0)
    apart = np.linalg.norm(places(obj)[:, None] - line, axis=2)
    near = apart.argmin(axis=1)
    chosen = np.flatnonzero((apart.min(axis=1) < 0.04) & (near > 20) & (near < 380))
    tangents = tangents[near[chosen]]
    return chosen, tangents / np.linalg.norm(tangents, axis=1, keepdims=True), apart.min(axis=1)[chosen]


@pytest.mark.parametrize("wish, lowest, highest", [("ALONG", 0, 8), ("ACROSS", 82, 90), ("PHASE", 0, 8)])
def test_directions_near_a_stroke_are_as_it_asks(wish, lowest, highest):
    obj = sphere(5)
    guide_strokes.add(obj, [LINE], wish, None)
    api.stripes(obj, spacing=0.2)
    chosen, tangents, away = beside_the_stroke(obj)
    cosines = np.abs(np.einsum("ij,ij->i", directions(obj)[chosen], tangents))
    angles = np.degrees(np.arccos(np.minimum(cosines, 1)))
    assert len(chosen) > 20 and lowest <= np.quantile(angles, 0.05) and np.quantile(angles, 0.95) <= highest
    if wish == "PHASE":
        shown = attribute(obj, "synch_pattern")[chosen]
        assert np.abs(shown - np.cos(2 * np.pi * away / 0.2)).max() < 0.15


def test_a_soft_stroke_draws_more_the_stronger_it_is():
    obj, off = sphere(5), []
    for weight in (1.0, 100.0, None):
        guide_strokes.remove(obj, [key for key, _ in keys(obj)])
        guide_strokes.add(obj, [LINE], "ALONG", weight)
        api.stripes(obj, spacing=0.2)
        chosen, tangents, _ = beside_the_stroke(obj)
        off.append(np.abs(np.einsum("ij,ij->i", directions(obj)[chosen], tangents)).mean())
    assert off[0] < off[1] <= off[2] + 1e-3


def test_a_curve_that_was_emptied_by_hand_is_named():
    obj = sphere()
    guide_strokes.add(obj, [LINE], "ALONG", None)
    data = obj.synch.constraints[0].curve.data
    data.splines.remove(data.splines[0])
    with pytest.raises(SynchError, match="'Icosphere Along' holds no curve"):
        api.stripes(obj, spacing=0.5)
    guide_strokes.add(obj, [LINE], "ALONG", None)
    api.stripes(obj, spacing=0.5)
