# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that show the layers of a solid: the layers, their dislocation curves, and the phase on a surface.

A second run of the same object gives these objects new data: what the user has made of them, their materials and
modifiers, stays.
"""

from functools import partial

import bpy
import numpy as np
from mathutils import Matrix

from ...core.errors import SynchError
from ...core.geometry.mesh_input import MeshInput
from ...core.geometry.polygons import Polygons
from ..blender import attributes, meshes, schema
from ..blender.defect_empties import KINDS, DefectEmpty, write_defects
from ..blender.new_geometry import add_spline, new_mesh
from ..blender.objects import hide, set_mode
from ..blender.transaction import assign, at_the_end, drop, leave, store, undone_by
from ..nodes.layers import curve_material, layer_material, open_layers
from ..nodes.materials import pattern_material
from ..patterns import write
from ..patterns.former_pattern import remove_former
from .links import MADE, SOLID, made_of

# Radius of a dislocation curve, in spacings.
_RADIUS = 0.06


def write_all(obj, layering, result, given, warn, spacing):
    """Make or fill anew the objects that show a :class:`SolidResult`.

    Returns them by their kinds: None for "curves" where there are none, the object itself for "surface" where its own
    mesh carries the phase.
    """
    _leave_modes(obj)
    keep_made(obj)
    made = {
        "layers": _write_layers(obj, layering),
        "curves": _write_curves(obj, layering, spacing),
        "surface": _write_surface(obj, layering, given, result.phases, warn, spacing),
    }
    ends = [DefectEmpty("dislocation", end.face, end.index, end.position, end.normal) for end in result.ends]
    write_defects(made["layers"], ends, kinds=KINDS, length=spacing)
    for kind, one in made.items():
        if one in (None, obj):
            _remove(obj, kind)
    return made


def keep_made(obj):
    """Restore the data of the objects made for an object if the work fails."""
    before = [(made, made.data, made.matrix_world.copy()) for made in _all_made(obj)]

    def give_back():
        for made, data, matrix in before:
            made.data, made.matrix_world = data, matrix

    undone_by(obj, give_back)
    at_the_end(lambda: bpy.data.batch_remove([data for _, data, _ in before if not data.users]))


def _leave_modes(obj):
    """Bring the objects of an earlier run into object mode: in other modes Blender gives them no new data."""
    active = bpy.context.view_layer.objects.active
    for made in _all_made(obj):
        if made.mode != "OBJECT" and active is not None and active.mode == made.mode:
            undone_by(made, partial(set_mode, active, made.mode))
            set_mode(active, "OBJECT")
        if made.mode != "OBJECT":
            raise SynchError(f"{made.name} is in another mode and not active: make it the active object, or leave it")


def _write_layers(obj, layering):
    """The layers as one mesh object with the face attribute ``synch_layer``."""
    surfaces = layering.surfaces
    data = new_mesh(f"{obj.data.name} Layers", surfaces.vertices, surfaces.triangles, smooth=True)
    made = place_object(obj, "layers", f"{obj.name} Layers", data, layering.matrix)
    attributes.write(made, schema.LAYER, surfaces.layers)
    layer_material(made, surfaces.count)
    open_layers(made)
    return made


def _write_curves(obj, layering, spacing):
    """The dislocation curves as a curve object, or None where there are none."""
    if not layering.curves:
        return None
    data = bpy.data.curves.new(f"{obj.data.name} Dislocations", "CURVE")
    data.dimensions, data.bevel_resolution, data.use_fill_caps = "3D", 2, True
    data.bevel_depth = _RADIUS * spacing
    for curve in layering.curves:
        add_spline(data, curve.smooth_points, is_closed=curve.is_closed)
    made = place_object(obj, "curves", f"{obj.name} Dislocations", data, layering.matrix)
    curve_material(made)
    return made


def _write_surface(obj, layering, given, phases, warn, spacing):
    """The phase on the given mesh, or on a new object of the solid's boundary; returns the object that has it."""
    if phases.is_own:
        mesh = phases.mesh
        data = new_mesh(f"{obj.data.name} Surface", mesh.vertices, mesh.triangles, smooth=True)
        shown = place_object(obj, "surface", f"{obj.name} Surface", data, layering.matrix)
        given = MeshInput(mesh, Polygons.of_triangles(mesh), np.eye(3), mesh, np.arange(mesh.vertex_count))
    else:
        shown = obj
        remove_former(obj)
    write.write_phases(shown, given, phases.edge_phases, warn)
    pattern_material(shown, "stripes", spacing=spacing, assign_faces=phases.is_own)
    if shown == obj:
        for earlier in (schema.DIRECTION, schema.SINGULARITY):  # of a field on the surface
            attributes.remove_attribute(obj, earlier.name)
        write_defects(obj, (), kinds=KINDS)
    meshes.update(shown)
    return shown


def hidden(obj):
    """Whether an object and what was made for it are hidden in the view layer and the render, by their numbers."""
    return {one.session_uid: (one.hide_get(), one.hide_render) for one in (obj, *_all_made(obj))}


def show_layers(obj, made, before, selection):
    """Show the layers instead of the object and its surface, and select them.

    What the user has hidden or shown since :func:`hidden` was ``before`` stays as it is, and what is selected where
    another object is active than at the :class:`Selection`.
    """
    layer = bpy.context.view_layer
    layer.update()  # forgets what has been removed
    now, layers = hidden(obj), made["layers"]
    for one in {obj, made["surface"], layers}:
        if now[one.session_uid] != before.get(one.session_uid, now[one.session_uid]):
            continue
        if one != layers:
            assign(one, "hide_render", True)
        if one.name in layer.objects:
            hide(one, one != layers)
    if layers.name in layer.objects:
        selection.give_to([layers])
    layer.update()


def place_object(obj, kind, name, data, matrix):
    """The object of a kind that an earlier run has made, with new data, or a new one; after :func:`keep_made`."""
    made = made_of(obj, kind)
    if made is None:
        made = bpy.data.objects.new(name, data)
        for collection in obj.users_collection:
            collection.objects.link(made)
        made[SOLID] = obj
        store(obj, MADE[kind], made)
    else:
        for slot in made.material_slots:
            data.materials.append(slot.material)
        made.data = data
    made.matrix_world = Matrix(matrix)
    return made


def _all_made(obj):
    """Objects that earlier runs have made for an object."""
    return [made for kind in MADE if (made := made_of(obj, kind)) is not None]


def _remove(obj, kind):
    made = made_of(obj, kind)
    if made is not None:
        data = made.data
        leave([made])
        at_the_end(lambda: None if data.users else bpy.data.batch_remove([data]))
    drop(obj, MADE[kind])
