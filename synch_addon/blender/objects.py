# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects found again after undo, a new name, or while something else went on."""

from dataclasses import dataclass

import bpy

from ...core.errors import SynchError, quote_value
from .transaction import undone_by

# On an object whose mesh is the own surface of another object's pattern: the state of what it was made of.
SURFACE_MARK = "synch_surface"


def world_of(obj):
    """An object's transform in the world; that of a pattern's own surface is the one of the object it belongs to."""
    is_surface = SURFACE_MARK in obj and obj.parent is not None
    return (obj.parent if is_surface else obj).matrix_world


def no_object(obj):
    """Why something is not an object of the file, in one line, or None."""
    if obj is None:
        return "no active object: select a mesh object"
    if not isinstance(obj, bpy.types.Object):
        return f"{quote_value(obj)} is not an object: give one of bpy.data.objects"
    try:
        return None if obj.session_uid else "the object has no number: give one of bpy.data.objects"
    except ReferenceError:
        return "the object is gone: it was removed from the file"


@dataclass(frozen=True)
class ObjectLink:
    """An object by the number that it has as long as the file is open.

    Attributes
    ----------
    number : its ``session_uid``
    name : what it was called
    """

    number: int
    name: str

    @classmethod
    def to(cls, obj):
        """The link to an object."""
        return cls(obj.session_uid, obj.name)

    @property
    def present(self):
        """The object, None where it is gone."""
        return next((obj for obj in bpy.data.objects if obj.session_uid == self.number), None)

    @property
    def found(self):
        """The object. Raises SynchError where it is gone."""
        obj = self.present
        if obj is None:
            raise SynchError(f"the object {self.name} is gone: nothing was written")
        return obj


@dataclass(frozen=True)
class Selection:
    """The active object when a job began: its result is selected only if the user has not selected another meanwhile.

    ``active``: number of the object, None where there was none.
    """

    active: int | None

    @classmethod
    def now(cls):
        """The current active object."""
        active = bpy.context.view_layer.objects.active
        return cls(None if active is None else active.session_uid)

    def give_to(self, objects):
        """Select some objects instead, the last one active; nothing where another one is active by now."""
        layer = bpy.context.view_layer
        if Selection.now() not in (self, Selection(None)):
            return
        before, active = [other for other in layer.objects if other.select_get()], layer.objects.active
        undone_by(layer, lambda: _select(layer, before, active))
        _select(layer, objects, objects[-1])


def _select(layer, objects, active):
    """Select some objects of a view layer and no others."""
    for other in layer.objects:
        other.select_set(other in objects)
    layer.objects.active = active


def set_mode(obj, mode):
    """Bring the active object into a mode, such as "EDIT".

    The object may be hidden: a 3D view's context does not have a hidden object as the active one, so it is named here.
    """
    with bpy.context.temp_override(active_object=obj):
        bpy.ops.object.mode_set(mode=mode)


def hide(obj, hidden):
    """Hide an object in the view layer, or show it; undone where the work fails."""
    before, selected = obj.hide_get(), obj.select_get()
    undone_by(obj, lambda: (obj.hide_set(before), obj.select_set(selected)))
    obj.hide_set(hidden)
