# SPDX-License-Identifier: GPL-3.0-or-later
"""Fields, patterns and quad meshes as jobs: read, solve in any thread, write what was found and remember it."""

from dataclasses import replace

import bpy

from ...core.errors import ContradictionError, SynchError
from ...core.extract.quad_mesh import quad_mesh as traced_quads
from ..blender import meshes
from ..jobs.jobs import portion
from ..jobs.report import Report, result_line
from . import frame_attributes, memory, numbers, quad_mesh, write
from .reading import PATTERNS, gather, settings_for, solve_directions, solve_pattern


class FieldJob:
    """One run in three steps, of which only the middle one takes long and touches no Blender data.

    Making it reads the object and refuses what cannot be; :meth:`solve` may run in another thread;
    :meth:`write` puts the result into the scene. Before that nothing has changed.
    """

    def __init__(self, command, obj, settings):
        meshes.refuse(obj)
        settings = settings_for(command, obj, settings)
        bpy.context.view_layer.update()  # a script may have scaled the object just now
        self.command = command
        self._report = Report(command, obj, settings)
        self._field = self._pattern = self._quads = None
        with meshes.object_mode(obj), self._report.clock("read"):
            self._task = gather(command, obj, settings)
            self._report.warn_about(obj, self._task)

    @property
    def vertex_count(self):
        """Of the mesh that is solved on."""
        return self._task.given.mesh.vertex_count

    def solve_early(self, callback=None):
        """A first result by one eigenvector each, for :func:`write.results`: task, field, pattern and a report; None
        for a command that shows no pattern. Errors as :meth:`solve`."""
        if self.command not in ("stripes", "quads"):
            return None
        task = replace(self._task, settings=replace(self._task.settings, method="spectral"))
        report = self._report.again()
        field = solve_directions(task, portion(callback, 0.0, 0.5))
        return task, field, solve_pattern(task, field, report, portion(callback, 0.5, 0.5)), report

    def solve(self, callback=None):
        """Solve on the arrays alone.

        Raises
        ------
        Cancelled
            when the callback returns False
        ContradictionError
            naming vertices of the object
        """
        try:
            self._solve(callback)
        except ContradictionError as error:
            raise error.renumbered(self._task.given.source) from None

    def _solve(self, callback):
        alone = self.command not in PATTERNS
        self._field = solve_directions(self._task, callback if alone else portion(callback, 0.0, 0.4))
        if not alone:
            self._pattern = solve_pattern(self._task, self._field, self._report, portion(callback, 0.4, 0.55))
        if self.command == "quad_mesh":
            self._quads = trace(self._task, self._pattern, self._report)

    def write(self, obj):
        """Write the result to the object at once; returns the report."""
        with meshes.object_mode(obj):
            if not meshes.is_unchanged(obj, self._task.given):
                raise SynchError(f"the mesh or the scale of {obj.name} changed while it was solved: run again")
            if self._quads is None:
                return write_result(obj, self._task, self._field, self._pattern, self._report)
            return write_quads(obj, self._task, self._field, self._pattern, self._quads, self._report)


def write_result(obj, task, field, pattern, report, number=0, change=None):
    """Write a field and remember it as variation ``number`` of its solve, made by ``change``; returns the report."""
    with report.clock("write"):
        defects, task = show(obj, task, field, pattern, report)
    plain = report.finish(field, pattern, defects)
    _remember(obj, memory.Solved(task, field, pattern, report, plain, number, change))
    return plain


def write_again(obj, solved):
    """Write a state of the present solve once more, as it was."""
    _, task = show(obj, solved.task, solved.field, solved.pattern, solved.report.again())
    _remember(obj, replace(solved, task=task))


def show(obj, task, field, pattern, report):
    """Write a field or pattern in place of all that an object shows; returns its defects, and the task with the faces
    as they are now."""
    frame_attributes.remove_frames(obj)
    defects, polygons = write.results(obj, task, field, pattern, report)
    task = replace(task, given=replace(task.given, polygons=polygons))
    numbers.renew_numbers(obj, task, pattern)
    return defects, task


def _remember(obj, solved):
    line = result_line(solved.plain)
    memory.show_line(obj, line, solved.number)
    memory.remember(obj, line, solved)


def trace(task, pattern, report):
    """The quad mesh of a pattern's grid lines."""
    with report.clock("extract"):
        return quad_mesh.smoothed(traced_quads(pattern.edge_phases), task)


def write_quads(obj, task, field, pattern, quads, report):
    """Make the quad mesh's object; returns the report."""
    with report.clock("write"):
        defects = write.reported_defects(obj, task, field, pattern)
        report.quad_mesh = quad_mesh.write(obj, task, quads)
    plain = report.finish(field, pattern, defects)
    made = bpy.data.objects[report.quad_mesh["object"]]
    if hasattr(made, "synch"):  # as long as the extension is registered
        made.synch.result = result_line(plain)
    return plain
