# SPDX-License-Identifier: GPL-3.0-or-later
"""Which flow is meant in the window, and how large its grid will be, told without reading it."""

from functools import lru_cache
from pathlib import Path

import bpy
import numpy as np

from ..core.errors import SynchError
from . import flows
from .strokes import SOURCE_TYPES


def flow_of(context, filepath):
    """What vortices are shown of: a file, the active volume, or what is selected.

    Raises
    ------
    SynchError
        when there is none of these
    """
    if filepath:
        return bpy.path.abspath(filepath)
    active = context.active_object
    if active is not None and active.type == "VOLUME":
        return active
    chosen = [obj for obj in context.selected_objects if obj.type in SOURCE_TYPES]
    if not chosen:
        raise SynchError("nothing has a flow: choose a file, a volume, a mesh, or curves that stand for filaments")
    return chosen


def expected_shape(context, filepath, resolution):
    """Nodes along the axes of the grid that will be solved, None where only reading the flow can tell."""
    try:
        source = flow_of(context, filepath)
    except SynchError:
        return None
    if isinstance(source, str):
        path = Path(source)
        box = _file_box(path, path.stat().st_mtime) if path.suffix.lower() == ".vdb" and path.is_file() else None
        margin = 0.0
    else:
        objects = source if isinstance(source, list) else [source]
        if any(obj.type == "MESH" and obj.data.polygons for obj in objects):
            return None
        box = _object_box(objects)
        margin = flows.MARGIN if isinstance(source, list) else 0.0
    if box is None:
        return None
    low, high = box
    more = margin * (high - low).max()
    return flows.box_grid(low - more, high + more, resolution).shape


def _object_box(objects):
    """Lowest and highest corner of objects in the world."""
    corners = [
        np.array(obj.bound_box) @ np.array(obj.matrix_world)[:3, :3].T + obj.matrix_world.translation for obj in objects
    ]
    corners = np.concatenate(corners)
    return corners.min(axis=0), corners.max(axis=0)


@lru_cache(maxsize=16)
def _file_box(path, _changed):
    """The box of the first vector grid of a file in the world, as its header tells it; None where it does not."""
    try:
        grids = flows.openvdb_module().readAllGridMetadata(str(path))
    except (SynchError, OSError, KeyError, RuntimeError):
        return None
    vectors = [grid for grid in grids if grid.valueTypeName.startswith("vec3")]
    if not vectors:
        return None
    try:
        low, high = (np.array(vectors[0][name]) for name in ("file_bbox_min", "file_bbox_max"))
    except KeyError:
        return None
    return flows.world_box(low, high, flows.index_to_world(vectors[0]))
