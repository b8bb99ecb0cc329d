# SPDX-License-Identifier: GPL-3.0-or-later
"""The only door between Blender's data and the core's arrays."""

from contextlib import contextmanager
from dataclasses import dataclass

import bmesh
import bpy
import numpy as np

from ..core.errors import MeshError, SettingError, SynchError
from ..core.geometry import TriangleMesh
from ..core.geometry.check import check_mesh
from ..core.geometry.polygons import Polygons

# Blender's names for an attribute type: numpy type, width, name in foreach_set.
_LAYOUTS = {
    "FLOAT": (np.float32, 1, "value"),
    "INT": (np.int32, 1, "value"),
    "BOOLEAN": (bool, 1, "value"),
    "INT32_2D": (np.int32, 2, "value"),
    "FLOAT_VECTOR": (np.float32, 3, "vector"),
    "FLOAT2": (np.float32, 2, "vector"),
    "FLOAT_COLOR": (np.float32, 4, "color"),
    "BYTE_COLOR": (np.float32, 4, "color"),
}
# Attributes that mark edges.
MARKS = {"seams": "uv_seam", "sharp": "sharp_edge", "creases": "crease_edge"}


@dataclass(frozen=True)
class MeshInput:
    """A mesh as the core sees it.

    ``stretch`` is the (3, 3) scale that lengths were measured with. Where edges are cut, ``mesh`` and ``polygons``
    have them apart, ``uncut`` is the whole mesh, and ``source`` the (n,) vertex of it that each vertex was: its
    own vertices first, then their second sides.
    """

    mesh: TriangleMesh
    polygons: Polygons
    stretch: np.ndarray
    uncut: TriangleMesh
    source: np.ndarray

    def to_object(self, vectors):
        """Unit vectors in object space at the object's vertices, for (n, 3) vectors of the measured mesh."""
        return unstretched(vectors[: self.uncut.vertex_count], self.stretch)


def unstretched(vectors, stretch):
    """Unit vectors in object space for (k, 3) vectors of the measured space; zero stays zero."""
    turned = vectors @ np.linalg.inv(stretch).T
    lengths = np.linalg.norm(turned, axis=1, keepdims=True)
    return np.divide(turned, lengths, out=np.zeros_like(turned), where=lengths > 0)


def refusal(obj):
    """Why an object cannot be given a field, in one line, or None."""
    if obj is None:
        return "no active object: select a mesh object"
    if obj.type != "MESH":
        return f"{obj.name} is not a mesh: select a mesh object, or convert it with Object > Convert"
    for owner, kind in ((obj, "object"), (obj.data, "mesh")):
        if not owner.is_editable:
            return f"the {kind} {owner.name} is linked: make it local with Object > Relations > Make Local"
    return None


def refuse(obj):
    """Raise SynchError for an object that cannot be given a field."""
    reason = refusal(obj)
    if reason:
        raise SynchError(reason)


@contextmanager
def object_mode(obj):
    """Leave edit mode while attributes are read and written, and come back to it."""
    editing = obj.mode == "EDIT"
    if editing:
        if bpy.context.view_layer.objects.active != obj:
            raise SynchError(
                f"{obj.name} is in edit mode and not active: make it the active object, or leave edit mode"
            )
        bpy.ops.object.mode_set(mode="OBJECT")
    try:
        yield
    finally:
        if editing and bpy.context.view_layer.objects.active == obj:  # not where a new object took its place
            bpy.ops.object.mode_set(mode="EDIT")


def read_mesh(obj, polygons=None):
    """Read the object's own mesh (before modifiers) in object mode, measured with the object's scale.

    An evaluated object's own mesh is the one behind the modifiers. Its faces are read where they are not given.

    Raises
    ------
    MeshError
        naming the first element that cannot carry a field
    """
    for group in obj.vertex_groups:
        if group.name.startswith("synch_"):  # Blender would number an attribute of the same name
            raise MeshError(f"the vertex group {group.name!r} of {obj.name} has a name of our attributes: rename it")
    stretch = _stretch(obj)
    vertices = _read(obj.data.attributes["position"]) if len(obj.data.vertices) else np.empty((0, 3))
    polygons = read_polygons(obj) if polygons is None else polygons
    mesh = TriangleMesh(vertices.astype(float) @ stretch.T, polygons.triangles)
    check_mesh(mesh, polygons.triangle_faces)
    return MeshInput(mesh, polygons, stretch, mesh, np.arange(mesh.vertex_count))


def is_unchanged(obj, given):
    """Whether the object still has the positions, faces and scale of a :class:`MeshInput`."""
    if len(obj.data.vertices) != given.uncut.vertex_count:
        return False
    vertices = _read(obj.data.attributes["position"]).astype(float) @ given.stretch.T
    now, then = read_polygons(obj), given.polygons
    return (
        np.array_equal(vertices, given.uncut.vertices)
        and np.array_equal(now.corner_vertices, given.source[then.corner_vertices])
        and np.array_equal(now.starts, then.starts)
        and np.array_equal(now.triangle_corners, then.triangle_corners)
        and np.array_equal(_stretch(obj), given.stretch)
    )


def read_polygons(obj):
    """The faces of the object's mesh and the triangles that Blender draws them with."""
    data = obj.data
    data.calc_loop_triangles()
    arrays = (
        read_all(data.loops, "vertex_index"),
        read_all(data.polygons, "loop_start"),
        read_all(data.polygons, "loop_total"),
        read_all(data.loop_triangles, "loops", 3),
        read_all(data.loop_triangle_polygons, "value"),
    )
    return Polygons(*(a.astype(np.int64) for a in arrays))


def read_all(elements, name, width=1, dtype=np.int32):
    """(n,) or (n, width) values of a property of all elements of a collection."""
    values = np.empty(len(elements) * width, dtype)
    elements.foreach_get(name, values)
    return values.reshape(-1, width) if width > 1 else values


def _stretch(obj):
    """Symmetric positive part of the object's transform: its scale without rotation and mirroring."""
    linear = np.array(obj.matrix_world.to_3x3())
    if not np.isfinite(linear).all():
        raise MeshError(f"the transform of {obj.name} is not finite: clear it with Object > Clear")
    values, axes = np.linalg.eigh(linear.T @ linear)
    if values[0] <= 1e-12 * values[2]:
        raise MeshError(f"the scale of {obj.name} is zero along an axis: give it a scale in every direction")
    return (axes * np.sqrt(values)) @ axes.T


def read_vectors(obj, name, given):
    """(n, 3) vectors of a POINT attribute, on the vertices and in the measured space of a :class:`MeshInput`.

    Raises
    ------
    SettingError
        when the attribute is missing or of another kind
    """
    return _read(_point_attribute(obj, name, "FLOAT_VECTOR", "vector")).astype(float)[given.source] @ given.stretch.T


def read_numbers(obj, name, given, outside=0.0):
    """(n,) numbers of a POINT attribute, or weights of a vertex group, ``outside`` it another number.

    Errors as :func:`read_vectors`.
    """
    if is_group(obj, name):
        return read_weights(obj, name, outside)[given.source]
    return _read(_point_attribute(obj, name, "FLOAT", "float")).astype(float)[given.source]


def is_group(obj, name):
    """Whether numbers of this name are the weights of a vertex group; an attribute of the name goes first."""
    return name in obj.vertex_groups and name not in obj.data.attributes


def read_uv_map(obj, name):
    """(c, 2) coordinates of the faces' corners in a UV map, the active one where the name is "".

    Raises
    ------
    SettingError
        when there is no such map
    """
    layers = obj.data.uv_layers
    layer = layers.get(name) if name else layers.active
    if layer is None:
        which = f"UV map {name!r}" if name else "UV map"
        present = ", ".join(found.name for found in layers) or "none yet"
        raise SettingError(f"the mesh {obj.data.name} has no {which}: choose one of its maps ({present}), or unwrap it")
    return _read(obj.data.attributes[layer.name]).astype(float)


def _point_attribute(obj, name, data_type, kind):
    attribute = obj.data.attributes.get(name)
    if attribute is None:
        present = [a.name for a in obj.data.attributes if a.data_type == data_type and a.name != "position"]
        have = f"it has {', '.join(present)}" if present else "it has none"
        raise SettingError(f"the mesh {obj.data.name} has no attribute {name!r}: choose a {kind} attribute ({have})")
    if attribute.data_type != data_type or attribute.domain != "POINT":
        raise SettingError(
            f"the attribute {name!r} is {attribute.data_type} on {attribute.domain}: it must be a {kind} on points"
        )
    return attribute


def read_marked_edges(obj, mark):
    """(k, 2) vertices of the edges that are "seams", "sharp" or "creases", where a face uses them."""
    marked = read_values(obj, MARKS[mark], "EDGE")
    if marked is None:
        return np.empty((0, 2), int)
    loose = read_all(obj.data.edges, "is_loose", dtype=bool)
    return read_all(obj.data.edges, "vertices", 2)[(marked > 0) & ~loose].astype(np.int64)


def read_group(obj, name):
    """(n,) bool: vertices of a vertex group, on the object's own vertices."""
    members = read_weights(obj, name) > 0
    if not members.any():
        raise SettingError(f"the vertex group {name!r} is empty: assign vertices to it")
    return members


def read_weights(obj, name, outside=0.0):
    """(n,) weights of a vertex group, another number for vertices outside."""
    group = obj.vertex_groups.get(name)
    if group is None:
        names = ", ".join(g.name for g in obj.vertex_groups) or "none yet"
        raise SettingError(f"{obj.name} has no vertex group {name!r}: choose one of its groups ({names})")
    weights = np.full(len(obj.data.vertices), outside)
    for vertex in obj.data.vertices:
        for member in vertex.groups:
            if member.group == group.index:
                weights[vertex.index] = member.weight
    return weights


def write_weights(obj, name, weights):
    """A new vertex group of (n,) weights, without the vertices whose weight is 0."""
    group = obj.vertex_groups.new(name=name)
    for vertex in np.flatnonzero(weights > 0).tolist():
        group.add([vertex], float(weights[vertex]), "REPLACE")


def read_values(obj, name, domain):
    """(n,) or (n, width) values of an attribute as they are, None where the mesh has none of the name on a domain."""
    attribute = obj.data.attributes.get(name)
    if attribute is None or attribute.domain != domain or attribute.data_type not in _LAYOUTS:
        return None
    return _read(attribute)


def _read(attribute):
    dtype, width, name = _LAYOUTS[attribute.data_type]
    return read_all(attribute.data, name, width, dtype)


def write_attribute(obj, name, domain, data_type, values):
    """Write an attribute, replacing one of the same name that has another domain or type."""
    attributes = obj.data.attributes
    attribute = attributes.get(name)
    if attribute is not None and (attribute.domain, attribute.data_type) != (domain, data_type):
        attributes.remove(attribute)
        attribute = None
    if attribute is None:
        attribute = attributes.new(name, data_type, domain)
    dtype, _, value_name = _LAYOUTS[data_type]
    attribute.data.foreach_set(value_name, np.ascontiguousarray(values, dtype).ravel())


def remove_attribute(obj, name):
    """Remove an attribute if it is there."""
    attribute = obj.data.attributes.get(name)
    if attribute is not None:
        obj.data.attributes.remove(attribute)


def show_same_maps(obj, made):
    """Of another mesh's UV maps and colours, the same are the active and the rendered ones as of the given one."""
    layers, others = obj.data.uv_layers, made.data.uv_layers
    for layer in layers:
        if layer.active_render and layer.name in others:
            others[layer.name].active_render = True
    if layers.active is not None and layers.active.name in others:
        others.active = others[layers.active.name]
    colors, others = obj.data.color_attributes, made.data.color_attributes
    if colors.active_color_name in others:
        others.active_color_name = colors.active_color_name
    if 0 <= colors.render_color_index < len(colors) and colors[colors.render_color_index].name in others:
        others.render_color_index = others.find(colors[colors.render_color_index].name)


def split_faces(obj, polygons, faces):
    """Replace faces by the triangles that draw them, keeping all their corner and face data.

    Returns the (c,) old corner that each corner was.
    """
    edited = bmesh.new()
    edited.from_mesh(obj.data)
    edited.faces.ensure_lookup_table()
    edited.verts.ensure_lookup_table()
    corner = edited.loops.layers.int.new("synch_corner")
    for number, loop in enumerate(loop for face in edited.faces for loop in face.loops):
        loop[corner] = number
    old = [edited.faces[face] for face in faces]
    for face, index in zip(old, faces, strict=True):
        loops = list(face.loops)
        source = {loop.vert: loop for loop in loops}
        for corners in polygons.triangle_corners[polygons.triangle_faces == index] - polygons.starts[index]:
            triangle = edited.faces.new([loops[k].vert for k in corners], face)
            for loop in triangle.loops:
                loop.copy_from(source[loop.vert])
    bmesh.ops.delete(edited, geom=old, context="FACES_ONLY")
    old_corners = [loop[corner] for face in edited.faces for loop in face.loops]
    edited.loops.layers.int.remove(corner)
    edited.to_mesh(obj.data)
    edited.free()
    return np.array(old_corners)


def faces_of_triangles(polygons, triangles):
    """(k,) face that draws each of (k, 3) triangles given by their vertices."""
    wanted = np.asarray(triangles).reshape(-1, 3)
    both = np.sort(np.concatenate([polygons.triangles, wanted]), axis=1)
    labels = np.unique(both, axis=0, return_inverse=True)[1].reshape(-1)
    face_of = np.empty(labels.max(initial=0) + 1, int)
    face_of[labels[: len(polygons.triangle_faces)]] = polygons.triangle_faces
    return face_of[labels[len(polygons.triangle_faces) :]]


def select_vertices(obj, vertices):
    """Select vertices and nothing else of a mesh in object mode, so that edit mode shows them."""
    bpy.context.tool_settings.mesh_select_mode = (True, False, False)
    chosen = np.zeros(len(obj.data.vertices), bool)
    chosen[vertices] = True
    ends = read_all(obj.data.edges, "vertices", 2)
    obj.data.vertices.foreach_set("select", chosen)
    obj.data.edges.foreach_set("select", chosen[ends].all(axis=1))
    obj.data.polygons.foreach_set("select", np.zeros(len(obj.data.polygons), bool))
    obj.data.update()


def select_faces(obj, faces):
    """Select faces and nothing else of a mesh in object mode, so that edit mode shows them.

    Raises
    ------
    MeshError
        where the mesh has fewer faces, and then nothing is selected
    """
    if max(faces, default=0) >= len(obj.data.polygons):
        raise MeshError(f"faces of {obj.name} were deleted since its defects were found: solve it again")
    bpy.context.tool_settings.mesh_select_mode = (False, False, True)
    chosen = np.zeros(len(obj.data.polygons), bool)
    chosen[list(faces)] = True
    for elements, value in ((obj.data.vertices, False), (obj.data.edges, False)):
        elements.foreach_set("select", np.full(len(elements), value))
    obj.data.polygons.foreach_set("select", chosen)
    obj.data.update()


def update(obj):
    """Tell Blender that the mesh's data changed."""
    obj.data.update()
