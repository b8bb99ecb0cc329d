# SPDX-License-Identifier: GPL-3.0-or-later
"""The last solves of each object, kept while Blender runs: variations and placed defects need no other.

What the panel keeps of a result tells the states of an object apart. Undo and redo bring it back with the attributes,
and the state that belongs to it is found here.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from ...core.errors import SynchError
from ...core.fields import DirectionField, Pattern
from ...core.tasks.surfaces import SurfaceRequest
from ..blender.changes import changes
from ..blender.pattern_surface import surface_of
from ..blender.transaction import assign, at_the_end
from ..jobs.lru_cache import LruCache, ObjectCache
from ..jobs.report import Report
from . import own_surface, write

# Objects whose solves are kept, the latest ones: some hundred bytes a vertex each.
MOST = 8
# Of each object: solves, and states that they have shown, each a report and how it was made.
SOLVES, STATES = 2, 256

_fields = ObjectCache(MOST)
_outdated = LruCache(MOST)


@dataclass
class Solved:
    """A solve and what of it the object shows.

    Attributes
    ----------
    request : what was read; its polygons are those after writing
    field : DirectionField
    pattern : Pattern, or None after directions alone
    report : Report that collected warnings and times
    plain : that report as it was returned
    number : of the variation
    change : what makes the variation of the solve, Solved -> DirectionField or Pattern; None for the solution itself
    """

    request: SurfaceRequest
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

    def put(self, line, solved, instead):
        if instead:
            self._unmade.pop(self._line, None)
        self._line, self._present = line, solved
        self._unmade[line] = solved.unmade()
        meshes = {id(state.request.given.mesh): None for state in reversed(self._unmade.values())}
        kept = list(meshes)[:SOLVES]
        lines = [line for line, state in self._unmade.items() if id(state.request.given.mesh) in kept]
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
    """Say at the object which state it shows, by what :func:`kept_results.result_line` keeps, and set the slider."""
    if hasattr(obj, "synch"):  # as long as the extension is registered
        assign(obj.synch, "result", "")  # so that setting the slider asks for nothing
        assign(obj.synch_shown, "variation", number)
        assign(obj.synch, "result", line)


def show_nothing(obj):
    """Say at the object that it shows no state of a solve, and keep its solves no longer."""
    at_the_end(lambda: forget(obj))
    show_line(obj, "", 0)


def _line(obj):
    """Of the state that an object shows; None for the latest one, where the extension is not registered."""
    return obj.synch.result if hasattr(obj, "synch") else None


def remember(obj, line, solved, instead=False):
    """Keep the state that an object shows now, instead of the last one or beside it."""
    states = _fields.get(obj) if _fields.holds(obj) else _States()
    states.put(line, solved, instead)
    _fields.put(obj, states)


def state(obj):
    """The :class:`Solved` that belongs to the result an object shows, be its mesh changed or not.

    Raises SynchError where there is none.
    """
    states = _fields.get(obj)
    if not states.holds(_line(obj)):
        raise SynchError(f"what {obj.name} shows is no longer in memory: solve it again")
    return states.get(_line(obj))


def recall(obj):
    """The :class:`Solved` that an object in object mode shows.

    Raises SynchError where there is none, the mesh has changed since, or another object that shares it has been solved.
    """
    solved = state(obj)
    if not own_surface.is_unchanged(obj, solved.request.given):
        raise SynchError(f"the mesh or the scale of {obj.name} has changed since it was solved: solve it again")
    if not write.is_written(obj, solved.request, solved.field, solved.pattern):
        raise SynchError(
            f"the mesh {surface_of(obj).data.name} shows another pattern than {obj.name} was given: solve it again"
        )
    return solved


def is_outdated(obj):
    """Whether the mesh of an object has changed since what it shows was solved; looked at again after a change only."""
    if obj.mode != "OBJECT" or not holds(obj):
        return False
    given = solve_of(obj).request.given
    key = (
        changes.state(obj.data),
        changes.state(surface_of(obj).data),
        id(given),
        tuple(map(tuple, obj.matrix_world.to_3x3())),
    )
    return _outdated.renewed(obj.session_uid, key, lambda: not own_surface.is_unchanged(obj, given))


def solve_of(obj):
    """The :class:`Solved` that :func:`state` gives, but with the phases of its solution: quick enough for panels."""
    return _fields.get(obj).unmade(_line(obj))


def forget(obj):
    """Keep the solves of an object no longer."""
    _fields.drop(obj)


def holds(obj):
    """Whether there is a solve of what an object shows, be its mesh changed or not."""
    return _fields.holds(obj) and _fields.get(obj).holds(_line(obj))
