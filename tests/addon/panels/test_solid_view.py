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
