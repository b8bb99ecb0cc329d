# SPDX-License-Identifier: GPL-3.0-or-later
"""Vortices of numbered files, or of a volume object that plays a sequence: an object a frame, seen at that alone."""

import re
import time
from pathlib import Path

import bpy
import numpy as np

from ...core.errors import SettingError
from ...core.files.flows import VELOCITY, flow_file
from ...core.files.volumes import VolumeFile
from ...core.tasks.flow_sequences import FrameFile, SequenceRequest
from ..blender.openvdb import module_file
from ..blender.transaction import at_the_end, whole_or_nothing
from ..blender.volume_files import played_file
from . import memory
from .choice import finish
from .memory import MOST_FRAMES, Filled, SolvedFlow
from .objects import facts, fill, make_filaments, make_tubes
from .report import sequence_report

# Where the name of a file has the digits of a frame.
_MARKS = re.compile(r"#+")


class SequenceJob:
    """Filaments and tubes of each frame; see :mod:`..jobs.job`."""

    link = None

    def __init__(self, source, settings):
        self._start = time.perf_counter()
        files, self._name = flow_frames(source, *settings.frames, settings.attribute)
        self.request = SequenceRequest(files, settings)

    def write(self, result):
        """Make a collection with an object for each frame, and for both two; returns the report."""
        with whole_or_nothing():
            collection = bpy.data.collections.new(f"{self._name} Vortices")
            at_the_end(memory.flows.begin_sequence)
            for frame in result.frames:
                shown, both = frame.shown, []
                for wanted, make, kind in (
                    (shown.tubes, make_tubes, "Tubes"),
                    (shown.lines, make_filaments, "Filaments"),
                ):
                    if wanted is not None:
                        made = make(f"{self._name} {kind} {frame.frame:04d}", shown)
                        collection.objects.link(made)
                        _show_at(made, frame.frame)
                        both.append(made)
                if frame.result is not None:
                    self._keep(frame, both)
            bpy.context.scene.collection.children.link(collection)
            return sequence_report(self._name, self.request.settings, result, collection, self._start)

    def _keep(self, frame, objects):
        """Keep the solve of a frame, so that its objects can show another point of the sphere."""
        name, numbers = f"{self._name} {frame.frame:04d}", tuple(obj.session_uid for obj in objects)
        solved = SolvedFlow(name, self.request.settings, frame.result, fill, numbers)
        finish(solved, Filled(facts(frame.shown), fill), objects, self._start)


def _show_at(obj, frame):
    """Keys that show an object at one frame alone, in views and renders."""
    for name in ("hide_viewport", "hide_render"):
        for when, hidden in ((frame - 1, True), (frame, False), (frame + 1, True)):
            setattr(obj, name, hidden)
            obj.keyframe_insert(name, frame=when)
        setattr(obj, name, bpy.context.scene.frame_current != frame)


def flow_frames(source, first, last, attribute=VELOCITY):
    """The :class:`FrameFile` of every frame of the scene from the first to the last, and the name of the sequence.

    The source is a path whose name has # in place of each digit of the frame's number, or a volume object with a
    sequence; the attribute is as of :func:`flow_source`. Raises SettingError for a source without frames, and naming
    the first file that is missing.
    """
    module = module_file()
    if isinstance(source, str | Path):
        path_at = lambda frame: _numbered(Path(source), frame)  # noqa: E731
        name = _MARKS.sub("", Path(source).stem).strip("_.- ") or Path(source).stem
        read = lambda path: flow_file(path, attribute, module)  # noqa: E731
    elif isinstance(source, bpy.types.Object) and source.type == "VOLUME":
        if not source.data.is_sequence:
            raise SettingError(
                f"the volume {source.name} is not a sequence: open its files as one, or solve it as it is"
            )
        if last - first >= MOST_FRAMES:  # one that repeats has a file for each
            raise SettingError(f"the frames are {first} to {last}: give {MOST_FRAMES} frames or fewer at once")
        path_at, name = lambda frame: played_file(source.data, frame), source.name
        matrix = np.array(source.matrix_world)
        read = lambda path: VolumeFile(path, matrix, name, attribute, module)  # noqa: E731
    else:
        raise SettingError("frames are solved of numbered files and of volumes with a sequence: choose one of these")
    files = []
    for frame in range(first, last + 1):  # up to the first file that is missing, however long the range is
        path = path_at(frame)
        if not path.is_file():
            raise SettingError(f"{path}: no such file: frame {frame} of the sequence is missing")
        files.append(FrameFile(frame, read(path)))
    return tuple(files), name


def _numbered(path, frame):
    marks = _MARKS.findall(path.name)
    if len(marks) != 1:
        raise SettingError(f"{path}: mark where the number of a frame stands, such as smoke_####.vdb")
    return path.with_name(path.name.replace(marks[0], f"{frame:0{len(marks[0])}d}"))
