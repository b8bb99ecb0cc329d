# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows that contradict each other or cannot be: named, selected, nothing written."""

import re
from itertools import pairwise

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import ContradictionError, SettingError
from synch_fields.synch_addon import api

from ..constraint_rows import OPERATORS, add_row, middle, sheet
from ..scenes import add_curve, add_group, attribute, make_active, set_vectors, snapshot, sphere, tube


def selection(obj):
    """Selected vertices, edges as pairs, and faces."""
    editing = obj.mode == "EDIT"
    if editing:
        bpy.ops.object.mode_set(mode="OBJECT")
    found = (
        [v.index for v in obj.data.vertices if v.select],
        [e.key for e in obj.data.edges if e.select],
        [p.index for p in obj.data.polygons if p.select],
    )
    if editing:
        bpy.ops.object.mode_set(mode="EDIT")
    return found


def unselected():
    """A snapshot without the selection of mesh elements."""
    found = snapshot()
    for mesh in found["meshes"].values():
        for name in list(mesh):
            if name.startswith(".select"):
                del mesh[name]
    return found


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
@pytest.mark.parametrize("select_mode", [(True, False, False), (False, False, True)])
def test_two_phases_at_one_vertex_are_named_and_selected(mode, select_mode):
    obj = sheet()
    bpy.context.tool_settings.mesh_select_mode = select_mode
    obj.data.polygons.foreach_set("select", np.ones(len(obj.data.polygons), bool))
    x, y, _ = attribute(obj, "position").T
    add_group(obj, "left", np.flatnonzero(x < -0.99))
    add_group(obj, "lower", np.flatnonzero(y < -0.59))
    add_row(obj, where="GROUP", what="PHASE", vertex_group="left")
    add_row(obj, where="GROUP", what="PHASE", vertex_group="lower", phase=1.0)
    bpy.ops.object.mode_set(mode=mode)
    before = unselected()
    with pytest.raises(RuntimeError) as refused:
        bpy.ops.synch.stripes()
    line = (
        "the constraint group left phase and the constraint group lower phase fix vertex 0 to different phases: remove"
    )
    assert line in str(refused.value) and "\n" not in str(refused.value).strip()
    assert obj.mode == mode and selection(obj) == ([0], [], [])
    bpy.ops.object.mode_set(mode="EDIT")
    assert selection(obj) == ([0], [], [])
    bpy.ops.object.mode_set(mode=mode)
    assert unselected() == before


@pytest.mark.parametrize("operator", OPERATORS)
def test_along_and_across_on_the_same_edges_are_named_and_selected(operator):
    obj = sheet()
    add_row(obj, where="SEAMS", what="ALONG")
    add_row(obj, where="SEAMS", what="ACROSS")
    before = unselected()
    with pytest.raises(
        RuntimeError, match="seams along and the constraint seams across ask for different directions at"
    ):
        getattr(bpy.ops.synch, operator)()
    on = np.flatnonzero(middle(obj)).tolist()
    assert selection(obj) == (on, list(pairwise(on)), [])
    assert unselected() == before
    obj.synch.constraints[1].soft = True
    assert getattr(bpy.ops.synch, operator)() == {"FINISHED"}


def test_contradictions_on_a_cut_mesh_name_the_vertices_of_the_object():
    obj = sheet()
    on = np.flatnonzero(middle(obj))
    rows = [{"where": "seams", "what": what} for what in ("cut", "along", "across")]
    with pytest.raises(ContradictionError) as refused:
        api.directions(obj, constraints=rows)
    np.testing.assert_array_equal(refused.value.vertices, on)
    assert f"vertices {on[0]}, {on[1]}, {on[2]} and 3 more: remove" in str(refused.value)


def test_a_line_of_the_same_phase_that_joins_two_phases_is_named():
    obj = sheet()
    on = np.flatnonzero(middle(obj))
    add_group(obj, "lowest", on[:1])
    add_group(obj, "highest", on[-1:])
    rows = [{"where": "seams", "what": "cut"}, {"where": "seams", "what": "constant"}]
    rows += [{"where": "group", "what": "phase", "name": name} for name in ("lowest", "highest")]
    api.stripes(obj, spacing=0.4, constraints=rows)
    rows[-1]["degrees"] = 90
    with pytest.raises(ContradictionError) as refused:
        api.stripes(obj, spacing=0.4, constraints=rows)
    message = f"the constraint seams constant joins vertices {on[0]}, {on[-1]}, for which different values are asked"
    assert message in str(refused.value)
    np.testing.assert_array_equal(refused.value.vertices, on[[0, -1]])


@pytest.mark.parametrize(
    "rows, message",
    [
        ("along", "the constraints are not a list: give a list of rows"),
        (["along"], "row 1 is 'along': give it a 'where' and a 'what'"),
        ([{"where": "seams"}], "row 1 is {'where': 'seams'}: give it a 'where' and a 'what'"),
        (
            [{"where": "seams", "what": "cut"}, {"where": "seams", "what": "cut", "angle": 3}],
            "row 2 has the key 'angle': use where, what, name, degrees, weight",
        ),
        ([{"where": "hem", "what": "cut"}], "'hem': use one of boundary, group, seams"),
        ([{"where": "seams", "what": "dance"}], "'dance': use one of along, across"),
        (
            [{"where": "curve", "what": "cut", "name": "c"}],
            "row 1: the constraint curve c cut is impossible: use one of",
        ),
        (
            [{"where": "seams", "what": "cut", "weight": 1}],
            "the constraint seams cut has a weight: a cut can only be hard",
        ),
        ([{"where": "group", "what": "along"}], "has no name: choose a vertex group"),
        (
            [{"where": "group", "what": "along", "name": 7}],
            "row 1: the name 7 in group along is not text: give a name",
        ),
        ([{"where": "seams", "what": "angle", "degrees": "10"}], "the degrees of the constraint seams angle is '10'"),
        ([{"where": "seams", "what": "angle", "degrees": float("nan")}], "is nan: give a finite number"),
        ([{"where": "seams", "what": "along", "weight": -1}], "the weight of the constraint seams along is -1: give"),
        ([{"where": "seams", "what": "constant", "weight": 1}], "constant is soft: a phase that is constant"),
        ([{"where": "sharp", "what": "along"}], "holds no edge: mark edges with Mark Sharp first, or remove the row"),
        ([{"where": "creases", "what": "cut"}], "holds no edge: mark edges with Edge Crease first"),
        (
            [{"where": "group", "what": "along", "name": "none"}],
            "no vertex group 'none': choose one of its groups (some)",
        ),
        ([{"where": "group", "what": "cut", "name": "some"}], "holds no edge: add both ends of at least one to 'some'"),
        ([{"where": "curve", "what": "along", "name": "none"}], "there is no curve object 'none': choose a curve"),
        ([{"where": "curve", "what": "along", "name": "Panel"}], "there is no curve object 'Panel': choose a curve"),
        ([{"where": "curve", "what": "along", "name": "Lamp"}], "the object 'Lamp' is a light: choose a curve"),
        ([{"where": "curve", "what": "along", "name": "Dot"}], "the object 'Dot' holds no curve: draw one"),
        ([{"where": "attribute", "what": "along", "name": "none"}], "no attribute 'none': choose a vector attribute"),
        ([{"where": "attribute", "what": "phase", "name": "none"}], "no attribute 'none': choose a float attribute"),
    ],
    ids=lambda value: str(value)[:60],
)
def test_what_cannot_be_is_refused_in_one_line_and_changes_nothing(rows, message):
    obj = sheet()
    add_group(obj, "some", [0])
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    bpy.context.scene.collection.objects.link(lamp)
    add_curve([(0, 0, 0)], "Dot")
    make_active(obj)
    before = snapshot()
    with pytest.raises(SettingError, match=re.escape(message)) as refused:
        api.stripes(obj, spacing=0.4, constraints=rows)
    assert "\n" not in str(refused.value)
    assert snapshot() == before


def test_a_closed_mesh_has_no_boundary_to_ask_of():
    with pytest.raises(SettingError, match="the mesh has no boundary"):
        api.stripes(sphere(), constraints=[{"where": "boundary", "what": "along"}])


def test_rows_that_are_not_followed_are_warned_about():
    obj = tube()
    set_vectors(obj, "up", np.tile((0.0, 0, 1), (len(obj.data.vertices), 1)))
    along, stripe = ({"where": "boundary", "what": what} for what in ("along", "phase"))

    def warnings(rows, **settings):
        return [w for w in api.stripes(obj, spacing=0.5, constraints=rows, **settings)["warnings"] if "boundary" in w]

    given = {"guidance": "attribute:up"}
    assert warnings([along]) == warnings([along], angle=0.3) == warnings([stripe]) == []
    assert "without the constraint boundary along: give it a strength (attribute:up=1)" in warnings([along], **given)[0]
    assert "without the constraint boundary along" in warnings([], boundary="along", **given)[0]
    assert "lines with a stripe (the constraint boundary phase): set it to 0" in warnings([stripe], angle=0.3)[0]
    assert "lines with a stripe" in warnings([], boundary="phase", angle=0.3)[0]
