# SPDX-License-Identifier: GPL-3.0-or-later
"""Flows of a range of frames: numbered files, or a volume object that plays a sequence."""

import re
from pathlib import Path

import bpy
import numpy as np

from ...core.errors import SettingError
from ...core.files.flows import VELOCITY, flow_file
from ...core.files.volumes import VolumeFile
from ...core.tasks.flow_sequences import FrameFile
from ..blender.openvdb import module_file
from ..blender.volume_files import played_file
from .memory import MOST_FRAMES

_MARKS = re.compile(r"#+")


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
            raise SettingError(f"the volume {source.name} is no sequence: open its files as one, or solve it as it is")
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
