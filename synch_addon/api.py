# SPDX-License-Identifier: GPL-3.0-or-later
"""The Python API: one function for each command on a mesh object, shared by operators and command line.

Each gathers arrays, calls the core, and only then writes: an error or a cancellation leaves the scene as it was. All
return the report that the command line writes as JSON. All raise :class:`SynchError`, whose one line names the element
and the remedy.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from numbers import Integral
from pathlib import Path
from typing import Unpack

import bpy

from ..core.errors import SettingError, SynchError, quote_value
from ..core.fields import DirectionField, Pattern
from ..core.fields.placement import check_vertices, move_defects, variation, with_line_ends
from ..core.files.json_text import Json
from ..core.geometry.tet_mesh import TetMesh
from ..core.monitor import Callback
from ..core.settings.bake import BakeSettings
from ..core.settings.keywords import BakeKeywords, LayerKeywords, LineKeywords, SurfaceKeywords
from ..core.settings.layers import LayerSettings
from ..core.settings.lines import LineSettings
from ..core.settings.surface import SYMMETRY_ORDERS, SurfaceSettings
from ..core.tasks.surface_result import SurfaceResult
from ..core.validation import convert_value, from_names
from .bakes.job import BakeJob
from .blender import field_files, meshes
from .blender.modifiers import bends
from .blender.objects import Selection
from .blender.pattern_surface import is_of_modifiers, surface_of
from .blender.transaction import whole_or_nothing
from .flows.choice import choose_point as choose_point
from .flows.files import filament_export as filament_export
from .flows.job import clebsch as clebsch
from .frames.job import animate as animate
from .jobs import job
from .jobs.report import versions
from .looks import presets
from .patterns import lines as line_object
from .patterns import memory
from .patterns.carrying import add_carry
from .patterns.job import FieldJob, rewrite, write_changed, write_quads
from .patterns.numbers import number_stripes as number_stripes
from .patterns.read_back import shown_pattern
from .patterns.refine import refine as refine
from .patterns.relief import add_relief
from .solids.job import LayerJob
from .solids.outputs import layer_export as layer_export
from .solids.outputs import layer_toolpaths as layer_toolpaths
from .solids.outputs import layer_volume as layer_volume

# The largest number that a slider of Blender holds.
MOST_VARIATIONS = 2**31 - 1


def directions(obj: bpy.types.Object, callback: Callback | None = None, **settings: Unpack[SurfaceKeywords]) -> Json:
    """Solve a direction field on a mesh object and write it as attributes and empties.

    Returns dict, the report. Raises SynchError, with nothing written.

    Parameters
    ----------
    obj : bpy.types.Object
    callback : called with a stage and a fraction of the work; False as its answer cancels
    settings : see :class:`SurfaceSettings`; spacing does not count
    """
    return run("directions", obj, from_names(SurfaceSettings, settings), callback)


def stripes(obj: bpy.types.Object, callback: Callback | None = None, **settings: Unpack[SurfaceKeywords]) -> Json:
    """Solve a stripe pattern along a direction field and write attributes, material and empties.

    Parameters, result and errors as :func:`directions`.
    """
    return run("stripes", obj, from_names(SurfaceSettings, settings), callback)


def quads(obj: bpy.types.Object, callback: Callback | None = None, **settings: Unpack[SurfaceKeywords]) -> Json:
    """Solve a quad pattern along a cross field and write attributes, material and empties.

    Parameters, result and errors as :func:`directions`; the symmetry is always that of a cross.
    """
    return run("quads", obj, from_names(SurfaceSettings, settings), callback)


def quad_mesh(obj: bpy.types.Object, callback: Callback | None = None, **settings: Unpack[SurfaceKeywords]) -> Json:
    """Solve a quad pattern and make the mesh of its grid lines, a new object; the given one is hidden.

    Parameters, result and errors as :func:`quads`; the report says in ``quad_mesh`` how good the mesh is, and in its
    ``object`` what it is called.
    """
    return run("quad_mesh", obj, from_names(SurfaceSettings, settings), callback)


def run(command: str, obj: bpy.types.Object, settings: SurfaceSettings, callback: Callback | None = None) -> Json:
    """Run a command by its name, with ready :class:`SurfaceSettings`."""
    asked = FieldJob(command, obj, settings)
    return job.run(asked, callback)


def layers(
    obj: bpy.types.Object,
    callback: Callback | None = None,
    solid: TetMesh | None = None,
    **settings: Unpack[LayerKeywords],
) -> Json:
    """Fill a closed mesh object and solve evenly spaced layers in it, made as new objects; the given one is hidden.

    Returns dict, the report: `layers_object`, `curves_object` and `surface_object` are names. Raises SynchError,
    with nothing written.

    Parameters
    ----------
    callback : as for :func:`directions`
    solid : TetMesh in the object's space whose boundary is its surface, in place of the one that would fill it
    settings : see :class:`LayerSettings`
    """
    return job.run(layer_job(obj, from_names(LayerSettings, settings), solid), callback)


def layer_job(obj: bpy.types.Object, settings: LayerSettings, solid: TetMesh | None = None) -> LayerJob:
    """A :class:`LayerJob` of ready :class:`LayerSettings`."""
    return LayerJob(obj, settings, solid)


def vary(obj: bpy.types.Object, number: int) -> Json:
    """Show another near-optimal configuration of the last solve of an object, without solving again.

    Returns dict, the report; its energy is that of what is shown. Raises SynchError, with nothing written.

    Parameters
    ----------
    obj : that was solved since the file was opened
    number : 0 for the solution, then the other local optima that were found, then seeds of further searches
    """
    if not isinstance(number, Integral) or isinstance(number, bool) or not 0 <= number <= MOST_VARIATIONS:
        raise SettingError(f"the variation is {quote_value(number)}: give a whole number from 0 to {MOST_VARIATIONS}")

    def change(solved: memory.Solved) -> DirectionField | Pattern:
        return variation(solved.shown, number)

    meshes.refuse(obj)
    with meshes.object_mode(obj), whole_or_nothing():
        return write_changed(obj, memory.recall(obj), change, change, number)


def place_defects(
    obj: bpy.types.Object, vertices: Sequence[int], renumber: bool = True, onto: memory.Solved | None = None
) -> Json:
    """Put a line end beside each of some vertices, where a short stripe begins; farther away the pattern stays.

    Parameters
    ----------
    obj : with stripes or quads that were solved since the file was opened
    vertices : indices of vertices
    renumber : whether numbered stripes are numbered anew; :func:`numbers.renew_shown` does it after the last of many
    onto : state of :func:`memory.recall` that they are put into, in place of what is shown

    Result and errors as :func:`vary`. Where phases are mirrored, the same happens at the mirror images.
    """
    return _edit(obj, lambda solved: with_line_ends(solved.needed_pattern, vertices), renumber, onto)


def move_defect(
    obj: bpy.types.Object, face: int, to_face: int, renumber: bool = True, onto: memory.Solved | None = None
) -> Json:
    """Move the line ends in a face to another one; farther away the pattern stays.

    Faces are those of the mesh that carries the pattern. Other parameters, result and errors as :func:`place_defects`.
    """

    def move(solved: memory.Solved) -> Pattern:
        starts, targets = (meshes.triangles_of_face(solved.request.given, number) for number in (face, to_face))
        return move_defects(solved.needed_pattern, starts, targets)

    return _edit(obj, move, renumber, onto)


def show_again(obj: bpy.types.Object, shown: memory.Solved) -> None:
    """Show a state of an object's last solve that :func:`memory.recall` has given.

    Errors as :func:`vary`.
    """
    meshes.refuse(obj)
    with meshes.object_mode(obj), whole_or_nothing():
        rewrite(obj, replace(shown, request=memory.recall(obj).request))


def trace_quads(obj: bpy.types.Object, smoothing: int = SurfaceSettings.smoothing) -> Json:
    """Make the mesh of the quads that an object shows, variations and placed defects included, without another solve.

    Parameters
    ----------
    obj : with quads that were solved since the file was opened; it is hidden
    smoothing : how often a vertex moves to the middle of its neighbours on the surface

    Result and errors as :func:`quad_mesh`.
    """
    meshes.refuse(obj)
    smoothing = from_names(SurfaceSettings, {"smoothing": smoothing}).smoothing
    with meshes.object_mode(obj), whole_or_nothing():
        solved = memory.recall(obj)
        if solved.request.command != "quads":
            raise SynchError(f"{obj.name} shows no quads: solve quads first")
        request = solved.request.smoothed(smoothing)
        found = SurfaceResult(solved.field, solved.pattern, **request.finish(*request.trace(solved.pattern)))
        report = solved.report.for_another_result("quad_mesh")
        report.take(found)
        report.asked = replace(report.asked, pins=report.settings.pins)  # on the faces that the object has now
        bending = [one for one in obj.modifiers if bends(one) and not is_of_modifiers(obj)]
        return write_quads(obj, request, found, report, Selection.now(), surface_of(obj), bending)


def isolines(obj: bpy.types.Object, **settings: Unpack[LineKeywords]) -> Json:
    """Make a curve object of the lines that an object shows: middles or edges of stripes, grid lines of quads.

    Returns dict, the report: its ``object`` is the curve's name. Raises SynchError, with nothing made.

    Parameters
    ----------
    obj : with stripes or quads
    settings : see :class:`LineSettings`
    """
    meshes.refuse(obj)
    chosen = from_names(LineSettings, settings)
    with meshes.object_mode(obj), whole_or_nothing():
        request, pattern = shown_pattern(obj)
        return line_object.write(obj, request, pattern, chosen)


def relief(
    obj: bpy.types.Object,
    height: float = 0.15,
    width: float = 0.5,
    profile: str | int = 0,
    level: int | None = None,
    smooth: bool = False,
) -> Json:
    """Raise an object's surface by its pattern, with a geometry nodes modifier that reads the attributes alone.

    Returns dict, the report. Raises SynchError, with nothing made.

    Parameters
    ----------
    obj : with stripes or quads
    height : in spacings; below 0 the pattern is cut in
    width : part of a period that is raised, or of the area of quads
    profile : of stripes "sine", "square", "triangle", "rounded" or "thread", of quads "grid lines", "checker",
        "weave" or "dots"; or its number
    level : how often the mesh is subdivided; None for as often as its edges need
    smooth : round the surface while it is subdivided
    """
    meshes.refuse(obj)
    with meshes.object_mode(obj), whole_or_nothing():
        made = add_relief(obj, height, width, profile, level, smooth)
    return {"status": "made", "command": "relief", "object": obj.name, **made, "versions": versions()}


def carry(obj: bpy.types.Object) -> Json:
    """Carry an object's pattern through its modifiers, with one of ours after them: what vertices have of it is made
    anew on the mesh that they leave.

    Returns dict, the report: the modifier's name. Raises SynchError, with nothing made.

    Parameters
    ----------
    obj : bpy.types.Object with stripes or quads
    """
    meshes.refuse(obj)
    with meshes.object_mode(obj), whole_or_nothing():
        made = add_carry(obj)
    return {"status": "made", "command": "carry", "object": obj.name, "modifier": made.name, "versions": versions()}


def preset(
    obj: bpy.types.Object,
    name: str,
    callback: Callback | None = None,
    solve: bool = False,
    **settings: Unpack[SurfaceKeywords],
) -> Json:
    """Show one of the :data:`presets.PRESETS` on an object: on its pattern, or on one that is solved for it.

    Returns dict, the report: the material's name, and in ``solve`` the report of the solve or None. Raises SynchError,
    with nothing written.

    Parameters
    ----------
    name : "zebra", "corduroy", "wood-cut", "knit", "cane" or "fingerprint"
    callback : as for :func:`directions`
    solve : solve the pattern that the preset is made for, also where the object has one that can show it
    settings : of the solve, in place of the preset's; see :class:`SurfaceSettings`
    """
    meshes.refuse(obj)
    needed = presets.solve_for(obj, name, convert_value("solve", bool, solve) or bool(settings))
    solved = None
    if needed is not None:
        solved = run(needed.pop("command"), obj, from_names(SurfaceSettings, needed | settings), callback)
    shown = presets.show(obj, name, bool(settings.get("assign_material")))
    return {"status": "shown", "command": "preset", "object": obj.name, "preset": name} | {
        "material": shown.name,
        "solve": solved,
        "versions": versions(),
    }


def bake(obj: bpy.types.Object, callback: Callback | None = None, **settings: Unpack[BakeKeywords]) -> Json:
    """Bake what an object's stripes or quads show into image files, or images packed into the .blend.

    Returns dict, the report: files or images, their sizes and seconds by the names of their maps. Raises SynchError,
    with nothing written.

    Parameters
    ----------
    obj : with stripes or quads; it may be hidden
    callback : asked between two maps
    settings : see :class:`BakeSettings`
    """
    return run_bake(obj, from_names(BakeSettings, settings), callback)


def run_bake(obj: bpy.types.Object, settings: BakeSettings, callback: Callback | None = None) -> Json:
    """Bake with ready :class:`BakeSettings`."""
    meshes.refuse(obj)
    return job.run(BakeJob(obj, settings), callback)


def _edit(
    obj: bpy.types.Object, edit: Callable[[memory.Solved], Pattern], renumber: bool, onto: memory.Solved | None
) -> Json:
    """Show what ``edit`` makes of what an object shows, or of another state of its last solution."""
    if onto is not None and not isinstance(onto, memory.Solved):
        raise SettingError(f"the state is {quote_value(onto)}: give one of memory.recall, or None")
    renumber = convert_value("renumber", bool, renumber)
    meshes.refuse(obj)
    with meshes.object_mode(obj), whole_or_nothing():
        shown = memory.recall(obj)
        onto = shown if onto is None else replace(onto, request=shown.request)
        return write_changed(obj, onto, edit, onto.then(edit), onto.number, renumber)


def import_field(obj: bpy.types.Object, path: str | Path) -> str:
    """Write the directions of a .rawfield or .rosy file to a mesh object's ``synch_direction``.

    Returns "vector", "line" or "cross", what the file's directions are. Raises SynchError, with nothing written.
    """
    meshes.refuse(obj)
    with meshes.object_mode(obj), whole_or_nothing():
        return field_files.import_directions(obj, path)


def export_field(obj: bpy.types.Object, path: str | Path, symmetry: str = "line") -> None:
    """Write a mesh object's ``synch_direction`` as a .rawfield or .rosy file, one set of directions a triangle.

    Raises SynchError, with nothing written.

    Parameters
    ----------
    obj : all of whose faces are triangles
    path : where to
    symmetry : "vector", "line" or "cross", what the directions are
    """
    meshes.refuse(obj)
    if convert_value("symmetry", str, symmetry) not in SYMMETRY_ORDERS:
        raise SettingError(f"symmetry {quote_value(symmetry)} is unknown: use one of {', '.join(SYMMETRY_ORDERS)}")
    with meshes.object_mode(obj):
        field_files.export_directions(obj, path, symmetry)


def select(obj: bpy.types.Object, vertices: Sequence[int]) -> None:
    """Select vertices and nothing else of an object's mesh, in object or edit mode.

    Raises SettingError for numbers that are not vertices.
    """
    meshes.refuse(obj)
    chosen = check_vertices(vertices, len(obj.data.vertices))
    with meshes.object_mode(obj):
        meshes.select_vertices(obj, chosen)
