# SPDX-License-Identifier: GPL-3.0-or-later
"""Patterns on a moving mesh: read in every frame, solved from frame to frame, and stored side by side.

The mesh of a frame is the one behind the object's modifiers, as long as they keep its faces.
"""

import math
from collections.abc import Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Unpack

import bpy
import numpy as np

from ...core.errors import MeshError, SettingError, SynchError, quote_value
from ...core.fields import given_directions
from ...core.fields.animation import carry_angles
from ...core.fields.directions import DirectionField
from ...core.files.json_text import Json
from ...core.interpolate import face_phases
from ...core.monitor import Callback
from ...core.settings.keywords import SurfaceKeywords
from ...core.settings.surface import SYMMETRY_ORDERS, SurfaceSettings
from ...core.tasks.animation import FramesRequest, fresh, in_frame
from ...core.validation import are_frames, check_choice, convert_value, from_names
from ..blender import attributes, meshes, modifiers
from ..blender.defect_empties import write_defects
from ..blender.modifiers import hidden
from ..blender.objects import ObjectLink
from ..blender.schema import BARYCENTRIC, DIRECTION, SINGULARITY
from ..blender.transaction import whole_or_nothing
from ..jobs.job import run
from ..jobs.report import Report
from ..nodes.canvas import GeometryCanvas, Socket, add_modifier, group_tree
from ..nodes.materials import pattern_material
from ..patterns import frame_attributes, write
from ..patterns.former_pattern import remove_former
from ..reading.surface import gather, settings_for

# How strongly a pattern holds on to the frame before. Measured: jumps become slides, for up to 3 % of energy.
HOLD = 0.1
# Frames that are read and kept at once: more than an hour.
MOST_FRAMES = 100_000

# The modifier's node group: its version and sockets.
_GROUP_VERSION = 1
_INPUTS = (
    Socket("Geometry", "Geometry", "A mesh with a pattern for each frame"),
    Socket("First", "Int", "First frame that has a pattern: it is shown before it, too", 1),
    Socket("Last", "Int", "Last frame that has a pattern: it is shown after it, too", 1),
)
_OUTPUTS = (Socket("Geometry", "Geometry", "The mesh with the pattern of this frame"),)


@dataclass(frozen=True)
class Span:
    """The frames to solve, and how.

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
        if not are_frames(self.first, self.last):
            raise SettingError(
                f"the frames are {quote_value(self.first)} to {quote_value(self.last)}: "
                "give the first and the last, in order"
            )
        if len(self.frames) > MOST_FRAMES:
            line = f"the frames are {self.first} to {self.last}: give {MOST_FRAMES} frames or fewer at once"
            raise SettingError(line)
        convert_value("pattern", str, self.pattern)
        check_choice(self, "pattern", modifiers.FRAMES)
        if not 0 <= convert_value("hold", float, self.hold) < math.inf:
            raise SettingError(f"the hold is {quote_value(self.hold)}: give a number from 0 on, such as {HOLD}")

    @property
    def frames(self):
        return range(self.first, self.last + 1)


def animate(
    obj: bpy.types.Object,
    callback: Callback | None = None,
    frames: Sequence[int] | None = None,
    pattern: str = "stripes",
    hold: float = HOLD,
    **settings: Unpack[SurfaceKeywords],
) -> Json:
    """Solve a pattern in each frame of a moving mesh, each frame from the one before; a modifier shows them.

    Parameters
    ----------
    obj : bpy.types.Object, whose shape keys and modifiers keep its faces
    callback : callable(stage, fraction) -> bool, optional; False cancels
    frames : first and last frame; None for the scene's
    pattern, hold : see :class:`Span`
    settings : see :class:`SurfaceSettings`

    Returns the report, whose ``frames`` are figures of each; errors as :func:`api.directions`.
    """
    scene = bpy.context.scene
    frames = (scene.frame_start, scene.frame_end) if frames is None else frames
    if not isinstance(frames, Sequence) or len(frames) != 2:
        raise SettingError(f"the frames are {quote_value(frames)}: give the first and the last one")
    return run_animate(obj, from_names(SurfaceSettings, settings), frames, pattern, hold, callback)


def run_animate(obj, settings, frames, pattern, hold, callback=None):
    """Animate with ready :class:`SurfaceSettings`."""
    return run(AnimationJob(obj, settings, Span(*frames, pattern, hold)), callback)


class AnimationJob:
    """A pattern in each frame of an object; see :mod:`..jobs.job`.

    Frames are read one by one. After each the scene's frame is the same as before; nothing else changes before
    :meth:`write`.
    """

    # Seconds of reading at each tick of the window's timer.
    at_once = 0.1

    def __init__(self, obj, settings, span):
        reason = meshes.refusal(obj)
        if reason is None and not obj.visible_get():
            reason = f"{obj.name} is hidden and does not move: show it in the viewport"
        if reason:
            raise SynchError(reason)
        scene = bpy.context.scene  # what keys and scripts have set counts now, as it will when all frames are read
        scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)
        self.link = ObjectLink.to(obj)
        self._span, self._settings = span, settings_for(span.pattern, obj, settings)
        self._report = Report("animate", obj, self._settings)
        self._requests = []
        with meshes.object_mode(obj), self._report.clock("read"):
            self._base = meshes.read_mesh(obj, strict=self._settings.strict)
            self._rest = _rest_directions(obj, self._settings, span, self._base)

    def advance(self):
        """Read a frame; returns which one comes next and the share that is done, None when all are read."""
        frames, requests, obj = self._span.frames, self._requests, self.link.found
        if len(requests) < len(frames):
            with meshes.object_mode(obj), self._report.clock("read"), _at_present(obj):
                requests.append(self._of_frame(obj, frames[len(requests)]))
        done = len(requests)
        if done < len(frames):
            return f"read frame {frames[done]}", done / len(frames)
        self._report.warn_about(obj, requests[0])
        return None

    def close(self):
        """Nothing: what has been read is gone with the job."""

    @property
    def request(self):
        """The :class:`FramesRequest`, when all frames are read."""
        return FramesRequest(tuple(self._span.frames), tuple(self._requests), self._span.hold)

    def _of_frame(self, obj, frame):
        bpy.context.scene.frame_set(frame)
        request = _request(obj, frame, self._settings, self._span, self._base)
        self._settings = replace(self._settings, spacing=request.spacing)  # an automatic one is that of the first frame
        return request if self._rest is None else _following(request, self._rest)

    def write(self, result):
        """Write all frames to the object at once; returns the report."""
        obj, first, request = self.link.found, result.first, self._requests[0]
        self._report.take(first)
        with meshes.object_mode(obj), whole_or_nothing():
            if not meshes.is_unchanged(obj, self._base):
                raise SynchError(f"the mesh or the scale of {obj.name} changed while it was solved: run again")
            defects = write.reported_defects(obj, request.given, first.field, first.pattern)
            with self._report.clock("write"):
                self._write(obj, result.frames, request.spacing)
        report = self._report.finish(first.field, first.pattern, defects)
        return report | {
            "pattern": self._span.pattern,
            "hold": self._span.hold,
            "frames": [frame.figures for frame in result.frames],
        }

    def _write(self, obj, frames, spacing):
        """Write the attributes of all frames, the first frame's under their plain names too, and the nodes that play
        them."""
        remove_former(obj)
        corners = self._split(obj, frames)
        own = frame_attributes.frame_layout(self._span.pattern)
        places, first = None, None
        for frame in frames:
            phases = face_phases(frame.edge_phases, corners(frame.polygons))
            values = write.attribute_values(phases, self._base.at_object(frame.edge_phases.arguments))
            values[DIRECTION.name] = frame.directions
            first = values if first is None else first
            place = values[BARYCENTRIC.name]
            # A face's places are the same in all frames in which it is singular, and do not matter in others.
            places = place if places is None else np.where(places.any(axis=1, keepdims=True), places, place)
            for name in own:
                if name in values:
                    of_frame = frame_attributes.frame_name(name, frame.number)
                    attributes.write_attribute(obj, of_frame, *own[name], values[name])
        directions = first.pop(DIRECTION.name)
        write.pattern_attributes(obj, first | {BARYCENTRIC.name: places})
        attributes.write(obj, DIRECTION, directions)
        attributes.remove_attribute(obj, SINGULARITY.name)
        write_defects(obj, [])  # they move
        all_faces = self._settings.assign_material or write.has_one_material(obj)
        pattern_material(obj, self._span.pattern, spacing=spacing, assign_faces=all_faces)
        _add_frames(obj, self._span.pattern, self._span.first, self._span.last)
        meshes.update(obj)

    def _split(self, obj, frames):
        """Split the faces that cannot carry their defects in some frame; returns a function from polygons before to
        polygons after."""
        unfit = [face_phases(frame.edge_phases, frame.polygons)[0].unfit for frame in frames]
        faces = meshes.can_be_split(obj, np.unique(np.concatenate(unfit)), self._base.polygons)
        if len(faces) == 0:
            return lambda polygons: polygons
        now, old_corners = write.split_faces(obj, faces, self._base.polygons, self._report.warn)
        return lambda polygons: polygons.after_split(now, old_corners)


# Reading


@contextmanager
def _at_present(obj):
    """Go through the frames for a while, without the modifier of an animation that is there and without Subdivision
    Surfaces at the end, which smooth what the frames show; then come back."""
    scene = bpy.context.scene
    present = scene.frame_current, scene.frame_subframe
    try:
        ours = [modifier for modifier in obj.modifiers if modifiers.is_ours(modifier)]
        with hidden(ours + modifiers.last_subdivisions(obj)):
            yield
    finally:
        scene.frame_set(present[0], subframe=present[1])


def _request(obj, frame, settings, span, base):
    """The request of a frame, which is the scene's present one; SynchError where the faces differ from the base's."""
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    if not meshes.has_faces(meshes.read_polygons(evaluated), base):
        modifier = _changing(obj, base)
        raise SynchError(
            f"frame {frame}: the modifier {modifier} of {obj.name} changes its faces: hide it in the viewport while "
            "the animation is solved, or apply it"
        )
    try:
        request = gather(span.pattern, evaluated, settings, base)
    except MeshError as error:
        raise in_frame(frame, error) from None
    return fresh(request)


def _rest_directions(obj, settings, span, base):
    """The field of directions that an attribute gives on the mesh at rest, which go along with it; or None."""
    if settings.exact_attribute is None:
        return None
    request = gather(span.pattern, obj, settings, base)
    return given_directions(request.given.mesh, SYMMETRY_ORDERS[settings.symmetry], request.source.directions)


def _following(request, rest):
    """The request along directions at rest that have gone along."""
    mesh = request.given.mesh
    vectors = DirectionField(mesh, 1, carry_angles(rest.angles, rest.mesh, mesh)).vectors
    return replace(request, source=replace(request.source, directions=vectors))


def _changing(obj, base):
    """Name of the first modifier behind which the mesh has other faces."""
    shown = [modifier for modifier in obj.modifiers if modifier.show_viewport]
    for number, modifier in enumerate(shown):
        with hidden(shown[number + 1 :]):
            seen = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
            if not meshes.has_faces(meshes.read_polygons(seen), base):
                return modifier.name
    return "that deforms it"


# The modifier


def _frames_group(kind):
    """The group "Synch Frames" of stripes or "Synch Quad Frames", built when missing, rebuilt when outdated.

    It stores the attributes of the scene's frame, ``synch_phase.12`` and so on, under the plain names that materials
    and reliefs read. It needs no driver and no script: a render farm shows what the viewport shows.
    """
    tree, canvas = group_tree(modifiers.FRAMES[kind], f"{_GROUP_VERSION}", _INPUTS, _OUTPUTS, GeometryCanvas)
    if canvas is None:
        return tree
    tree.is_modifier = True
    with canvas.band("Frame"):
        inputs = canvas.inputs()
        frame = canvas.math("ROUND", canvas.value("GeometryNodeInputSceneTime", "Frame"))
        frame = frame.maximum(inputs["First"]).minimum(inputs["Last"]).named("frame")
        text = canvas.value("FunctionNodeValueToString", "String", "frame", {"Value": frame, "Decimals": 0})
    geometry = inputs["Geometry"]
    for name, (domain, data_type) in frame_attributes.frame_layout(kind).items():
        with canvas.band(name):
            geometry = _stored(canvas, geometry, text, name, domain, data_type)
    canvas.outputs(Geometry=geometry)
    return tree


def _stored(canvas, geometry, text, name, domain, data_type):
    """The geometry with a frame's attribute under its plain name; one that is missing is zero."""
    replaced = {"String": frame_attributes.frame_name(name, "#"), "Find": "#", "Replace": text}
    of_frame = canvas.value("FunctionNodeReplaceString", "String", f"{name} of frame", replaced)
    read_type = "FLOAT_VECTOR" if data_type == "FLOAT2" else data_type  # two numbers are read as a vector
    read = canvas.value("GeometryNodeInputNamedAttribute", "Attribute", "", {"Name": of_frame}, data_type=read_type)
    return canvas.stored(geometry, name, (domain, data_type), read)


def _add_frames(obj, kind, first, last):
    """Give an object the modifier, before the first one that changes its faces; returns the modifier."""
    group = _frames_group(kind)
    add_modifier(obj, group, {"First": first, "Last": last})
    others = (
        n
        for n, other in enumerate(obj.modifiers)
        if modifiers.changes_faces(other) and not modifiers.shows_frames(other)
    )
    place = next(others, len(obj.modifiers) - 1)
    obj.modifiers.move(len(obj.modifiers) - 1, place)
    return obj.modifiers[place]
