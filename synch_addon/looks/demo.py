# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo's input: Blender's own Suzanne as one smooth, evenly meshed surface of some 10k vertices."""

import bpy

_VOXEL = 0.0335
_SMOOTHING = 4


def add_demo_object(coarseness=1.0):
    """Add the remeshed Suzanne to the scene and return it, with edges that are longer by a factor."""
    bpy.ops.mesh.primitive_monkey_add(size=2.0)
    obj = bpy.context.active_object
    obj.name = obj.data.name = "Suzanne"
    subdivision = obj.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels = subdivision.render_levels = 2
    remesh = obj.modifiers.new("Remesh", "REMESH")
    remesh.mode, remesh.voxel_size = "VOXEL", _VOXEL * coarseness
    smooth = obj.modifiers.new("Smooth", "SMOOTH")
    smooth.factor, smooth.iterations = 0.5, _SMOOTHING
    obj.modifiers.new("Triangulate", "TRIANGULATE")
    apply_modifiers(obj)
    bpy.ops.object.shade_smooth()
    return obj


def apply_modifiers(obj):
    """Apply all modifiers of the active object, whatever the scene's Simplify says."""
    render = bpy.context.scene.render
    simplified, render.use_simplify = render.use_simplify, False
    for name in [modifier.name for modifier in obj.modifiers]:
        bpy.ops.object.modifier_apply(modifier=name)
    render.use_simplify = simplified
