# SPDX-License-Identifier: GPL-3.0-or-later
"""A finer copy of an object's mesh with everything that the mesh has, as an object that no scene shows."""

import bpy
import numpy as np

from ...core.graphs import find, pair_keys
from ...core.unit_vectors import unit_vectors
from . import attributes, groups, schema
from .new_geometry import new_mesh
from .objects import SURFACE_MARK

# Of a pattern itself nothing goes over but its directions, which guide.
_DIRECTION = schema.DIRECTION.name
# What Blender makes anew with the faces, and the normals, which are carried as vectors.
_MADE_ANEW = ("position", "custom_normal")
# Where triangles only lay side by side, normals within this cosine of their mean become one.
_ALIKE = np.cos(np.radians(20))


def refined_object(source, bound, owner, mark):
    """A new object with the mesh of a BoundSurface of another object, with the place of a third.

    Materials, vertex groups, marks of edges, UV maps, colours, all other attributes and custom normals are copied:
    real numbers are interpolated, other values are those of the nearest corner or vertex. Each vertex stores its three
    vertices of ``source`` and their weights.

    Parameters
    ----------
    bound : BoundSurface of its mesh
    owner : bpy.types.Object whose pattern the mesh is for
    mark : state of what the mesh is made of, for :data:`objects.SURFACE_MARK`
    """
    name = f"{owner.name} Surface"
    sizes = np.diff(bound.starts, append=len(bound.corner_vertices))
    data = new_mesh(name, bound.vertices, bound.corner_vertices, sizes, smooth=True)
    for slot in source.material_slots:
        data.materials.append(slot.material)
    made = bpy.data.objects.new(name, data)
    made.parent = owner
    made[SURFACE_MARK] = mark
    _carry_attributes(source, made, bound)
    _carry_normals(source, data, bound)
    carry_groups(source, made, bound.parents, bound.weights)
    for attribute, values in zip(schema.PARENTS, bound.parents.T, strict=True):
        attributes.write(made, attribute, values)
    attributes.write(made, schema.WEIGHTS, bound.weights)
    attributes.write(made, schema.SOURCE_FACE, bound.face_source)
    data.update()
    return made


def carry_groups(source, made, parents, weights):
    """Give an object the vertex groups of another one, of which (v, 3) vertices and their weights make each vertex."""
    made.vertex_groups.clear()
    members = groups.read_members(source)
    for group in source.vertex_groups:
        at_parents = groups.read_weights(source, group.name, members=members)[parents]
        groups.write_weights(made, group.name, np.einsum("vk,vk->v", weights, at_parents))


def _carry_attributes(source, made, bound):
    """Carry all but the pattern's attributes from the source to the finer mesh made of it."""
    edges = _edge_numbers(made, bound.edge_vertices)
    for attribute in list(source.data.attributes):
        name, domain, data_type = attribute.name, attribute.domain, attribute.data_type
        is_pattern = name.startswith(schema.PREFIX) and name != _DIRECTION
        if is_pattern or name[0] == "." or name in _MADE_ANEW:
            continue
        if data_type == "STRING":
            values = np.array([element.value for element in attribute.data], object)
        else:
            values = attributes.read_values(source, name, domain)
        if values is None:
            continue
        if domain == "FACE":
            values = values[bound.face_source]
        elif domain == "EDGE":
            values = _at_edges(values[bound.edge_source], edges, len(made.data.edges))
        else:
            of_corners = domain == "CORNER"
            parents = bound.corner_parents if of_corners else bound.parents
            values = _mean(values, parents, bound.corner_weights if of_corners else bound.weights, name)
        if data_type == "STRING":
            for element, value in zip(made.data.attributes.new(name, data_type, domain).data, values, strict=True):
                element.value = value
        else:
            attributes.write_attribute(made, name, domain, data_type, values)
    attributes.show_same_maps(source, made)


def _mean(values, parents, weights, name):
    """Values at places between three elements; directions that may point either way have no mean."""
    if values.dtype.kind == "f" and name != _DIRECTION:
        return np.einsum("vk,vk...->v...", weights, values[parents])
    return values[np.take_along_axis(parents, weights.argmax(axis=1)[:, None], axis=1)[:, 0]]


def _edge_numbers(made, pairs):
    """(e,) edges of a mesh by (e, 2) their vertices."""
    count, ends = len(made.data.vertices), attributes.read_all(made.data.edges, "vertices", 2).astype(np.int64)
    return find(pair_keys(ends, count), pair_keys(pairs, count))


def _at_edges(values, edges, count):
    """Values at all edges of a mesh from those of the source's edges: zero, or no text, inside its faces; an edge
    joined from several is marked if one of them is."""
    result = np.full((count, *values.shape[1:]), b"" if values.dtype == object else 0, values.dtype)
    if values.dtype == bool:
        result[edges[values]] = True
    else:
        result[edges] = values
    return result


def _carry_normals(source, data, bound):
    """Carry custom normals, and those of smooth faces that were divided: their parts are flat."""
    is_smooth = source.data.normals_domain != "FACE" and len(bound.starts) != len(source.data.polygons)
    if not (source.data.has_custom_normals or is_smooth):
        return
    normals = attributes.read_all(source.data.corner_normals, "vector", 3, np.float32)
    normals = unit_vectors(np.einsum("ck,ckx->cx", bound.corner_weights, normals[bound.corner_parents]))
    if bound.welded and not source.data.has_custom_normals:
        normals = _join_normals(normals, bound.corner_vertices)
    data.normals_split_custom_set(normals.tolist())


def _join_normals(normals, vertices):
    """Normals of corners, one at each vertex where they differ little: Blender marks edges between others as sharp."""
    means = np.zeros((vertices.max() + 1, 3))
    np.add.at(means, vertices, normals)
    means = unit_vectors(means)[vertices]
    least = np.ones(len(means))
    np.minimum.at(least, vertices, np.einsum("cx,cx->c", normals, means))
    return np.where(least[vertices, None] > _ALIKE, means, normals)
