# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects of a solved flow: filaments as a curve, tubes as a mesh coloured by the sphere."""

import math

import bpy
import numpy as np

from ..blender import attributes
from ..blender.new_geometry import add_spline, fill_mesh, new_mesh
from ..blender.schema import COLOR, SPHERE
from ..blender.transaction import keep, store
from ..nodes.materials import pattern_material
from ..nodes.vortices import STRENGTH, add_filaments_modifier
from .memory import Filled


def make_filaments(name, shown):
    """A curve object with a spline for every filament."""
    data = bpy.data.curves.new(name, "CURVE")
    data.dimensions = "3D"
    made = bpy.data.objects.new(name, data)
    fill_filaments(made, shown)
    add_filaments_modifier(made, shown.thickness, shown.quantum)
    return made


def fill_filaments(obj, shown):
    """Put filaments into a curve object in place of what it has."""
    data = obj.data
    keep(data)
    store(obj, STRENGTH, shown.quantum)
    data.splines.clear()
    for line in shown.lines:
        parts = [line.course] if shown.unwrapped else line.parts
        for part in parts:
            spline = add_spline(data, part, is_closed=len(parts) == 1 and line.is_loop)
            # Thicker where several coincide.
            thickness = math.sqrt(line.strength / shown.quantum)
            spline.points.foreach_set("radius", np.full(len(part), thickness, np.float32))


def make_tubes(name, shown):
    """A mesh object with the tubes."""
    made = bpy.data.objects.new(name, new_mesh(name))
    fill_tubes(made, shown)
    pattern_material(made, "tubes")
    return made


def fill_tubes(obj, shown):
    """Put tubes into a mesh object in place of what it has; its materials stay."""
    data, tubes = obj.data, shown.tubes
    keep(data)
    store(obj, STRENGTH, tubes.strength)
    fill_mesh(data, tubes.vertices, tubes.triangles, smooth=True)
    write_sphere(obj, tubes.sphere)


def write_sphere(obj, points):
    """Write (n, 3) points of the sphere to the vertices of a mesh object, and the colours that they have."""
    attributes.write(obj, SPHERE, points)
    attributes.write(obj, COLOR, np.column_stack([0.5 + 0.5 * points, np.ones(len(points))]))


def present(objects, selection):
    """Put new objects into the scene, and select them, the last one active, unless another object is active by now than
    in the :class:`Selection` at the time when the flow was read."""
    for made in objects:
        bpy.context.scene.collection.objects.link(made)
    selection.give_to(objects)


def fill(result, _settings, objects):
    """Show a result in the objects that were made for its solve; returns the :class:`Filled`."""
    shown = result.shown
    for obj in objects:
        if obj.type == "CURVE" and shown.lines is not None:
            fill_filaments(obj, shown)
        elif obj.type == "MESH" and shown.tubes is not None:
            fill_tubes(obj, shown)
    return Filled(facts(shown), fill)


def facts(shown):
    """Entries of a report about the filaments and the tubes."""
    result = {}
    if shown.lines is not None:
        result["filaments"] = [
            {
                "strength": line.strength,
                "closed": line.is_closed,
                "winding": list(line.winding),
                "points": len(line.points),
                "length": line.length,
                "vorticity_share": line.share,
            }
            for line in shown.lines
        ]
        result["stubs"] = shown.stubs
        result["windings"] = sum(any(line.winding) for line in shown.lines)
    if shown.tubes is not None:
        result["tubes"] = {
            "faces": len(shown.tubes.triangles),
            "pieces": shown.tubes.pieces,
            "blobs": shown.tubes.blobs,
        }
    return result


def linking_facts(winding):
    """Entries of a report about a :class:`Linked`; {} for None."""
    if winding is None:
        return {}
    return {
        "loops": list(winding.loops),
        "linking": winding.numbers.tolist(),
        "writhe": winding.writhes.tolist(),
        "writhes": winding.all_writhes.tolist(),
        "helicity": winding.helicity,
    }
