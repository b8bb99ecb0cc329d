# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Custom properties that a .blend keeps of ours and that others have written to: one line, or as if absent."""

import math

import bpy
import pytest

from synch_fields.core.errors import SynchError
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender.defect_empties import defect_empties

from ..baked_images import bake
from ..scenes import make_active, sphere
from ..solid_objects import block

SPOILT = ["a text\nin two lines", "", [1, 2], {"a": {"b": 1}}, math.nan, math.inf, -1.0, 0, 2**31 - 1, b"\xff", True]
# Of the empties that mark defects.
EMPTY_PROPERTIES = ["synch_kind", "synch_index", "synch_face", "synch_phase"]


def solved():
    obj = sphere(2)
    api.stripes(obj, spacing=0.7, method="spectral")
    return obj


def one_line(work):
    """The result of some work; None where it has said in one line why not."""
    try:
        return work()
    except SynchError as error:
        assert "\n" not in str(error) and str(error)
        return None


@pytest.mark.parametrize("value", SPOILT[::2], ids=repr)
def test_a_spoilt_spacing_is_told_where_it_is_needed_and_spoilt_empties_are_not_ours(value, tmp_path):
    """Until the next solve replaces both."""
    obj = solved()
    obj["synch_spacing"] = value
    count = len(defect_empties(obj))
    for name, empty in zip(EMPTY_PROPERTIES, defect_empties(obj), strict=False):
        empty[name] = value
    one_line(lambda: api.relief(obj))
    bake(obj, tmp_path, size=16)
    make_active(obj)
    try:
        assert bpy.ops.synch.select_defects() == {"FINISHED"}
        bpy.ops.object.mode_set(mode="OBJECT")
    except RuntimeError as error:  # as Blender raises what an operator reports
        assert "solve it again" in str(error)
    assert api.stripes(obj, spacing=0.7, method="spectral")["status"]
    assert obj["synch_spacing"] == pytest.approx(0.7)
    assert count > 4 and 0 <= count - len(defect_empties(obj)) <= len(EMPTY_PROPERTIES)
    assert api.relief(obj)


@pytest.mark.parametrize("value", SPOILT[::4], ids=repr)
def test_spoilt_links_between_a_solid_and_what_shows_its_layers_are_as_if_absent(value):
    obj = block()
    count = api.layers(obj, guidance="axis:Z", spacing=0.3, size=0.15)["layers"]
    api.layer_toolpaths(obj, 0.3)
    (collection,) = (found for found in bpy.data.collections if found.get("synch_solid") == obj)
    for owner in (obj, collection, *bpy.data.objects):
        for name in list(owner.keys()):
            if name.startswith("synch_") and name != "synch_solid":
                owner[name] = value
    one_line(lambda: api.layer_toolpaths(obj, 0.3))
    assert api.layers(obj, guidance="axis:Z", spacing=0.3, size=0.15)["layers"] == count
    assert api.layer_toolpaths(obj, 0.3)["paths"]
