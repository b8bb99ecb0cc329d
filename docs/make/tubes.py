# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of an object with lines on it, drawn as tubes."""

import bpy

from synch_fields.synch_addon.blender.new_geometry import add_spline
from synch_fields.synch_addon.blender.transaction import only_for_now
from synch_fields.synch_addon.looks.render import picture_scene, render_scene
from synch_fields.synch_addon.nodes.canvas import surface_material


def render_with_tubes(obj, lines, path, *, color, radius, resolution, samples, view):
    """Render an object with (n, 3) lines of its own space, as tubes of a colour, to an image file.

    The radius is a share of the object's longest side; other arguments as of ``render_picture``.
    """
    with only_for_now():
        scene, _ = picture_scene(obj, resolution=resolution, markers=False, edges=False, view=view)
        tubes = tubes_along(lines, radius * max(obj.dimensions), color)
        tubes.matrix_world = obj.matrix_world
        scene.collection.objects.link(tubes)
        render_scene(scene, path, resolution, samples)
    return path


def tubes_along(lines, radius, color):
    """A curve object that no scene holds yet, with a tube around each of some (n, 3) lines."""
    curve = bpy.data.curves.new("Tubes", "CURVE")
    curve.dimensions, curve.bevel_depth, curve.bevel_resolution, curve.use_fill_caps = "3D", radius, 3, True
    for points in lines:
        add_spline(curve, points)
    material, surface, _ = surface_material("Tubes")
    surface.inputs["Base Color"].default_value = color
    curve.materials.append(material)
    return bpy.data.objects.new("Tubes", curve)
