# SPDX-License-Identifier: GPL-3.0-or-later
"""Which flow is meant in the window, and how large its grid will be, without reading it."""

import math
from functools import lru_cache
from typing import NamedTuple

import bpy
import numpy as np

from ...core.errors import SynchError
from ...core.fields.biot_savart import surrounding_grid
from ...core.files.volumes import VolumeFile, world_box
from ...core.geometry.grid import box_grid
from ...core.tasks.flow_costs import solve_memory, solve_seconds
from ..blender.strokes import SOURCE_TYPES
from .properties import plain
from .sequence_job import flow_frames
from .sources import flow_source


class Expected(NamedTuple):
    """Expected cost of a solve: nodes along the axes of its grid, or vertices of its surface; seconds of one core; and
    megabytes, None for a surface."""

    shape: tuple[int, ...]
    seconds: float
    megabytes: float | None


def flow_of(context, filepath):
    """The chosen flow: a file, the active volume, the selected objects, or the source of selected filaments and tubes.

    Raises SynchError if none of these is chosen.
    """
    if filepath:
        return bpy.path.abspath(filepath)
    active = context.active_object
    sources = active.synch_vortices.source_objects if active is not None and active.select_get() else []
    if sources:
        return sources[0] if sources[0].type == "VOLUME" else sources
    if active is not None and active.type == "VOLUME":
        return active
    chosen = [obj for obj in context.selected_objects if obj.type in SOURCE_TYPES]
    if not chosen:
        raise SynchError("nothing has a flow: choose a file, a volume, a mesh, or curves that stand for filaments")
    return chosen


def settings_that_count(context, filepath):
    """The settings that the chosen flow depends on: "core" for filaments, "attribute" for other flows, both if nothing
    is chosen."""
    try:
        source = flow_of(context, filepath)
    except SynchError:
        return {"core", "attribute"}
    if not isinstance(source, list):
        return {"attribute"}
    return {"attribute" if obj.type == "MESH" and obj.data.polygons else "core" for obj in source}


def expected_solve(context, properties):
    """How large a solve with the scene's properties will be, an :class:`Expected`; None where only reading the flow can
    tell, or where it will be refused."""
    try:
        settings = plain(properties)
        shape = _expected_shape(flow_of(context, properties.filepath), settings)
    except SynchError:
        return None
    if shape is None:
        return None
    nodes, is_surface = math.prod(shape), len(shape) == 1
    count = None if settings.frames is None else len(range(settings.frames[0], settings.frames[1] + 1))
    is_of_curves = isinstance(flow_of(context, properties.filepath), list) and not is_surface
    seconds = solve_seconds(nodes, settings, count, is_surface, is_of_curves)
    return Expected(shape, seconds, None if is_surface else solve_memory(nodes) / 2**20)


def _expected_shape(source, settings):
    """Nodes along the axes of the grid, of the first frame of a sequence, or the number of vertices of a surface."""
    if isinstance(source, list):
        surfaces = [obj for obj in source if obj.type == "MESH" and obj.data.polygons]
        if not surfaces:
            return surrounding_grid(*_object_box(source), settings.resolution).shape
        is_flow = surfaces == source and settings.attribute in surfaces[0].data.attributes
        return (len(surfaces[0].data.vertices),) if is_flow else None
    if settings.frames is None:
        file = flow_source(source, None, settings.attribute)
    else:
        first = settings.frames[0]
        file = flow_frames(source, first, first, settings.attribute)[0][0].source
    if not isinstance(file, VolumeFile) or not file.path.is_file():
        return None
    header = _header(file.path, file.attribute, file.module, file.path.stat().st_mtime)
    if header is None:
        return None
    low, high, to_world = header
    return box_grid(*world_box(low, high, file.matrix @ to_world), settings.resolution).shape


def _object_box(objects):
    """Lowest and highest corner of objects in the world."""
    corners = [
        np.array(obj.bound_box) @ np.array(obj.matrix_world)[:3, :3].T + obj.matrix_world.translation for obj in objects
    ]
    corners = np.concatenate(corners)
    return corners.min(axis=0), corners.max(axis=0)


@lru_cache(maxsize=16)
def _header(path, attribute, module, _changed):
    """The header of a file, as :meth:`VolumeFile.header`, read once for each change of the file."""
    return VolumeFile(path, np.eye(4), path.name, attribute, module).header()
