# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is left of work that fails, and what comes at its end."""

import os
from contextlib import nullcontext

import bpy
import numpy as np
import pytest

from synch_fields.synch_addon.blender import attributes
from synch_fields.synch_addon.blender.schema import ATTRIBUTES
from synch_fields.synch_addon.blender.transaction import assign, at_the_end, drop, keep_file, store, whole_or_nothing

from ..scenes import LAYOUTS, add_attribute, attribute, grid, snapshot, sphere


def test_work_that_fails_takes_what_is_new_and_gives_back_what_was_changed():
    obj = sphere()
    with pytest.raises(MemoryError), whole_or_nothing():
        bpy.data.materials.new("New")
        assign(obj, "show_wire", True)
        with whole_or_nothing():
            assign(obj, "show_name", True)
        raise MemoryError
    assert "New" not in bpy.data.materials and not obj.show_wire and not obj.show_name
    with whole_or_nothing():
        assign(obj, "show_wire", True)
    assert obj.show_wire


def test_one_end_that_fails_keeps_no_other_from_coming():
    came = []

    def fail():
        raise MemoryError

    with pytest.raises(MemoryError), whole_or_nothing():
        for step in (lambda: came.append(1), fail, lambda: came.append(2)):
            at_the_end(step)
    assert came == [1, 2]
    at_the_end(lambda: came.append(3))
    assert came == [1, 2, 3]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes among files there")
def test_files_come_back_and_what_is_no_file_stays(tmp_path):
    obj = bpy.data.objects.new("Owner", None)
    there, new, pipe = (tmp_path / name for name in ("there.txt", "new.txt", "pipe"))
    there.write_text("old")
    os.mkfifo(pipe)
    for fails in (True, False):
        with pytest.raises(MemoryError) if fails else nullcontext(), whole_or_nothing():
            for path in (there, new, pipe):
                keep_file(obj, path)
            for path in (there, new):
                path.write_text("changed")
            if fails:
                raise MemoryError
        expected = {"pipe", "there.txt"} if fails else {"pipe", "there.txt", "new.txt"}
        assert {path.name for path in tmp_path.iterdir()} == expected and pipe.is_fifo()
        assert there.read_text() == ("old" if fails else "changed")


PROPERTIES = {
    "numbers": list(range(7, 27)),
    "floats": [0.5, 1e300],
    "single floats": np.float32([0.1, 2]),
    "flags": [True, False],
    "no numbers": [],
    "rows": [[1, 2], [3.5, 4]],
    "group": {"inner": {"numbers": [1, 2, 3], "flags": [True]}, "text": "a"},
    "groups": [{"a": 1}, {"b": [2.5]}],
    "texts": ["a", "b"],
    "text": "a text",
    "bytes": b"\xff\x00a",
    "whole": 3,
    "number": 0.25,
    "flag": True,
}


def plain(value):
    """A custom property as plain values with the types of its arrays."""
    if hasattr(value, "to_dict"):
        return {key: plain(part) for key, part in value.items()}
    if hasattr(value, "typecode"):
        return value.typecode, value.to_list()
    return [plain(part) for part in value] if isinstance(value, list) else value


@pytest.mark.parametrize("change", [lambda block, key: store(block, key, 1), drop])
def test_custom_properties_of_every_kind_come_back(change):
    """Blender frees an array or a group when another value takes its place: a record that refers to it is garbage."""
    block = sphere().data
    for key, value in PROPERTIES.items():
        block[key] = value
    block["object"] = bpy.data.objects.new("Other", None)
    block.id_properties_ui("whole").update(min=1, max=9, description="of the user")
    before = {key: plain(block[key]) for key in block.keys()}
    shown = block.id_properties_ui("whole").as_dict()
    with pytest.raises(MemoryError), whole_or_nothing():
        for key in [*before, "new"]:
            change(block, key)
        for number in range(200):  # what was freed is used for others
            block[f"other {number}"] = list(range(number))
        for number in range(200):
            del block[f"other {number}"]
        raise MemoryError
    assert {key: plain(block[key]) for key in block.keys()} == before
    assert block.id_properties_ui("whole").as_dict() == shown


@pytest.mark.parametrize("domain", ["POINT", "EDGE", "FACE", "CORNER"])
@pytest.mark.parametrize("data_type", LAYOUTS)
def test_attributes_of_every_kind_with_our_names_come_back(data_type, domain):
    obj = grid(3)
    if not add_attribute(obj.data, ATTRIBUTES[0].name, data_type, domain):
        pytest.skip("this Blender has no such attributes")
    for seed, ours in enumerate(ATTRIBUTES[1:], 1):
        add_attribute(obj.data, ours.name, data_type, domain, seed)
    before, values = snapshot(), {ours.name: attribute(obj, ours.name) for ours in ATTRIBUTES}
    with pytest.raises(MemoryError), whole_or_nothing():
        for ours in ATTRIBUTES:
            width = attributes.TYPES[ours.data_type][1]
            count = obj.data.attributes.domain_size(ours.domain)
            zeros = np.zeros((count, width) if width > 1 else count, attributes.TYPES[ours.data_type][0])
            attributes.write(obj, ours, zeros)
            attributes.remove_attribute(obj, ours.name)
            attributes.write(obj, ours, zeros)
            assert attributes.read(obj, ours).shape == zeros.shape
        raise MemoryError
    assert snapshot() == before
    for name, kept in values.items():
        np.testing.assert_array_equal(attribute(obj, name), kept)
    assert not [a.name for a in obj.data.attributes if a.name.startswith(".synch")]


def test_what_leaves_is_gone_when_the_work_has_succeeded_and_maps_stay_active():
    obj = grid(3)
    obj.data.uv_layers.new(name="synch_phase")
    obj.data.uv_layers.new(name="Second")
    obj.data.uv_layers.active = obj.data.uv_layers["synch_phase"]
    colours = obj.data.color_attributes.new("synch_index", "BYTE_COLOR", "CORNER")
    obj.data.attributes.active_color_name = colours.name
    phases = np.zeros(len(obj.data.loops), np.float32)
    for fails in (True, False):
        with pytest.raises(MemoryError) if fails else nullcontext(), whole_or_nothing():
            attributes.write_attribute(obj, "synch_phase", "CORNER", "FLOAT", phases)
            attributes.remove_attribute(obj, "synch_index")
            if fails:
                raise MemoryError
        if fails:
            assert obj.data.uv_layers.active.name == "synch_phase"
            assert obj.data.attributes.active_color_name == "synch_index"
    assert obj.data.attributes["synch_phase"].data_type == "FLOAT" and "synch_index" not in obj.data.attributes
    assert not [a.name for a in obj.data.attributes if a.name.startswith(".synch")]
