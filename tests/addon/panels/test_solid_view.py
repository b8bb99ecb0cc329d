# SPDX-License-Identifier: GPL-3.0-or-later
"""What Solid view draws of an object, read from its attributes, and of which objects."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from scipy.spatial import cKDTree

from synch_fields.synch_addon.blender import attributes
from synch_fields.synch_addon.panels import solid_view

from .. import scenes


@pytest.mark.parametrize("command", ["stripes", "quads"])
def test_triangles_have_the_phases_that_the_vertices_have(command):
    obj = scenes.quad_sphere(9)
    assert solid_view.corners_of(obj) is None
    getattr(bpy.ops.synch, command)(spacing=0.5)
    places, phases, of_quads = solid_view.corners_of(obj)
    assert of_quads == (command == "quads")
    vertices = attributes.read_values(obj, "position", "POINT")
    away, nearest = cKDTree(vertices).query(places)
    at = away < 1e-6
    heights = np.cos(phases).prod(axis=1)
    wanted = attributes.read_values(obj, "synch_pattern", "POINT")[nearest]
    assert at.sum() > 3 * len(vertices)
    np.testing.assert_allclose(heights[at], wanted[at], atol=2e-3)  # singular triangles are drawn a little inside
    corners = places.reshape(-1, 3, 3)
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    assert areas.sum() == pytest.approx(sum(face.area for face in obj.data.polygons), rel=0.02)  # faces are not flat


def test_what_modifiers_make_of_the_object_is_read():
    obj = scenes.quad_sphere(9)
    bpy.ops.synch.stripes(spacing=0.5)
    before, *_ = solid_view.corners_of(obj)
    obj.modifiers.new("smooth", "SUBSURF").levels = 1
    after, *_ = solid_view.corners_of(obj.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    assert len(after) > 3 * len(before)


def bent_by_a_shape_key(obj):
    obj.shape_key_add(name="Basis")
    key = obj.shape_key_add(name="bent")
    key.value = 0.0
    key.data.foreach_set("co", np.float32(scenes.places(obj) * [1, 1, 3]).ravel())
    return lambda: setattr(key, "value", 1.0)


def bent_in_time(obj):
    bend = bent_by_a_shape_key(obj)
    key = obj.data.shape_keys.key_blocks["bent"]
    key.keyframe_insert("value", frame=1)
    bend()
    key.keyframe_insert("value", frame=10)
    bpy.context.scene.frame_set(1)
    return lambda: bpy.context.scene.frame_set(10)


def bent_by_a_lattice(obj):
    data = bpy.data.lattices.new("Cage")
    cage = bpy.data.objects.new("Cage", data)
    bpy.context.collection.objects.link(cage)
    cage.scale = 4, 4, 4
    obj.modifiers.new("Cage", "LATTICE").object = cage

    def bend():
        for point in data.points:
            point.co_deform = (point.co[0], point.co[1], 2 * point.co[2])

    return bend


def bent_by_an_armature(obj):
    bpy.ops.object.armature_add()
    bone = bpy.context.object.pose.bones[0]
    obj.vertex_groups.new(name=bone.name).add(range(len(obj.data.vertices)), 1.0, "REPLACE")
    obj.modifiers.new("Rig", "ARMATURE").object = bone.id_data
    return lambda: setattr(bone, "scale", (1, 3, 1))  # its own y axis points up


@pytest.mark.parametrize("prepare", [bent_by_a_shape_key, bent_in_time, bent_by_a_lattice, bent_by_an_armature])
def test_the_ink_follows_the_shape_and_is_made_again_only_when_that_changes(prepare, monkeypatch):
    obj = scenes.quad_sphere(9)
    bpy.ops.synch.stripes(spacing=0.5)
    bend, made, cut = prepare(obj), [], []

    def drawn_of(places, phases, **_):
        made.append((places, phases))
        return made[-1]

    monkeypatch.setattr(solid_view, "DrawnPattern", drawn_of)
    of = solid_view.DrawnTriangles.of
    monkeypatch.setattr(solid_view.DrawnTriangles, "of", lambda *given: cut.append(1) or of(*given))
    for _ in range(3):
        bpy.context.view_layer.update()
        before = solid_view.drawn_pattern(obj, bpy.context.evaluated_depsgraph_get())
    assert len(made) == 1
    bend()
    bpy.context.view_layer.update()
    places, phases = solid_view.drawn_pattern(obj, bpy.context.evaluated_depsgraph_get())
    assert np.ptp(places[:, 2]) > 1.5 * np.ptp(before[0][:, 2])
    assert phases is before[1] and len(cut) == 1  # what does not depend on places is as it was


def test_only_objects_that_have_a_pattern_and_are_drawn_solid_are_shown():
    obj, plain = scenes.quad_sphere(5), scenes.grid(4)
    bpy.context.view_layer.objects.active = obj
    bpy.ops.synch.stripes(spacing=0.5)

    def shown():
        return list(solid_view.shown_objects(SimpleNamespace(visible_objects=[obj, plain])))

    assert shown() == [obj]
    obj.display_type = "WIRE"
    assert shown() == []


def test_the_switch_and_the_view_decide():
    view = next(a.spaces.active for screen in bpy.data.screens for a in screen.areas if a.type == "VIEW_3D")
    context = SimpleNamespace(space_data=view, scene=bpy.context.scene)
    view.shading.type, view.overlay.show_overlays = "SOLID", True
    assert solid_view.shows(context)
    bpy.context.scene.synch_overlay.pattern = False
    assert not solid_view.shows(context)
    bpy.context.scene.synch_overlay.pattern = True
    view.shading.type = "MATERIAL"
    assert not solid_view.shows(context)
