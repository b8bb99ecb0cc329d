# SPDX-License-Identifier: GPL-3.0-or-later
"""The last solves of each object, kept while Blender runs, so that variations and placed defects need no new solve.

The line that an object stores of its result (``obj.synch.result``) is the key of its state here. Blender's undo and
redo restore the attributes and this line together, so the state that fits them is found again.
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
from ..settings.fields import source_of
from . import made_from, own_surface, write

# Number of objects whose solves are kept, the latest ones: some hundred bytes a vertex each.
MOST = 8
# For each object: number of solves, and of states, which take a report each.
SOLVES, STATES = 2, 256

_fields = ObjectCache(MOST)
_outdated = LruCache(MOST)


@dataclass
class Solved:
    """A solve, and the variation of it that the object shows.

    Attributes
    ----------
    request : what was solved; its polygons are the object's after writing
    pattern : Pattern, or None after directions alone
    report : Report that collected warnings and times
    plain : the same report as a dict
    number : of the variation
    change : function that computes the variation, Solved -> DirectionField or Pattern; None for the solution itself
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
        """The pattern, or the field without a pattern: the subject of variations."""
        return self.field if self.pattern is None else self.pattern

    @property
    def needed_pattern(self):
        """The pattern; SynchError for directions alone."""
        if self.pattern is None:
            raise SynchError("defects are placed in stripes and quads: solve one of them first")
        return self.pattern

    @property
    def varies(self):
        """Whether there is a lifted field, of which variations and placed defects are projections."""
        return getattr(self.shown.solution, "lifted", None) is not None

    def field_and_pattern(self, shown):
        """The field and the pattern, or None, with ``shown`` in place of the present :attr:`shown`."""
        return (shown, None) if self.pattern is None else (self.field, shown)

    def then(self, edit):
        """The change of the solution that leads to this state and on to what ``edit`` makes of it."""
        before = self.change
        return edit if before is None else lambda solution: edit(solution._with(before(solution)))

    def restored(self):
        """The state that :meth:`compact` was called on: the phases of its variation are computed again."""
        return self if self.change is None else self._with(self.change(self))

    def compact(self):
        """The state with the phases of the solution, which are shared, instead of the variation's own."""
        return self if self.change is None else self._with(self.shown.with_phases(self.shown.solution.phases))

    def _with(self, shown):
        field, pattern = self.field_and_pattern(shown)
        return replace(self, field=field, pattern=pattern)


class _States:
    """States that an object has shown, by the lines of :func:`show_line`: the present one whole, all others compact."""

    def __init__(self):
        self._compact, self._line, self._present = {}, None, None

    def put(self, line, solved, instead):
        if instead:
            self._compact.pop(self._line, None)
        self._line, self._present = line, solved
        self._compact[line] = solved.compact()
        meshes = {id(state.request.given.mesh): None for state in reversed(self._compact.values())}
        kept = list(meshes)[:SOLVES]
        lines = [line for line, state in self._compact.items() if id(state.request.given.mesh) in kept]
        self._compact = {line: self._compact[line] for line in lines[-STATES:]}

    def holds(self, line):
        return line is None or line in self._compact

    def compact(self, line):
        return self._compact[self._line if line is None else line]

    def get(self, line):
        if line not in (None, self._line):
            self._line, self._present = line, self._compact[line].restored()
        return self._present


def show_line(obj, line, number):
    """Store on the object which state it shows, as a line of :func:`kept_results.result_line`, and set the slider."""
    if hasattr(obj, "synch"):  # as long as the extension is registered
        assign(obj.synch, "result", "")  # so that setting the slider does not start a change
        assign(obj.synch_shown, "variation", number)
        assign(obj.synch, "result", line)


def show_nothing(obj):
    """Store on the object that it shows no state of a solve, and forget its solves."""
    at_the_end(lambda: forget(obj))
    show_line(obj, "", 0)


def _line(obj):
    """The line of the state that an object shows; None, for the latest one, if the extension is not registered."""
    return obj.synch.result if hasattr(obj, "synch") else None


def remember(obj, line, solved, instead=False):
    """Keep the state that an object shows now, beside the last one or ``instead`` of it."""
    states = _fields.get(obj) if _fields.holds(obj) else _States()
    states.put(line, solved, instead)
    _fields.put(obj, states)


def state(obj):
    """The :class:`Solved` of the result that an object shows, even if its mesh has changed since.

    Raises SynchError if it is no longer kept.
    """
    states = _fields.get(obj)
    if not states.holds(_line(obj)):
        raise SynchError(f"what {obj.name} shows is no longer in memory: solve it again")
    return states.get(_line(obj))


def recall(obj):
    """The :class:`Solved` that an object in object mode shows.

    Raises SynchError if it is no longer kept, the mesh has changed since, or its attributes are those of another solve.
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
    """Whether an object's mesh, or what a quad mesh was made of, has changed since it was solved; compared again only
    after a change."""
    source = source_of(obj)
    if source is not None and obj.synch.made_from and source.mode == "OBJECT":
        return made_from.has_changed(obj, source)
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
    """As :func:`state`, but compact (:meth:`Solved.compact`): quick enough for panels."""
    return _fields.get(obj).compact(_line(obj))


def forget(obj):
    """Forget the solves of an object."""
    _fields.drop(obj)


def holds(obj):
    """Whether the solve of an object's result is still kept, even if its mesh has changed since."""
    return _fields.holds(obj) and _fields.get(obj).holds(_line(obj))
