# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where quad meshes lie whose object is placed by vertices of a parent, constraints, deltas or a mirroring scale."""

import bpy
import numpy as np
import pytest

from synch_fields.synch_addon.patterns import memory

from ..quad_meshes import made_from
from ..scenes import make_active, sphere


def _at_vertices(obj, other):
    obj.parent, obj.parent_type, obj.parent_vertices = other, "VERTEX_3", (1, 5, 7)


def _constrained(obj, other):
    obj.constraints.new("COPY_TRANSFORMS").target = other
    obj.constraints.new("CHILD_OF").influence = 0.5


def _by_deltas(obj, _other):
    obj.delta_location, obj.delta_rotation_euler, obj.delta_scale = (1, 2, 3), (0.3, 0.2, 0.1), (2, 1, 0.5)
    obj.scale, obj.rotation_euler = (1, 1, -3), (0.1, -0.4, 0.2)


def _by_quaternions(obj, _other):
    obj.rotation_mode = "QUATERNION"
    obj.rotation_quaternion, obj.delta_rotation_quaternion = (0.5, 0.5, -0.5, 0.5), (0.8, 0.6, 0, 0)


@pytest.mark.parametrize("place", [_at_vertices, _constrained, _by_deltas, _by_quaternions])
def test_quads_lie_where_the_object_lies_also_when_they_are_made_again(place):
    bpy.ops.mesh.primitive_cube_add(location=(1, 2, 3), rotation=(0.2, 0.3, 0.4))
    other, obj = bpy.context.active_object, sphere()
    place(obj, other)
    bpy.context.view_layer.update()
    made, _ = made_from(obj, faces=200)
    assert np.allclose(made.matrix_world, obj.matrix_world, atol=1e-5)
    other.location.z += 1
    bpy.context.view_layer.update()
    assert np.allclose(made.matrix_world, obj.matrix_world, atol=1e-5)
    make_active(made)
    assert not memory.is_outdated(made)
    assert bpy.ops.synch.quad_mesh_again() == {"FINISHED"}
    bpy.context.view_layer.update()
    assert np.allclose(made.matrix_world, obj.matrix_world, atol=1e-5)
