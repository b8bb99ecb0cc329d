# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Stripes in shaders at every point, their profiles, and the materials that show them."""

import bpy
import numpy as np
import pytest

from synch_fields.synch_addon.blender.schema import PHASES
from synch_fields.synch_addon.nodes import stripes as nodes
from synch_fields.synch_addon.nodes.canvas import find_node
from synch_fields.synch_addon.nodes.materials import pattern_material

from ..single_faces import FACES, PIXELS, Face, differences, point_samples, show_socket


@pytest.mark.parametrize("name", FACES)
def test_shader_follows_the_formula_at_every_point(name, tmp_path):
    face = FACES[name]
    show_socket(face.build(), "Cosine")
    found = differences(face, point_samples(tmp_path))
    assert found.max() < 2e-4


@pytest.mark.slow
def test_shader_follows_the_formula_in_eevee(tmp_path):
    engine = "BLENDER_EEVEE" if bpy.app.version >= (5, 0) else "BLENDER_EEVEE_NEXT"
    for name in ("triangle, disclination", "quad, both triangles", "dart, disclination"):
        bpy.ops.wm.read_homefile(use_empty=True)
        show_socket(FACES[name].build(), "Cosine")
        bpy.context.scene.eevee.taa_render_samples = 1
        # EEVEE renders in half precision: (1 + cos) / 2 has steps of 5e-4 below 1.
        assert differences(FACES[name], point_samples(tmp_path, engine)).max() < 2e-3


@pytest.mark.parametrize("width", [0.0, 0.25, 0.5, 1.0])
def test_width_is_the_part_of_a_period_that_is_stripe(width, tmp_path):
    # Eight periods from left to right over the whole picture.
    square = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    group = show_socket(Face(square, (0, 16 * np.pi, 16 * np.pi, 0)).build(), "Factor")
    group.inputs["Width"].default_value = width
    factor = point_samples(tmp_path)
    assert abs(factor.mean() - width) < 0.01
    assert factor.min() > -1e-6 and factor.max() < 1 + 1e-6


def test_height_is_one_along_the_middle_of_a_stripe_and_zero_outside(tmp_path):
    square = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    phases = (-np.pi, np.pi, np.pi, -np.pi)
    show_socket(Face(square, phases).build(), "Height")
    row = point_samples(tmp_path)[PIXELS // 2]
    theta = np.linspace(-np.pi, np.pi, PIXELS, endpoint=False) + np.pi / PIXELS
    expected = np.where(np.abs(theta) < np.pi / 2, (1 + np.cos(2 * theta)) / 2, 0.0)
    assert np.abs(row - expected).max() < 1e-5


SHAPES = {
    "sine": lambda s, a: 0.5 - 0.5 * np.cos(np.pi * s),
    "square": lambda s, a: np.clip(4 * s, 0, 1) ** 2 * (3 - 2 * np.clip(4 * s, 0, 1)),
    "triangle": lambda s, a: s,
    "rounded": lambda s, a: np.sqrt(s * (2 - s)),
    "thread": lambda s, a: np.sqrt(s * (2 - s)) * (1 - 0.38 * (1 - np.abs(np.sin(3 * np.pi * a)))),
}


def numbered_square():
    """A square with two and a half periods from left to right, stripes of the numbers 7, 4 and 9, going upwards."""
    obj = Face([(-1, -1), (1, -1), (1, 1), (-1, 1)], (-np.pi, 4 * np.pi, 4 * np.pi, -np.pi)).build()
    # Periods 0, 1 and 2 in their slots; the phase of the second grows to the right of its direction.
    obj.data.attributes.new("synch_number", "FLOAT_VECTOR", "FACE").data[0].vector = (7, -4, 9)
    along = obj.data.attributes.new("synch_along", "FLOAT_VECTOR", "CORNER")
    along.data.foreach_set("vector", np.float32([(0, 2, 0), (0, 2, 0), (3, -1, 3), (3, -1, 3)]).ravel())
    return obj


def places_in_stripes():
    """Periods from the left, the stripe that each is in, and periods along the stripes, at the pixels."""
    line = (np.arange(PIXELS) + 0.5) / PIXELS
    periods, along = np.meshgrid(2.5 * line - 0.5, 3 * line)
    slot = np.rint(periods).astype(int)
    return periods, slot, np.where(slot == 1, 2 - along, along)


def test_place_in_a_numbered_stripe(tmp_path):
    obj = numbered_square()
    periods, slot, along = places_in_stripes()
    sure = np.abs(periods - slot) < 0.49
    expected = {
        "Across": 2 * (periods - slot) * np.choose(slot, [1, -1, 1]),
        "Along": along,
        "Index": np.choose(slot, [7, 4, 9]),
    }
    for name, values in expected.items():
        obj.data.materials.clear()
        show_socket(obj, name)
        found = point_samples(tmp_path)
        np.testing.assert_allclose(found[sure], values[sure], atol=2e-4)
    obj.data.materials.clear()
    show_socket(obj, "Random")
    found = point_samples(tmp_path)
    for one in range(3):
        assert np.ptp(found[sure & (slot == one)]) < 1e-5
    assert len({round(float(value), 3) for value in found[sure]}) == 3 and 0 <= found.min() < found.max() <= 1


@pytest.mark.parametrize("profile", SHAPES)
def test_profiles_have_their_closed_forms(profile, tmp_path):
    obj = numbered_square()
    group = show_socket(obj, "Height")
    group.inputs["Profile"].default_value = list(SHAPES).index(profile)
    group.inputs["Width"].default_value = 0.8
    group.inputs["Strands"].default_value = 3
    periods, slot, along = places_in_stripes()
    offset = (periods - slot) * np.choose(slot, [1, -1, 1])
    share = np.clip(1 - np.abs(offset) / 0.4, 0, 1)
    twist = along + np.arcsin(np.clip(offset / 0.4, -1, 1)) / (3 * np.pi)
    np.testing.assert_allclose(point_samples(tmp_path), SHAPES[profile](share, twist), atol=2e-3)


def test_group_is_reused_and_an_outdated_one_is_rebuilt_with_its_users_settings():
    group = show_socket(FACES["regular quad"].build(), "Cosine")
    group.inputs["Width"].default_value = 0.3
    tree = nodes.stripes_group()
    assert group.node_tree == tree
    tree["synch_stamp"] = "of an older version"
    tree.nodes.clear()
    assert nodes.stripes_group() == tree
    assert any(node.type == "GROUP_OUTPUT" for node in tree.nodes)
    assert group.inputs["Width"].default_value == pytest.approx(0.3)
    assert [item.name for item in bpy.data.node_groups] == ["Synch Phase", "Synch Stripes"]


def test_inner_group_reads_other_attributes(tmp_path):
    face = FACES["regular triangle"]
    obj = face.build()
    obj.data.attributes["synch_phase"].name = "synch_phase_x"
    renamed = PHASES["stripes"][0]._replace(phase=PHASES["quads"][0].phase)
    group = show_socket(obj, "Cosine")
    group.node_tree = nodes.phase_group("Synch Phase x", renamed)
    tree = obj.data.materials[0].node_tree
    tree.links.new(group.outputs["Cosine"], find_node(tree, "ShaderNodeMath").inputs[0])
    assert differences(face, point_samples(tmp_path)).max() < 2e-4


def test_material_edits_survive_a_second_run():
    obj = FACES["regular quad"].build()
    material = pattern_material(obj, "stripes", spacing=0.1)
    group = next(node for node in material.node_tree.nodes if node.type == "GROUP")
    group.inputs["Width"].default_value = 0.2
    material.name = "Zebra"
    assert pattern_material(obj, "stripes", spacing=0.2) == material
    assert group.inputs["Width"].default_value == pytest.approx(0.2)
    assert list(obj.data.materials) == [material]
    assert obj["synch_spacing"] == pytest.approx(0.2)


def test_an_object_without_materials_gets_stripes_and_so_does_an_empty_slot():
    bare, slotted = FACES["regular quad"].build(), FACES["regular triangle"].build()
    slotted.data.materials.append(None)
    material = pattern_material(bare, "stripes")
    assert pattern_material(slotted, "stripes") == material
    assert list(bare.data.materials) == list(slotted.data.materials) == [material]


def test_other_materials_keep_their_faces_unless_all_are_asked_for():
    obj = FACES["regular quad"].build()
    steel = bpy.data.materials.new("steel")
    obj.data.materials.append(steel)
    stripes = pattern_material(obj, "stripes")
    assert list(obj.data.materials) == [steel, stripes]
    assert obj.data.polygons[0].material_index == 0
    assert pattern_material(obj, "stripes", assign_faces=True) == stripes
    assert list(obj.data.materials) == [steel, stripes]
    assert obj.data.polygons[0].material_index == 1
