# SPDX-License-Identifier: GPL-3.0-or-later
"""Flows of a range of frames: numbered files, or a volume object that plays a sequence."""

import re
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import bpy
import numpy as np

from ...core.errors import SettingError
from ...core.geometry.grid import Grid
from ..blender.volume_files import played_file
from .sources import VELOCITY, ArrayFile, VolumeFile, box_grid, flow_source

_MARKS = re.compile(r"#+")


@dataclass(frozen=True)
class FrameFile:
    """The file of one frame.

    Attributes
    ----------
    frame : of the scene
    path : of the file
    source : callable that gives the flow's source anew, so that no frame is kept longer than it is needed
    """

    frame: int
    path: Path
    source: partial


def flow_frames(source, first, last, attribute=VELOCITY):
    """The :class:`FrameFile` of every frame of a range, and the name of the sequence.

    Parameters
    ----------
    source : path whose name has # in place of each digit of the frame's number, or a volume object with a sequence
    first, last : frames of the scene
    attribute : grid of a volume, as :func:`flow_source` has it

    Raises
    ------
    SettingError
        for a source without frames, and naming the first file that is missing
    """
    numbers = range(first, last + 1)
    if isinstance(source, str | Path):
        paths = [_numbered(Path(source), frame) for frame in numbers]
        files = [
            FrameFile(frame, path, partial(flow_source, path, attribute=attribute))
            for frame, path in zip(numbers, paths, strict=True)
        ]
        name = _MARKS.sub("", Path(source).stem).strip("_.- ") or Path(source).stem
    elif isinstance(source, bpy.types.Object) and source.type == "VOLUME":
        if not source.data.is_sequence:
            raise SettingError(f"the volume {source.name} is no sequence: open its files as one, or solve it as it is")
        matrix, name = np.array(source.matrix_world), source.name
        paths = [played_file(source.data, frame) for frame in numbers]
        files = [
            FrameFile(frame, path, partial(VolumeFile, path, matrix, name, attribute))
            for frame, path in zip(numbers, paths, strict=True)
        ]
    else:
        raise SettingError("frames are solved of numbered files and of volumes with a sequence: choose one of these")
    for file in files:
        if not file.path.is_file():
            raise SettingError(f"{file.path}: no such file: frame {file.frame} of the sequence is missing")
    return files, name


def _numbered(path, frame):
    marks = _MARKS.findall(path.name)
    if len(marks) != 1:
        raise SettingError(f"{path}: mark where the number of a frame stands, such as smoke_####.vdb")
    return path.with_name(path.name.replace(marks[0], f"{frame:0{len(marks[0])}d}"))


def common_grid(files, resolution, step):
    """A grid that holds the flow of every frame.

    Parameters
    ----------
    files : list of FrameFile
    resolution : nodes along the longest side
    step : callable(number of the file) asked before each one is read; it may raise

    Raises
    ------
    SettingError
        where files hold grids of their own that differ
    """
    low, high, fixed = np.full(3, np.inf), np.full(3, -np.inf), None
    for number, file in enumerate(files):
        step(number)
        source = file.source()
        if isinstance(source, ArrayFile):
            grid = source.grid(resolution)
            fixed = fixed or grid
            if not _is_same(grid, fixed):
                raise SettingError(
                    f"{file.path}: its grid is not that of {files[0].path.name}: all frames need the same"
                )
        else:
            lowest, highest = source.box
            low, high = np.minimum(low, lowest), np.maximum(high, highest)
    return fixed or box_grid(low, high, resolution)


def _is_same(grid: Grid, other: Grid):
    places = [(one.shape, one.periodic, *one.spacing, *one.origin) for one in (grid, other)]
    return places[0] == places[1]
