# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps are painted by one click, in their own units."""

import json

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SynchError
from synch_fields.synch_addon import api
from synch_fields.synch_addon.settings.painting import painted_map

from ..run_commands import add_weights
from ..scenes import add_group, directions, grid, places, set_numbers, snapshot, sphere


@pytest.fixture(autouse=True)
def _leaves_the_mode():
    yield
    if bpy.context.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")


def brush():
    return bpy.context.window_manager.synch_brush


@pytest.fixture(params=[False, True], ids=["own", "shared"], autouse=True)
def _weight_of_all_brushes(request, blender):
    tools = bpy.context.tool_settings
    shared = getattr(tools.weight_paint, "unified_paint_settings", None) or tools.unified_paint_settings
    shared.use_unified_weight = request.param


def weight():
    """What Blender's own brush paints."""
    tools = bpy.context.tool_settings
    shared = getattr(tools.weight_paint, "unified_paint_settings", None) or tools.unified_paint_settings
    return (shared if shared.use_unified_weight else tools.weight_paint.brush).weight


@pytest.mark.parametrize("target, name", [("SPACING", "spacing_map"), ("ANGLE", "angle_attribute")])
def test_a_click_makes_the_group_and_paints_it(target, name):
    obj = grid()
    assert bpy.ops.synch.paint_map(target=target) == {"FINISHED"}
    assert obj.mode == "WEIGHT_PAINT" and painted_map(obj) == target
    assert getattr(obj.synch, name) == obj.vertex_groups.active.name == target.title()
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.synch.paint_map(target=target)  # and again, in the same group
    assert len(obj.vertex_groups) == 1 and obj.mode == "WEIGHT_PAINT"


@pytest.mark.parametrize("target, settings", [("SPACING", "synch"), ("LAYERS", "synch_layering")])
def test_a_new_map_of_spacing_is_of_finer_lines_where_no_range_was_chosen(target, settings):
    for chosen in (None, 3.0):
        stored = getattr(grid(), settings)
        if chosen:
            stored.spacing_range = chosen
        bpy.ops.synch.paint_map(target=target)
        assert stored.spacing_range == (chosen or 0.5)
        bpy.ops.object.mode_set(mode="OBJECT")


def test_it_is_painted_from_edit_mode_too():
    obj = grid()
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.synch.paint_map(target="ANGLE")
    assert obj.mode == "WEIGHT_PAINT" and {len(vertex.groups) for vertex in obj.data.vertices} == {1}


def test_the_layers_have_a_map_of_their_own():
    obj = grid()
    bpy.ops.synch.paint_map(target="LAYERS")
    assert obj.synch_layering.spacing_map == "Layer Spacing" and obj.synch.spacing_map == ""
    assert painted_map(obj) == "LAYERS"


def test_a_group_that_is_named_is_painted_and_a_missing_one_made():
    obj = grid()
    add_group(obj, "other", [0])
    add_group(obj, "wide", [1])
    obj.synch.spacing_map = "wide"
    bpy.ops.synch.paint_map(target="SPACING")
    assert obj.vertex_groups.active.name == "wide" and len(obj.vertex_groups) == 2
    bpy.ops.object.mode_set(mode="OBJECT")
    obj.synch.spacing_map = "gone"
    bpy.ops.synch.paint_map(target="SPACING")
    assert obj.vertex_groups.active.name == obj.synch.spacing_map == "gone"


def test_a_new_group_gets_a_name_that_no_attribute_has():
    obj = grid()
    set_numbers(obj, "Spacing", np.ones(len(obj.data.vertices)))
    assert bpy.ops.synch.paint_map(target="SPACING") == {"FINISHED"}
    assert painted_map(obj) == "SPACING" and obj.synch.spacing_map == "Spacing.001"
    assert bpy.ops.object.mode_set(mode="OBJECT") == {"FINISHED"}
    assert bpy.ops.synch.paint_map(target="SPACING") == {"FINISHED"} and len(obj.vertex_groups) == 1


def test_an_attribute_is_refused_and_left_alone():
    obj = grid()
    set_numbers(obj, "wide", np.ones(len(obj.data.vertices)))
    obj.synch.spacing_map = "wide"
    before = snapshot()
    with pytest.raises(RuntimeError, match="wide is an attribute, and vertex groups are painted"):
        bpy.ops.synch.paint_map(target="SPACING")
    assert snapshot() == before and obj.mode == "OBJECT"


@pytest.mark.parametrize("full, factor", [(0.25, 0.5), (4.0, 2.0), (2.0, 1.0)])
def test_the_brush_speaks_of_factors_on_the_spacing(full, factor):
    obj = grid()
    bpy.ops.synch.paint_map(target="SPACING")
    obj.synch.spacing_range = full
    brush().factor = factor
    assert weight() == pytest.approx(np.log(factor) / np.log(full)) and brush().factor == pytest.approx(factor)
    brush().factor = full**2  # beyond what a weight can stand for
    assert weight() == 1 and brush().factor == pytest.approx(full)


def test_the_brush_speaks_of_angles():
    obj = grid()
    bpy.ops.synch.paint_map(target="ANGLE")
    obj.synch.angle_range = np.radians(-60)
    brush().angle = np.radians(-15)
    assert weight() == pytest.approx(0.25) and brush().angle == pytest.approx(np.radians(-15))
    brush().angle = 1.0
    assert weight() == 0


def test_what_is_painted_is_what_is_solved():
    """The brush's value over all vertices turns the directions by the angle that it shows."""
    obj = grid()
    bpy.ops.synch.paint_map(target="ANGLE")
    obj.synch.angle_range = np.radians(80)
    brush().angle = np.radians(20)
    painted = weight()
    bpy.ops.object.mode_set(mode="OBJECT")
    obj.vertex_groups["Angle"].add(range(len(obj.data.vertices)), painted, "REPLACE")
    api.directions(obj, guidance="axis:X", symmetry="vector", angle_attribute="Angle", angle_range=np.radians(80))
    found = directions(obj)
    np.testing.assert_allclose(
        found, np.tile([np.cos(np.radians(20)), np.sin(np.radians(20)), 0], (len(found), 1)), atol=1e-4
    )


@pytest.mark.parametrize("kind", ["stripes", "quad_mesh"])
def test_one_click_ends_painting_and_makes_what_the_panel_makes(kind):
    obj = sphere()
    obj.synch_simple.kind = kind
    bpy.ops.synch.paint_map(target="SPACING")
    assert bpy.ops.synch.done_painting(solves=True) == {"FINISHED"}
    made = bpy.context.active_object
    assert (made == obj) == (kind == "stripes") and made.mode == "OBJECT"
    assert json.loads(made.synch.result)["command"] == kind
    if kind == "stripes":
        return
    before = len(made.data.polygons)
    made.synch.faces, made.synch.spacing_map, made.synch.spacing_range = 2 * before, "", 2.0  # as of one without a map
    bpy.ops.synch.paint_map(target="SPACING")
    bpy.ops.synch.done_painting()
    assert made.mode == "OBJECT" and len(made.data.polygons) == before and made.synch.spacing_range == 0.5
    bpy.ops.synch.paint_map(target="SPACING")
    bpy.ops.synch.done_painting(solves=True)
    assert len(made.data.polygons) == pytest.approx(2 * before, rel=0.1)


def test_why_nothing_is_made_after_painting_is_said_in_one_line():
    obj = sphere()
    bpy.ops.synch.paint_map(target="SPACING")
    obj.scale = (0, 0, 0)
    with pytest.raises(RuntimeError, match="the scale of Icosphere is zero along an axis") as caught:
        bpy.ops.synch.done_painting(solves=True)
    assert str(caught.value).strip().count("\n") == 0 and obj.mode == "OBJECT"


def test_weights_between_give_angles_between():
    obj = grid()
    x = places(obj)[:, 0]
    add_weights(obj, "ramp", (x + 1) / 2)
    api.directions(obj, guidance="axis:X", symmetry="vector", angle_attribute="ramp", angle_range=-0.8)
    angles = -0.8 * (x + 1) / 2
    np.testing.assert_allclose(directions(obj), np.column_stack([np.cos(angles), np.sin(angles), 0 * x]), atol=1e-4)
    with pytest.raises(SynchError, match="the angle range is inf"):
        api.directions(obj, angle_attribute="ramp", angle_range=float("inf"))
