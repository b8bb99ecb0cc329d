# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pins of an object: disclinations of chosen faces, in solves, in what is read back, and by a click."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SettingError, SynchError
from synch_fields.core.settings.pins import parse_pins, text_of_pins
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender.defect_empties import COLORS as DEFECT_COLORS
from synch_fields.synch_addon.operators.pins import SYNCH_OT_pin
from synch_fields.synch_addon.panels import overlay, overlay_view
from synch_fields.synch_addon.patterns import memory
from synch_fields.synch_addon.patterns.picking import PickedSurface
from synch_fields.synch_addon.patterns.pin_costs import PinCosts, cost_line

from ..scenes import attribute, grid, quad_sphere, snapshot, sphere, torus


@pytest.mark.parametrize("command, order", [("stripes", 2), ("quads", 4)])
@pytest.mark.parametrize("build", [torus, sphere])
def test_solves_have_the_turns_that_were_asked_for(build, command, order):
    obj = build()
    pins = {10: 1, 200: -1}
    report = getattr(api, command)(obj, spacing=0.5, pins=text_of_pins(pins))
    found = {defect["face"]: defect["index"] for defect in report["disclinations"]}
    if build is sphere:  # each of its faces is one triangle
        assert {face: found[face] * order for face in pins} == pins
    else:
        numbers = [d for d in memory.recall(obj).field.disclinations if d.triangle in (20, 400)]
        assert {d.triangle: d.index * order for d in numbers} == {20: 1, 400: -1}
    assert sum(d["index"] for d in report["disclinations"]) == pytest.approx(report["euler_characteristic"])


def test_the_objects_own_pins_count_and_are_read_back():
    obj = quad_sphere(9)
    obj.synch.pins = "100=1"
    report = api.stripes(obj, spacing=0.5)
    assert report["settings"]["pins"] == "100=1"
    lines = api.isolines(obj)["lines"]
    obj.synch.pins = ""  # what is shown is as it was solved
    memory.forget(obj)
    assert api.isolines(obj)["lines"] == lines
    assert api.stripes(obj, spacing=0.5)["settings"]["pins"] == ""


def test_a_solve_tells_what_other_pins_cost():
    obj = sphere()
    assert "pins_cost" not in api.stripes(obj, spacing=0.5)
    free = memory.recall(obj).field
    report = api.stripes(obj, spacing=0.5, pins="10=1,200=-1")
    pinned = memory.recall(obj).field
    bent = free.problem.energy(np.exp(2j * pinned.angles))
    assert report["pins_cost"] == pytest.approx(bent / free.energy - 1) and report["pins_cost"] > 0.05
    assert "pins_cost" not in api.vary(obj, 1)
    assert api.stripes(obj, spacing=0.5)["pins_cost"] < -0.05
    assert "pins_cost" not in api.stripes(obj, spacing=0.4, pins="10=1")


def test_a_click_pins_a_face_and_what_was_pinned_comes_back():
    obj = quad_sphere(9)
    surface = PickedSurface.of(obj)
    operator, shown = SimpleNamespace(turns=-1), bpy.context.scene.synch_overlay
    shown.show = shown.constraints = False
    SYNCH_OT_pin.begin(operator, obj)
    rays = [((*(3 * np.array(face.center)),), (*(-np.array(face.center)),)) for face in obj.data.polygons]
    rays = [tuple(map(tuple, ray)) for ray in rays]
    assert SYNCH_OT_pin.pick(operator, obj, surface, rays[7], False)
    assert SYNCH_OT_pin.pick(operator, obj, surface, rays[8], True)  # dragged there
    operator.turns = 0
    assert SYNCH_OT_pin.pick(operator, obj, surface, rays[30], False)
    assert parse_pins(obj.synch.pins) == {8: -1, 30: 0}
    assert not SYNCH_OT_pin.pick(operator, obj, surface, ((9, 9, 9), (1, 0, 0)), False)
    assert shown.show and "PINS" in shown.parts
    SYNCH_OT_pin.take_back(operator, obj)
    assert obj.synch.pins == "" and not shown.show and "PINS" not in shown.parts
    obj.synch.pins = "5=1"
    assert bpy.ops.synch.unpin() == {"FINISHED"} and obj.synch.pins == ""


@pytest.mark.parametrize("symmetry, command", [("LINE", "stripes"), ("CROSS", "quads")])
def test_what_pins_cost_is_told_about_right_before_the_solve(symmetry, command):
    obj = torus()
    obj.synch.symmetry = symmetry
    pins = "10=1,200=-1"
    getattr(api, command)(obj, spacing=0.5)
    free = memory.recall(obj).field.bending
    costs = PinCosts(obj)
    obj.synch.pins = ""
    assert costs.compute(obj) == pytest.approx(0, abs=1e-6)
    obj.synch.pins = pins
    told = costs.compute(obj)
    assert f"2 pins: about {told:+.0%} bending" == cost_line(obj)
    getattr(api, command)(obj, spacing=0.5)
    true = memory.recall(obj).field.bending / free - 1
    assert true > 0.1 and 1 + told == pytest.approx(1 + true, rel=0.15)  # first fields have more energy
    obj.synch.pins = "10=1"
    assert cost_line(obj) == ""


def test_directions_that_do_not_bend_have_no_cost():
    obj = grid(9)
    obj.synch.pins = "10=1"
    assert PinCosts(obj).compute(obj) is None and cost_line(obj) == ""


def test_pinned_faces_are_marked_in_the_colours_of_their_disclinations():
    obj = quad_sphere(9)
    obj.synch.pins = "7=1,8=-2,30=0,9=3,9999=1"
    layers = {colour: points for points, colour in overlay.pin_points(obj)}
    middles = [np.array(face.center) for face in obj.data.polygons]
    positive, negative = DEFECT_COLORS["disclination"]
    for colour, faces in ((positive, [7, 9]), (negative, [8]), (overlay.UNTURNED_COLOR, [30])):
        np.testing.assert_allclose(layers.pop(colour), [middles[face] for face in faces])
    assert not layers
    before = overlay_view.key(obj)
    obj.synch.pins = "what"
    assert overlay.pin_points(obj) == [] and overlay_view.key(obj) != before


@pytest.mark.parametrize(
    "pins, match", [("5", "pin 5= cannot be read"), ("a=1", "a=1"), ("5=x", "5=x"), (7, "give a text")]
)
def test_what_is_no_pin_is_refused(pins, match):
    with pytest.raises(SettingError, match=match):
        api.stripes(sphere(), pins=pins)


def test_faces_that_are_not_there_and_mirrors_are_refused_and_nothing_changes():
    obj = torus()
    before = snapshot()
    for settings, match in (({"pins": "9999=1"}, "no face 9999"), ({"pins": "5=1", "mirror": "X"}, "pin both sides")):
        with pytest.raises(SynchError, match=match):
            api.stripes(obj, spacing=0.5, **settings)
    assert snapshot() == before
    api.stripes(obj, spacing=0.5)
    api.directions(obj, guidance="attribute:synch_direction", pins="3=1")
    assert len(attribute(obj, "synch_direction"))
