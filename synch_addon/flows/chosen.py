# SPDX-License-Identifier: GPL-3.0-or-later
"""Which flow is meant in the window, and how large its grid will be, told without reading it."""

from functools import lru_cache
from pathlib import Path

import bpy
import numpy as np

from ...core.errors import SynchError
from ..blender import openvdb
from ..blender.strokes import SOURCE_TYPES
from ..blender.volume_files import shown_file
from . import sources as blender_sources


def flow_of(context, filepath):
    """What vortices are shown of: a file, the active volume, or what is selected; of filaments and tubes that were
    made of a flow, what they were made of.

    Raises
    ------
    SynchError
        when there is none of these
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
        path = shown_file(source) if isinstance(source, bpy.types.Object) else source
    except SynchError:
        return None
    if isinstance(source, list):
        if any(obj.type == "MESH" and obj.data.polygons for obj in source):
            return None
        low, high = _object_box(source)
        margin = blender_sources.MARGIN * (high - low).max()
        return blender_sources.box_grid(low - margin, high + margin, resolution).shape
    matrix = np.eye(4) if isinstance(source, str) else np.array(source.matrix_world)
    path = Path(path)
    header = (
        _header(path, attribute, path.stat().st_mtime) if path.suffix.lower() == ".vdb" and path.is_file() else None
    )
    if header is None:
        return None
    low, high, to_world = header
    return blender_sources.box_grid(*blender_sources.world_box(low, high, matrix @ to_world), resolution).shape


def _object_box(objects):
    """Lowest and highest corner of objects in the world."""
    corners = [
        np.array(obj.bound_box) @ np.array(obj.matrix_world)[:3, :3].T + obj.matrix_world.translation for obj in objects
    ]
    corners = np.concatenate(corners)
    return corners.min(axis=0), corners.max(axis=0)


@lru_cache(maxsize=16)
def _header(path, attribute, _changed):
    """Lowest and highest index of a file's grid of velocities, and the matrix that takes them to the world, as its
    header tells them; None where it does not."""
    try:
        grids = openvdb.openvdb_module().readAllGridMetadata(str(path))
        chosen, _ = blender_sources.vector_grid(path, grids, attribute)
        low, high = (np.array(chosen[name]) for name in ("file_bbox_min", "file_bbox_max"))
    except (SynchError, OSError, KeyError, RuntimeError):
        return None
    return low, high, blender_sources.index_to_world(chosen)
