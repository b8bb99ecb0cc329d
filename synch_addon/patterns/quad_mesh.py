# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh of a quad pattern's grid lines as an object, on the surface and with what the given mesh carries."""

from dataclasses import replace

import bpy
import numpy as np

from ...core.errors import SettingError
from ...core.extract.quad_quality import quality
from ..blender import attributes, groups
from ..blender.bvh import nearest, surface_tree
from ..blender.defect_empties import defect_empties
from ..nodes.materials import shows_pattern
from ..settings.fields import PROPERTY_NAMES

# Shares of the way to the middle of its neighbours that a vertex moves at once, forth and back: uneven places are
# smoothed, and little shrinks (after Taubin 1995).
_STEPS = 0.5, -0.4
# A vertex nearer than this to a mirror plane, as a share of the object's size, lies on it.
_ON_PLANE = 1e-5
# Cosine of the angle between the normals of neighbours beyond which both stay where they are: rims keep their shape.
_SHARP = 0.5
# A vertex of the quad mesh nearer to an edge than this, as a barycentric coordinate, lies on it.
_ON_EDGE = 1e-3
# How far from a corner, towards the middle of its face, the values of corners are read: on the face's side of a seam.
_INSIDE = 0.05
# Types whose values can be averaged; the others are taken from one face.
_SMOOTH = {"FLOAT", "FLOAT2", "FLOAT_VECTOR", "FLOAT_COLOR", "BYTE_COLOR"}


def smoothed(quads, task):
    """Vertices moved towards the middle of their neighbours and back onto the surface, as often as the task says.

    Those on the boundary, on lines that were asked for, on mirror planes and at sharp edges stay there. Refuses a
    pattern without any face, one whose faces would meet themselves, and one that loses a handle.
    """
    if len(quads.sizes) == 0:
        raise SettingError("no grid lines cross on the mesh: reduce the spacing")
    if not quads.is_simple:
        raise SettingError("the quads are too large for the mesh, some would meet themselves: reduce the spacing")
    mesh = task.given.mesh
    if not mesh.boundary_vertices.any() and quads.euler_characteristic > mesh.euler_characteristic:
        raise SettingError("the quads are too large for the mesh, a handle of it would be lost: reduce the spacing")
    edges, counts = quads.edges
    free = ~_on_lines(quads, mesh, task.rows)
    free[edges[counts == 1]] = False
    in_object = quads.vertices @ np.linalg.inv(task.given.stretch).T
    for axis in task.settings.mirror:
        free &= np.abs(in_object[:, "XYZ".index(axis)]) > _ON_PLANE * np.ptp(in_object, axis=0).max()
    normals = mesh.face_normals[quads.triangles]
    free[edges[np.einsum("ij,ij->i", normals[edges[:, 0]], normals[edges[:, 1]]) < _SHARP]] = False
    tree = surface_tree(mesh.vertices, mesh.triangles)
    degrees = np.bincount(edges.ravel(), minlength=len(quads.vertices))[:, None]
    for _ in range(task.settings.smoothing):
        for step in _STEPS:
            sums = np.zeros_like(quads.vertices)
            np.add.at(sums, edges[:, 0], quads.vertices[edges[:, 1]])
            np.add.at(sums, edges[:, 1], quads.vertices[edges[:, 0]])
            moved = quads.vertices + step * (sums / degrees - quads.vertices)
            places, triangles = nearest(tree, moved[free])
            quads = _moved(quads, mesh, free, places, triangles)
    return quads


def _on_lines(quads, mesh, rows):
    """(n,) bool: vertices on edges or at vertices of rows that ask for a grid line."""
    held = np.zeros(mesh.vertex_count, bool)
    for row in rows:
        if row.is_of_phases:
            held[row.line.nodes] = True
    return (held[mesh.triangles[quads.triangles]] | (quads.weights < _ON_EDGE)).all(axis=1)


def _moved(quads, mesh, which, places, triangles):
    """The quad mesh with some vertices at other places of the surface."""
    weights = barycentric(mesh, triangles, places)
    result = replace(quads, **{n: getattr(quads, n).copy() for n in ("vertices", "triangles", "weights")})
    result.vertices[which], result.triangles[which], result.weights[which] = places, triangles, weights
    return result


def barycentric(mesh, triangles, places):
    """(k, 3) barycentric coordinates of places in the planes of triangles, negative beyond a side."""
    corners = mesh.vertices[mesh.triangles[triangles]]
    normals = mesh.face_normals[triangles]
    weights = np.stack([_double_areas(places, corners[:, k - 2], corners[:, k - 1], normals) for k in range(3)], axis=1)
    sums = weights.sum(axis=1, keepdims=True)
    return np.divide(weights, sums, out=np.full_like(weights, 1 / 3), where=sums > 0)


def _double_areas(a, b, c, normals):
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), normals)


def write(obj, task, quads):
    """Make the object, show it instead of the given one, and return its figures for the report."""
    mesh = task.given.mesh
    data = bpy.data.meshes.new(f"{obj.data.name} Quads")
    inverse = np.linalg.inv(task.given.stretch)
    ends = np.cumsum(quads.sizes)
    faces = [quads.corner_vertices[start:end].tolist() for start, end in zip(quads.starts, ends, strict=True)]
    data.from_pydata((quads.vertices @ inverse.T).tolist(), [], faces, shade_flat=False)
    made = bpy.data.objects.new(f"{obj.name} Quads", data)
    # In the same place as the given one: a parent may shear it.
    made.parent, made.parent_type, made.parent_bone = obj.parent, obj.parent_type, obj.parent_bone
    made.matrix_parent_inverse, made.matrix_basis = obj.matrix_parent_inverse, obj.matrix_basis
    for collection in obj.users_collection:
        collection.objects.link(made)
    if hasattr(obj, "synch"):  # as long as the extension is registered
        for name in (*PROPERTY_NAMES, "automatic_spacing"):
            setattr(made.synch, name, getattr(obj.synch, name))
    tree = surface_tree(mesh.vertices, mesh.triangles)
    centres = np.add.reduceat(quads.vertices[quads.corner_vertices], quads.starts) / quads.sizes[:, None]
    at_centres, under = nearest(tree, centres)
    _carry(obj, made, task.given, quads, centres, under, tree)
    data.update()
    _show_instead(obj, made)
    back, _ = nearest(surface_tree(quads.vertices, faces), np.delete(mesh.vertices, mesh.loose_vertices, axis=0))
    apart = np.linalg.norm(back - np.delete(mesh.vertices, mesh.loose_vertices, axis=0), axis=1)
    distance = max(np.linalg.norm(at_centres - centres, axis=1).max(), apart.max())
    return {"object": made.name, **quality(quads), "hausdorff_distance": float(distance)}


def _carry(obj, made, given, quads, centres, under, tree):
    """Materials, vertex groups and attributes go over: those of vertices and corners interpolated, those of faces from
    the face under the middle. Where a quad lies across a UV seam its coordinates are those of both sides."""
    kept = [None if shows_pattern(slot.material) else slot.material for slot in obj.material_slots]
    for material in kept if any(kept) else ():
        made.data.materials.append(material)
    corners = given.source[given.mesh.triangles[quads.triangles]]
    faces = given.polygons.triangle_faces[under]
    pulled = quads.vertices[quads.corner_vertices]
    pulled = pulled + _INSIDE * (centres[quads.corner_faces] - pulled)
    _, triangles = nearest(tree, pulled)
    weights = barycentric(given.mesh, triangles, quads.vertices[quads.corner_vertices])
    loops = given.polygons.triangle_corners[triangles]
    for attribute in list(obj.data.attributes):
        name, domain, data_type = attribute.name, attribute.domain, attribute.data_type
        if name.startswith((".", "synch_")) or name == "position":
            continue
        values = attributes.read_values(obj, name, domain)
        if values is None or (domain != "FACE" and data_type not in _SMOOTH):
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
    for group in obj.vertex_groups:
        weights = groups.read_weights(obj, group.name)[corners]
        groups.write_weights(made, group.name, np.einsum("nk,nk->n", quads.weights, weights))


def _show_instead(obj, made):
    """The new object is active and selected, the given one hidden, where the scene lets it."""
    made.display_type = obj.display_type
    obj.hide_render = True
    layer = bpy.context.view_layer
    if obj.name in layer.objects:
        obj.select_set(False)
        obj.hide_set(True)
        for empty in defect_empties(obj):
            if empty.name in layer.objects:
                empty.hide_set(True)
    if made.name in layer.objects:
        made.select_set(True)
        layer.objects.active = made
    layer.update()  # so that its place in the world is known at once
