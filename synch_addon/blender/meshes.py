# SPDX-License-Identifier: GPL-3.0-or-later
"""The only door between Blender's data and the core's arrays."""

from contextlib import contextmanager
from numbers import Integral

import bmesh
import bpy
import numpy as np

from ...core.errors import MeshError, SettingError, SynchError, quote_value
from ...core.geometry.manifold_repair import finite_places
from ...core.geometry.mesh_input import ObjectMesh
from ...core.geometry.polygons import Polygons
from ...core.graphs import label_rows
from .attributes import read_all, read_values
from .objects import no_object, set_mode, world_of
from .transaction import at_the_end, undone_by

# Types of objects that Object > Convert makes meshes of.
_CONVERTIBLE = {"CURVE", "FONT", "META", "SURFACE"}


def refusal(obj):
    """Why an object cannot be given a field, in one line, or None."""
    reason = no_object(obj)
    if reason:
        return reason
    if obj.type != "MESH":
        others = ", or convert it with Object > Convert" if obj.type in _CONVERTIBLE else ""
        return f"{obj.name} is not a mesh: select a mesh object{others}"
    for owner, kind in ((obj, "object"), (obj.data, "mesh")):
        if not owner.is_editable:
            return f"the {kind} {owner.name} is linked: make it local with Object > Relations > Make Local"
    return _edited_elsewhere(obj)


def _edited_elsewhere(obj):
    """Why the mesh of an object cannot be read while another object that shares it is in edit mode, or None."""
    if obj.type == "MESH" and obj.data.is_editmode and obj.mode != "EDIT":
        return f"the mesh {obj.data.name} of {obj.name} is in edit mode by another object: leave edit mode"
    return None


def refuse(obj):
    """Raise SynchError for an object that cannot be given a field; the transforms of others are up to date then, also
    where a script has just moved or scaled something."""
    reason = refusal(obj)
    if reason:
        raise SynchError(reason)
    bpy.context.view_layer.update()


@contextmanager
def object_mode(obj):
    """Leave edit mode while attributes are read and written, and come back to it."""
    reason, editing = _edited_elsewhere(obj), obj.mode == "EDIT"
    if reason:
        raise SynchError(reason)
    if editing:
        if bpy.context.view_layer.objects.active != obj:
            raise SynchError(
                f"{obj.name} is in edit mode and not active: make it the active object, or leave edit mode"
            )
        set_mode(obj, "OBJECT")
    try:
        yield
    finally:
        if editing and bpy.context.view_layer.objects.active == obj:  # not where a new object took its place
            set_mode(obj, "EDIT")


def read_mesh(obj, base=None, strict=False, weld=False):
    """Read the object's own mesh (before modifiers) in object mode, in the shape of :func:`measured_key` and measured
    with the object's scale.

    An evaluated object's own mesh is the one behind the modifiers. Raises MeshError, naming the first element that
    cannot carry a field.

    Parameters
    ----------
    base : MeshInput of the same faces in another shape, so that the surface has the same faces as there
    strict : refuse a mesh that is not manifold, instead of solving on a repaired copy
    weld : join boundary vertices at the same place
    """
    return read_faces(obj).surface(strict, weld) if base is None else read_faces(obj, base.polygons).moved(base)


def read_faces(obj, polygons=None):
    """The :class:`ObjectMesh` of an object, with its own polygons or the given ones."""
    for group in obj.vertex_groups:
        if group.name.startswith("synch_"):  # Blender would number an attribute of the same name
            raise MeshError(f"the vertex group {group.name!r} of {obj.name} has a name of our attributes: rename it")
    return ObjectMesh(obj.name, measured_places(obj), polygons or read_polygons(obj), _stretch(obj))


def measured_key(obj):
    """The shape key whose shape is solved on: the locked one (Solo Active Shape Key), else the first, or None."""
    keys = None if obj.is_evaluated else obj.data.shape_keys
    if keys is None:
        return None
    locked = obj.active_shape_key if obj.show_only_shape_key else None
    return keys.reference_key if locked is None or locked.mute else locked


def measured_places(obj):
    """(n, 3) the object's own vertices in the shape of :func:`measured_key`, in object space."""
    key = measured_key(obj)
    if key is not None and key != obj.data.shape_keys.reference_key:
        return read_all(key.points, "co", 3, np.float32).astype(float)
    return read_values(obj, "position", "POINT").astype(float) if len(obj.data.vertices) else np.empty((0, 3))


def is_unchanged(obj, given):
    """Whether the object still has the positions, faces and scale of a :class:`MeshInput`."""
    if len(obj.data.vertices) != given.vertex_count:
        return False
    now, then = read_polygons(obj), given.polygons
    with np.errstate(invalid="ignore"):  # vertices that are not finite are kept
        places = finite_places(measured_places(obj) @ given.stretch.T)
    if not (np.array_equal(places, given.uncut.vertices[: given.vertex_count]) and has_faces(now, given)):
        return False
    drawn = now.triangle_corners[then.drawn[now.triangle_faces]]
    is_drawn_alike = np.array_equal(drawn, then.triangle_corners)
    if not is_drawn_alike:  # repaired triangles may run the other way round
        is_drawn_alike = np.array_equal(np.sort(drawn, axis=1), np.sort(then.triangle_corners, axis=1))
    return is_drawn_alike and np.array_equal(_stretch(obj), given.stretch)


def has_faces(polygons, given):
    """Whether Polygons have the corners of the object that was read."""
    corners = polygons.corner_vertices if given.own is None else given.own[polygons.corner_vertices]
    then = given.polygons
    same = np.array_equal(corners, given.source[then.corner_vertices])
    return same and np.array_equal(polygons.starts, then.starts)


def read_polygons(obj, with_triangles=True):
    """The faces of the object's mesh and, unless left out to save time, the triangles that Blender draws them with."""
    data = obj.data
    if len(data.loops) == 3 * len(data.polygons):
        starts = 3 * np.arange(len(data.polygons))
    else:
        starts = read_all(data.polygons, "loop_start").astype(np.int64)
    sizes = np.diff(starts, append=len(data.loops))
    if not with_triangles:
        triangles, faces = np.empty((0, 3), np.int64), np.empty(0, np.int64)
    elif (sizes == 3).all():  # each draws itself
        triangles, faces = starts[:, None] + np.arange(3), np.arange(len(starts))
    else:
        data.calc_loop_triangles()
        triangles = read_all(data.loop_triangles, "loops", 3).astype(np.int64)
        faces = read_all(data.loop_triangle_polygons, "value").astype(np.int64)
    # As an attribute they are read two hundred times as fast as from the corners.
    corners = read_values(obj, ".corner_vert", "CORNER")
    corners = np.empty(0, np.int64) if corners is None else corners.astype(np.int64)
    return Polygons(corners, starts, sizes, triangles, faces)


def _stretch(obj):
    """Symmetric positive part of the object's transform: its scale without rotation and mirroring."""
    linear = np.array(world_of(obj).to_3x3())
    if not np.isfinite(linear).all():
        raise MeshError(f"the transform of {obj.name} is not finite: clear it with Object > Clear")
    values, axes = np.linalg.eigh(linear.T @ linear)
    if values[0] <= 1e-12 * values[2]:
        raise MeshError(f"the scale of {obj.name} is zero along an axis: give it a scale in every direction")
    return (axes * np.sqrt(values)) @ axes.T


def can_be_split(obj, faces, surface):
    """Faces, out of (k,), that can be split into triangles: none of the triangles is a face already.

    A face that doubles another one in the surface's Polygons may be one of its triangles, and is not split itself.
    """
    faces = faces[surface.drawn[faces]]
    if len(faces) == 0:
        return faces
    polygons, shown = read_polygons(obj), _shown(surface)
    small = np.flatnonzero(polygons.sizes == 3)
    rows = np.isin(polygons.triangle_faces, faces)
    there = polygons.corner_vertices[polygons.starts[small, None] + np.arange(3)]
    both = np.sort(np.concatenate([there, polygons.triangles[rows]]), axis=1)
    labels = label_rows(both)
    met, asked = np.split(labels, [len(small)])
    near = np.isin(met, asked)
    chosen, owners = [], {}
    for label, face in zip(met[near].tolist(), shown[small[near]].tolist(), strict=True):
        owners[label] = face if owners.get(label, face) == face else None
    for face in faces:
        own = asked[polygons.triangle_faces[rows] == face].tolist()
        if all(owners.get(label, face) == face for label in own):
            chosen.append(face)
            owners |= dict.fromkeys(own, face)
    return np.array(chosen, int)


def _shown(surface):
    """(p,) the face whose triangles are drawn for each face: itself, or the one that it duplicates."""
    return surface.at_faces(np.arange(len(surface.starts)))


def doubles_of(faces, surface):
    """The polygons of more than three corners that double one of (k,) faces in the surface's Polygons."""
    return np.flatnonzero(np.isin(_shown(surface), faces) & ~surface.drawn & (surface.sizes > 3))


def split_faces(obj, faces, doubles):
    """Replace faces by the triangles that draw them, keeping all their corner and face data, and remove their doubles,
    whose own triangles could be others.

    A triangle that exists already is not made again (see :func:`can_be_split`).

    Returns (c,), for each corner now, the corner that it was before.
    """
    mesh, polygons = obj.data, read_polygons(obj)
    _keep_faces(mesh)
    edited = _edited(mesh)
    edited.faces.ensure_lookup_table()
    edited.verts.ensure_lookup_table()
    corner = edited.loops.layers.int.new("synch_corner")
    for number, loop in enumerate(loop for face in edited.faces for loop in face.loops):
        loop[corner] = number
    old = [edited.faces[index] for index in doubles]
    for index, face in [(index, edited.faces[index]) for index in faces]:
        loops = list(face.loops)
        source = {loop.vert: loop for loop in loops}
        triangles = polygons.triangle_corners[polygons.triangle_faces == index] - polygons.starts[index]
        corners = [[loops[k].vert for k in triangle] for triangle in triangles]
        new = [vertices for vertices in corners if edited.faces.get(vertices) is None]
        for vertices in new:
            triangle = edited.faces.new(vertices, face)
            for loop in triangle.loops:
                loop.copy_from(source[loop.vert])
        old += [face] if new or len(loops) > 3 else []
    bmesh.ops.delete(edited, geom=old, context="FACES_ONLY")
    old_corners = [loop[corner] for face in edited.faces for loop in face.loops]
    edited.loops.layers.int.remove(corner)
    edited.to_mesh(mesh)
    edited.free()
    return np.array(old_corners)


def _keep_faces(mesh):
    """Restore the whole mesh if the transaction fails."""
    before, names = _edited(mesh), {attribute.name for attribute in mesh.attributes}

    def give_back():
        before.to_mesh(mesh)
        before.free()
        for name in [attribute.name for attribute in mesh.attributes if attribute.name not in names]:
            mesh.attributes.remove(mesh.attributes[name])

    undone_by(mesh, give_back)
    at_the_end(before.free)


def _edited(mesh):
    edited = bmesh.new()
    edited.from_mesh(mesh)
    return edited


def faces_of_triangles(polygons, triangles):
    """(k,) face that draws each of (k, 3) triangles given by their vertices."""
    wanted, drawn = np.asarray(triangles).reshape(-1, 3), polygons.triangles
    is_near = np.zeros(max(drawn.max(initial=-1), wanted.max(initial=-1)) + 1, bool)
    is_near[wanted] = True
    near = np.flatnonzero(is_near[drawn].all(axis=1))  # mostly few are wanted
    both = np.sort(np.concatenate([drawn[near], wanted]), axis=1)
    labels = label_rows(both)
    face_of = np.empty(labels.max(initial=0) + 1, int)
    face_of[labels[: len(near)]] = polygons.triangle_faces[near]
    return face_of[labels[len(near) :]]


def triangles_of_face(given, face):
    """(k,) triangles of the mesh of a MeshInput that lie in one of its faces."""
    polygons, triangles = given.polygons, given.mesh.triangles
    if not isinstance(face, Integral) or isinstance(face, bool) or not 0 <= face < len(polygons.starts):
        raise SettingError(f"there is no face {quote_value(face)}: the mesh has {len(polygons.starts)}, from 0 on")
    start = polygons.starts[face]
    corners = polygons.corner_vertices[start : start + polygons.sizes[face]]
    inside = np.flatnonzero(np.isin(triangles, corners).all(axis=1))
    return inside[faces_of_triangles(polygons, triangles[inside]) == face]


def select_vertices(obj, vertices):
    """Select vertices and nothing else of a mesh in object mode, so that edit mode shows them."""
    chosen = np.zeros(len(obj.data.vertices), bool)
    chosen[vertices] = True
    _select(obj, (True, False, False), chosen, chosen[read_all(obj.data.edges, "vertices", 2)].all(axis=1), False)


def select_edges(obj, pairs):
    """Select edges, by (k, 2) their ends, and nothing else of a mesh in object mode, so that edit mode shows them."""
    known, asked = (np.sort(ends, axis=1) for ends in (read_all(obj.data.edges, "vertices", 2), np.asarray(pairs)))
    names = label_rows(np.concatenate([known, asked]))
    vertices = np.isin(np.arange(len(obj.data.vertices)), asked)
    _select(obj, (False, True, False), vertices, np.isin(names[: len(known)], names[len(known) :]), False)


def select_faces(obj, faces):
    """Select faces and nothing else of a mesh in object mode, so that edit mode shows them.

    Raises MeshError where the mesh has fewer faces, and then nothing is selected.
    """
    if max(faces, default=0) >= len(obj.data.polygons):
        raise MeshError(f"faces of {obj.name} were deleted since its defects were found: solve it again")
    chosen = np.zeros(len(obj.data.polygons), bool)
    chosen[list(faces)] = True
    _select(obj, (False, False, True), False, False, chosen)


def _select(obj, mode, *chosen):
    """Select the chosen vertices, edges and faces, each a bool or one for all, in a select mode of the three."""
    bpy.context.tool_settings.mesh_select_mode = mode
    for elements, is_chosen in zip((obj.data.vertices, obj.data.edges, obj.data.polygons), chosen, strict=True):
        elements.foreach_set("select", np.broadcast_to(is_chosen, len(elements)).copy())
    obj.data.update()


def update(obj):
    """Tell Blender that the mesh's data changed."""
    obj.data.update()
