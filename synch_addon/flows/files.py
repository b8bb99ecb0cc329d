# SPDX-License-Identifier: GPL-3.0-or-later
"""Vortices that are shown, as files for other programs."""

from pathlib import Path

import bpy

from ...core.errors import SettingError
from ...core.files.filaments import WRITERS, filament_shape, table_of, tube_shape
from ...core.files.json_text import Json
from ...core.files.whole import write_text, write_whole
from ...core.validation import check_path
from ..blender.files import check_output, placed_mesh, written_by_operator
from ..blender.objects import no_object
from ..blender.transaction import only_for_now
from . import memory

TABLE, SCENE = ".csv", ".abc"
# Some Blenders, such as Debian's, are built without Alembic.
SUFFIXES = (TABLE, *WRITERS, *([SCENE] if bpy.app.build_options.alembic else []))


def filament_export(obj: bpy.types.Object, path: str | Path) -> Json:
    """Write the filaments, or the tubes, that an object shows to a file, in the flow's coordinates.

    Filaments are written in one piece each, with what the report says of them in .csv, .vtp and .vtk. Alembic holds the
    object as it is seen, filaments as tubes.

    Parameters
    ----------
    obj : object that was made for the filaments or the tubes of a flow in space
    path : .vtp, .vtk, .ply, .obj, .abc, and of filaments .csv; // is the folder of the .blend

    Returns a dict with `filaments` or `tubes` (their number) and `files`.

    Raises SynchError with one line that names the element and the remedy.
    """
    reason = no_object(obj)
    if reason:
        raise SettingError(reason)
    path = bpy.path.abspath(check_path(path))
    check_output(path, SUFFIXES)
    suffix, counted = Path(path).suffix.lower(), {}
    if obj.type == "MESH":
        shown = memory.flows.get(obj).result.shown
        if shown is None:
            raise SettingError(f"{obj.name} is a surface with its map: choose filaments or tubes")
        tubes = shown.tubes
        counted["tubes"] = tubes.pieces
        if suffix == TABLE:
            raise SettingError(f"{path}: a table holds filaments only: write tubes as {', '.join(SUFFIXES[1:])}")
        shape = tube_shape(tubes)
    else:
        lines, winding = memory.shown_filaments.get(obj)
        counted["filaments"] = len(lines)
        shape = filament_shape(lines, winding)
    if suffix == SCENE:
        _write_alembic(obj, path)
    else:
        write_text(path, table_of(lines, winding) if suffix == TABLE else WRITERS[suffix](shape))
    return {
        "status": "written",
        "command": "filament_export",
        "object": obj.name,
        **counted,
        "files": [path],
        "warnings": [],
    }


def can_export(obj):
    """Whether an object shows filaments, or tubes of a flow in space."""
    if obj is not None and obj.type == "MESH":
        return memory.flows.holds(obj) and memory.flows.get(obj).result.shown is not None
    return memory.shown_filaments.holds(obj)


def _write_alembic(obj, path):
    """Write an object as it is seen with Blender's exporter, which takes what is selected."""
    layer = bpy.context.view_layer
    selected = [other for other in layer.objects if other.select_get()]
    frame, name = bpy.context.scene.frame_current, obj.name
    try:
        with only_for_now(), write_whole(path) as made:
            shown = _shown_mesh(obj)
            for other in layer.objects:
                other.select_set(other == shown)
            with written_by_operator(path):
                bpy.ops.wm.alembic_export(
                    filepath=str(made), selected=True, start=frame, end=frame, as_background_job=False
                )
    finally:
        obj.name = name
        for other in layer.objects:
            other.select_set(other in selected)


def _shown_mesh(obj):
    """A mesh object of what an object shows, also where it is hidden, as frames of a sequence are at other frames: the
    exporter leaves these out, and writes a curve without what its modifiers make."""
    copy = obj.copy()
    copy.animation_data_clear()
    copy.hide_viewport = False
    bpy.context.scene.collection.objects.link(copy)
    shown = placed_mesh(copy.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    shown.rename(obj.name, mode="ALWAYS")  # the object gets its name back
    return shown
