# SPDX-License-Identifier: GPL-3.0-or-later
"""The last solves of each object, kept while Blender runs: variations and placed defects need no other.

What the panel keeps of a result tells the states of an object apart. Undo and redo bring it back with the attributes,
and the state that belongs to it is found here.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from uuid import uuid4

import bpy
import numpy as np

from ...core.errors import SynchError
from ...core.fields import DirectionField, Pattern
from ..blender import meshes as blender_meshes
from ..jobs.report import Report
from ..solids.links import made_of
from ..solids.surface import Layering
from . import write
from .reading import Task

# Objects whose solves are kept, the latest ones: some hundred bytes a vertex each, of flows a kilobyte a node.
MOST, MOST_FLOWS = 8, 4
# Of each object: solves, and states that they have shown, each a report and how it was made.
SOLVES, STATES = 2, 256
# Solves of solids that are kept, up to a kilobyte a tetrahedron; undo brings earlier ones of an object back.
MOST_SOLIDS = 3
KEPT_SOLIDS = f"kept for the last {MOST_SOLIDS} solves while the file is open"
# Custom property of the layers that were made: which solve they show.
RUN = "synch_run"


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
            kept = f"kept for the last {self._most} objects while the file is open"
            raise SynchError(f"{obj.name} has no solve in memory ({kept}): solve it first")
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
# Of solids, by the run that the layers show.
_solids = {}


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
    number : of the variation
    change : what makes the variation of the solve, Solved -> DirectionField or Pattern; None for the solution itself
    """

    task: Task
    field: DirectionField
    pattern: Pattern | None
    report: Report
    plain: dict
    number: int = 0
    change: Callable | None = None

    @property
    def shown(self):
        """The field or pattern whose phases vary."""
        return self.field if self.pattern is None else self.pattern

    @property
    def varies(self):
        """Whether there is a lifted field, which other variations and placed defects are projections of."""
        return getattr(self.shown.solution, "lifted", None) is not None

    def showing(self, shown):
        """The field and the pattern with a variation of one of them."""
        return (shown, None) if self.pattern is None else (self.field, shown)

    def made_again(self):
        """The state with phases of its own, for one of :meth:`unmade`."""
        return self if self.change is None else self._with(self.change(self))

    def unmade(self):
        """The state without phases of its own: those of the solution, from which it can be made again."""
        return self if self.change is None else self._with(self.shown.showing(self.shown.solution.phases))

    def _with(self, shown):
        field, pattern = self.showing(shown)
        return replace(self, field=field, pattern=pattern)


class _States:
    """States that an object has shown, by their lines: the present one with its phases, others as they were made."""

    def __init__(self):
        self._unmade, self._line, self._present = {}, None, None

    def put(self, line, solved):
        self._line, self._present = line, solved
        self._unmade[line] = solved.unmade()
        meshes = {id(state.task.given.mesh): None for state in reversed(self._unmade.values())}
        kept = list(meshes)[:SOLVES]
        lines = [line for line, state in self._unmade.items() if id(state.task.given.mesh) in kept]
        self._unmade = {line: self._unmade[line] for line in lines[-STATES:]}

    def holds(self, line):
        return line is None or line in self._unmade

    def unmade(self, line):
        return self._unmade[self._line if line is None else line]

    def get(self, line):
        if line not in (None, self._line):
            self._line, self._present = line, self._unmade[line].made_again()
        return self._present


def show_line(obj, line, number):
    """Say at the object which state it shows, by what :func:`report.result_line` keeps of it, and set the slider."""
    if hasattr(obj, "synch"):  # as long as the extension is registered
        obj.synch.result = ""  # so that setting the slider asks for nothing
        obj.synch.variation, obj.synch.result = number, line


def _line(obj):
    """Of the state that an object shows; None for the latest one, where the extension is not registered."""
    return obj.synch.result if hasattr(obj, "synch") else None


def remember(obj, line, solved):
    """Keep the state that an object shows now."""
    states = _fields.get(obj) if _fields.holds(obj) else _States()
    states.put(line, solved)
    _fields.put(obj, states)


def state(obj):
    """The :class:`Solved` that belongs to the result an object shows, be its mesh changed or not.

    Raises
    ------
    SynchError
        where there is none
    """
    states = _fields.get(obj)
    if not states.holds(_line(obj)):
        raise SynchError(f"what {obj.name} shows is no longer in memory: solve it again")
    return states.get(_line(obj))


def recall(obj):
    """The :class:`Solved` that an object in object mode shows.

    Raises
    ------
    SynchError
        where there is none, the mesh has changed since, or another object that shares it has been solved
    """
    solved = state(obj)
    if not blender_meshes.is_unchanged(obj, solved.task.given):
        raise SynchError(f"the mesh or the scale of {obj.name} has changed since it was solved: solve it again")
    if not write.is_written(obj, solved.task, solved.field, solved.pattern):
        raise SynchError(f"the mesh {obj.data.name} shows another pattern than {obj.name} was given: solve it again")
    return solved


def solve_of(obj):
    """The :class:`Solved` that :func:`state` gives, but with the phases of its solution: quick enough for panels."""
    return _fields.get(obj).unmade(_line(obj))


def remember_layers(obj, given, layering):
    """Keep the :class:`Layering` that the layers of an object show, whose mesh was a :class:`MeshInput`."""
    run = uuid4().hex
    made_of(obj, "layers")[RUN] = run
    _solids[run] = given, layering
    while len(_solids) > MOST_SOLIDS:
        del _solids[next(iter(_solids))]


def recall_layers(obj) -> Layering:
    """The :class:`Layering` that the layers of an object show, where these layers are now.

    Raises
    ------
    SynchError
        where there is none, or the mesh has changed since
    """
    made = made_of(obj, "layers")
    if made is None or made.get(RUN) not in _solids:
        raise SynchError(f"no layers of {obj.name} are in memory ({KEPT_SOLIDS}): solve them first")
    given, layering = _solids[made[RUN]]
    if not blender_meshes.is_unchanged(obj, given):
        raise SynchError(f"the mesh or the scale of {obj.name} has changed since its layers were solved: solve again")
    bpy.context.view_layer.update()
    return replace(layering, matrix=np.array(made.matrix_world, float))


def holds_layers(obj):
    """Whether there is a :class:`Layering` of the layers that an object has, be its mesh changed or not."""
    made = made_of(obj, "layers")
    return made is not None and made.get(RUN) in _solids


def solid_matrix(obj, given):
    """(4, 4) from the space in which an object was measured to the world."""
    unscaled = np.eye(4)
    unscaled[:3, :3] = np.linalg.inv(given.stretch)
    return np.array(obj.matrix_world, float) @ unscaled


def forget(obj):
    """Keep the solves of an object no longer."""
    _fields.drop(obj)


def holds(obj):
    """Whether there is a solve of what an object shows, be its mesh changed or not."""
    return _fields.holds(obj) and _fields.get(obj).holds(_line(obj))


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
