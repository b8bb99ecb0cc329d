# SPDX-License-Identifier: GPL-3.0-or-later
"""Which flow is meant in the window, and how large its grid will be, told without reading it."""

from functools import lru_cache

import bpy
import numpy as np

from ...core.errors import SynchError
from ...core.fields.biot_savart import surrounding_grid
from ...core.files.volumes import VolumeFile, world_box
from ...core.geometry.grid import box_grid
from ..blender.strokes import SOURCE_TYPES
from .sources import flow_source


def flow_of(context, filepath):
    """What vortices are shown of: a file, the active volume, or what is selected; of filaments and tubes that were
    made of a flow, what they were made of.

    Raises SynchError when there is none of these.
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


def expected_shape(context, filepath, resolution, attribute):
    """Nodes along the axes of the grid that will be solved, None where only reading the flow can tell."""
    try:
        source = flow_of(context, filepath)
        if isinstance(source, list):
            if any(obj.type == "MESH" and obj.data.polygons for obj in source):
                return None
            return surrounding_grid(*_object_box(source), resolution).shape
        file = flow_source(source, None, attribute)
    except SynchError:
        return None
    if not isinstance(file, VolumeFile) or not file.path.is_file():
        return None
    header = _header(file.path, file.attribute, file.module, file.path.stat().st_mtime)
    if header is None:
        return None
    low, high, to_world = header
    return box_grid(*world_box(low, high, file.matrix @ to_world), resolution).shape


def _object_box(objects):
    """Lowest and highest corner of objects in the world."""
    corners = [
        np.array(obj.bound_box) @ np.array(obj.matrix_world)[:3, :3].T + obj.matrix_world.translation for obj in objects
    ]
    corners = np.concatenate(corners)
    return corners.min(axis=0), corners.max(axis=0)


@lru_cache(maxsize=16)
def _header(path, attribute, module, _changed):
    """What the header of a file tells, as :meth:`VolumeFile.header`."""
    return VolumeFile(path, np.eye(4), path.name, attribute, module).header()
