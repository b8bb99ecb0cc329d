# SPDX-License-Identifier: GPL-3.0-or-later
"""Patterns on a moving mesh: read in every frame, solved from frame to frame, and stored side by side.

The mesh of a frame is the one behind the object's modifiers, as long as they keep its faces.
"""

import math
import time
from contextlib import contextmanager
from dataclasses import dataclass, replace

import bpy
import numpy as np

from ...core.errors import Cancelled, ContradictionError, MeshError, SettingError, SynchError
from ...core.fields import given_directions
from ...core.fields.directions import SYMMETRIES, DirectionField
from ...core.fields.frames import carried_angles, is_moved
from ...core.geometry import TriangleMesh
from ...core.geometry.polygons import Polygons
from ...core.interpolate import EdgePhases, face_phases
from ...core.keywords import check_choice, from_names
from ..blender import attributes, meshes, modifiers
from ..blender.defect_empties import write_defects
from ..blender.modifiers import hidden
from ..jobs.jobs import portion
from ..jobs.report import Report
from ..nodes.materials import pattern_material
from ..patterns import frame_attributes, memory, numbers, write
from ..patterns.reading import gather, settings_for, solve_directions, solve_pattern
from ..settings.fields import Settings
from . import nodes

# How strongly a pattern holds on to the frame before. Measured: jumps become slides, for up to 3 % of energy.
HOLD = 0.1
# The first frame is searched for; the others only go on. What part of the work reading is, and the first frame's share.
_READING, _FIRST = 0.1, 4
# Seconds of reading at each tick of the window's timer.
_PIECE = 0.1


@dataclass(frozen=True)
class Span:
    """Frames to solve, and what.

    Attributes
    ----------
    first, last : frames
    pattern : "stripes" or "quads"
    hold : how strongly the phases are drawn to those of the frame before; 0 for not at all
    """

    first: int
    last: int
    pattern: str = "stripes"
    hold: float = HOLD

    def __post_init__(self):
        if not (isinstance(self.first, int) and isinstance(self.last, int) and self.first <= self.last):
            raise SettingError(f"the frames are {self.first!r} to {self.last!r}: give the first and the last, in order")
        check_choice(self, "pattern", modifiers.FRAMES)
        if not isinstance(self.hold, int | float) or not (math.isfinite(self.hold) and self.hold >= 0):
            raise SettingError(f"the hold is {self.hold!r}: give a number from 0 on, such as {HOLD}")

    @property
    def frames(self):
        return range(self.first, self.last + 1)


@dataclass(frozen=True)
class _Frame:
    """What is kept of a solved frame."""

    number: int
    edge_phases: EdgePhases
    polygons: Polygons
    directions: np.ndarray
    figures: dict


def animate(obj, callback=None, frames=None, pattern="stripes", hold=HOLD, **settings):
    """Solve a pattern in each frame of a moving mesh, each frame from the one before; a modifier shows them.

    Parameters
    ----------
    obj : bpy.types.Object, whose shape keys and modifiers keep its faces
    callback : callable(stage, fraction) -> bool, optional; False cancels
    frames : first and last frame; None for the scene's
    pattern, hold : see :class:`Span`
    settings : see :class:`Settings`

    Returns the report, whose ``frames`` are figures of each; errors as :func:`api.directions`.
    """
    scene = bpy.context.scene
    frames = (scene.frame_start, scene.frame_end) if frames is None else frames
    return run_animate(obj, from_names(Settings, settings), frames, pattern, hold, callback)


def run_animate(obj, settings, frames, pattern, hold, callback=None):
    """Animate with ready :class:`Settings`."""
    job = AnimationJob(obj, settings, Span(*frames, pattern, hold))
    job.solve(callback)
    return job.write(obj)


class AnimationJob:
    """A run in three steps like :class:`field_job.FieldJob`: reading all frames, solving them in any thread, writing.

    Frames are read in pieces by :meth:`advance`, see :class:`jobs.ReadAndSolve`, or else by :meth:`solve`. After each
    piece the scene's frame is the same as before; nothing else changes before :meth:`write`.
    """

    def __init__(self, obj, settings, span):
        reason = meshes.refusal(obj)
        if reason is None and not obj.visible_get():
            reason = f"{obj.name} is hidden and does not move: show it in the viewport"
        if reason:
            raise SynchError(reason)
        self._obj, self._span, self._settings = obj, span, settings_for(span.pattern, obj, settings)
        self._report = Report("animate", obj, self._settings)
        self._tasks, self._solved = [], []
        with meshes.object_mode(obj), self._report.clock("read"):
            self._base = meshes.read_mesh(obj)
            self._rest = _rest_directions(obj, self._settings, span)

    def advance(self):
        """Read frames for a moment; returns what comes next and the share that is done, None when all are read."""
        until = time.monotonic() + _PIECE
        return self._read(lambda *_: time.monotonic() < until)

    def solve(self, callback=None):
        """Read what is left, and solve on the arrays alone; errors as of :class:`field_job.FieldJob`, by frame."""
        if self._read(callback or (lambda *_: True)) is not None:
            raise Cancelled("cancelled: nothing was changed")
        done, work = 0, len(self._tasks) + _FIRST - 1
        field = pattern = None
        for number, frame in enumerate(self._span.frames):
            task, share = self._tasks[number], 1 if number else _FIRST
            begin, whole = _READING + (1 - _READING) * done / work, (1 - _READING) * share / work
            ask = portion(_saying(callback, frame), begin, whole)
            try:
                found = _solved(task, field, pattern, self._span.hold, self._report if number == 0 else None, ask)
            except ContradictionError as error:
                raise _in_frame(frame, error.renumbered(task.given.source)) from None
            self._keep(frame, task, *found, pattern)
            field, pattern = found
            if number == 0:
                self._first = found
            else:
                self._tasks[number] = None  # its mesh is not needed any more
            done += share

    def _read(self, goes_on):
        """Read a :class:`Task` of each frame until ``goes_on(stage, fraction)`` is false; returns those, or None."""
        frames = self._span.frames
        if len(self._tasks) == len(frames):
            return None
        with meshes.object_mode(self._obj), self._report.clock("read"), _at_present(self._obj):
            while len(self._tasks) < len(frames):
                self._tasks.append(self._task(frames[len(self._tasks)]))
                done = len(self._tasks)
                if done < len(frames):
                    piece = f"read frame {frames[done]}", _READING * done / len(frames)
                    if not goes_on(*piece):
                        return piece
        self._report.warn_about(self._obj, self._tasks[0])
        return None

    def _task(self, frame):
        bpy.context.scene.frame_set(frame)
        task = _task(self._obj, frame, self._settings, self._span, self._base.polygons)
        self._settings = replace(self._settings, spacing=task.spacing)  # an automatic one is that of the first frame
        return task if self._rest is None else _following(task, self._rest)

    def _keep(self, frame, task, field, pattern, before):
        """Keep what is written of a frame; all frames share the mesh of the first, whose places do not count."""
        phases, shared = pattern.edge_phases, self._tasks[0].given.mesh
        if is_moved(shared, phases.mesh):
            phases = replace(phases, mesh=shared)
        figures = {
            "frame": frame,
            "energy": pattern.energy,
            "direction_energy": field.energy,
            "disclinations": len(field.disclinations),
            "dislocations": len(pattern.dislocations),
            "change": None if before is None else _change(before, pattern),
        }
        directions = task.given.to_object(field.vectors).astype(np.float32)
        self._solved.append(_Frame(frame, phases, task.given.polygons, directions, figures))

    def write(self, obj):
        """Write all frames to the object at once; returns the report."""
        with meshes.object_mode(obj):
            if not meshes.is_unchanged(obj, self._base):
                raise SynchError(f"the mesh or the scale of {obj.name} changed while it was solved: run again")
            task, (field, pattern) = self._tasks[0], self._first
            defects = write.reported_defects(obj, task, field, pattern)
            with self._report.clock("write"):
                self._write(obj, task)
        report = self._report.finish(field, pattern, defects)
        return report | {
            "pattern": self._span.pattern,
            "hold": self._span.hold,
            "frames": [frame.figures for frame in self._solved],
        }

    def _write(self, obj, task):
        frame_attributes.remove_frames(obj)
        corners = self._split(obj)
        count = self._base.mesh.vertex_count
        own = frame_attributes.frame_layout(self._span.pattern)
        places, first = None, None
        for frame in self._solved:
            phases = face_phases(frame.edge_phases, corners(frame.polygons))
            values = write.attribute_values(phases, frame.edge_phases.arguments[:count])
            values["synch_direction"] = frame.directions
            first = values if first is None else first
            place = values["synch_barycentric"]
            # A face's places are the same in all frames in which it is singular, and do not matter in others.
            places = place if places is None else np.where(places.any(axis=1, keepdims=True), places, place)
            for name in own.keys() & values.keys():
                attributes.write_attribute(
                    obj, frame_attributes.frame_name(name, frame.number), *own[name], values[name]
                )
        directions = first.pop("synch_direction")
        write.pattern_attributes(obj, first | {"synch_barycentric": places})
        attributes.write_attribute(obj, "synch_direction", *own["synch_direction"], directions)
        attributes.remove_attribute(obj, "synch_singularity")
        write_defects(obj, [])  # they move
        all_faces = task.settings.assign_material or write.has_one_material(obj)
        pattern_material(obj, self._span.pattern, spacing=task.spacing, assign_faces=all_faces)
        nodes.add_frames(obj, self._span.pattern, self._span.first, self._span.last)
        memory.show_nothing(obj)
        numbers.remove_numbers(obj)
        meshes.update(obj)

    def _split(self, obj):
        """Split the faces that cannot carry their defects in some frame; how polygons are afterwards."""
        unfit = [face_phases(frame.edge_phases, frame.polygons)[0].unfit for frame in self._solved]
        faces = np.unique(np.concatenate(unfit))
        if len(faces) == 0:
            return lambda polygons: polygons
        self._report.warn(write.split_line(faces))
        old_corners = meshes.split_faces(obj, self._base.polygons, faces)
        now = meshes.read_polygons(obj)
        return lambda polygons: replace(now, corner_vertices=polygons.corner_vertices[old_corners])


def _solved(task, field, pattern, hold, report, ask):
    """Directions and pattern of a frame, from those of the frame before, if there are any of the same triangles."""
    if field is not None and not is_moved(field.mesh, task.given.mesh):  # other edges were cut
        field = pattern = None
    following = solve_directions(task, portion(ask, 0.0, 0.4), field)
    return following, solve_pattern(task, following, report, portion(ask, 0.4, 0.6), pattern, hold)


def _change(before, pattern):
    """Mean difference of what is seen at the vertices."""
    if len(before.vertex_phases) != len(pattern.vertex_phases):
        return None
    seen = [np.cos(shown.vertex_phases).prod(axis=1) for shown in (before, pattern)]
    return float(np.abs(seen[1] - seen[0]).mean())


# Reading


@contextmanager
def _at_present(obj):
    """Go through the frames for a while, without the modifier of an animation that is there; then come back."""
    scene = bpy.context.scene
    present = scene.frame_current, scene.frame_subframe
    try:
        with hidden([modifier for modifier in obj.modifiers if modifiers.is_ours(modifier)]):
            yield
    finally:
        scene.frame_set(present[0], subframe=present[1])


def _task(obj, frame, settings, span, polygons):
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    if not _has_faces(evaluated, polygons):
        modifier = _changing(obj, polygons)
        raise SynchError(
            f"frame {frame}: the modifier {modifier} of {obj.name} changes its faces: hide it in the viewport while "
            "the animation is solved, or apply it"
        )
    try:
        task = gather(span.pattern, evaluated, settings, polygons)
    except MeshError as error:
        raise _in_frame(frame, error) from None
    given = task.given
    uncut = _fresh(given.uncut)
    mesh = uncut if given.mesh is given.uncut else _fresh(given.mesh)
    return replace(task, given=replace(given, mesh=mesh, uncut=uncut))


def _fresh(mesh):
    """The mesh without all that has been computed of it, for many of them are kept."""
    return TriangleMesh(mesh.vertices, mesh.triangles)


def _in_frame(frame, error):
    """The error with its frame."""
    return SynchError(f"frame {frame}: {error}", error.vertices)


def _rest_directions(obj, settings, span):
    """The field of directions that an attribute gives on the mesh at rest, which go along with it; or None."""
    if settings.exact_attribute is None:
        return None
    task = gather(span.pattern, obj, settings)
    return given_directions(task.given.mesh, SYMMETRIES[settings.symmetry], task.directions)


def _following(task, rest):
    """The task along directions at rest that have gone along."""
    mesh = task.given.mesh
    return replace(task, directions=DirectionField(mesh, 1, carried_angles(rest.angles, rest.mesh, mesh)).vectors)


def _has_faces(obj, polygons):
    """Whether an object's mesh has these faces."""
    now = meshes.read_polygons(obj)
    return np.array_equal(now.corner_vertices, polygons.corner_vertices) and np.array_equal(now.starts, polygons.starts)


def _changing(obj, polygons):
    """Name of the first modifier behind which the mesh has other faces."""
    shown = [modifier for modifier in obj.modifiers if modifier.show_viewport]
    for number, modifier in enumerate(shown):
        with hidden(shown[number + 1 :]):
            if not _has_faces(obj.evaluated_get(bpy.context.evaluated_depsgraph_get()), polygons):
                return modifier.name
    return "that deforms it"


def _saying(callback, frame):
    """A callback that says which frame it is."""
    return None if callback is None else lambda stage, fraction: callback(f"frame {frame}: {stage}", fraction)
