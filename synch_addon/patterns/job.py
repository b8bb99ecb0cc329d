# SPDX-License-Identifier: GPL-3.0-or-later
"""Fields, patterns and quad meshes as jobs: the scene is read into a request, its result is written and remembered."""

from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import asdict, replace

import bpy
import numpy as np

from ...core.errors import AsymmetryError, SynchError
from ...core.fields import DirectionField, Pattern
from ...core.files.json_text import Json
from ..blender import meshes
from ..blender.modifiers import bends, foreign_modifiers
from ..blender.objects import ObjectLink, Selection
from ..blender.pattern_surface import surface_of
from ..blender.transaction import assign, whole_or_nothing
from ..jobs.kept_results import result_line
from ..jobs.report import Report
from ..reading.refinement import refinement_of, solved_object
from ..reading.surface import gather, settings_for
from ..settings.fields import mesh_values
from . import frame_attributes, made_from, memory, numbers, own_surface, painted_back, quad_mesh, write
from .curves_read import curves_read


class FieldJob:
    """A field, a pattern or a quad mesh of an object; see :mod:`..jobs.job`.

    ``replaced`` is an earlier quad mesh of the object, whose place the new one and its first results take;
    ``ended_early`` says whether the result is one that the user did not want to wait longer for.
    """

    ended_early = False

    def __init__(self, command, obj, settings, replaced=None):
        meshes.refuse(obj)
        settings = settings_for(command, obj, settings)
        self.link, self._selection = ObjectLink.to(obj), Selection.now()
        self.replaced = None if replaced is None else ObjectLink.to(replaced)
        self._report = Report(command, obj, settings)
        with meshes.object_mode(obj), self._report.clock("read"):
            try:
                settings = self._read(command, obj, settings, follows_mirror=True)
            except AsymmetryError:  # modifiers after the mirror may spoil its symmetry
                if settings.mirror:
                    raise
                settings = self._read(command, obj, settings, follows_mirror=False)
            self._report.curves_read = curves_read(obj, settings)
            self._report.warn_about(obj, self.request, self._refinement)
            if command == "quad_mesh":
                self._report.made_from = made_from.made_from(obj, self._report.asked, self._refinement is not None)

    def _read(self, command, obj, settings, follows_mirror):
        """Read the request, with arguments of :func:`refinement_of`; returns the settings with its mirror and pins."""
        self._refinement, read = refinement_of(command, obj, settings, follows_mirror)
        if self._refinement is not None:
            settings = replace(settings, mirror=self._refinement.mirror)
        with solved_object(obj, self._refinement) as surface:
            self._pins = own_surface.moved_pins(settings.pins, surface_of(obj), surface)
            settings = self._report.settings = replace(settings, pins=self._pins)
            self.request = gather(command, surface, settings, read=read)
        return settings

    def write(self, result):
        """Write the result to the object at once; returns the report."""
        obj, request = self.link.found, self.request
        self._report.take(result)
        self._report.ended_early = self.ended_early
        with meshes.object_mode(obj), whole_or_nothing():
            if result.quads is not None:
                with solved_object(obj, self._refinement) as surface:
                    _refuse_changed(obj, meshes.is_unchanged(surface, request.given))
                    replaced = None if self.replaced is None else self.replaced.found
                    self._warn_of_poses(obj)
                    with nullcontext() if replaced is None else meshes.object_mode(replaced):
                        chosen = self._report, self._selection
                        return write_quads(obj, request, result, *chosen, surface, self._bending(obj), replaced)
            own_surface.bind(obj, self._refinement, self._report.warn)
            _refuse_changed(obj, own_surface.is_unchanged(obj, request.given))
            if hasattr(obj, "synch") and obj.synch.pins == self._report.asked.pins != self._pins:
                assign(obj.synch, "pins", self._pins)
            return write_result(obj, request, result.field, result.pattern, self._report)

    def _bending(self, obj):
        """The modifiers of an object that have not shaped the surface, and bend any mesh alike."""
        is_seen = self._refinement is not None and self._refinement.is_seen
        return [one for one in obj.modifiers if bends(one) and (not is_seen or one.name in self._refinement.unbent)]

    def _warn_of_poses(self, obj):
        """Warn of armatures whose pose has shaped the surface, unless the setting asks for what modifiers show."""
        if self._refinement is None or not self._refinement.is_seen or self._report.settings.surface == "seen":
            return
        kept = self._refinement.unbent
        posing = [one for one in foreign_modifiers(obj) if one.type == "ARMATURE" and one.name not in kept]
        if posing:
            names, last = " and ".join(modifier.name for modifier in posing), foreign_modifiers(obj)[-1].name
            self._report.warn(
                f"the pose of {names} is part of the quad mesh, which the rig does not move: to change that, move "
                f"{names} below {last} and make it again"
            )


def _refuse_changed(obj, is_unchanged):
    if not is_unchanged:
        raise SynchError(f"the mesh or the scale of {obj.name} changed while it was solved: run again")


def write_result(obj, request, field, pattern, report, number=0, change=None, renumber=True, instead=False) -> Json:
    """Write a field and remember it as variation ``number`` of its solve, made by ``change``; returns the report.

    Numbers of stripes stay as they are where they are not to be renewed, for :func:`numbers.renew_shown`. It is kept
    ``instead`` of what was kept last, or beside it.
    """
    report.pins_cost = _pins_cost(obj, request, field, report)
    with report.clock("write"):
        defects, request = show(obj, request, field, pattern, report, renumber)
    plain = report.finish(field, pattern, defects)
    _remember(obj, memory.Solved(request, field, pattern, report, plain, number, change), instead)
    return plain


def write_changed(
    obj: bpy.types.Object,
    solved: memory.Solved,
    make: Callable[[memory.Solved], DirectionField | Pattern],
    change: Callable[[memory.Solved], DirectionField | Pattern],
    number: int,
    renumber: bool = True,
) -> Json:
    """Write what ``make`` finds, which is a change of the solution."""
    report = solved.report.for_another_result()
    with report.clock("round"):
        field, pattern = solved.field_and_pattern(make(solved))
    return write_result(obj, solved.request, field, pattern, report, number, change, renumber)


def _pins_cost(obj, request, field, report):
    """How much more the directions bend than those that the object shows, as a share, where only the pins are others;
    else None."""
    if not memory.holds(obj):
        return None
    shown = memory.solve_of(obj)
    before, now = shown.report.settings, report.settings
    same = before.pins != now.pins and replace(before, pins=now.pins) == now
    if not same or shown.request.command != request.command or shown.field.bending == 0:
        return None
    given = shown.request.given.mesh
    if not np.array_equal(given.triangles, request.given.mesh.triangles) or not np.array_equal(
        given.vertices, request.given.mesh.vertices
    ):
        return None
    return field.bending / shown.field.bending - 1


def rewrite(obj, solved):
    """Write a state of the present solve again, unchanged."""
    _, request = show(obj, solved.request, solved.field, solved.pattern, solved.report.for_another_result())
    _remember(obj, replace(solved, request=request))


def show(obj, request, field, pattern, report, renumber=True):
    """Write a field or pattern in place of all that an object shows.

    Returns its defects, and the request with the faces as they are now.
    """
    frame_attributes.remove_frames(obj)
    defects, polygons = write.results(obj, request, field, pattern, report)
    request = request.on_mesh(replace(request.given, polygons=polygons))
    if renumber:
        numbers.renew_numbers(obj, request, pattern)
    return defects, request


def _remember(obj, solved, instead=False):
    line = result_line(solved.plain)
    memory.show_line(obj, line, solved.number)
    if solved.pattern is not None and hasattr(obj, "synch") and obj.synch.automatic_spacing:
        assign(obj.synch, "spacing", solved.request.spacing)  # where it begins once it is no longer automatic
    memory.remember(obj, line, solved, instead)


def write_quads(obj, request, result, report, selection, surface, bending, replaced=None) -> Json:
    """Make the quad mesh's object, or give ``replaced`` its faces, with what the object ``surface`` carries that was
    solved on, and the modifiers that bend it, too; returns the report."""
    with report.clock("write"):
        defects = write.reported_defects(obj, result.given or request.given, result.field, result.pattern)
        report.quad_mesh = quad_mesh.write(obj, request, result.quads, selection, surface, bending, replaced)
        if result.loops_before is not None:
            report.quad_mesh["loops_before"] = result.loops_before
    plain = report.finish(result.field, result.pattern, defects)
    made = bpy.data.objects[report.quad_mesh["object"]]
    if hasattr(made, "synch"):  # as long as the extension is registered
        spacing = plain["settings"]["spacing"]
        for name, value in mesh_values(report.asked, spacing).items() if report.made_from else ():
            assign(made.synch, name, value)
        painted_back.note_map(made)
        asked = asdict(report.asked) | {"spacing": spacing}
        assign(made.synch, "made_from", report.made_from)
        assign(made.synch, "result", result_line(plain | {"carrier": {}, "settings": asked}))  # it is a surface
    return plain
