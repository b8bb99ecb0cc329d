# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked images against the formulas at every texel."""

import bpy
import numpy as np
import pytest
from scipy.ndimage import binary_dilation

from synch_fields.core.extract.lines.stripe_numbers import SLOTS
from synch_fields.core.interpolate import TURN, evaluate
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import attributes, meshes
from synch_fields.synch_addon.nodes.canvas import surface_material
from synch_fields.synch_addon.patterns import memory

from ..baked_images import PATTERNS, SIZE, SOFTNESS, bake, inside_of, patterned, phases_at, picture, rasterised
from ..rebuilt_pattern import phases_of, polygons_of
from ..scenes import attribute, grid, mark_edges, places, quad_sphere, sphere, torus


@pytest.mark.parametrize(("kind", "samples"), [("stripes", 16), ("quads", 1)])
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
    assert (off > 1 / 255).mean() < 6e-3  # at the centres of defects, where the phase turns within a texel
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
    polygons = meshes.read_polygons(obj)
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
    # Beside the ends of stripes, numbers change along the edges of faces.
    assert (numbers[:, 1:] == numbers[:, :-1])[both].mean() > (0.99 if kind == "stripes" else 0.995)
    covered = np.zeros((SIZE, SIZE), bool)
    covered[pixels[:, 0], pixels[:, 1]] = True
    beside = binary_dilation(covered, np.ones((3, 3)), iterations=margin - 2)
    far = ~binary_dilation(covered, np.ones((3, 3)), iterations=margin + 1)
    assert numbers[beside].all()
    assert not numbers[far].any()


def cut_grid():
    obj = grid(24)
    mark_edges(obj, "seams", np.abs(places(obj)[:, 0]) < 1e-6)
    return obj


@pytest.mark.parametrize("build", [lambda: sphere(3), torus, lambda: quad_sphere(7), cut_grid])
def test_index_is_the_number_that_the_shader_shows(build, tmp_path):
    obj = build()
    rows = [{"where": "seams", "what": "cut"}] if build is cut_grid else []
    api.stripes(obj, spacing=0.4, constraints=rows)
    for layer in list(obj.data.uv_layers):
        obj.data.uv_layers.remove(layer)
    report = bake(obj, tmp_path, maps="index", file_format="EXR")
    baked = picture(tmp_path / "index.exr")[:, :, 0]
    lines = api.number_stripes(obj)
    numbers = np.abs(attribute(obj, "synch_number"))
    assert report["count"] == numbers.max() >= lines > 2
    pixels, triangles, weights = rasterised(obj)
    polygons = polygons_of(obj)
    periods = np.rint(evaluate(phases_of(obj), polygons, triangles, weights) / TURN).astype(int)
    shown = numbers[polygons.triangle_faces[triangles], periods % SLOTS]
    assert shown.min() > 0
    # But where the middle of a pixel lies on the border of two stripes.
    assert (baked[pixels[:, 0], pixels[:, 1]] == shown).mean() > 0.999
    bake(obj, tmp_path, maps="index", file_format="EXR")
    np.testing.assert_array_equal(picture(tmp_path / "index.exr")[:, :, 0], baked)


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


def test_mask_is_on_all_faces_and_colour_is_that_of_each_material(tmp_path):
    obj = patterned()
    red, surface, _ = surface_material("Red")
    surface.inputs["Base Color"].default_value = (1, 0, 0, 1)
    obj.data.materials.append(red)
    half = np.arange(len(obj.data.polygons)) % 2
    attributes.write_attribute(obj, "material_index", "FACE", "INT", half)
    bake(obj, tmp_path, maps="mask,colour")
    pixels, triangles, _ = rasterised(obj)
    _, phases = phases_at(obj)
    inside, _ = inside_of(phases)
    mask = picture(tmp_path / "mask.png")[pixels[:, 0], pixels[:, 1], 0]
    assert np.quantile(np.abs(mask - (inside > 0))[np.abs(inside) > 0.012], 0.998) < 1 / 255
    colour = picture(tmp_path / "colour.png")[pixels[:, 0], pixels[:, 1], :3]
    is_red = half[meshes.read_polygons(obj).triangle_faces[triangles]] == 1
    assert np.allclose(colour[is_red], (1, 0, 0)) and not (colour[~is_red] == (1, 0, 0)).all(axis=1).any()
    # Nothing shows the pattern any more: the mask has its standard look.
    obj.data.materials.clear()
    bake(obj, tmp_path, maps="mask")
    again = picture(tmp_path / "mask.png")[pixels[:, 0], pixels[:, 1], 0]
    assert np.array_equal(again, mask) and not obj.data.materials


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
