# SPDX-License-Identifier: GPL-3.0-or-later
"""The part of the Python API that brings the last layers of an object out: files, tool paths and a volume."""

import bpy

from ...core.errors import SettingError
from ..blender import meshes
from ..blender.files import check_output
from . import files as layer_files
from . import memory
from .links import solid_of
from .volume import write_volume


def layer_export(obj, path, together=False):
    """Write the last layers of an object to mesh files (.stl, .ply, .obj), in the world.

    Parameters
    ----------
    obj : the object whose layers were solved, or one that was made of them
    path : part.stl stands for part_000.stl, part_001.stl ..., from bottom to top; // is the folder of the .blend
    together : all into the one file instead

    Returns
    -------
    dict with `files` and `warnings`: of files of an earlier run with more layers, which stay

    Raises
    ------
    SynchError
        with one line that names the element and the remedy
    """
    obj, path = solid_of(obj), _absolute(path)
    with meshes.object_mode(obj):
        written = layer_files.export_layers(memory.recall_layers(obj), path, together)
    older = [] if together else layer_files.left_behind(path, written)
    warnings = []
    if older:
        names = f"{older[0]} to {older[-1]}" if len(older) > 1 else older[0]
        warnings = [f"{names}: of an earlier run, no layer of this one: delete what you do not need"]
    return {
        "status": "written",
        "command": "layer_export",
        "object": obj.name,
        "files": written,
        "warnings": warnings,
    }


def layer_toolpaths(obj, step=None, fill="contour", path=None):
    """Make a curve object of paths for a tool on each of the last layers of an object, in a collection of their own.

    Parameters
    ----------
    obj : as for :func:`layer_export`
    step, fill : see :class:`PathSettings`
    path : write them to this file (.csv, .obj) as well

    Returns
    -------
    dict with `collection`, `paths` (their number), `length` and `files`

    Raises
    ------
    SynchError
        with one line that names the element and the remedy; nothing is made
    """
    obj = solid_of(obj)
    settings = layer_files.PathSettings(step, fill)
    if path is not None:
        path = _absolute(path)
        check_output(path, layer_files.PATH_SUFFIXES)
    with meshes.object_mode(obj):
        layering = memory.recall_layers(obj)
        paths = layer_files.paths_of(layering, settings)
        files = [] if path is None else [layer_files.export_paths(layering, paths, path)]
        made = layer_files.write_paths(obj, layering, paths)
    return {
        "status": "made",
        "command": "layer_toolpaths",
        "object": obj.name,
        "collection": made.name,
        "paths": len(paths.layers),
        "length": float(paths.lines.lengths.sum()),
        "step": paths.step,
        "fill": fill,
        "files": files,
    }


def layer_volume(obj, path, resolution=128):
    """Write the pattern of the last layers of an object to an OpenVDB file, and make a volume object that shows it.

    Parameters
    ----------
    obj : as for :func:`layer_export`
    path : .vdb, with the grid `pattern`: cos(phase), 1 on the layers
    resolution : voxels along the longest side

    Returns
    -------
    dict with `volume_object`, `voxels` (inside) and `files`

    Raises
    ------
    SynchError
        with one line that names the element and the remedy; nothing is made
    """
    obj, path = solid_of(obj), _absolute(path)
    with meshes.object_mode(obj):
        made, voxels = write_volume(obj, memory.recall_layers(obj), path, resolution)
    return {
        "status": "made",
        "command": "layer_volume",
        "object": obj.name,
        "volume_object": made.name,
        "voxels": voxels,
        "files": [bpy.path.abspath(made.data.filepath)],
    }


def _absolute(path):
    """A path that may begin with //, for the folder of the .blend file."""
    if str(path).startswith("//") and not bpy.data.filepath:
        raise SettingError(f"{path} begins with //, the folder of a .blend that is not saved: save it first")
    return bpy.path.abspath(str(path))
