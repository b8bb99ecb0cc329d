# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that earlier versions saved open here: one of each version, with every kind of result (saved/make.py)."""

import importlib.util
import json
import re
from pathlib import Path

import bpy
import pytest

from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import schema
from synch_fields.synch_addon.nodes.stripes import stripes_group
from synch_fields.synch_addon.patterns import favourites, memory

from .scenes import make_active, sphere

FOLDER = Path(__file__).with_name("saved")
SAVED = sorted(FOLDER.glob("*.blend"))


def maker():
    spec = importlib.util.spec_from_file_location("make", FOLDER / "make.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(params=SAVED, ids=[path.stem for path in SAVED])
def facts(request):
    """An old file is open; what it was to hold."""
    bpy.ops.wm.open_mainfile(filepath=str(request.param))
    return json.loads(request.param.with_suffix(".json").read_text(encoding="utf-8"))


def shown(name):
    obj = bpy.data.objects[name]
    make_active(obj)
    return obj


def without_numbers():
    """The file as it was before formats had numbers."""
    for mesh in bpy.data.meshes:
        mesh.pop(schema.STAMP, None)
    for obj in bpy.data.objects:
        kept = json.loads(obj.synch.result) if obj.synch.result else {}
        if kept:
            kept.pop("format", None)
            obj.synch.result = json.dumps(kept)


def test_a_file_of_every_version_is_kept():
    assert SAVED[0].stem == "0.1.0" and all(path.with_suffix(".json").exists() for path in SAVED)


def test_every_attribute_is_there_as_it_was_and_known(facts):
    found = maker().attributes()
    assert found.keys() == facts["attributes"].keys()
    for name, expected in facts["attributes"].items():
        assert found[name].keys() == expected.keys(), name
        for attribute, (*layout, square) in expected.items():
            assert found[name][attribute][:2] == layout and tuple(layout) == schema.layout_of(attribute), attribute
            assert found[name][attribute][2] == pytest.approx(square, rel=1e-5, abs=1e-9), (name, attribute)
    written = {re.sub(r"\.\d+$", "", attribute) for own in found.values() for attribute in own}
    rare = {a.name for a in schema.ATTRIBUTES} - written
    # Those of patterns with a surface of their own and of quad meshes with a map, which the file has none of.
    bound = {"synch_parent_1", "synch_parent_2", "synch_parent_3", "synch_weights", "synch_source_face"}
    bound |= {"synch_spacing_map"}
    assert rare <= {"synch_index_2", "synch_index_x_2", "synch_index_y_2", *bound}, rare


def test_settings_are_as_they_were(facts):
    settings = bpy.data.objects["Stripes"].synch
    assert (settings.symmetry, settings.guidance, settings.automatic_spacing) == ("VECTOR", "BLEND", False)
    assert (settings.spacing, settings.angle) == (pytest.approx(0.3), pytest.approx(0.25))
    assert [(row.where, row.what, row.vertex_group) for row in settings.constraints] == [("GROUP", "ALONG", "Belt")]
    for name, expected in facts["objects"].items():
        if "command" in expected:
            kept = json.loads(bpy.data.objects[name].synch.result)
            assert {key: kept[key] for key in expected.keys() & kept.keys()} == {
                key: expected[key] for key in expected.keys() & kept.keys()
            }


@pytest.mark.parametrize("has_numbers", [True, False])
@pytest.mark.parametrize("name", ["Stripes", "Calm", "Quads"])
def test_lines_are_drawn_of_what_was_saved(facts, name, has_numbers):
    if not has_numbers:
        without_numbers()
    assert api.isolines(shown(name))["lines"] == facts["objects"][name]["lines"]


@pytest.mark.parametrize("name", ["Stripes", "Quads"])
def test_favourites_are_shown(facts, name):
    obj, phase = shown(name), "synch_phase" if name == "Stripes" else "synch_phase_x"
    before = maker().attributes()[name][phase]
    (api.quads if name == "Stripes" else api.stripes)(obj, spacing=0.5, constraints=[])
    favourites.show(obj, "Best")
    assert maker().attributes()[name][phase][2] == pytest.approx(before[2], rel=1e-4)


def test_animations_show_each_frame(facts):
    for name, phase in (("Moving stripes", "synch_phase"), ("Moving quads", "synch_phase_x")):
        seen = []
        for frame in (1, 2):
            bpy.context.scene.frame_set(frame)
            evaluated = bpy.data.objects[name].evaluated_get(bpy.context.evaluated_depsgraph_get())
            seen.append([value.value for value in evaluated.data.attributes[phase].data])
        own = [[v.value for v in bpy.data.objects[name].data.attributes[f"{phase}.{k}"].data] for k in (1, 2)]
        assert seen == own and seen[0] != seen[1]


def test_results_of_other_kinds_are_there(facts):
    objects = facts["objects"]
    assert len(bpy.data.objects["Mesh Quads"].data.polygons) == objects["Mesh"]["faces"]
    layers = bpy.data.objects["Block Layers"].data.attributes["synch_layer"]
    assert len({value.value for value in layers.data}) == objects["Block"]["layers"]
    assert len(bpy.data.objects[objects["Ring"]["object"]].data.splines) == objects["Ring"]["filaments"]
    assert len([child for child in bpy.data.objects["Flow"].children if "synch_strength" in child]) == 16


def test_all_is_solved_again_and_groups_of_then_are_used_or_built_anew(facts):
    count = len(bpy.data.node_groups)
    obj = shown("Stripes")
    assert api.stripes(obj, spacing=0.3, guidance="axis:Z")["certificate"]
    assert stripes_group().name == "Synch Stripes" and len(bpy.data.node_groups) == count


@pytest.mark.parametrize("place", ["mesh", "result"])
def test_what_a_newer_version_has_written_is_refused_in_one_line(place):
    obj = sphere(4)
    api.stripes(obj, spacing=0.4)
    memory.forget(obj)
    assert obj.data[schema.STAMP] == json.loads(obj.synch.result)["format"] == schema.FORMAT
    if place == "mesh":
        obj.data[schema.STAMP] = schema.FORMAT + 1
    else:
        obj.synch.result = json.dumps(json.loads(obj.synch.result) | {"format": schema.FORMAT + 1})
    with pytest.raises(Exception, match=r"of a newer Synch Fields \(format 2, this one reads up to 1\): update"):
        api.isolines(obj)
    api.stripes(obj, spacing=0.4)
    memory.forget(obj)
    assert api.isolines(obj)["lines"] > 1


def test_the_number_is_taken_back_where_the_write_fails(monkeypatch):
    obj = sphere(3)

    def fail(*_):
        raise ValueError("on purpose")

    monkeypatch.setattr("synch_fields.synch_addon.patterns.write.meshes.update", fail)
    with pytest.raises(ValueError, match="on purpose"):
        api.stripes(obj, spacing=0.4)
    assert schema.STAMP not in obj.data
