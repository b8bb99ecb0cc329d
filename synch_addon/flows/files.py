# SPDX-License-Identifier: GPL-3.0-or-later
"""Filaments that are shown, as files for other programs."""

from pathlib import Path

import bpy

from ...core.errors import SynchError
from ...core.files.filaments import WRITERS
from ...core.files.whole import write_text
from ...core.validation import check_path
from ..blender.files import check_output
from ..blender.objects import no_object
from .memory import shown_filaments

SUFFIXES = tuple(WRITERS)


def filament_export(obj, path):
    """Write the filaments that an object shows to a file, in the flow's coordinates and in one piece each.

    Parameters
    ----------
    obj : object that was made for the filaments of a flow in space
    path : .csv, .vtp or .vtk; // is the folder of the .blend

    Returns
    -------
    dict with `filaments` (their number) and `files`

    Raises
    ------
    SynchError
        with one line that names the element and the remedy
    """
    reason = no_object(obj)
    if reason:
        raise SynchError(reason)
    path = bpy.path.abspath(check_path(path))
    check_output(path, SUFFIXES)
    lines, winding = shown_filaments.get(obj)
    write_text(path, WRITERS[Path(path).suffix.lower()](lines, winding))
    return {
        "status": "written",
        "command": "filament_export",
        "object": obj.name,
        "filaments": len(lines),
        "files": [path],
        "warnings": [],
    }
