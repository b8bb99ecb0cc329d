# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a quad mesh takes over from the given mesh: materials, shading, vertex groups, attributes and UV maps."""

import bpy
import numpy as np
import pytest

from synch_fields.synch_addon.patterns import made_from as quad_sources

from ..quad_meshes import corner_vertices, made_from
from ..run_commands import add_weights
from ..scenes import attribute, grid, hexagon_sphere, make_active, mark_edges, places, quad_sphere, sphere


def lattice(obj, **settings):
    """The regular quads of a flat square, a quarter wide."""
    return made_from(obj, spacing=0.5, boundary="phase", **settings)[0]


def add_values(obj, name, data_type, domain, values):
    """Add an attribute of scalars, vectors or colours."""
    kind, dtype = {
        "FLOAT": ("value", np.float32),
        "INT": ("value", np.int32),
        "BOOLEAN": ("value", bool),
        "FLOAT_COLOR": ("color", np.float32),
        "BYTE_COLOR": ("color", np.float32),
    }.get(data_type, ("vector", np.float32))
    obj.data.attributes.new(name, data_type, domain).data.foreach_set(kind, np.asarray(values, dtype).ravel())


def add_materials(obj, used):
    for name in ("Red", "Green", "Blue"):
        obj.data.materials.append(bpy.data.materials.new(name))
    obj.data.polygons.foreach_set("material_index", np.asarray(used, np.int32))


def middles(obj):
    return np.array([p.center[:] for p in obj.data.polygons])


# Materials and shading


def test_materials_stay_on_their_part_of_the_surface():
    obj = grid(16)
    add_materials(obj, np.where(middles(obj)[:, 0] > 0, 2, 1))
    made = lattice(obj)
    assert [m.name for m in made.data.materials] == ["Red", "Green", "Blue"]
    np.testing.assert_array_equal(attribute(made, "material_index"), np.where(middles(made)[:, 0] > 0, 2, 1))


def test_empty_slots_stay_empty():
    obj = sphere()
    for material in (None, bpy.data.materials.new("Red")):
        obj.data.materials.append(material)
    made, _ = made_from(obj, spacing=0.7)
    assert list(made.data.materials) == [None, bpy.data.materials["Red"]]


def test_materials_of_the_object_are_taken_too():
    obj = sphere()
    obj.data.materials.append(bpy.data.materials.new("Of the mesh"))
    (slot,) = obj.material_slots
    slot.link = "OBJECT"
    slot.material = bpy.data.materials.new("Of the object")
    made, _ = made_from(obj, spacing=0.7)
    assert [s.material.name for s in made.material_slots] == ["Of the object"]


@pytest.mark.parametrize(("build", "smooth"), [(sphere, True), (hexagon_sphere, False)])
def test_a_smooth_surface_stays_smooth_and_a_flat_one_flat(build, smooth):
    obj = build()
    (obj.data.shade_smooth if smooth else obj.data.shade_flat)()
    made, _ = made_from(obj, spacing=0.7)
    assert {p.use_smooth for p in made.data.polygons} == {smooth}


def test_each_face_is_shaded_as_the_surface_under_it():
    obj = grid(16)
    for polygon in obj.data.polygons:
        polygon.use_smooth = polygon.center.y > 0
    made = lattice(obj)
    assert [p.use_smooth for p in made.data.polygons] == [p.center.y > 0 for p in made.data.polygons]


# Vertex groups and attributes


@pytest.mark.parametrize(("build", "smoothing"), [(grid, 0), (quad_sphere, 3)])
def test_weights_are_interpolated(build, smoothing):
    obj = build()
    x = places(obj)[:, 0]
    add_weights(obj, "east", np.clip((x + 1) / 2, 0, 1))
    obj.vertex_groups.new(name="nobody")
    made, _ = made_from(obj, spacing=0.4, smoothing=smoothing)
    assert [g.name for g in made.vertex_groups] == ["east", "nobody"]
    weights = np.zeros(len(made.data.vertices))
    for vertex in made.data.vertices:
        assert all(0 < g.weight <= 1 for g in vertex.groups), "vertices outside are in no group"
        for group in vertex.groups:
            weights[vertex.index] = group.weight
    np.testing.assert_allclose(weights, (places(made)[:, 0] + 1) / 2, atol=1e-5)


@pytest.mark.parametrize(("build", "smoothing"), [(grid, 0), (quad_sphere, 3), (hexagon_sphere, 3)])
def test_values_on_vertices_are_interpolated(build, smoothing):
    """A value that is linear on each triangle, such as a coordinate, is exact."""
    obj = build()
    here = places(obj)
    colours = np.column_stack([(here + 1) / 2, np.ones(len(here))])
    add_values(obj, "x", "FLOAT", "POINT", here[:, 0])
    add_values(obj, "place", "FLOAT_VECTOR", "POINT", here)
    add_values(obj, "flat", "FLOAT2", "POINT", here[:, :2])
    add_values(obj, "colour", "FLOAT_COLOR", "POINT", colours)
    add_values(obj, "bytes", "BYTE_COLOR", "POINT", colours)
    made, _ = made_from(obj, spacing=0.4, smoothing=smoothing)
    there = places(made)
    np.testing.assert_allclose(attribute(made, "x"), there[:, 0], atol=1e-5)
    np.testing.assert_allclose(attribute(made, "place"), there, atol=1e-5)
    np.testing.assert_allclose(attribute(made, "flat"), there[:, :2], atol=1e-5)
    np.testing.assert_allclose(attribute(made, "colour")[:, :3], (there + 1) / 2, atol=1e-5)
    np.testing.assert_allclose(attribute(made, "bytes")[:, :3], (there + 1) / 2, atol=0.02)
    for name in ("x", "place", "flat", "colour", "bytes"):
        found, given = made.data.attributes[name], obj.data.attributes[name]
        assert (found.domain, found.data_type) == (given.domain, given.data_type)


@pytest.mark.parametrize("data_type", ["FLOAT", "INT", "BOOLEAN", "FLOAT_VECTOR", "FLOAT_COLOR"])
def test_values_of_faces_are_those_of_the_surface_under_the_middle(data_type):
    obj = grid(16)
    quarter = (middles(obj)[:, :2] > 0) @ [1, 2]
    width = {"FLOAT_VECTOR": 3, "FLOAT_COLOR": 4}.get(data_type, 1)
    add_values(obj, "quarter", data_type, "FACE", np.repeat(quarter, width))
    made = lattice(obj)
    expected = (middles(made)[:, :2] > 0) @ [1, 2]
    expected = expected > 0 if data_type == "BOOLEAN" else np.repeat(expected, width).reshape(-1, width)
    np.testing.assert_allclose(attribute(made, "quarter").reshape(expected.shape), expected, atol=1e-6)


@pytest.mark.parametrize("smoothing", [0, 3])
def test_values_at_corners_are_interpolated(smoothing):
    obj = grid()
    add_values(obj, "x", "FLOAT", "CORNER", places(obj)[corner_vertices(obj), 0])
    made, _ = made_from(obj, spacing=0.4, smoothing=smoothing)
    np.testing.assert_allclose(attribute(made, "x"), places(made)[corner_vertices(made), 0], atol=1e-4)


def test_corner_values_keep_to_their_side_of_a_step():
    """As UV maps do at a seam: values of a quad come from the faces under it, not from across the edge."""
    obj = grid(16)
    east = np.array([p.center.x > 0 for p in obj.data.polygons for _ in range(p.loop_total)])
    add_values(obj, "side", "FLOAT", "CORNER", east)
    made = lattice(obj)
    expected = [p.center.x > 0 for p in made.data.polygons for _ in range(p.loop_total)]
    np.testing.assert_allclose(attribute(made, "side"), expected, atol=1e-6)


def test_a_cut_keeps_the_values_of_both_sides():
    obj = grid(16)
    here = places(obj)
    mark_edges(obj, "seams", np.abs(here[:, 0]) < 1e-6)
    add_values(obj, "x", "FLOAT", "POINT", here[:, 0])
    add_weights(obj, "north", np.clip((here[:, 1] + 1) / 2, 0, 1))
    made = lattice(obj, constraints=[{"where": "seams", "what": "cut"}])
    there = places(made)
    assert np.count_nonzero(np.abs(there[:, 0]) < 1e-6) > 9, "both sides of the cut"
    np.testing.assert_allclose(attribute(made, "x"), there[:, 0], atol=1e-5)
    weights = [sum(g.weight for g in vertex.groups) for vertex in made.data.vertices]
    np.testing.assert_allclose(weights, (there[:, 1] + 1) / 2, atol=1e-5)


# UV maps


def unwrapped(obj, name="Flat"):
    """Give a flat square the UV map of its own coordinates."""
    layer = obj.data.uv_layers.new(name=name)
    layer.data.foreach_set("uv", ((places(obj)[corner_vertices(obj), :2] + 1) / 2).astype(np.float32).ravel())
    return obj


def test_a_uv_map_is_carried_over_without_a_gap():
    made = lattice(unwrapped(grid(16)))
    layer = made.data.uv_layers["Flat"]
    uv = np.array([corner.uv[:] for corner in layer.data])
    np.testing.assert_allclose(uv, (places(made)[corner_vertices(made), :2] + 1) / 2, atol=1e-4)


def test_the_maps_and_colours_that_are_shown_are_those_that_were():
    obj = unwrapped(unwrapped(quad_sphere(), "One"), "Two")
    obj.data.uv_layers.active = obj.data.uv_layers["Two"]
    obj.data.uv_layers["One"].active_render = True
    for name in ("First", "Second"):
        obj.data.color_attributes.new(name, "FLOAT_COLOR", "POINT")
    obj.data.color_attributes.active_color = obj.data.color_attributes["Second"]
    made, _ = made_from(obj, spacing=0.7)
    assert made.data.uv_layers.active.name == "Two"
    assert [layer.name for layer in made.data.uv_layers if layer.active_render] == ["One"]
    assert made.data.color_attributes.active_color.name == "Second"


# What stays behind


def test_the_pattern_of_an_earlier_run_stays_behind():
    """Its numbers belong to the given mesh; so do its material, which shows them, and its defects.

    The kind that the panel shows is the quad mesh's own; Blender 4.5 lists it among the properties.
    """
    obj = sphere()
    assert bpy.ops.synch.quads(spacing=0.7) == {"FINISHED"}
    made, _ = made_from(obj, spacing=0.7)
    assert not [a.name for a in made.data.attributes if a.name.startswith("synch_")]
    groups = [n.node_tree.name for m in made.data.materials for n in m.node_tree.nodes if n.type == "GROUP"]
    assert "Synch Quads" not in groups
    assert not made.children and not {key for key, _ in made.items() if key.startswith("synch_")} - {"synch_simple"}


def test_names_that_blender_hides_stay_behind():
    obj = sphere()
    obj.data.attributes.new(".hidden", "FLOAT", "POINT")
    obj.data.attributes.new("weights of edges", "FLOAT", "EDGE")
    made, _ = made_from(obj, spacing=0.7)
    assert ".hidden" not in made.data.attributes and "weights of edges" not in made.data.attributes


def sharp_edges(obj):
    """(k, 2, 3) ends of the edges that are marked sharp."""
    marked = attribute(obj, "sharp_edge")
    ends = np.array([edge.vertices[:] for edge in obj.data.edges])
    return places(obj)[ends[marked]]


def test_edges_along_sharp_ones_are_shaded_sharp():
    """Of a block whose edges are marked, all twelve, and no other one."""
    bpy.ops.mesh.primitive_cube_add(size=2)
    obj = bpy.context.active_object
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.mark_sharp()
    bpy.ops.mesh.subdivide(number_cuts=9)
    bpy.ops.object.mode_set(mode="OBJECT")
    corner = np.abs(places(obj)) > 0.99
    ends = np.array([edge.vertices[:] for edge in obj.data.edges])
    obj.data.attributes["sharp_edge"].data.foreach_set("value", (corner[ends].all(axis=1).sum(axis=1) == 2).tolist())
    obj.data.shade_smooth()
    made, _ = made_from(obj, spacing=0.5)
    found = sharp_edges(made)
    assert np.linalg.norm(found[:, 1] - found[:, 0], axis=1).sum() == pytest.approx(24, rel=1e-3)
    assert ((np.abs(found) > 1 - 1e-3).all(axis=1).sum(axis=1) == 2).all()
    assert not attribute(made, "sharp_face").any() if "sharp_face" in made.data.attributes else True


# Modifiers


def test_a_quad_mesh_follows_the_rig_of_its_source():
    """The upper half of a ball is raised by a bone, and so is that of its quads."""
    obj = sphere()
    bpy.ops.object.armature_add()
    rig = bpy.context.active_object
    group = obj.vertex_groups.new(name="Bone")
    group.add([v.index for v in obj.data.vertices if v.co.z > 0], 1.0, "REPLACE")
    modifier = obj.modifiers.new("Rig", "ARMATURE")
    modifier.object, modifier.use_bone_envelopes, modifier.use_deform_preserve_volume = rig, False, True
    rig.pose.bones["Bone"].location = (0, 1, 0)  # along the bone, which stands upright
    made, _ = made_from(obj, spacing=0.5)
    copy = made.modifiers["Rig"]
    assert copy.object == rig and copy.use_deform_preserve_volume and not copy.use_bone_envelopes
    bpy.context.view_layer.update()
    low, high = (np.array(made.evaluated_get(bpy.context.evaluated_depsgraph_get()).bound_box)[k, 2] for k in (0, 1))
    top = places(obj)[:, 2].max()
    assert low == pytest.approx(-top, abs=0.1) and high == pytest.approx(top + 1, abs=0.1)


def raised_half(*kinds):
    """A half ball that modifiers complete, then a bone raises where it is above the middle; and the bone's rig."""
    obj = sphere()
    bpy.ops.object.armature_add()
    rig = bpy.context.active_object
    obj.vertex_groups.new(name="Bone").add([v.index for v in obj.data.vertices if v.co.z > 0], 1.0, "REPLACE")
    for kind in kinds:
        modifier = obj.modifiers.new(kind.title(), kind)
        if kind == "ARMATURE":
            modifier.object = rig
        elif kind == "MIRROR":
            modifier.use_bisect_axis = (True, False, False)
    rig.pose.bones["Bone"].location = (0, 1, 0)
    make_active(obj)
    return obj, rig


@pytest.mark.parametrize("kinds", [("MIRROR", "ARMATURE"), ("ARMATURE", "SUBSURF"), ("SUBSURF", "ARMATURE")])
def test_a_pose_after_modifiers_that_change_faces_stays_one(kinds):
    """The quads are of the ball at rest, and posed as it is; at rest they are a ball again."""
    obj, rig = raised_half(*kinds)
    made, _ = made_from(obj, spacing=0.5)
    assert np.linalg.norm(places(made), axis=1) == pytest.approx(1, abs=0.05)
    assert [modifier.type for modifier in made.modifiers] == ["ARMATURE"] and made.modifiers[0].object == rig
    assert not quad_sources.has_changed(made, obj)

    def heights():
        bpy.context.view_layer.update()
        return np.array(made.evaluated_get(bpy.context.evaluated_depsgraph_get()).bound_box)[:2, 2]

    assert heights() == pytest.approx([-1, 2], abs=0.1)
    rig.pose.bones["Bone"].location = (0, 0, 0)
    assert heights() == pytest.approx([-1, 1], abs=0.1)
    assert not quad_sources.has_changed(made, obj)


def test_a_setting_of_what_shapes_the_quads_before_a_pose_counts():
    obj, rig = raised_half("MIRROR", "ARMATURE")
    displace = obj.modifiers.new("Displace", "DISPLACE")
    displace.strength = 0.1
    obj.modifiers.move(2, 1)
    made, _ = made_from(obj, spacing=0.5)
    rig.pose.bones["Bone"].location = (0, 0, 0)
    obj.modifiers.active = obj.modifiers["Mirror"]
    displace.show_expanded = not displace.show_expanded
    bpy.context.view_layer.update()
    assert not quad_sources.has_changed(made, obj)
    displace.strength = 0.3
    bpy.context.view_layer.update()
    assert quad_sources.has_changed(made, obj)


def test_a_pose_that_others_shape_later_is_part_of_the_quads():
    """A warning says so, and its remedy helps."""
    obj, _ = raised_half("ARMATURE", "MIRROR")
    made, report = made_from(obj, spacing=0.5)
    assert places(made)[:, 2].max() == pytest.approx(2, abs=0.1) and not made.modifiers
    (warning,) = [line for line in report["warnings"] if "pose" in line]
    assert "the pose of Armature is part of the quad mesh" in warning and "move Armature below Mirror" in warning
    make_active(obj)
    obj.modifiers.move(0, 1)
    made, report = made_from(obj, spacing=0.5)
    assert [modifier.type for modifier in made.modifiers] == ["ARMATURE"] and "pose" not in " ".join(report["warnings"])


def test_what_modifiers_have_shaped_is_not_shaped_again():
    obj = sphere()
    modifier = obj.modifiers.new("Flat", "CAST")
    modifier.cast_type, modifier.factor = "CUBOID", 0.5
    made, _ = made_from(obj, spacing=0.5, surface="seen")
    assert not made.modifiers
