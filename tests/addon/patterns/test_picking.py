# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A click on a modified object picks the vertex of its own mesh that is seen there."""

import bpy
import numpy as np
import pytest
from mathutils import Vector

from synch_fields.synch_addon import api
from synch_fields.synch_addon.patterns.picking import PickedSurface

from ..scenes import places, sphere


def reduced(obj):
    obj.modifiers.new("Fewer", "DECIMATE").ratio = 0.3


def subdivided(obj):
    obj.modifiers.new("More", "SUBSURF").levels = 2


def raised(obj):
    api.stripes(obj, spacing=0.5)
    api.relief(obj, level=2)


def moved(obj):
    """Carried far away by an armature's bone, then with other faces."""
    bpy.ops.object.armature_add()
    rig = bpy.context.active_object
    (bone,) = rig.pose.bones
    obj.vertex_groups.new(name=bone.name).add(range(len(obj.data.vertices)), 1.0, "REPLACE")
    obj.modifiers.new("Rig", "ARMATURE").object = rig
    bone.location.x = 5
    subdivided(obj)
    bpy.context.view_layer.update()


@pytest.mark.parametrize("modify, offset", [(reduced, 0), (subdivided, 0), (raised, 0), (moved, 5)])
def test_the_vertex_under_the_mouse_is_one_of_the_mesh_itself(modify, offset):
    obj = sphere()
    modify(obj)
    shown = [modifier.show_viewport for modifier in obj.modifiers]
    surface = PickedSurface.of(obj)
    there = places(obj) + (offset, 0, 0)
    for vertex in range(0, len(there), 7):
        outwards = Vector(places(obj)[vertex] + (1e-4, 2e-4, 3e-4))
        origin = Vector(there[vertex]) + 2 * outwards
        assert surface.vertex_at(origin, -outwards) == vertex
        assert surface.vertex_at(origin, outwards) is None
    assert [modifier.show_viewport for modifier in obj.modifiers] == shown
    np.testing.assert_allclose(surface.places, there, atol=1e-5)


@pytest.mark.parametrize("modify, offset", [(reduced, 0), (subdivided, 0), (moved, 5)])
def test_a_place_on_what_is_seen_is_found_on_the_mesh_itself(modify, offset):
    obj = sphere()
    modify(obj)
    surface = PickedSurface.of(obj)
    own = places(obj)
    for face in range(0, len(obj.data.polygons), 11):
        corners = own[list(obj.data.polygons[face].vertices)]
        inside = np.array([0.5, 0.3, 0.2]) @ corners
        outwards = Vector(inside)
        seen, found = surface.place_at(Vector(inside + (offset, 0, 0)) + 2 * outwards, -outwards)
        np.testing.assert_allclose(found, inside, atol=1e-5)
        np.testing.assert_allclose(seen, inside + (offset, 0, 0), atol=1e-5)
    assert surface.place_at(Vector((offset, 0, 9)), Vector((0, 0, 1))) is None
    np.testing.assert_allclose(surface.nearest(1.5 * own[:5]), own[:5], atol=0.02)
