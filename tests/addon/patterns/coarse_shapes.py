# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects whose faces are too coarse for a pattern, or whose modifiers make other faces."""

import importlib

import bpy
import numpy as np
import pytest

from ..scenes import add_group, added, attribute, hexagon_sphere, make_active, tube

bmesh = importlib.import_module("bmesh")  # on the path once bpy is loaded, as isort cannot know


def cube():
    bpy.ops.mesh.primitive_cube_add(size=2)
    return added("Cube")


def half_body():
    """The half of a ball that mirror, subdivision and walls make a body of."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=6)
    obj = added("Sphere")
    half = bmesh.new()
    half.from_mesh(obj.data)
    bmesh.ops.delete(half, geom=[v for v in half.verts if v.co.x < -1e-4], context="VERTS")
    half.to_mesh(obj.data)
    half.free()
    obj.data.shade_smooth()
    for kind in ("MIRROR", "SUBSURF", "SOLIDIFY"):
        obj.modifiers.new(kind.capitalize(), kind)
    obj.modifiers["Solidify"].thickness = 0.1
    obj.modifiers["Subsurf"].levels, obj.modifiers["Subsurf"].render_levels = 1, 2
    return obj


def rigged_tube():
    """A tube of eight sides whose upper half an armature bends from frame 1 to frame 20."""
    obj = tube(segments=8, rings=5, height=4.0)
    rig = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
    bpy.context.scene.collection.objects.link(rig)
    make_active(rig)
    bpy.ops.object.mode_set(mode="EDIT")
    for name, low in (("lower", 0), ("upper", 2)):
        bone = rig.data.edit_bones.new(name)
        bone.head, bone.tail = (0, 0, low), (0, 0, low + 2)
    rig.data.edit_bones["upper"].parent = rig.data.edit_bones["lower"]
    bpy.ops.object.mode_set(mode="OBJECT")
    heights = attribute(obj, "position")[:, 2]
    for name, chosen in (("lower", heights < 2.5), ("upper", heights >= 2)):
        add_group(obj, name, np.flatnonzero(chosen))
    obj.modifiers.new("Armature", "ARMATURE").object = rig
    bone = rig.pose.bones["upper"]
    bone.rotation_mode = "XYZ"
    for frame, angle in ((1, 0.0), (20, 1.0)):
        bone.rotation_euler = (angle, 0, 0)
        bone.keyframe_insert("rotation_euler", frame=frame)
    bpy.context.scene.frame_set(1)
    return make_active(obj)


def coarse_hexagons():
    return hexagon_sphere(2)


SHAPES = {
    "cube of 8 vertices": (cube, {"spacing": 0.3, "guidance": "axis:Z"}, "mesh"),
    "half a body": (half_body, {"spacing": 0.25}, "modifiers"),
    "rigged tube": (rigged_tube, {"spacing": 0.4, "guidance": "axis:Z"}, "mesh"),
    "sphere of hexagons": (coarse_hexagons, {"spacing": 0.25}, "mesh"),
}
BUILD = pytest.mark.parametrize(("build", "settings", "of"), SHAPES.values(), ids=SHAPES)


def bytes_of(mesh):
    """All that a mesh holds."""
    keys = [key.name for key in mesh.shape_keys.key_blocks] if mesh.shape_keys else []
    found = {a.name: (a.domain, a.data_type, _bytes(a)) for a in mesh.attributes}
    return found, [m and m.name for m in mesh.materials], keys, list(mesh.keys())


def _bytes(found):
    name = {"FLOAT_VECTOR": "vector", "FLOAT2": "vector"}.get(found.data_type, "value")
    return str([np.array(getattr(element, name)).tolist() for element in found.data])


def seen(obj):
    """What modifiers make of an object now."""
    return obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
