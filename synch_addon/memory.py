# SPDX-License-Identifier: GPL-3.0-or-later
"""The last solve of each object, kept while Blender runs: variations and placed defects need no other."""

from dataclasses import dataclass, replace

import bpy
import numpy as np

from ..core.errors import SynchError
from ..core.fields import DirectionField, Pattern
from . import scene_io
from .report import Report
from .solids import Layering
from .task import Task

# Objects whose solves are kept, the latest ones: some hundred bytes a vertex each, of flows a kilobyte a node, and of
# solids up to a kilobyte a tetrahedron.
MOST, MOST_FLOWS, MOST_SOLIDS = 8, 4, 2


class Shelf:
    """What was computed for objects, of the latest of them."""

    def __init__(self, most):
        self._most, self._kept = most, {}

    def put(self, obj, solved):
        """Keep something for an object, in place of what there was."""
        self.drop(obj)
        self._kept[obj.session_uid] = solved
        while len(self._kept) > self._most:
            del self._kept[next(iter(self._kept))]

    def get(self, obj):
        """What is kept for an object.

        Raises
        ------
        SynchError
            where there is nothing
        """
        if not self.holds(obj):
            raise SynchError(f"{obj.name} has not been solved since the file was opened: solve it first")
        return self._kept[obj.session_uid]

    def drop(self, obj):
        """Keep it no longer."""
        self._kept.pop(obj.session_uid, None)

    def holds(self, obj):
        """Whether anything is kept for an object."""
        return obj is not None and obj.session_uid in self._kept

    def clear(self):
        """Keep nothing."""
        self._kept.clear()


_fields = Shelf(MOST)
# Of the objects that show the vortices of a flow.
flows = Shelf(MOST_FLOWS)
_solids = Shelf(MOST_SOLIDS)


@dataclass
class Solved:
    """A solve and what of it the object shows.

    Attributes
    ----------
    task : what was read; its polygons are those after writing
    field : DirectionField
    pattern : Pattern, or None after directions alone
    report : Report that collected warnings and times
    plain : that report as it was returned
    """

    task: Task
    field: DirectionField
    pattern: Pattern | None
    report: Report
    plain: dict

    @property
    def shown(self):
        """The field or pattern whose phases vary."""
        return self.field if self.pattern is None else self.pattern

    def showing(self, shown):
        """The field and the pattern with a variation of one of them."""
        return (shown, None) if self.pattern is None else (self.field, shown)


def remember(obj, solved):
    """Keep the solve that an object shows now."""
    _fields.put(obj, solved)


def recall(obj):
    """The :class:`Solved` that an object shows.

    Raises
    ------
    SynchError
        where there is none, or the mesh has changed since
    """
    solved = _fields.get(obj)
    if not scene_io.is_unchanged(obj, solved.task.given):
        raise SynchError(f"the mesh or the scale of {obj.name} has changed since it was solved: solve it again")
    return solved


def remember_layers(obj, given, layering):
    """Keep the :class:`Layering` that was solved in an object, whose mesh was a :class:`MeshInput`."""
    _solids.put(obj, (given, layering))


def recall_layers(obj) -> Layering:
    """The last :class:`Layering` of an object, where the object is now.

    Raises
    ------
    SynchError
        where there is none, or the mesh has changed since
    """
    if not holds_layers(obj):
        raise SynchError(f"no layers were solved in {obj.name} since the file was opened: solve them first")
    given, layering = _solids.get(obj)
    if not scene_io.is_unchanged(obj, given):
        raise SynchError(f"the mesh or the scale of {obj.name} has changed since its layers were solved: solve again")
    return replace(layering, matrix=solid_matrix(obj, given))


def holds_layers(obj):
    """Whether there is a :class:`Layering` of an object, be its mesh changed or not."""
    return _solids.holds(obj)


def solid_matrix(obj, given):
    """(4, 4) from the space in which an object was measured to the world."""
    unscaled = np.eye(4)
    unscaled[:3, :3] = np.linalg.inv(given.stretch)
    return np.array(obj.matrix_world, float) @ unscaled


def forget(obj):
    """Keep the solve of an object no longer."""
    _fields.drop(obj)


def holds(obj):
    """Whether there is a solve of an object, be its mesh changed or not."""
    return _fields.holds(obj)


@bpy.app.handlers.persistent
def _forget_all(*_):
    _fields.clear()
    flows.clear()
    _solids.clear()


def register():
    bpy.app.handlers.load_post.append(_forget_all)


def unregister():
    bpy.app.handlers.load_post.remove(_forget_all)
    _forget_all()
