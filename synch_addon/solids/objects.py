# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that show the layers of a solid: the layers, their dislocation curves, and the phase on a surface.

A second run of the same object gives these objects new data: what the user has made of them, their materials and
modifiers, stays.
"""

import bpy
import numpy as np
from mathutils import Matrix

from ...core.errors import SynchError
from ...core.geometry import mesh_input
from ...core.geometry.nearest import NearestTriangles
from ..blender import attributes, meshes, schema
from ..blender.defect_empties import KINDS, Defect, write_defects
from ..nodes.layers import curve_material, layer_material
from ..nodes.materials import pattern_material
from ..patterns import memory, write
from .links import MADE, SOLID, made_of

# Radius of a dislocation curve, in spacings.
_RADIUS = 0.06


def leave_modes(obj):
    """Bring what an earlier run has made for an object into object mode: elsewhere Blender gives it no new data."""
    active = bpy.context.view_layer.objects.active
    for made in filter(None, (made_of(obj, kind) for kind in MADE)):
        if made.mode != "OBJECT" and active is not None and active.mode == made.mode:
            bpy.ops.object.mode_set(mode="OBJECT")
        if made.mode != "OBJECT":
            raise SynchError(f"{made.name} is in another mode and not active: make it the active object, or leave it")


def write_layers(obj, layering, spacing):
    """The layers as one mesh object with the face attribute ``synch_layer``, which is shown instead of the given one.

    Returns the object.
    """
    surfaces = layering.surfaces
    data = bpy.data.meshes.new(f"{obj.data.name} Layers")
    data.from_pydata(surfaces.vertices.tolist(), [], surfaces.triangles.tolist())
    data.shade_smooth()
    made = placed(obj, "layers", f"{obj.name} Layers", data, layering.matrix)
    attributes.write(made, schema.LAYER, surfaces.layers)
    layer_material(made, surfaces.count)
    write_defects(made, _ends(layering), kinds=KINDS, length=spacing)
    return made


def _ends(layering):
    """The places where dislocation curves leave the solid, by the right hand: positive where they come out."""
    solid, surfaces = layering.solid, layering.surfaces
    ends = [
        (curve.points[place], curve.faces[place], sign * curve.index)
        for curve in layering.curves
        if not curve.is_closed
        for place, sign in ((0, -1), (-1, 1))
    ]
    if not ends:
        return []
    _, faces = NearestTriangles(surfaces.vertices, surfaces.triangles).nearest([end[0] for end in ends])
    rows = np.searchsorted(solid.boundary_faces, [end[1] for end in ends])
    a, b, c = np.moveaxis(solid.vertices[solid.boundary_triangles[rows]], 1, 0)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return [
        Defect("dislocation", int(face), index, tuple(point.tolist()), tuple(normal.tolist()))
        for (point, _, index), face, normal in zip(ends, faces, normals, strict=True)
    ]


def write_curves(obj, layering, spacing):
    """The dislocation curves as a curve object, or None where there are none."""
    if not layering.curves:
        _remove(obj, "curves")
        return None
    data = bpy.data.curves.new(f"{obj.data.name} Dislocations", "CURVE")
    data.dimensions, data.bevel_resolution, data.use_fill_caps = "3D", 2, True
    data.bevel_depth = _RADIUS * spacing
    for curve in layering.curves:
        points = curve.smooth_points
        spline = data.splines.new("POLY")
        spline.points.add(len(points) - 1)
        spline.points.foreach_set("co", np.column_stack([points, np.ones(len(points))]).astype(np.float32).ravel())
        spline.use_cyclic_u = curve.is_closed
    made = placed(obj, "curves", f"{obj.name} Dislocations", data, layering.matrix)
    curve_material(made)
    return made


def write_surface(obj, layering, given, phases, warn, spacing):
    """The phase on the given mesh, or on a new object of the solid's boundary; returns the object that has it."""
    if phases.is_own:
        data = bpy.data.meshes.new(f"{obj.data.name} Surface")
        data.from_pydata(phases.mesh.vertices.tolist(), [], phases.mesh.triangles.tolist())
        data.shade_smooth()
        shown = placed(obj, "surface", f"{obj.name} Surface", data, layering.matrix)
        given = mesh_input.MeshInput(
            phases.mesh, meshes.read_polygons(shown), np.eye(3), phases.mesh, np.arange(phases.mesh.vertex_count)
        )
    else:
        _remove(obj, "surface")
        shown = obj
        for earlier in (schema.DIRECTION, schema.SINGULARITY):  # of a field on the surface
            attributes.remove_attribute(obj, earlier.name)
        write_defects(obj, (), kinds=KINDS)
        memory.show_nothing(obj)
    write.write_phases(shown, given, phases.edge_phases, warn)
    pattern_material(shown, "stripes", spacing=spacing, assign_faces=phases.is_own)
    meshes.update(shown)
    return shown


def show_layers(obj, made, others):
    """The layers are active and selected; the given object and others are hidden, where the scene lets it."""
    layer = bpy.context.view_layer
    layer.update()  # forgets what has been removed
    for other in layer.objects:
        other.select_set(False)
    for hidden in (obj, *others):
        hidden.hide_render = True
        if hidden.name in layer.objects:
            hidden.hide_set(True)
    if made.name in layer.objects:
        made.hide_set(False)
        made.select_set(True)
        layer.objects.active = made
    layer.update()


def placed(obj, kind, name, data, matrix):
    """The object of a kind that an earlier run has made, with new data, or a new one."""
    made = made_of(obj, kind)
    if made is None:
        made = bpy.data.objects.new(name, data)
        for collection in obj.users_collection:
            collection.objects.link(made)
        made[SOLID], obj[MADE[kind]] = obj, made
    else:
        old = made.data
        for slot in made.material_slots:
            data.materials.append(slot.material)
        made.data = data
        if not old.users:
            bpy.data.batch_remove([old])
    made.matrix_world = Matrix(matrix)
    return made


def _remove(obj, kind):
    made = made_of(obj, kind)
    if made is not None:
        data = made.data
        bpy.data.objects.remove(made)
        if not data.users:
            bpy.data.batch_remove([data])
    if MADE[kind] in obj:
        del obj[MADE[kind]]
