# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Quads in shaders: the two phases, the profiles that do not tell one from the other, and the material."""

import bpy
import numpy as np
import pytest

from synch_fields.core.fields import direction_field
from synch_fields.core.fields.target_one_form import TargetOneForm
from synch_fields.core.interpolate import evaluate, face_phases
from synch_fields.synch_addon.blender import attributes, meshes
from synch_fields.synch_addon.nodes import quads
from synch_fields.synch_addon.nodes.canvas import surface_material
from synch_fields.synch_addon.nodes.materials import pattern_material

from ..scenes import add_object, attribute, grid, quad_sphere, sphere

PIXELS = 512
GRID_LINES, CHECKER, WEAVE, DOTS = range(4)
PROFILES = pytest.mark.parametrize("profile", [GRID_LINES, CHECKER, WEAVE, DOTS], ids=quads.PROFILES)
# Raises every value above zero, where a picture is not clamped.
OFFSET = 64.0


def write_phases(obj, phases, polygons):
    """The attributes of two phases that the shader reads."""
    for axis, phase in zip("xy", phases, strict=True):
        attributes.write_attribute(obj, f"synch_phase_{axis}", "CORNER", "FLOAT", phase.corner_phase)
        attributes.write_attribute(obj, f"synch_index_{axis}", "FACE", "INT", phase.index)
        if phase.index_2.any():
            attributes.write_attribute(obj, f"synch_index_{axis}_2", "FACE", "INT", phase.index_2)
        attributes.write_attribute(obj, f"synch_disclination_{axis}", "FACE", "FLOAT_COLOR", phase.disclination)
    attributes.write_attribute(obj, "synch_barycentric", "CORNER", "FLOAT_VECTOR", phases[0].corner_place)
    closings = np.column_stack([phase.closing for phase in phases])
    attributes.write_attribute(obj, "synch_closing", "FACE", "FLOAT2", closings)


def unfold(obj, polygons):
    """Give each face a square of the picture; returns (c, 2) corners in pixels."""
    rows = int(np.ceil(np.sqrt(len(polygons.starts))))
    size = PIXELS / rows
    faces = np.repeat(np.arange(len(polygons.starts)), polygons.sizes)
    corners = np.array([(0.05, 0.05), (0.95, 0.05), (0.95, 0.95), (0.05, 0.95)])
    places = corners[np.arange(len(faces)) - polygons.starts[faces]]
    uv = (np.column_stack([faces % rows, faces // rows]) + places) * size
    layer = obj.data.uv_layers.new(name="unfolded")
    layer.uv.foreach_set("vector", np.float32(uv / PIXELS).ravel())
    layer.active = True
    return uv


def points_of(polygons, uv):
    """Pixels, the triangles that they are in and their weights there, away from edges and centres."""
    pixels, triangles, weights = [], [], []
    for triangle, corners in enumerate(polygons.triangle_corners):
        low, high = np.floor(uv[corners].min(axis=0)), np.ceil(uv[corners].max(axis=0))
        grid = np.stack(np.meshgrid(*(np.arange(a, b) for a, b in zip(low, high, strict=True))), axis=-1).reshape(-1, 2)
        matrix = np.vstack([uv[corners].T, np.ones(3)])
        inside = np.linalg.solve(matrix, np.vstack([grid.T + 0.5, np.ones(len(grid))])).T
        kept = (inside.min(axis=1) > 0.01) & (inside.min(axis=1) < 0.3)
        pixels.append(grid[kept].astype(int))
        triangles.append(np.full(kept.sum(), triangle))
        weights.append(inside[kept])
    return np.concatenate(pixels), np.concatenate(triangles), np.concatenate(weights)


def baked(obj, outputs, pixels=PIXELS, **inputs):
    """(pixels, pixels, 3) values of up to three outputs of the group over the unfolded faces."""
    material, *_ = surface_material("probe")
    tree = material.node_tree
    tree.nodes.clear()
    group = tree.nodes.new("ShaderNodeGroup")
    group.node_tree = quads.quads_group()
    for name, value in inputs.items():
        group.inputs[name].default_value = value
    joined = tree.nodes.new("ShaderNodeCombineXYZ")
    for output, socket in zip(outputs, joined.inputs, strict=False):
        tree.links.new(group.outputs[output], socket)
    raised = tree.nodes.new("ShaderNodeVectorMath")
    raised.inputs[1].default_value = (OFFSET,) * 3
    tree.links.new(joined.outputs[0], raised.inputs[0])
    glow, surface = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(raised.outputs[0], glow.inputs["Color"])
    tree.links.new(glow.outputs[0], surface.inputs["Surface"])
    picture = tree.nodes.new("ShaderNodeTexImage")
    picture.image = bpy.data.images.new("baked", pixels, pixels, float_buffer=True)
    tree.nodes.active = picture
    obj.data.materials.clear()
    obj.data.materials.append(material)
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.samples = "CYCLES", 1
    bpy.ops.object.bake(type="EMIT", margin=0)
    values = np.empty(pixels * pixels * 4, np.float32)
    picture.image.pixels.foreach_get(values)
    return values.reshape(pixels, pixels, 4)[:, :, :3] - OFFSET


def random_phases(obj):
    """The object's faces with random phases along the smoothest crosses: full of defects of both kinds."""
    given = meshes.read_mesh(obj)
    growth = TargetOneForm.of(given.mesh, direction_field(given.mesh, 4), 0.5)
    random = np.random.default_rng(2)
    phases = np.exp(1j * random.uniform(-np.pi, np.pi, len(growth.masses)))
    return given.polygons, face_phases(growth.edge_phases(phases), given.polygons)


@pytest.mark.parametrize("build", [lambda: sphere(2), quad_sphere], ids=["triangles", "quads"])
def test_shader_and_core_agree_on_both_phases_everywhere(build):
    obj = build()
    polygons, phases = random_phases(obj)
    write_phases(obj, phases, polygons)
    pixels, triangles, weights = points_of(polygons, unfold(obj, polygons))
    picture = baked(obj, ("Phase X", "Phase Y"))[pixels[:, 1], pixels[:, 0]]
    fit = ~np.isin(polygons.triangle_faces[triangles], phases[0].unfit)
    torn = np.setdiff1d(np.flatnonzero(phases[0].disclination.any(axis=1)), phases[0].unfit)
    assert len(torn) > 5 and np.ptp(attribute(obj, "synch_closing")[torn], axis=0).min() > 1
    for axis, phase in enumerate(phases):
        assert (phase.index == 1).any() and (phase.index == -1).any()
        assert (phase.index_2 != 0).any() or polygons.sizes.max() == 3
        off = picture[fit, axis] - evaluate(phase, polygons, triangles[fit], weights[fit])
        np.testing.assert_allclose(off - 2 * np.pi * np.rint(off / (2 * np.pi)), 0, atol=5e-3)


@pytest.fixture
def plane():
    """One square face on which both phases go from -2 pi to 2 pi, x to the right and y upwards."""
    corners = np.array([(-1.0, -1), (1, -1), (1, 1), (-1, 1)])
    obj = add_object(np.column_stack([corners, np.zeros(4)]), [range(4)])
    for axis, values in zip("xy", corners.T * 2 * np.pi, strict=True):
        attributes.write_attribute(obj, f"synch_phase_{axis}", "CORNER", "FLOAT", values)
    layer = obj.data.uv_layers.new()
    layer.uv.foreach_set("vector", np.float32((corners + 1) / 2).ravel())
    return obj


def cells():
    """x and y at the pixels of the plane, in cells."""
    line = ((np.arange(PIXELS) + 0.5) / PIXELS - 0.5) * 4
    return np.meshgrid(line, line)


def to_whole(numbers):
    return np.abs(numbers - np.rint(numbers))


PICTURE = ("Factor", "Height", "Pattern")


@PROFILES
def test_no_picture_tells_the_phases_and_their_signs_apart(plane, profile):
    """(y, -x) is the plane turned by a quarter; 2 pi are two cells, half the plane."""
    picture = baked(plane, PICTURE, Profile=profile)
    np.testing.assert_allclose(np.rot90(picture), picture, atol=2e-3)
    for axis in (0, 1):
        np.testing.assert_allclose(np.roll(picture, PIXELS // 2, axis), picture, atol=2e-3)
    assert np.ptp(picture, axis=(0, 1)) == pytest.approx((1, 1, 2), abs=1e-2)


@PROFILES
def test_softest_picture_has_no_jumps(plane, profile):
    """Where the strands of a weave exchange places, above all."""
    picture = baked(plane, PICTURE, Profile=profile, Softness=1.0)
    for axis in (0, 1):
        assert np.abs(np.diff(picture, axis=axis)).max() < 0.16


def test_profiles_are_what_their_names_say(plane):
    x, y = cells()
    near, reach = np.minimum(to_whole(x), to_whole(y)), np.hypot(to_whole(x), to_whole(y))
    wave = np.cos(np.pi * x) * np.cos(np.pi * y)
    for profile, inside in (
        (GRID_LINES, (1 - np.sqrt(0.75)) / 2 - near),
        (CHECKER, np.sign(wave) * (0.5 - np.maximum(to_whole(x), to_whole(y))) - (1 - np.sqrt(0.5)) / 2),
        (DOTS, np.sqrt(0.25 / np.pi) - reach),
    ):
        factor, height, pattern = np.moveaxis(baked(plane, PICTURE, Profile=profile, Width=0.25), -1, 0)
        sure = np.abs(inside) > 0.011
        np.testing.assert_allclose(factor[sure], inside[sure] > 0, atol=1e-4)
        np.testing.assert_allclose(pattern, wave, atol=1e-4)
        assert not (height[inside < -1e-4] > 1e-4).any() and height[inside > 0.9 * inside.max()].min() > 0.95


def test_strands_of_the_weave_pass_above_and_below_in_turn(plane):
    factor, height, _ = np.moveaxis(baked(plane, PICTURE, Profile=WEAVE), -1, 0)
    x, y = cells()
    crossing = np.abs(x % 1 - 0.5) + np.abs(y % 1 - 0.5) < 0.05
    assert factor[crossing].min() == pytest.approx(1, abs=1e-4) and height[crossing].min() > 0.9
    assert height[factor < 1e-3].max() < 1e-3  # in the gaps too
    below = []
    for middle in (0.5, 1.5):
        column = factor[:, np.argmin(np.abs(x[0] - middle))]
        cut = np.flatnonzero((column[1:] < 0.5) & (column[:-1] >= 0.5))
        assert len(cut) == 4  # two of the four crossings are below, with a gap on either side
        below.append(set(np.floor(y[cut, 0]).astype(int)))
    assert sorted(set.union(*below)) == [-2, -1, 0, 1] and not set.intersection(*below)


@pytest.mark.parametrize("width", [0.0, 0.3, 1.0])
def test_width_is_the_part_of_the_area_that_has_the_color(plane, width):
    for profile in (GRID_LINES, CHECKER, WEAVE, DOTS):
        factor = baked(plane, PICTURE, 256, Profile=profile, Width=width, Softness=0.0)[:, :, 0]
        assert factor.min() > -1e-5 and factor.max() < 1 + 1e-5
        if profile == WEAVE:  # crossings, and the strands between them
            assert width - 0.01 < factor.mean() < 1 - (1 - np.sqrt(width)) ** 2 + 0.01
        elif profile == DOTS and width == 1:  # the dots overlap
            assert 0.9 < factor.mean() < 0.92
        else:
            assert factor.mean() == pytest.approx(width, abs=0.015)


def test_profile_is_chosen_by_a_number_that_its_description_explains():
    tree = quads.quads_group()
    socket = next(item for item in tree.interface.items_tree if item.name == "Profile")
    assert (socket.min_value, socket.max_value, socket.default_value) == (0, 3, 0)
    assert socket.description == "0: grid lines, 1: checker, 2: weave, 3: dots"
    names = ["Synch Phase X", "Synch Phase Y", "Synch Quads"]
    assert quads.quads_group() == tree and [group.name for group in bpy.data.node_groups] == names


def relief_of(material):
    return next(node for node in material.node_tree.nodes if node.type == "MATH").inputs[1].default_value


@pytest.mark.parametrize("first, second", [("stripes", "quads"), ("quads", "stripes")])
def test_the_other_kind_takes_over_the_slot_and_comes_back_as_it_was(first, second):
    obj = grid()
    steel = bpy.data.materials.new("steel")
    obj.data.materials.append(steel)
    before = pattern_material(obj, first, spacing=0.2)
    obj.data.polygons[3].material_index = 1
    after = pattern_material(obj, second, spacing=0.3)
    assert list(obj.data.materials) == [steel, after] and after.name == f"Synch {second.title()}"
    assert [polygon.material_index for polygon in obj.data.polygons[2:5]] == [0, 1, 0]
    assert obj["synch_spacing"] == pytest.approx(0.3)
    assert relief_of(after) != relief_of(before)
    assert pattern_material(obj, second, assign_faces=True) == after
    assert {polygon.material_index for polygon in obj.data.polygons} == {1}
    assert pattern_material(obj, first) == before
    assert list(obj.data.materials) == [steel, before]


def test_quads_survive_a_second_run_with_the_users_settings():
    obj = grid()
    material = pattern_material(obj, "quads")
    group = material.node_tree.nodes.active
    group.inputs["Profile"].default_value = WEAVE
    obj.data.materials.append(pattern_material(sphere(1), "stripes"))
    assert pattern_material(obj, "quads", assign_faces=True) == material
    assert group.inputs["Profile"].default_value == WEAVE
    assert [slot.material.name for slot in obj.material_slots] == ["Synch Quads", "Synch Stripes"]


def test_empty_slots_are_filled_and_keep_their_faces():
    obj = grid()
    obj.data.materials.append(None)
    obj.data.materials.append(None)
    obj.data.polygons[0].material_index = 1
    material = pattern_material(obj, "quads", assign_faces=True)
    assert list(obj.data.materials) == [material, material]
    assert obj.data.polygons[0].material_index == 1
