# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a Blender user expects: modes, shared and linked data, modifiers, selections, reasons in tooltips."""

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SynchError
from synch_fields.synch_addon import api

from ..scenes import add_object, attribute, empties, grid, make_active, quad_sphere, snapshot, sphere, tube

OPERATORS = ["directions", "stripes"]


def call(operator, **settings):
    return getattr(bpy.ops.synch, operator)(**settings)


def refusal_of(operator):
    """The reason that the greyed-out button shows."""
    assert not getattr(bpy.ops.synch, operator).poll()
    with pytest.raises(RuntimeError) as refused:
        call(operator)
    return str(refused.value).strip()


@pytest.mark.parametrize("operator", OPERATORS)
def test_edit_mode_is_left_and_entered_again(operator):
    obj = sphere()
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    assert call(operator) == {"FINISHED"}
    assert obj.mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    assert not attribute(obj, "synch_direction")[0].tolist() == [0, 0, 0]
    assert not any(v.select for v in obj.data.vertices)


def test_edits_that_were_not_flushed_count():
    obj = grid()
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide()
    bpy.ops.synch.stripes()
    bpy.ops.object.mode_set(mode="OBJECT")
    assert len(attribute(obj, "synch_phase")) == len(obj.data.loops) == 4 * 4 * 144


@pytest.mark.parametrize("operator", OPERATORS)
@pytest.mark.parametrize("mode", ["SCULPT", "WEIGHT_PAINT"])
def test_other_modes_are_refused(operator, mode):
    obj = sphere()
    bpy.ops.object.mode_set(mode=mode)
    assert "leave the present mode" in refusal_of(operator)
    assert obj.mode == mode


def test_shared_mesh_works_with_a_warning():
    obj = sphere()
    other = bpy.data.objects.new("Other", obj.data)
    bpy.context.scene.collection.objects.link(other)
    (warning,) = api.stripes(make_active(obj))["warnings"]
    assert obj.data.name in warning and "2 users" in warning
    assert len(obj.data.attributes["synch_phase"].data) == len(other.data.loops)
    assert empties(obj) and not empties(other)


@pytest.mark.parametrize("command", ["stripes", "directions", "quad_mesh", "isolines", "relief"])
def test_a_shared_mesh_that_another_object_has_in_edit_mode_is_refused_in_one_line(command):
    obj = sphere(2)
    settings = {} if command in ("isolines", "relief") else {"method": "spectral"}
    if not settings:
        api.stripes(obj, method="spectral")
    other = bpy.data.objects.new("Other", obj.data)
    bpy.context.scene.collection.objects.link(other)
    make_active(other)
    bpy.ops.object.mode_set(mode="EDIT")
    with pytest.raises(SynchError, match="is in edit mode by another object: leave edit mode"):
        getattr(api, command)(obj, **settings)
    bpy.ops.object.mode_set(mode="OBJECT")
    assert getattr(api, command)(obj, **settings)


def test_fake_user_is_no_user():
    obj = sphere()
    obj.data.use_fake_user = True
    assert api.stripes(obj)["warnings"] == []


def test_modifiers_that_change_faces_are_named():
    obj = sphere()
    obj.modifiers.new("Rounder", "SUBSURF")
    obj.modifiers.new("Wobble", "WAVE")
    faces = len(obj.data.polygons)
    (warning,) = api.stripes(obj)["warnings"]
    assert "Rounder" in warning and "Wobble" not in warning and "apply" in warning
    assert len(obj.data.polygons) == faces and len(obj.modifiers) == 2


def test_hidden_modifiers_are_not_worth_a_warning():
    obj = sphere()
    obj.modifiers.new("Rounder", "SUBSURF").show_viewport = False
    assert api.stripes(obj)["warnings"] == []


@pytest.mark.parametrize("operator", OPERATORS)
def test_only_the_active_object_is_touched(operator):
    others = [grid(), tube()]
    obj = sphere()
    for other in others:
        other.select_set(True)
    before = snapshot()["meshes"]
    assert call(operator) == {"FINISHED"}
    after = snapshot()["meshes"]
    assert {name for name in after if after[name] != before[name]} == {obj.data.name}
    assert all(other.select_get() for other in others)


@pytest.mark.parametrize("operator", OPERATORS)
def test_no_active_object(operator):
    assert "no active object" in refusal_of(operator) and "select" in refusal_of(operator)


@pytest.mark.parametrize("operator", OPERATORS)
@pytest.mark.parametrize("add", ["light_add", "camera_add", "empty_add", "text_add"])
def test_object_without_a_mesh(operator, add):
    getattr(bpy.ops.object, add)()
    reason = refusal_of(operator)
    assert bpy.context.active_object.name in reason and "is not a mesh" in reason


@pytest.mark.parametrize("hide", ["eye", "viewport"])
def test_hidden_active_object_works(hide):
    obj = sphere()
    if hide == "eye":
        obj.hide_set(True)
    else:
        obj.hide_viewport = True
    assert call("stripes") == {"FINISHED"}
    assert "synch_phase" in obj.data.attributes


@pytest.mark.parametrize("operator", OPERATORS)
@pytest.mark.parametrize("linked", ["object", "mesh"])
def test_linked_data_is_refused_with_the_reason(operator, linked, tmp_path):
    library = str(tmp_path / "library.blend")
    name, mesh_name = sphere().name, bpy.context.active_object.data.name
    bpy.ops.wm.save_as_mainfile(filepath=library)
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(library, link=True) as (_, wanted):
        wanted.objects, wanted.meshes = [name], [mesh_name]
    obj = bpy.data.objects[name] if linked == "object" else bpy.data.objects.new("Local", bpy.data.meshes[mesh_name])
    bpy.context.scene.collection.objects.link(obj)
    make_active(obj)
    reason = refusal_of(operator)
    assert f"the {linked}" in reason and "is linked" in reason and "Make Local" in reason
    with pytest.raises(Exception, match="is linked"):
        api.stripes(obj)
    bpy.ops.object.make_local(type="SELECT_OBDATA")
    assert call(operator) == {"FINISHED"}


def test_materials_of_the_user_are_kept():
    obj = sphere()
    for name in ("Red", "Green"):
        obj.data.materials.append(bpy.data.materials.new(name))
    used = np.arange(len(obj.data.polygons), dtype=np.int32) % 2
    obj.data.polygons.foreach_set("material_index", used)
    assert call("stripes") == {"FINISHED"}
    assert [m.name for m in obj.data.materials] == ["Red", "Green", "Synch Stripes"]
    np.testing.assert_array_equal(attribute(obj, "material_index"), used)
    assert call("stripes", assign_material=True) == {"FINISHED"}
    assert len(obj.data.materials) == 3
    assert set(attribute(obj, "material_index")) == {2}


def test_attribute_of_the_same_name_and_another_kind_is_replaced():
    obj = sphere()
    obj.data.attributes.new("synch_phase", "INT", "POINT")
    obj.data.attributes.new("synch_direction", "FLOAT", "FACE")
    assert call("stripes") == {"FINISHED"}
    found = obj.data.attributes
    assert (found["synch_phase"].domain, found["synch_phase"].data_type) == ("CORNER", "FLOAT")
    assert (found["synch_direction"].domain, found["synch_direction"].data_type) == ("POINT", "FLOAT_VECTOR")


def test_shape_keys_survive():
    obj = quad_sphere()
    obj.shape_key_add(name="Basis")
    obj.shape_key_add(name="Wide").data[0].co.x += 1
    assert call("stripes") == {"FINISHED"}
    assert [key.name for key in obj.data.shape_keys.key_blocks] == ["Basis", "Wide"]


def test_pieces_are_solved_together():
    """Three pieces, two with a boundary; Suzanne's eyes are not joined to her head."""
    bpy.ops.mesh.primitive_monkey_add()
    obj = bpy.context.active_object
    report = api.stripes(obj, spacing=0.2)
    assert report["nodes"] == len(obj.data.vertices) == 507
    assert report["certificate"] in ("proved", "estimated")
    assert np.isfinite(attribute(obj, "synch_phase")).all()
    lengths = np.linalg.norm(attribute(obj, "synch_direction"), axis=1)
    np.testing.assert_allclose(lengths, 1, atol=1e-5)


def test_a_single_quad_carries_stripes():
    """The plane that Shift A adds."""
    bpy.ops.mesh.primitive_plane_add()
    assert call("stripes") == {"FINISHED"}


def test_loose_vertices_get_no_field_and_a_warning():
    vertices = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (5, 5, 5), (1, 2, 0)]
    obj = add_object(vertices, [(0, 1, 2), (0, 2, 3), (3, 2, 5)])
    report = api.stripes(obj, spacing=0.7)
    (warning,) = [line for line in report["warnings"] if "without a face" in line]
    assert "vertex 4 " in warning and "Delete Loose" in warning
    assert report["nodes"] == 5
    assert not attribute(obj, "synch_direction")[4].any()
    assert np.isfinite(attribute(obj, "synch_pattern")).all()


def test_too_fine_a_spacing_warns_with_the_edge_length_it_needs():
    report = api.stripes(grid(), spacing=0.1, surface="faces")
    (warning,) = report["warnings"]
    assert "0.1 is finer than the mesh can carry" in warning
    assert "edges shorter than 0.05" in warning and "set the surface to automatic" in warning
