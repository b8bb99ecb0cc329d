# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake changes nothing but what it is asked for, and nothing at all when it is refused, fails or is interrupted."""

import importlib
from contextlib import suppress

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import Cancelled, SettingError, SynchError
from synch_fields.synch_addon import api
from synch_fields.synch_addon.bakes import job as bake_job
from synch_fields.synch_addon.bakes.scene_copy import SceneCopy
from synch_fields.synch_addon.blender import attributes
from synch_fields.synch_addon.nodes.materials import pattern_material

from ..baked_images import patterned
from ..scenes import add_group, attribute, datablocks, hexagon_sphere, make_active, snapshot, sphere

addon_utils = importlib.import_module("addon_utils")  # on the path once bpy is loaded, as isort cannot know
pytestmark = pytest.mark.slow  # hundreds of bakes by Cycles


def furnished():
    """Stripes on an object with much that a bake could disturb."""
    obj = hexagon_sphere(2)
    obj.data.materials.append(bpy.data.materials.new("Red"))
    obj.data.materials.append(None)
    attributes.write_attribute(obj, "material_index", "FACE", "INT", np.arange(len(obj.data.polygons)) % 2)
    for name in ("First", "Second"):
        obj.data.uv_layers.new(name=name)
    obj.data.uv_layers.active = obj.data.uv_layers["Second"]
    obj.data.uv_layers["First"].active_render = True
    add_group(obj, "some", range(10))
    obj["mine"] = 3.0
    obj.modifiers.new("thick", "SOLIDIFY").thickness = 0.01
    twin = bpy.data.objects.new("Twin", obj.data)
    bpy.context.scene.collection.objects.link(twin)
    make_active(obj)
    api.stripes(obj, spacing=0.6)
    pattern_material(obj, "stripes", assign_faces=True)
    tree = obj.material_slots[-1].material.node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = bpy.data.images.new("Mine", 8, 8)
    tree.nodes.active = texture
    scene = bpy.context.scene
    scene.render.engine = "BLENDER_WORKBENCH"
    scene.render.bake.margin, scene.cycles.samples, scene.frame_current = 3, 77, 5
    scene.render.image_settings.file_format = "JPEG"
    twin.select_set(True)
    bpy.context.view_layer.update()
    return obj


def everything():
    """Names and users of all datablocks, and all properties of those that a bake could touch."""
    touched = ("scenes", "objects", "materials", "node_groups", "images", "collections")
    properties = {(name, block.name): plain(block) for name in touched for block in getattr(bpy.data, name)}
    maps = {m.name: [(u.name, u.active, u.active_render) for u in m.uv_layers] for m in bpy.data.meshes}
    others = {"present": datablocks(), "properties": properties, "maps": maps, "shown": bpy.context.window.scene.name}
    return snapshot() | others


# What is computed or refers back.
LEFT_OUT = {"rna_type", "id_data", "original", "session_uid", "depsgraph", "is_updated", "is_updated_data", "pixels"}
LEFT_OUT |= {"preview", "use_nodes"}


def plain(value, depth=0):
    if isinstance(value, bpy.types.ID) and depth and not isinstance(value, bpy.types.NodeTree):
        return type(value).__name__, value.name
    if isinstance(value, bpy.types.bpy_struct):
        if depth > 5:
            return str(value)
        names = [p.identifier for p in value.bl_rna.properties if p.identifier not in LEFT_OUT]
        found = {}
        for name in names:
            with suppress(AttributeError, RuntimeError):
                found[name] = plain(getattr(value, name), depth + 1)
        return found
    if isinstance(value, bpy.types.bpy_prop_collection):
        return [plain(item, depth + 1) for item in value]
    if hasattr(value, "__len__") and not isinstance(value, str | set | bytes):
        return [plain(item, depth + 1) for item in value]
    return value if isinstance(value, int | float | str | bool | set | bytes | None) else str(value)


SETTINGS = dict(maps="mask,colour,normal,phase,index", size=24, samples=1)


@pytest.mark.parametrize("hidden", [False, True])
@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_a_bake_to_files_changes_nothing_in_the_blend(mode, hidden, tmp_path):
    obj = furnished()
    if hidden:
        obj.hide_render = obj.hide_viewport = True
        obj.hide_set(True)
        bpy.context.view_layer.objects.active = obj
    elif mode == "EDIT":
        bpy.ops.object.mode_set(mode="EDIT")
    before = everything()
    assert len(str(before)) > 10**5
    api.bake(obj, folder=str(tmp_path), uv_map="First", **SETTINGS)
    assert everything() == before
    assert len(list(tmp_path.iterdir())) == 5


def test_the_new_map_is_all_that_a_bake_with_one_adds(tmp_path):
    obj = furnished()
    before = everything()
    api.bake(obj, folder=str(tmp_path), unwrap=True, **SETTINGS)
    layers = obj.data.uv_layers
    assert layers.keys() == ["First", "Second", "Synch Bake"]
    assert layers.active.name == "Second" and layers["First"].active_render
    uv = attribute(obj, "Synch Bake")
    assert uv.min() >= 0 and uv.max() <= 1 and np.ptp(uv, axis=0).min() > 0.3
    layers.remove(layers["Synch Bake"])
    bpy.context.view_layer.update()
    assert everything() == before


@pytest.mark.parametrize("calls", range(1, 8))
@pytest.mark.parametrize("error", [None, KeyboardInterrupt])
def test_interrupted_bake_changes_nothing(calls, error, tmp_path):
    obj = furnished()
    (tmp_path / "kept.txt").touch()
    before, asked = everything(), []

    def callback(stage, fraction):
        asked.append((stage, fraction))
        if len(asked) == calls and error:
            raise error
        return len(asked) < calls

    with pytest.raises(error or Cancelled):
        api.bake(obj, callback, folder=str(tmp_path), unwrap=True, material=True, **SETTINGS)
    assert len(asked) == calls and all(0 <= fraction <= 1 for _, fraction in asked)
    assert everything() == before
    assert [p.name for p in tmp_path.iterdir()] == ["kept.txt"]


@pytest.mark.parametrize("failing", ["unwrapped", "bake", "save"])
def test_failing_bake_changes_nothing(failing, tmp_path, monkeypatch):
    obj = furnished()
    before = everything()
    calls = []

    def fail(*arguments, **named):
        calls.append(arguments)
        raise MemoryError

    if failing == "save":
        monkeypatch.setattr("synch_fields.synch_addon.bakes.images.save", fail)
    else:
        monkeypatch.setattr(SceneCopy, failing, fail)
    with pytest.raises(MemoryError):
        api.bake(obj, folder=str(tmp_path), unwrap=True, material=True, **SETTINGS)
    assert calls and everything() == before and not list(tmp_path.iterdir())


ERRORS = {
    "unknown map": (dict(maps="colour,smell"), "'smell' is unknown: use one or more of mask, colour"),
    "no map": (dict(maps=()), "no map is asked for"),
    "tiny": (dict(size=8), "the size is 8: give a whole number from 16 to 16384"),
    "huge": (dict(size=20000), "the size is 20000"),
    "half a pixel": (dict(size=64.5), "the size is 64.5"),
    "margin": (dict(margin=-1), "the margin is -1"),
    "samples": (dict(samples=0), "the samples is 0"),
    "format": (dict(file_format="JPEG"), "'JPEG' is unknown: use one of PNG, EXR"),
    "no such UV map": (dict(uv_map="Third"), "has no UV map 'Third': choose one of its maps (First, Second)"),
    "no such folder": (dict(folder="/nowhere"), "/nowhere: this folder does not exist, create it first"),
    "beside nothing": (dict(folder="//textures"), "lies beside the .blend: save that first"),
    "empty map": (dict(uv_map="First"), "is empty"),
    "one name": (dict(naming="{object}"), "is the same for 2 maps: add {map}"),
    "unknown field": (dict(naming="{mesh}_{map}"), "cannot be filled in"),
    "broken field": (dict(naming="{map"), "cannot be filled in"),
    "field in a format": (dict(naming="{map:{width}}"), "cannot be filled in"),
    "numbered field in a format": (dict(naming="{map:{}}"), "cannot be filled in"),
    "width beyond memory": (dict(naming="{map:>99999999999999}"), "cannot be filled in"),
    "path": (dict(naming="../{map}"), "cannot be filled in"),
    "material of nothing": (dict(maps="mask", material=True), "add one of them to the maps"),
    "displacement of nothing": (dict(material=True, displacement=True), "ask for both"),
    "unknown setting": (dict(resolution=4), "the setting 'resolution' is unknown: use one of maps, size"),
}


@pytest.mark.parametrize("name", ERRORS)
def test_refused_bake_is_one_line_and_does_nothing(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    obj = furnished()
    if name == "empty map":
        obj.data.uv_layers["First"].uv.foreach_set("vector", np.zeros(2 * len(obj.data.loops), np.float32))
    monkeypatch.setattr(bake_job, "make_scene_copy", lambda *_, **__: pytest.fail("work has begun"))
    settings, reason = ERRORS[name]
    before = everything()
    with pytest.raises(SettingError) as refusal:
        api.bake(obj, **dict(maps="mask,colour", size=16) | settings)
    assert reason in str(refusal.value) and "\n" not in str(refusal.value)
    assert everything() == before and not list(tmp_path.iterdir())


def test_objects_without_pattern_or_map_are_refused():
    with pytest.raises(SynchError, match="no active object"):
        api.bake(None)
    obj = sphere(2)
    with pytest.raises(SynchError, match="has no pattern: solve stripes or quads on it first"):
        api.bake(obj)
    api.directions(obj)
    with pytest.raises(SynchError, match="has no pattern"):
        api.bake(obj)
    obj = patterned()
    with pytest.raises(SettingError, match=r"has no UV map: .* \(none yet\), or ask for Smart UV Project"):
        api.bake(obj)


def test_without_cycles_a_bake_is_refused():
    obj = patterned()
    addon_utils.disable("cycles")
    try:
        with pytest.raises(SettingError, match="Cycles is switched off"):
            api.bake(obj, unwrap=True)
    finally:
        addon_utils.enable("cycles")
    assert not obj.data.uv_layers


def test_maps_that_show_faces_twice_or_not_at_all_are_warned_of(tmp_path):
    obj = patterned()
    layer = obj.data.uv_layers.new(name="Same")
    layer.uv.foreach_set("vector", np.tile(np.float32([[0, 0], [1, 0], [0, 1]]), (len(obj.data.polygons), 1)).ravel())
    settings = dict(maps="mask", size=16, samples=1, folder=str(tmp_path))
    (warning,) = api.bake(obj, **settings)["warnings"]
    assert "overlap" in warning
    obj.data.uv_layers["Same"].uv.foreach_set("vector", np.float32(attribute(obj, "Same") * 0.1 + 5).ravel())
    (warning,) = api.bake(obj, **settings)["warnings"]
    assert warning.startswith("100.0% of the corners lie outside")
