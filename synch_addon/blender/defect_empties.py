# SPDX-License-Identifier: GPL-3.0-or-later
"""Defects of a field as empties: one for each, parented to the object, coloured by its sign."""

import math
from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from typing import NamedTuple

import bpy
import numpy as np
from mathutils import Matrix, Vector

from .transaction import assign, at_the_end, drop, leave, store

KINDS = ("disclination", "dislocation", "vortex")
# Not "Synch ...", as in earlier versions: the search (F3) finds collections too, before what "syn" is typed for.
COLLECTION_NAME, _EARLIER_NAME = "Defects", "Synch Defects"

_KIND, _INDEX, _FACE, _PHASE = "synch_kind", "synch_index", "synch_face", "synch_phase"
# On our collections: "scene" for the one that holds all, "object" for the one of an object.
_MARK = "synch_defects"
# (positive, negative): warm and cool, in hues that differ between the kinds too.
COLORS = {
    "disclination": ((1.0, 0.19, 0.05, 1.0), (0.02, 0.32, 1.0, 1.0)),
    "dislocation": ((1.0, 0.55, 0.0, 1.0), (0.0, 0.65, 0.55, 1.0)),
    "vortex": ((0.9, 0.05, 0.25, 1.0), (0.1, 0.1, 0.8, 1.0)),
}
_DISPLAY = {"disclination": ("SPHERE", 0.3), "dislocation": ("SINGLE_ARROW", 0.5), "vortex": ("CIRCLE", 0.3)}


class DefectEmpty(NamedTuple):
    """The properties of one empty: `write_defects` takes any record with these names.

    `phase` is "x" or "y" for a dislocation of quads, which have two phases.
    """

    kind: str
    face: int
    index: float
    position: tuple[float, float, float]
    normal: tuple[float, float, float]
    phase: str = ""


def write_defects(
    obj, defects: Sequence[DefectEmpty], *, kinds=KINDS, length=1.0, mesh=None, hidden=False
) -> list[bpy.types.Object]:
    """Leave one empty of `obj` for each of `defects`, and no others of these `kinds`.

    An empty that exists moves to the next defect of its kind and index, since making and removing one costs Blender
    more. Positions and normals are in object space; an empty's Z axis is the normal. `length`, in scene units, sets the
    display size: the distance between stripes is a good one. Empties follow the faces of `mesh`, where one is given
    whose vertices are the first ones that `obj` shows. New empties lie in "Defects: <object>", a collection
    inside "Defects" of the object's scene, which keeps its visibility settings; a new one is `hidden` in views or not.
    Returns the empties, in the order of `defects`.
    """
    collection = _collection_of(obj, hidden)
    free = {}
    for empty in defect_empties(obj):
        if empty[_KIND] in kinds:
            label = _label(empty[_KIND], empty.get(_PHASE, ""), empty[_INDEX])
            free.setdefault(label, []).append(empty)
    for of_label in free.values():
        of_label.sort(key=lambda empty: empty.name, reverse=True)
    counts, empties = {}, []
    for defect in defects:
        label = _label(defect.kind, defect.phase, defect.index)
        counts[label] = counts.get(label, 0) + 1
        made = free.get(label) or [_new_empty(obj, f"{label}.{counts[label]:03d}", collection)]
        empties.append(made.pop())
    _remove_empties([empty for of_label in free.values() for empty in of_label])
    size = length / mean_scale(obj)
    for empty, defect in zip(empties, defects, strict=True):
        _place(empty, defect, size, _corners(mesh, defect.face))
    at_the_end(lambda: _remove_if_empty(collection))
    return empties


def defect_empties(obj) -> list[bpy.types.Object]:
    """The empties of `obj` that mark defects, wherever the user may have put them."""
    return [child for child in obj.children if _marks_defect(child)]


def _marks_defect(obj):
    """Whether an object is an empty whose custom properties are those of a defect; others can write there."""
    if obj.type != "EMPTY" or obj.get(_KIND) not in KINDS:
        return False
    index, face, phase = obj.get(_INDEX), obj.get(_FACE), obj.get(_PHASE, "")
    return isinstance(index, float) and math.isfinite(index) and isinstance(face, int) and isinstance(phase, str)


def orphaned_empties():
    """The empties whose object is gone: in a collection of an object's defects none has a parent, and no object of its
    name is there. Empties that a user has freed from their object stay."""
    found = []
    for collection in bpy.data.collections:
        if collection.get(_MARK) != "object" or not collection.is_editable:
            continue
        empties = [obj for obj in collection.objects if _marks_defect(obj)]
        name = collection.name.removeprefix("Synch ").removeprefix(f"{COLLECTION_NAME}: ")
        if not any(empty.parent for empty in empties) and name not in bpy.data.objects:
            found += empties
    return found


def collection_of_defects(obj):
    """The collection of all defect empties of `obj`; None if a user has moved them elsewhere."""
    empties = defect_empties(obj)
    found = {collection for empty in empties[:1] for collection in empty.users_collection if _MARK in collection}
    return found.pop() if found else None


def _remove_empties(leaving):
    """Remove empties; until the transaction ends they do not count as defects."""
    for empty in leaving:
        drop(empty, _KIND)
    leave(leaving)


def _new_empty(obj, name, collection):
    empty = bpy.data.objects.new(name, None)
    empty.parent = obj
    collection.objects.link(empty)
    return empty


def _corners(mesh, face):
    """Three vertices of a face as parents of an empty, and the inverse of the matrix that Blender gives their children.

    Without a mesh, or for a face of no area, the empty has no such parents: (), identity.
    """
    if mesh is not None:
        numbers = mesh.polygons[face].vertices[:3]
        first, second, third = (mesh.vertices[number].co for number in numbers)
        along, normal = (second - first).normalized(), (second - first).cross(third - first).normalized()
        if along and normal:
            turn = Matrix((along, normal.cross(along), normal))
            inverse = turn.to_4x4()
            inverse.translation = -(turn @ ((first + second + third) / 3))
            return tuple(numbers), inverse
    return (), Matrix.Identity(4)


def _place(empty, defect, size, corners):
    """Make an empty show a defect, as far as it does not yet; undone where the work fails."""
    shape, part = _DISPLAY[defect.kind]
    numbers, inverse = corners
    wanted = {
        # Of a face as parent, Blender draws no dashed line across the object.
        "parent_type": "VERTEX_3" if numbers else "OBJECT",
        "parent_vertices": numbers or tuple(empty.parent_vertices),
        "use_parent_final_indices": bool(numbers),
        "matrix_parent_inverse": inverse,
        "rotation_mode": "QUATERNION",
        "rotation_quaternion": Vector(defect.normal).to_track_quat("Z", "Y"),
        "location": Vector(defect.position),
        "color": Vector(COLORS[defect.kind][0 if defect.index > 0 else 1]),
        "empty_display_type": shape,
        "empty_display_size": float(np.float32(part * size)),
    }
    for name, value in wanted.items():
        now = getattr(empty, name)
        if _plain(now) != _plain(value):
            assign(empty, name, value)
    properties = {_KIND: defect.kind, _INDEX: float(defect.index), _FACE: int(defect.face)}
    for key, value in (properties | ({_PHASE: defect.phase} if defect.phase else {})).items():
        if empty.get(key) != value:
            store(empty, key, value)


def _plain(value):
    """A value that can be compared: arrays of properties only say whether they are the same array."""
    if isinstance(value, Matrix):
        return tuple(map(tuple, value))
    return tuple(value) if hasattr(value, "__len__") and not isinstance(value, str) else value


def _label(kind, phase, index):
    return f"{kind} {phase}{' ' if phase else ''}{_fraction(index)}"


@cache
def _fraction(index):
    """+1/2, -1, +3/4 ..."""
    value = Fraction(float(index)).limit_denominator(12)
    return f"{'-' if value < 0 else '+'}{abs(value)}"


def mean_scale(obj):
    """Length in the scene of a unit of an object's space, on average over its axes."""
    scale = obj.matrix_world.to_scale()
    return max(sum(abs(factor) for factor in scale) / 3.0, 1e-12)


def _collection_of(obj, hidden):
    """The collection for the defects of `obj`: where they lie now, or a new one, hidden in views or not."""
    name = f"{COLLECTION_NAME}: {obj.name}"
    for collection in {c for empty in defect_empties(obj) for c in empty.users_collection}:
        # A duplicated hierarchy shares its collection with the original: it gets its own.
        if collection.get(_MARK) == "object" and all(other.parent == obj for other in collection.objects):
            if collection.name != name:
                assign(collection, "name", name)
            return collection
    collection = _new_collection(name, "object")
    collection.hide_viewport = hidden
    _scene_collection(obj).children.link(collection)
    return collection


def _scene_collection(obj):
    """The collection "Defects" of the object's scene."""
    scenes = obj.users_scene
    scene = bpy.context.scene if bpy.context.scene in scenes or not scenes else scenes[0]
    for collection in scene.collection.children_recursive:
        if collection.get(_MARK) == "scene":
            if collection.name == _EARLIER_NAME:
                assign(collection, "name", COLLECTION_NAME)
            return collection
    collection = _new_collection(COLLECTION_NAME, "scene")
    scene.collection.children.link(collection)
    return collection


def _new_collection(name, role):
    collection = bpy.data.collections.new(name)
    collection[_MARK] = role
    collection.color_tag = "NONE"  # without this, undo does not bring its objects back
    return collection


def remove_collections(collections):
    """Remove empty collections of defects, and then collections that become empty."""
    for collection in collections:
        if _MARK in collection:
            _remove_if_empty(collection)


def _remove_if_empty(collection):
    """Remove a collection without content, and then the one around it."""
    if len(collection.objects) or len(collection.children):
        return
    parents = [other for other in bpy.data.collections if _MARK in other and collection in other.children.values()]
    bpy.data.collections.remove(collection)
    for parent in parents:
        _remove_if_empty(parent)
