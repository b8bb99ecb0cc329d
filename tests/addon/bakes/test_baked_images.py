# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked images as files and in the .blend, the material that shows them, the operator and its panel."""

import importlib
import json
import struct
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from synch_fields.synch_addon import api
from synch_fields.synch_addon.jobs.job import run
from synch_fields.synch_addon.operators.bake import SYNCH_OT_bake

from ..baked_images import SIZE, bake, inside_of, patterned, phases_at, picture
from ..scenes import snapshot, sphere

addon_utils = importlib.import_module("addon_utils")  # on the path once bpy is loaded, as isort cannot know
FORMATS = {"mask": (8, 0), "colour": (8, 2), "height": (16, 0), "normal": (8, 2), "phase": (16, 2), "index": (16, 0)}


def header(path):
    """Width, height, bits of a channel, and colour type (0 grey, 2 RGB) of a PNG file."""
    start = path.read_bytes()[:26]
    assert start[:8] == b"\x89PNG\r\n\x1a\n"
    return struct.unpack(">IIBB", start[16:26])


def test_files_have_their_depth_and_the_report_their_sizes(tmp_path):
    obj = patterned()
    obj.name = "Ball: 1/2"
    report = api.bake(obj, maps=list(FORMATS), size=32, samples=1, unwrap=True, folder=str(tmp_path))
    assert set(report["maps"]) == set(FORMATS)
    assert {p.name for p in tmp_path.iterdir()} == {f"Ball__1_2_{name}.png" for name in FORMATS}
    for name, (bits, colour_type) in FORMATS.items():
        entry = report["maps"][name]
        path = tmp_path / f"Ball__1_2_{name}.png"
        assert entry["file"] == str(path) and entry["bytes"] == path.stat().st_size and entry["bits"] == bits
        assert header(path) == (32, 32, bits, colour_type) and entry["seconds"] > 0
    assert not bpy.data.images


@pytest.mark.parametrize("file_format, suffix", [("PNG", ".png"), ("EXR", ".exr")])
def test_packed_images_replace_older_ones_and_stay_in_the_file(file_format, suffix, tmp_path):
    """Though nothing uses them."""
    obj = patterned()
    for size in (16, 32):
        report = api.bake(obj, maps=list(FORMATS), size=size, samples=1, unwrap=True, file_format=file_format)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "packed.blend"))
    bpy.ops.wm.read_homefile(use_empty=True)
    assert not bpy.data.images
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "packed.blend"))
    assert sorted(bpy.data.images.keys()) == sorted(f"{report['object']}_{name}{suffix}" for name in FORMATS)
    for name, entry in report["maps"].items():
        image = bpy.data.images[entry["image"]]
        assert image.packed_file is not None and tuple(image.size) == (32, 32)
        assert image.packed_file.size == entry["bytes"]
        space = ("sRGB" if file_format == "PNG" else "Linear Rec.709") if name == "colour" else "Non-Color"
        assert image.colorspace_settings.name == space
        assert np.ptp(picture(image, 32)) > 0


def glb(path):
    """The JSON part of a .glb file, and the bytes of its images."""
    data = path.read_bytes()
    length = struct.unpack("<I", data[12:16])[0]
    content = json.loads(data[20 : 20 + length])
    binary = data[20 + length + 8 :]
    views = [content["bufferViews"][image["bufferView"]] for image in content.get("images", [])]
    return content, [binary[v.get("byteOffset", 0) :][: v["byteLength"]] for v in views]


@pytest.mark.parametrize("packed", [True, False], ids=["packed", "files"])
def test_material_of_images_goes_into_a_glb(packed, tmp_path):
    obj = patterned()
    pattern = obj.data.materials[0]
    report = api.bake(
        obj, size=64, samples=1, unwrap=True, material=True, folder="" if packed else str(tmp_path), naming="ball_{map}"
    )
    assert report["materials"] == [obj.data.materials[0].name] and obj.data.materials[0] != pattern
    addon_utils.enable("io_scene_gltf2")
    bpy.ops.export_scene.gltf(filepath=str(tmp_path / "out.glb"))
    content, images = glb(tmp_path / "out.glb")
    (material,) = content["materials"]
    colour = material["pbrMetallicRoughness"]["baseColorTexture"]["index"]
    normal = material["normalTexture"]["index"]
    assert material["pbrMetallicRoughness"]["roughnessFactor"] == pytest.approx(0.42)
    assert len(images) == 2 and all(data.startswith(b"\x89PNG") for data in images)
    names = [content["images"][content["textures"][k]["source"]]["name"] for k in (colour, normal)]
    assert [name.removesuffix(".png") for name in names] == ["ball_colour", "ball_normal"]
    if not packed:
        assert (tmp_path / "ball_colour.png").read_bytes() in images
    assert "TEXCOORD_0" in content["meshes"][0]["primitives"][0]["attributes"]


def test_height_bumps_where_there_are_no_normals_and_displaces_on_request():
    obj = patterned()
    node = next(n for n in obj.data.materials[0].node_tree.nodes if n.type == "GROUP")
    node.inputs["Width"].default_value = 0.3
    pattern = obj.data.materials[0]
    api.bake(obj, maps="height", size=16, samples=1, unwrap=True, material=True)
    baked = obj.data.materials[0]
    kinds = {n.type: n for n in baked.node_tree.nodes}
    assert kinds["BUMP"].inputs["Distance"].default_value == pytest.approx(0.05 * obj["synch_spacing"])
    assert "DISPLACEMENT" not in kinds and baked["synch_source"] == pattern
    next(n for n in baked.node_tree.nodes if n.type == "BSDF_PRINCIPLED").inputs["Roughness"].default_value = 0.9
    api.bake(obj, maps="height", size=16, samples=1, material=True, displacement=True, uv_map="Synch Bake")
    assert obj.data.materials[0] == baked and len(bpy.data.materials) == 2
    kinds = {n.type: n for n in baked.node_tree.nodes}
    assert "BUMP" not in kinds and baked.displacement_method == "BOTH"
    assert kinds["DISPLACEMENT"].inputs["Scale"].default_value == pytest.approx(0.05 * obj["synch_spacing"])
    assert kinds["BSDF_PRINCIPLED"].inputs["Roughness"].default_value == pytest.approx(0.9)


@pytest.mark.any_surface
@pytest.mark.parametrize("surface", ["faces", "seen"])
def test_the_material_of_images_is_named_for_the_object(surface):
    obj = sphere()
    api.stripes(obj, spacing=0.8, surface=surface)
    report = api.bake(obj, maps="colour", size=16, samples=1, unwrap=True, material=True)
    assert report["materials"] == [f"{obj.name} Baked"]


def test_a_second_bake_shows_the_pattern_again_not_its_images(tmp_path):
    obj = patterned()
    bake(obj, tmp_path, maps="colour", material=True, size=16)
    shown = obj.data.materials[0].node_tree.nodes
    image = next(n.image for n in shown if n.type == "TEX_IMAGE")
    assert tuple(image.size) == (16, 16)
    bake(obj, tmp_path, maps="colour", material=True)
    assert tuple(image.size) == (SIZE, SIZE) and len(bpy.data.images) == 1
    pixels, phases = phases_at(obj)
    inside, _ = inside_of(phases)
    dark = picture(tmp_path / "colour.png")[pixels[:, 0], pixels[:, 1], 0] < 0.5
    assert ((inside > 0) == dark)[np.abs(inside) > 0.02].mean() > 0.998


def test_operator_bakes_packs_and_undoes():
    obj = patterned()
    bpy.ops.ed.undo_push(message="before")
    before = snapshot()
    settings = dict(maps={"COLOUR", "HEIGHT"}, size=16, samples=1, unwrap=True, material=True)
    assert bpy.ops.synch.bake(**settings) == {"FINISHED"}
    bpy.ops.ed.undo_push(message="bake")
    assert set(bpy.data.images.keys()) == {f"{obj.name}_colour.png", f"{obj.name}_height.png"}
    bpy.ops.ed.undo()
    assert snapshot() == before and not bpy.data.images
    with pytest.raises(RuntimeError, match="has no UV map"):
        bpy.ops.synch.bake(size=16)
    bpy.ops.mesh.primitive_cube_add()
    with pytest.raises(RuntimeError, match="poll"):
        bpy.ops.synch.bake(size=16)


def test_panel_shows_for_objects_with_a_pattern_and_keeps_the_settings_with_the_scene():
    panel = bpy.types.SYNCH_PT_bake
    obj = patterned()
    assert panel.poll(bpy.context) and "DEFAULT_CLOSED" in panel.bl_options
    stored = bpy.context.scene.synch_bake
    stored.size, stored.maps, stored.unwrap = 16, {"MASK"}, True
    # Without a window nothing is invoked.
    operator = SimpleNamespace(_elsewhere=False)
    SYNCH_OT_bake._take(operator, bpy.context)
    run(SYNCH_OT_bake._job(operator, bpy.context))
    (image,) = bpy.data.images
    assert tuple(image.size) == (16, 16) and image.name == f"{obj.name}_mask.png"
    sphere(2)
    assert not panel.poll(bpy.context)
