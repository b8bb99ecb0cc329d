# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh of a quad pattern's grid lines as an object, with the materials and attributes of the given mesh."""

import bpy
import numpy as np

from ...core.extract.quads.measure.loops import quad_loops
from ...core.extract.quads.measure.quality import quality
from ...core.geometry.barycentric import barycentric
from ...core.geometry.nearest import NearestTriangles
from ..blender import attributes, meshes
from ..blender.defect_empties import defect_empties
from ..blender.new_geometry import new_mesh
from ..blender.objects import hide
from ..blender.refined_mesh import carry_groups
from ..blender.schema import PREFIX
from ..blender.transaction import assign, leave
from ..nodes.materials import shows_pattern
from ..settings.fields import STORED_NAMES

# How far from a corner, towards the middle of its face, the values of corners are read: on the face's side of a seam.
_INSIDE = 0.05
# Places along an edge that have to be near to a sharp one, and how near, as shares of its length.
_ALONG, _NEAR = (0.1, 0.5, 0.9), 0.1
# What places an object, in an order in which it can be set: a parent resets its inverse.
_PLACE = (
    *("parent", "parent_type", "parent_bone", "parent_vertices", "use_parent_final_indices", "matrix_parent_inverse"),
    *("rotation_mode", "location", "rotation_euler", "rotation_quaternion", "rotation_axis_angle", "scale"),
    *("delta_location", "delta_rotation_euler", "delta_rotation_quaternion", "delta_scale"),
)


def write(obj, request, quads, selection, carrying, bending, replaced=None):
    """Make the object, show it instead of the given one, and return its figures for the report.

    ``carrying`` is the object whose mesh was solved on: the given one, or one with a surface of the pattern's own.
    ``bending`` are modifiers that have not shaped that mesh, and bend the new one, too.
    ``replaced`` is an earlier quad mesh of the object, which gets the new faces.
    """
    mesh = request.given.mesh
    points = quads.vertices @ np.linalg.inv(request.given.stretch).T
    if replaced is not None and replaced.data.users == 1:
        leave([replaced.data])
    data = new_mesh(f"{obj.data.name} Quads", points, quads.corner_vertices, quads.sizes, smooth=True)
    if replaced is None:
        made = _new_object(obj, data)
        for modifier in bending:
            _copy(modifier, made)
    else:
        made = replaced
        assign(made, "data", data)
        assign(made, "scale", obj.scale)  # of the source as it is now
    surface = mesh.finder
    centres = np.add.reduceat(quads.vertices[quads.corner_vertices], quads.starts) / quads.sizes[:, None]
    at_centres, under = surface.nearby(centres)
    _carry(carrying, made, request.given, quads, centres, under, surface)
    data.update()
    _show_instead(obj, made, selection)
    given = np.delete(mesh.vertices, mesh.loose_vertices, axis=0)
    back, _ = NearestTriangles(quads.vertices, meshes.read_polygons(made).triangles).nearby(given)
    apart = np.linalg.norm(back - given, axis=1)
    distance = max(np.linalg.norm(at_centres - centres, axis=1).max(), apart.max())
    return {"object": made.name, **quality(quads), **quad_loops(quads).figures, "hausdorff_distance": float(distance)}


def _new_object(obj, data):
    """An object for a quad mesh, in the place of the given one and with its settings."""
    made = bpy.data.objects.new(f"{obj.name} Quads", data)
    for name in _PLACE:  # in the same place as the given one: a parent may shear it
        setattr(made, name, getattr(obj, name))
    for constraint in obj.constraints:
        made.constraints.copy(constraint)
    for collection in obj.users_collection:
        collection.objects.link(made)
    if hasattr(obj, "synch"):  # as long as the extension is registered
        for name in STORED_NAMES:
            setattr(made.synch, name, getattr(obj.synch, name))
        made.synch.source = obj
        made.synch_simple.kind = "quad_mesh"
    return made


def _copy(modifier, made):
    """Give an object a modifier like another one's."""
    copy = made.modifiers.new(modifier.name, modifier.type)
    for setting in modifier.bl_rna.properties:
        if not setting.is_readonly:
            setattr(copy, setting.identifier, getattr(modifier, setting.identifier))


def _carry(obj, made, given, quads, centres, under, surface):
    """Materials, vertex groups and attributes go over: those of vertices and corners interpolated, those of faces from
    the face under the middle. Where a quad lies across a UV seam its coordinates are those of both sides."""
    kept = [None if shows_pattern(slot.material) else slot.material for slot in obj.material_slots]
    for material in kept if any(kept) else ():
        made.data.materials.append(material)
    corners = given.source[given.mesh.triangles[quads.triangles]]
    faces = given.polygons.triangle_faces[under]
    pulled = quads.vertices[quads.corner_vertices]
    pulled = pulled + _INSIDE * (centres[quads.corner_faces] - pulled)
    _, triangles = surface.nearest(pulled)
    weights = barycentric(given.mesh, triangles, quads.vertices[quads.corner_vertices])
    loops = given.polygons.triangle_corners[triangles]
    for attribute in list(obj.data.attributes):
        name, domain, data_type = attribute.name, attribute.domain, attribute.data_type
        if name.startswith((".", PREFIX)) or name == "position":
            continue
        values = attributes.read_values(obj, name, domain)
        if values is None or (domain != "FACE" and values.dtype.kind != "f"):  # nothing that can be averaged
            continue
        if domain == "POINT":
            values = np.einsum("nk,nk...->n...", quads.weights, values[corners])
        elif domain == "CORNER":
            values = np.einsum("nk,nk...->n...", weights, values[loops])
        elif domain == "FACE":
            values = values[faces]
        else:
            continue
        attributes.write_attribute(made, name, domain, data_type, values)
    attributes.show_same_maps(obj, made)
    carry_groups(obj, made, corners, quads.weights)
    _mark_sharp(obj, made)


def _mark_sharp(obj, made):
    """Mark the edges along those that are marked sharp on the given mesh, so that both are shaded alike."""
    marked = attributes.read_marked_edges(obj, "sharp")
    if len(marked) == 0:
        return
    lines = NearestTriangles(meshes.measured_places(obj), marked[:, [0, 1, 1]])
    ends = meshes.measured_places(made)[attributes.read_values(made, ".edge_verts", "EDGE")]
    ways = ends[:, 1] - ends[:, 0]
    places = ends[:, :1] + np.array(_ALONG)[None, :, None] * ways[:, None]
    apart = np.linalg.norm(lines.nearest(places.reshape(-1, 3))[0].reshape(places.shape) - places, axis=2).max(axis=1)
    attributes.write_attribute(made, "sharp_edge", "EDGE", "BOOLEAN", apart <= _NEAR * np.linalg.norm(ways, axis=1))


def _show_instead(obj, made, selection):
    """The given object is hidden, and the new one active and selected unless another one is by now."""
    made.display_type, made.show_wire = obj.display_type, True  # smooth faces without edges do not look like quads
    assign(obj, "hide_render", True)
    layer = bpy.context.view_layer
    if obj.name in layer.objects:
        hide(obj, True)
        for empty in defect_empties(obj):
            if empty.name in layer.objects:
                hide(empty, True)
    if made.name in layer.objects:
        selection.give_to([made])
    layer.update()  # so that its place in the world is known at once
