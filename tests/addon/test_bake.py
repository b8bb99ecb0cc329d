# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked images against the formulas at every texel, how they are kept, and that nothing else changes."""

import importlib
import json
import struct
from contextlib import suppress
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from scipy.ndimage import binary_dilation

from synch_fields.core.errors import Cancelled, SettingError, SynchError
from synch_fields.core.interpolate import evaluate
from synch_fields.synch_addon import api, bake_stage, memory, scene_io
from synch_fields.synch_addon.bake_settings import plain as plain_settings
from synch_fields.synch_addon.materials import pattern_material
from synch_fields.synch_addon.operators.bake import SYNCH_OT_bake

from .scenes import add_group, attribute, grid, hexagon_sphere, make_active, quad_sphere, snapshot, sphere

addon_utils = importlib.import_module("addon_utils")  # on the path once bpy is loaded, as isort cannot know

SIZE = 192
WIDTH, SOFTNESS = 0.5, 0.02
PATTERNS = {"stripes": (lambda: sphere(3), 0.5), "quads": (lambda: quad_sphere(7), 0.7)}


pytestmark = pytest.mark.slow  # hundreds of bakes by Cycles


def patterned(kind="stripes", build=None, **settings):
    """An object with a pattern that has defects of both kinds, and no UV map yet."""
    standard, spacing = PATTERNS[kind]
    obj = (build or standard)()
    for layer in list(obj.data.uv_layers):
        obj.data.uv_layers.remove(layer)
    getattr(api, kind)(obj, **{"spacing": spacing} | settings)
    if kind == "quads":
        api.vary(obj, 20)  # the solution has no dislocation
    return obj


def bake(obj, folder, **settings):
    """Bake into files that are called as their maps."""
    standard = dict(size=SIZE, margin=2, samples=1, unwrap=True, folder=str(folder), naming="{map}")
    return api.bake(obj, **standard | settings)


def rasterised(obj, size=SIZE, layer="Synch Bake"):
    """Pixels (row, column) whose middle lies in a face, the triangles there, and (k, 3) weights of their corners."""
    polygons = scene_io.read_polygons(obj)
    uv = attribute(obj, layer).astype(float)[polygons.triangle_corners] * size
    pixels, triangles, weights = [], [], []
    for triangle, corners in enumerate(uv):
        low, high = np.floor(corners.min(axis=0)), np.ceil(corners.max(axis=0))
        x, y = np.meshgrid(*(np.arange(a, b) for a, b in zip(low, high, strict=True)))
        matrix = np.vstack([corners.T, np.ones(3)])
        inside = np.linalg.solve(matrix, np.vstack([x.ravel() + 0.5, y.ravel() + 0.5, np.ones(x.size)])).T
        kept = inside.min(axis=1) > 1e-3
        pixels.append(np.column_stack([y.ravel(), x.ravel()])[kept].astype(int))
        triangles.append(np.full(kept.sum(), triangle))
        weights.append(inside[kept])
    return np.concatenate(pixels), np.concatenate(triangles), np.concatenate(weights)


def phases_at(obj, size=SIZE, layer="Synch Bake"):
    """Pixels, and the (k, p) phases of the solved pattern there: what the core says, without any attribute."""
    pixels, triangles, weights = rasterised(obj, size, layer)
    polygons = scene_io.read_polygons(obj)
    solved = memory.recall(obj)
    assert {d["kind"] for d in solved.plain["disclinations"] + solved.plain["dislocations"]} == {
        "disclination",
        "dislocation",
    }
    phases = [evaluate(phase, polygons, triangles, weights) for phase in solved.pattern.on_faces(polygons)]
    return pixels, np.column_stack(phases)


def inside_of(phases):
    """Distance to the edge of a stripe or grid line, in periods or cells, and the largest one."""
    if phases.shape[1] == 1:
        away = np.abs((phases[:, 0] + np.pi) % (2 * np.pi) - np.pi)
        return (WIDTH - away / np.pi) / 2, WIDTH / 2
    line = 1 - np.sqrt(1 - WIDTH)
    away = np.abs((phases + np.pi / 2) % np.pi - np.pi / 2).min(axis=1) / np.pi
    return line / 2 - away, line / 2


def picture(path, size=SIZE, space="Non-Color"):
    """(size, size, 4) values of an image file or image as they are stored, the lowest row first."""
    image = path if isinstance(path, bpy.types.Image) else bpy.data.images.load(str(path))
    values = np.empty(size * size * 4, np.float32)
    kept, image.colorspace_settings.name = image.colorspace_settings.name, space
    image.pixels.foreach_get(values)
    image.colorspace_settings.name = kept
    return values.reshape(size, size, 4)


def header(path):
    """Width, height, bits of a channel, and colour type (0 grey, 2 RGB) of a PNG file."""
    start = path.read_bytes()[:26]
    assert start[:8] == b"\x89PNG\r\n\x1a\n"
    return struct.unpack(">IIBB", start[16:26])


@pytest.mark.parametrize("samples", [1, 16])
@pytest.mark.parametrize("kind", PATTERNS)
def test_mask_and_height_follow_the_formula_at_every_texel(kind, samples, tmp_path):
    obj = patterned(kind)
    bake(obj, tmp_path, maps="mask,height", samples=samples)
    pixels, phases = phases_at(obj)
    inside, deepest = inside_of(phases)
    mask, height = (picture(tmp_path / f"{name}.png")[pixels[:, 0], pixels[:, 1], 0] for name in ("mask", "height"))
    # Further from an edge than it is soft, and than a texel reaches.
    clear = np.abs(inside) > 0.5 * SOFTNESS + (0.06 if samples > 1 else 0.001)
    off = np.abs(mask - (inside > 0))[clear]
    assert clear.mean() > 0.5 and len(off) > 5000
    assert off.mean() < 0.5 / 255
    assert (off > 1 / 255).mean() < 5e-3  # at the centres of defects, where the phase turns within a texel
    profile = np.where(inside > 0, 0.5 - 0.5 * np.cos(np.pi * np.clip(inside / deepest, 0, 1)), 0.0)
    if samples == 1:
        ramp = np.clip(inside / SOFTNESS + 0.5, 0, 1)
        assert np.abs(mask - ramp * ramp * (3 - 2 * ramp)).mean() < 1 / 255
        assert np.abs(height - profile).mean() < 1e-3
    else:
        assert np.abs(height - profile).mean() < 0.03


@pytest.mark.parametrize("symmetry", ["line", "vector"])
def test_phase_is_kept_as_cosine_and_sine(symmetry, tmp_path):
    obj = patterned(symmetry=symmetry) if symmetry == "line" else patterned(symmetry=symmetry, spacing=0.4)
    report = bake(obj, tmp_path, maps="phase", file_format="EXR")
    pixels, triangles, weights = rasterised(obj)
    polygons = scene_io.read_polygons(obj)
    (phase,) = memory.recall(obj).pattern.on_faces(polygons)
    theta = evaluate(phase, polygons, triangles, weights)
    found = 2 * picture(tmp_path / "phase.exr")[pixels[:, 0], pixels[:, 1], :2] - 1
    signed = symmetry == "vector"
    assert report["phase"] == f"cos(theta) and {'sin(theta)' if signed else '|sin(theta)|'}"
    sine = np.sin(theta) if signed else np.abs(np.sin(theta))
    off = np.abs(found - np.column_stack([np.cos(theta), sine])).max(axis=1)
    assert np.quantile(off, 0.998) < 4e-3  # Blender samples a texel some thousandths beside its middle
    if signed:
        assert (found[:, 1] < -0.5).any()


def test_phases_of_quads_are_kept_in_the_order_of_their_cosines(tmp_path):
    obj = patterned("quads")
    report = bake(obj, tmp_path, maps=["phase"])
    pixels, phases = phases_at(obj)
    found = 2 * picture(tmp_path / "phase.png")[pixels[:, 0], pixels[:, 1], :2] - 1
    off = np.abs(found - np.sort(np.cos(phases), axis=1)[:, ::-1]).max(axis=1)
    assert np.quantile(off, 0.998) < 4e-3
    assert report["phase"] == "greater and lesser of cos(x) and cos(y)"


@pytest.mark.parametrize("kind", PATTERNS)
def test_index_numbers_stripes_and_quads(kind, tmp_path):
    obj = patterned(kind)
    margin = 4
    report = bake(obj, tmp_path, maps="index", margin=margin, file_format="EXR")
    bake(obj, tmp_path, maps="index", margin=margin)
    numbers = picture(tmp_path / "index.exr")[:, :, 0]
    assert np.array_equal(numbers, np.rint(numbers))
    assert np.array_equal(np.rint(picture(tmp_path / "index.png")[:, :, 0] * 65535), numbers)
    assert 1 < report["count"] and numbers.max() == report["count"]
    pixels, phases = phases_at(obj)
    assert (numbers[pixels[:, 0], pixels[:, 1]] > 0).all()
    # Next to each other in the middle of a stripe, or of a quad: the same number.
    inside = np.full((SIZE, SIZE), np.nan)
    values = np.cos(phases[:, 0]) - 0.8 if kind == "stripes" else np.abs(np.sin(phases)).min(axis=1) - 0.5
    inside[pixels[:, 0], pixels[:, 1]] = values
    both = (inside[:, 1:] > 0) & (inside[:, :-1] > 0)
    assert both.sum() > 500
    assert (numbers[:, 1:] == numbers[:, :-1])[both].mean() > 0.995
    covered = np.zeros((SIZE, SIZE), bool)
    covered[pixels[:, 0], pixels[:, 1]] = True
    beside = binary_dilation(covered, np.ones((3, 3)), iterations=margin - 2)
    far = ~binary_dilation(covered, np.ones((3, 3)), iterations=margin + 1)
    assert numbers[beside].all()
    assert not numbers[far].any()


def test_colour_is_what_the_material_shows_and_encoded_for_the_screen(tmp_path):
    obj = patterned()
    red, blue = (0.8, 0.1, 0.05, 1.0), (0.0, 0.2, 0.5, 1.0)
    node = next(n for n in obj.data.materials[0].node_tree.nodes if n.type == "GROUP")
    node.inputs["Color"].default_value, node.inputs["Background"].default_value = red, blue
    for file_format in ("PNG", "EXR"):
        bake(obj, tmp_path, maps="colour", file_format=file_format)
    pixels, phases = phases_at(obj)
    inside, _ = inside_of(phases)
    clear = np.abs(inside) > 0.02
    linear = np.where(inside[clear, None] > 0, red, blue)[:, :3]
    encoded = np.where(linear <= 0.0031308, linear * 12.92, 1.055 * np.abs(linear) ** (1 / 2.4) - 0.055)
    for name, expected, bound in (("colour.png", encoded, 1 / 255), ("colour.exr", linear, 1e-3)):
        found = picture(tmp_path / name)[pixels[clear, 0], pixels[clear, 1], :3]
        assert np.quantile(np.abs(found - expected).max(axis=1), 0.998) < bound


def test_normals_lean_down_the_bump_along_the_baked_map(tmp_path):
    """One period along X of a flat square; the bump's slope is that of the height, turned as the UV map is."""
    obj = grid(24)
    api.stripes(obj, spacing=1.0, guidance="axis:Y")
    coordinates = (attribute(obj, "position")[:, :2] + 1) / 2
    corners = np.array([loop.vertex_index for loop in obj.data.loops])
    for layer in list(obj.data.uv_layers):
        obj.data.uv_layers.remove(layer)
    for name, uv in (
        ("straight", coordinates),
        ("turned", np.column_stack([coordinates[:, 1], 1 - coordinates[:, 0]])),
    ):
        obj.data.uv_layers.new(name=name).uv.foreach_set("vector", np.float32(uv[corners]).ravel())
    found = {}
    for name in ("straight", "turned"):
        bake(obj, tmp_path, maps="normal,height", samples=4, uv_map=name)
        found[name] = picture(tmp_path / "normal.png")[:, :, :3] * 2 - 1, picture(tmp_path / "height.png")[:, :, 0]
    normals, height = found["straight"]
    middle = slice(SIZE // 4, 3 * SIZE // 4)
    # The material bumps by 0.05 spacings, and Bump mixes with its strength.
    slope = np.gradient(height[middle, middle], 2 / SIZE, axis=1) * 0.05
    tilted = np.stack([-slope, np.zeros_like(slope), np.ones_like(slope)], axis=2)
    tilted /= np.linalg.norm(tilted, axis=2, keepdims=True)
    mixed = 0.6 * tilted + 0.4 * np.array([0, 0, 1])
    mixed /= np.linalg.norm(mixed, axis=2, keepdims=True)
    assert np.abs(slope).max() > 0.05
    assert np.abs(normals[middle, middle] - mixed).mean() < 0.01
    # The map "turned" shows X downwards, though it is not the active one.
    turned = found["turned"][0]
    assert np.abs(turned[middle, middle, 1] + np.rot90(normals[:, :, 0])[middle, middle]).mean() < 0.01
    assert np.abs(turned[middle, middle, 0]).max() < 0.02


def test_margin_goes_on_beyond_the_islands(tmp_path):
    obj = patterned()
    shown = {}
    for margin in (0, 6):
        bake(obj, tmp_path, maps="colour", margin=margin)
        shown[margin] = picture(tmp_path / "colour.png")[:, :, :3].max(axis=2) > 0
    assert not (shown[0] & ~shown[6]).any()
    grown = binary_dilation(shown[0], np.ones((3, 3)), iterations=7)
    assert shown[6].sum() > 1.1 * shown[0].sum()
    assert not (shown[6] & ~grown).any()


FORMATS = {
    "mask": (8, 0),
    "colour": (8, 2),
    "height": (16, 0),
    "normal": (8, 2),
    "phase": (16, 2),
    "index": (16, 0),
}


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


def test_mask_is_on_all_faces_and_colour_is_that_of_each_material(tmp_path):
    obj = patterned()
    red = bpy.data.materials.new("Red")
    red.use_nodes = True
    red.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (1, 0, 0, 1)
    obj.data.materials.append(red)
    half = np.arange(len(obj.data.polygons)) % 2
    scene_io.write_attribute(obj, "material_index", "FACE", "INT", half)
    bake(obj, tmp_path, maps="mask,colour")
    pixels, triangles, _ = rasterised(obj)
    _, phases = phases_at(obj)
    inside, _ = inside_of(phases)
    mask = picture(tmp_path / "mask.png")[pixels[:, 0], pixels[:, 1], 0]
    assert np.quantile(np.abs(mask - (inside > 0))[np.abs(inside) > 0.012], 0.998) < 1 / 255
    colour = picture(tmp_path / "colour.png")[pixels[:, 0], pixels[:, 1], :3]
    is_red = half[scene_io.read_polygons(obj).triangle_faces[triangles]] == 1
    assert np.allclose(colour[is_red], (1, 0, 0)) and not (colour[~is_red] == (1, 0, 0)).all(axis=1).any()
    # Nothing shows the pattern any more: the mask has its standard look.
    obj.data.materials.clear()
    bake(obj, tmp_path, maps="mask")
    again = picture(tmp_path / "mask.png")[pixels[:, 0], pixels[:, 1], 0]
    assert np.array_equal(again, mask) and not obj.data.materials


def furnished():
    """Stripes on an object with much that a bake could disturb."""
    obj = hexagon_sphere(2)
    obj.data.materials.append(bpy.data.materials.new("Red"))
    obj.data.materials.append(None)
    scene_io.write_attribute(obj, "material_index", "FACE", "INT", np.arange(len(obj.data.polygons)) % 2)
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
    lists = [p.identifier for p in bpy.data.bl_rna.properties if p.type == "COLLECTION"]
    present = sorted((name, block.name, block.users) for name in lists for block in getattr(bpy.data, name))
    touched = ("scenes", "objects", "materials", "node_groups", "images", "collections")
    properties = {(name, block.name): plain(block) for name in touched for block in getattr(bpy.data, name)}
    maps = {m.name: [(u.name, u.active, u.active_render) for u in m.uv_layers] for m in bpy.data.meshes}
    others = {"present": present, "properties": properties, "maps": maps, "shown": bpy.context.window.scene.name}
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
        monkeypatch.setattr("synch_fields.synch_addon.bake_images.save", fail)
    else:
        monkeypatch.setattr(bake_stage.Stage, failing, fail)
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
    monkeypatch.setattr(bake_stage, "staged", lambda *_, **__: pytest.fail("work has begun"))
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


def test_pattern_on_modifiers_and_parents_is_baked_as_it_is_rendered(tmp_path):
    obj = patterned()
    bake(obj, tmp_path, maps="mask", naming="flat")
    parent = bpy.data.objects.new("Parent", None)
    bpy.context.scene.collection.objects.link(parent)
    obj.parent, parent.scale = parent, (2, -1, 0.5)
    obj.modifiers.new("soft", "SUBSURF").subdivision_type = "SIMPLE"
    bake(obj, tmp_path, maps="mask", naming="soft")
    pixels, _, _ = rasterised(obj)
    flat, soft = (picture(tmp_path / f"{name}.png")[pixels[:, 0], pixels[:, 1], 0] for name in ("flat", "soft"))
    assert np.ptp(flat) == 1 and np.abs(flat - soft).mean() < 0.01


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
    operator = SimpleNamespace()
    SYNCH_OT_bake._take(operator, bpy.context)
    api.bake(obj, **plain_settings(operator))
    (image,) = bpy.data.images
    assert tuple(image.size) == (16, 16) and image.name == f"{obj.name}_mask.png"
    sphere(2)
    assert not panel.poll(bpy.context)
