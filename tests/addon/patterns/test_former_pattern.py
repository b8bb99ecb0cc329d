# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers, flows and animations on an object that shows a pattern: nothing of that is left to hide the new phases."""

import bpy
import numpy as np
import pytest

from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender.modifiers import shows_frames
from synch_fields.synch_addon.blender.pattern_surface import surface_modifier
from synch_fields.synch_addon.nodes.stripe_profiles import ALONG, NUMBER

from ..scenes import sphere


def _numbered(obj):
    api.stripes(obj, surface="faces")
    api.number_stripes(obj)
    assert NUMBER in obj.data.attributes


def _on_own_surface(obj):
    api.stripes(obj, surface="seen")
    assert surface_modifier(obj) is not None


def _animated(obj):
    api.animate(obj, frames=(1, 2))
    assert any(map(shows_frames, obj.modifiers))


def _flow(obj):
    places = np.array([vertex.co for vertex in obj.data.vertices])
    velocity = np.cross((0, 0, 1), places).astype(np.float32)
    obj.data.attributes.new("velocity", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", velocity.ravel())
    api.clebsch(obj)


NEW = {
    "layers": lambda obj: api.layers(obj, spacing=0.8, size=0.4),
    "flow": _flow,
    "animation": lambda obj: api.animate(obj, frames=(3, 4)),
}


@pytest.mark.parametrize("new", NEW)
@pytest.mark.parametrize("former", [_numbered, _on_own_surface, _animated])
def test_nothing_is_left_of_the_former_pattern(former, new):
    obj = sphere()
    former(obj)
    NEW[new](obj)
    frames = {"synch_phase.3", "synch_phase.4"} if new == "animation" else set()
    names = {attribute.name for attribute in obj.data.attributes}
    assert "synch_phase" in names
    assert {name for name in names if name.startswith("synch_phase.")} == frames
    assert not {NUMBER, ALONG} & names
    assert surface_modifier(obj) is None
    assert any(map(shows_frames, obj.modifiers)) == bool(frames)
    assert obj.synch.result == ""
    layer = bpy.context.evaluated_depsgraph_get()
    shown = obj.evaluated_get(layer).data
    assert len(shown.polygons) == len(obj.data.polygons)
