# SPDX-License-Identifier: GPL-3.0-or-later
"""Defects of a field as empties: one for each, parented to the object, coloured by its sign."""

from collections.abc import Iterable
from fractions import Fraction
from typing import NamedTuple

import bpy
from mathutils import Matrix, Vector

from .transaction import assign, at_the_end, drop, leave

KINDS = ("disclination", "dislocation", "vortex")
COLLECTION_NAME = "Synch Defects"

_KIND, _INDEX, _FACE, _PHASE = "synch_kind", "synch_index", "synch_face", "synch_phase"
# On our collections: "scene" for the one that holds all, "object" for the one of an object.
_MARK = "synch_defects"
# (positive, negative): warm and cool, in hues that tell the kinds apart too.
COLORS = {
    "disclination": ((1.0, 0.19, 0.05, 1.0), (0.02, 0.32, 1.0, 1.0)),
    "dislocation": ((1.0, 0.55, 0.0, 1.0), (0.0, 0.65, 0.55, 1.0)),
    "vortex": ((0.9, 0.05, 0.25, 1.0), (0.1, 0.1, 0.8, 1.0)),
}
_DISPLAY = {"disclination": ("SPHERE", 0.3), "dislocation": ("SINGLE_ARROW", 0.5), "vortex": ("CIRCLE", 0.3)}


class DefectEmpty(NamedTuple):
    """What one empty shows of a defect: any record with these names will do for `write_defects`.

    `phase` is "x" or "y" for a dislocation of quads, which have two phases.
    """

    kind: str
    face: int
    index: float
    position: tuple[float, float, float]
    normal: tuple[float, float, float]
    phase: str = ""


def write_defects(obj, defects: Iterable[DefectEmpty], *, kinds=KINDS, length=1.0) -> list[bpy.types.Object]:
    """Replace the empties of `obj` of these `kinds` by one for each of `defects`.

    Positions and normals are in object space; an empty's Z axis is the normal. `length`, in scene
    units, sets the display size: the distance between stripes is a good one. The empties lie in
    "Synch Defects: <object>", a collection inside "Synch Defects" of the object's scene, which
    keeps its visibility settings. Returns the new empties, in the order of `defects`.
    """
    collection = _collection_of(obj)
    _remove_empties(obj, kinds)
    scale = mean_scale(obj)
    counts = {}
    empties = [_new_empty(obj, defect, collection, length / scale, counts) for defect in defects]
    at_the_end(lambda: _remove_if_empty(collection))
    return empties


def defect_empties(obj) -> list[bpy.types.Object]:
    """The empties of `obj` that mark defects, wherever the user may have put them."""
    return [child for child in obj.children if child.type == "EMPTY" and _KIND in child]


def _remove_empties(obj, kinds):
    """Remove empties from the file; those that are leaving are no defects any more."""
    leaving = [empty for empty in defect_empties(obj) if empty[_KIND] in kinds]
    for empty in leaving:
        drop(empty, _KIND)
    leave(leaving)


def _new_empty(obj, defect, collection, size, counts):
    label = f"{defect.kind} {defect.phase}{' ' if defect.phase else ''}{_fraction(defect.index)}"
    counts[label] = counts.get(label, 0) + 1
    empty = bpy.data.objects.new(f"{label}.{counts[label]:03d}", None)
    empty.parent = obj
    empty.matrix_parent_inverse = Matrix.Identity(4)
    empty.rotation_mode = "QUATERNION"
    empty.rotation_quaternion = Vector(defect.normal).to_track_quat("Z", "Y")
    empty.location = defect.position
    empty.color = COLORS[defect.kind][0 if defect.index > 0 else 1]
    empty.empty_display_type, part = _DISPLAY[defect.kind]
    empty.empty_display_size = part * size
    empty[_KIND], empty[_INDEX], empty[_FACE] = defect.kind, float(defect.index), int(defect.face)
    if defect.phase:
        empty[_PHASE] = defect.phase
    collection.objects.link(empty)
    return empty


def _fraction(index):
    """+1/2, -1, +3/4 ..."""
    value = Fraction(float(index)).limit_denominator(12)
    return f"{'-' if value < 0 else '+'}{abs(value)}"


def mean_scale(obj):
    """Length in the scene of a unit of an object's space, on average over its axes."""
    scale = obj.matrix_world.to_scale()
    return max(sum(abs(factor) for factor in scale) / 3.0, 1e-12)


def _collection_of(obj):
    """The collection for the defects of `obj`: where they lie now, or a new one."""
    name = f"{COLLECTION_NAME}: {obj.name}"
    for collection in {c for empty in defect_empties(obj) for c in empty.users_collection}:
        # A duplicated hierarchy shares its collection with the original: it gets its own.
        if collection.get(_MARK) == "object" and all(other.parent == obj for other in collection.objects):
            if collection.name != name:
                assign(collection, "name", name)
            return collection
    collection = _new_collection(name, "object")
    _scene_collection(obj).children.link(collection)
    return collection


def _scene_collection(obj):
    """The collection "Synch Defects" of the object's scene."""
    scenes = obj.users_scene
    scene = bpy.context.scene if bpy.context.scene in scenes or not scenes else scenes[0]
    for collection in scene.collection.children_recursive:
        if collection.get(_MARK) == "scene":
            return collection
    collection = _new_collection(COLLECTION_NAME, "scene")
    scene.collection.children.link(collection)
    return collection


def _new_collection(name, role):
    collection = bpy.data.collections.new(name)
    collection[_MARK] = role
    collection.color_tag = "COLOR_01"
    return collection


def _remove_if_empty(collection):
    """Remove a collection without content, and then the one around it."""
    if len(collection.objects) or len(collection.children):
        return
    parents = [other for other in bpy.data.collections if _MARK in other and collection in other.children.values()]
    bpy.data.collections.remove(collection)
    for parent in parents:
        _remove_if_empty(parent)
