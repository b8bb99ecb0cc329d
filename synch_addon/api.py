# SPDX-License-Identifier: GPL-3.0-or-later
"""The Python API: one function for each command on a mesh object, shared by operators and command line.

Each gathers arrays, calls the core, and only then writes; an error or a cancellation leaves the
scene as it was. All return the report that the command line writes as JSON.
"""

from dataclasses import replace

import bpy

from ..core.errors import ContradictionError, SettingError, SynchError
from ..core.extract.quad_mesh import quad_mesh as traced_quads
from ..core.fields.directions import SYMMETRIES
from ..core.fields.placement import variation, with_defects
from . import field_io, frame_nodes, memory, presets, quad_object, scene_io, stripe_numbers, write
from . import isolines as line_object
from .animation import animate as animate
from .bake import BakeJob
from .bake_settings import BakeSettings
from .clebsch import clebsch as clebsch
from .jobs import portion
from .layer_outputs import layer_export as layer_export
from .layer_outputs import layer_toolpaths as layer_toolpaths
from .layer_outputs import layer_volume as layer_volume
from .layer_settings import LayerSettings
from .layers import LayerJob
from .read_back import shown_pattern
from .refine import refine as refine
from .relief import add_relief
from .report import Report, result_line, versions
from .settings import Settings, from_names
from .stripe_numbers import number_stripes as number_stripes
from .task import PATTERNS, gather, settings_for, solve_directions, solve_pattern
from .vortex_choice import choose_point as choose_point


def directions(obj, callback=None, **settings):
    """Solve a direction field on a mesh object and write it as attributes and empties.

    Parameters
    ----------
    obj : bpy.types.Object
    callback : callable(stage, fraction) -> bool, optional; False cancels
    settings : see :class:`Settings`; spacing does not count

    Returns
    -------
    dict, the report

    Raises
    ------
    SynchError
        with one line that names the element and the remedy; nothing is written
    """
    return run("directions", obj, from_names(settings), callback)


def stripes(obj, callback=None, **settings):
    """Solve a stripe pattern along a direction field and write attributes, material and empties.

    Parameters, result and errors as :func:`directions`.
    """
    return run("stripes", obj, from_names(settings), callback)


def quads(obj, callback=None, **settings):
    """Solve a quad pattern along a cross field and write attributes, material and empties.

    Parameters, result and errors as :func:`directions`; the symmetry is always that of a cross.
    """
    return run("quads", obj, from_names(settings), callback)


def quad_mesh(obj, callback=None, **settings):
    """Solve a quad pattern and make the mesh of its grid lines, a new object; the given one is hidden.

    Parameters, result and errors as :func:`quads`; the report says in ``quad_mesh`` how good the mesh is, and in its
    ``object`` what it is called.
    """
    return run("quad_mesh", obj, from_names(settings), callback)


def run(command, obj, settings, callback=None):
    """Run a command by its name, with ready :class:`Settings`."""
    job = FieldJob(command, obj, settings)
    job.solve(callback)
    return job.write(obj)


def layers(obj, callback=None, solid=None, **settings):
    """Fill a closed mesh object and solve evenly spaced layers in it, made as new objects; the given one is hidden.

    Parameters
    ----------
    obj : bpy.types.Object
    callback : callable(stage, fraction) -> bool, optional; False cancels
    solid : TetMesh in the object's space whose boundary is its surface, in place of the one that would fill it
    settings : see :class:`LayerSettings`

    Returns
    -------
    dict, the report: `layers_object`, `curves_object` and `surface_object` are names

    Raises
    ------
    SynchError
        with one line that names the element and the remedy; nothing is written
    """
    job = layer_job(obj, LayerSettings.from_names(settings), solid)
    job.solve(callback)
    return job.write(obj)


def layer_job(obj, settings, solid=None):
    """A :class:`LayerJob` of ready :class:`LayerSettings`."""
    refuse(obj)
    return LayerJob(obj, settings, solid)


def vary(obj, number):
    """Show another near-optimal configuration of the last solve of an object, without solving again.

    Parameters
    ----------
    obj : bpy.types.Object that was solved since the file was opened
    number : 0 for the solution, then the other local optima that were found, then random projections (Eq. 29)

    Returns
    -------
    dict, the report; its energy is that of what is shown

    Raises
    ------
    SynchError
        with one line that names the element and the remedy; nothing is written
    """
    if not isinstance(number, int) or number < 0:
        raise SettingError(f"the variation is {number!r}: give a whole number from 0 on")
    return _show(obj, lambda solved: variation(solved.shown, number), number)


def place_defects(obj, vertices):
    """Show the configuration of an object's last solve with a dislocation at each of some vertices (Section 4.6).

    Parameters
    ----------
    obj : bpy.types.Object with stripes or quads that were solved since the file was opened
    vertices : indices of vertices; how many there may be is the rank of the lifted field less one, for line and cross
        fields half of that

    Result and errors as :func:`vary`.
    """

    def place(solved):
        if solved.pattern is None:
            raise SynchError("defects are placed in stripes and quads: solve one of them first")
        return with_defects(solved.pattern, vertices)

    return _show(obj, place)


def show_again(obj, shown, number):
    """Show a state of an object's last solve that :func:`memory.recall` has given, as variation ``number``.

    Errors as :func:`vary`.
    """
    refuse(obj)
    with scene_io.object_mode(obj):
        task = memory.recall(obj).task
        write.results(obj, task, shown.field, shown.pattern, shown.report.again())
        _keep(obj, replace(shown, task=task), number)


def trace_quads(obj, smoothing=Settings.smoothing):
    """Make the mesh of the quads that an object shows, variations and placed defects included, without another solve.

    Parameters
    ----------
    obj : bpy.types.Object with quads that were solved since the file was opened; it is hidden
    smoothing : how often a vertex moves to the middle of its neighbours on the surface

    Result and errors as :func:`quad_mesh`.
    """
    refuse(obj)
    with scene_io.object_mode(obj):
        solved = memory.recall(obj)
        if solved.task.command != "quads":
            raise SynchError(f"{obj.name} shows no quads: solve quads first")
        task = replace(solved.task, settings=replace(solved.task.settings, smoothing=smoothing))
        report = solved.report.again("quad_mesh")
        return _write_quads(obj, task, solved.field, solved.pattern, _traced(task, solved.pattern, report), report)


def isolines(obj, **settings):
    """Make a curve object of the lines that an object shows: middles or edges of stripes, grid lines of quads.

    Parameters
    ----------
    obj : bpy.types.Object with stripes or quads
    settings : see :class:`LineSettings`

    Returns
    -------
    dict, the report: its ``object`` is the curve's name

    Raises
    ------
    SynchError
        with one line that names the element and the remedy; nothing is made
    """
    refuse(obj)
    settings = line_object.from_names(settings)
    with scene_io.object_mode(obj):
        return line_object.write(obj, *shown_pattern(obj), settings)


def relief(obj, height=0.15, width=0.5, profile=0, level=None, smooth=False):
    """Raise an object's surface by its pattern, with a geometry nodes modifier that reads the attributes alone.

    Parameters
    ----------
    obj : bpy.types.Object with stripes or quads
    height : in spacings; below 0 the pattern is cut in
    width : part of a period that is raised, or of the area of quads
    profile : of stripes "sine", "square", "triangle", "rounded" or "thread", of quads "grid lines", "checker",
        "weave" or "dots"; or its number
    level : how often the mesh is subdivided; None for as often as its edges need
    smooth : round the surface while it is subdivided

    Returns
    -------
    dict, the report

    Raises
    ------
    SynchError
        with one line that names the element and the remedy; nothing is made
    """
    refuse(obj)
    with scene_io.object_mode(obj):
        made = add_relief(obj, height, width, profile, level, smooth)
    return {"status": "made", "command": "relief", "object": obj.name, **made, "versions": versions()}


def preset(obj, name, callback=None, solve=False, **settings):
    """Show one of the :data:`presets.PRESETS` on an object: on its pattern, or on one that is solved for it.

    Parameters
    ----------
    obj : bpy.types.Object
    name : "zebra", "corduroy", "wood-cut", "knit", "cane" or "fingerprint"
    callback : callable(stage, fraction) -> bool, optional; False cancels the solve
    solve : solve the pattern that the preset is made for, also where the object has one that can show it
    settings : of the solve, in place of the preset's; see :class:`Settings`

    Returns
    -------
    dict, the report: the material's name, and in ``solve`` the report of the solve or None

    Raises
    ------
    SynchError
        with one line that names the element and the remedy; nothing is written
    """
    refuse(obj)
    needed = presets.solve_for(obj, name, solve or bool(settings))
    solved = None if needed is None else run(needed.pop("command"), obj, from_names(needed | settings), callback)
    shown = presets.show(obj, name, bool(settings.get("assign_material")))
    return {"status": "shown", "command": "preset", "object": obj.name, "preset": name} | {
        "material": shown.name,
        "solve": solved,
        "versions": versions(),
    }


def bake(obj, callback=None, **settings):
    """Bake what an object's stripes or quads show into image files, or images packed into the .blend.

    Parameters
    ----------
    obj : bpy.types.Object with stripes or quads; it may be hidden
    callback : callable(stage, fraction) -> bool, optional; False cancels between two maps
    settings : see :class:`BakeSettings`

    Returns
    -------
    dict, the report: files or images, their sizes and seconds by the names of their maps

    Raises
    ------
    SynchError
        with one line that names the element and the remedy; nothing is written
    """
    return run_bake(obj, BakeSettings.from_names(settings), callback)


def run_bake(obj, settings, callback=None):
    """Bake with ready :class:`BakeSettings`."""
    refuse(obj)
    job = BakeJob(obj, settings)
    job.solve(callback)
    return job.report


def _show(obj, change, number=0):
    refuse(obj)
    with scene_io.object_mode(obj):
        solved = memory.recall(obj)
        report = solved.report.again()
        with report.clock("round"):
            field, pattern = solved.showing(change(solved))
        return write_result(obj, solved.task, field, pattern, report, number)


def write_result(obj, task, field, pattern, report, number=0):
    """Write a field and remember it as variation ``number`` of its solve; returns the report."""
    with report.clock("write"):
        frame_nodes.remove_frames(obj)
        defects, polygons = write.results(obj, task, field, pattern, report)
    task = replace(task, given=replace(task.given, polygons=polygons))
    plain = report.finish(field, pattern, defects)
    _keep(obj, memory.Solved(task, field, pattern, report, plain), number)
    stripe_numbers.renew_numbers(obj)
    return plain


def _keep(obj, solved, number):
    """Remember what an object shows now."""
    memory.forget(obj)  # so that setting the slider asks for nothing
    if hasattr(obj, "synch"):  # as long as the extension is registered
        obj.synch.variation, obj.synch.result = number, result_line(solved.plain)
    memory.remember(obj, solved)


def _traced(task, pattern, report):
    """The quad mesh of a pattern's grid lines."""
    with report.clock("extract"):
        return quad_object.smoothed(traced_quads(pattern.edge_phases), task)


def _write_quads(obj, task, field, pattern, quads, report):
    """Make the quad mesh's object; returns the report."""
    with report.clock("write"):
        defects = write.reported_defects(obj, task, field, pattern)
        report.quad_mesh = quad_object.write(obj, task, quads)
    plain = report.finish(field, pattern, defects)
    made = bpy.data.objects[report.quad_mesh["object"]]
    if hasattr(made, "synch"):  # as long as the extension is registered
        made.synch.result = result_line(plain)
    return plain


def refuse(obj):
    """Raise SynchError for an object that cannot be given a field."""
    reason = scene_io.refusal(obj)
    if reason:
        raise SynchError(reason)


def import_field(obj, path):
    """Write the directions of a .rawfield or .rosy file to a mesh object's ``synch_direction``.

    Returns
    -------
    "vector", "line" or "cross", what the file's directions are

    Raises
    ------
    SynchError
        with one line that names the element and the remedy; nothing is written
    """
    refuse(obj)
    with scene_io.object_mode(obj):
        return field_io.import_directions(obj, path)


def export_field(obj, path, symmetry="line"):
    """Write a mesh object's ``synch_direction`` as a .rawfield or .rosy file, one set of directions a triangle.

    Parameters
    ----------
    obj : bpy.types.Object, all of whose faces are triangles
    path : where to
    symmetry : "vector", "line" or "cross", what the directions are

    Raises
    ------
    SynchError
        with one line that names the element and the remedy; nothing is written
    """
    refuse(obj)
    if symmetry not in SYMMETRIES:
        raise SettingError(f"symmetry {symmetry!r} is unknown: use one of {', '.join(SYMMETRIES)}")
    with scene_io.object_mode(obj):
        field_io.export_directions(obj, path, symmetry)


def select(obj, vertices):
    """Select vertices and nothing else of an object's mesh, in object or edit mode."""
    with scene_io.object_mode(obj):
        scene_io.select_vertices(obj, vertices)


class FieldJob:
    """One run in three steps, of which only the middle one takes long and touches no Blender data.

    Making it reads the object and refuses what cannot be; :meth:`solve` may run in another thread;
    :meth:`write` puts the result into the scene. Before that nothing has changed.
    """

    def __init__(self, command, obj, settings):
        refuse(obj)
        settings = settings_for(command, obj, settings)
        bpy.context.view_layer.update()  # a script may have scaled the object just now
        self.command = command
        self._report = Report(command, obj, settings)
        self._field = self._pattern = self._quads = None
        with scene_io.object_mode(obj), self._report.clock("read"):
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
            self._quads = _traced(self._task, self._pattern, self._report)

    def write(self, obj):
        """Write the result to the object at once; returns the report."""
        with scene_io.object_mode(obj):
            if not scene_io.is_unchanged(obj, self._task.given):
                raise SynchError(f"the mesh or the scale of {obj.name} changed while it was solved: run again")
            if self._quads is None:
                return write_result(obj, self._task, self._field, self._pattern, self._report)
            return _write_quads(obj, self._task, self._field, self._pattern, self._quads, self._report)
