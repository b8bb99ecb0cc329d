# SPDX-License-Identifier: GPL-3.0-or-later
"""The part of the Python API that brings the last layers of an object out: files, tool paths and a volume."""

from contextlib import nullcontext
from dataclasses import replace
from os import PathLike

import bpy

from ...core.errors import SettingError, SynchError, quote_value
from ...core.files.json_text import Json
from ...core.printing.machine import MACHINES, USUAL, Machine, read_machine
from ...core.tasks.layer_outputs import PathSettings
from ...core.validation import check_path, convert_value
from ..blender import meshes
from ..blender.files import check_output
from ..blender.objects import ObjectLink, no_object
from ..blender.transaction import keep_file, whole_or_nothing
from ..jobs.job import run
from . import files, memory
from .beads import LOOKS
from .links import solid_of
from .report import print_facts
from .volume import check_volume, grid_file, make_volume


def layer_export(obj: bpy.types.Object, path: str | PathLike[str], together: bool = False) -> Json:
    """Write the last layers of an object to mesh files (.stl, .ply, .obj), in the world.

    Parameters
    ----------
    obj : the object whose layers were solved, or one that was made of them
    path : part.stl stands for part_000.stl, part_001.stl ..., from bottom to top; // is the folder of the .blend
    together : all into the one file instead

    Returns a dict with `files` and `warnings`: of files of an earlier run with more layers, which stay.

    Raises SynchError with one line that names the element and the remedy.
    """
    obj, path, together = _solid(obj), _absolute(path), convert_value("together", bool, together)
    with meshes.object_mode(obj):
        written = files.export_layers(memory.recall_layers(obj), path, together)
    older = [] if together else files.left_behind(path, written)
    warnings = []
    if older:
        names = f"{older[0]} to {older[-1]}" if len(older) > 1 else older[0]
        warnings = [f"{names}: of an earlier run, no layer of this one: delete what you do not need"]
    return {"status": "written", "command": "layer_export", "object": obj.name, "files": written, "warnings": warnings}


def layer_toolpaths(
    obj: bpy.types.Object,
    step: float | None = None,
    fill: str = "contour",
    path: str | PathLike[str] | None = None,
    machine: str | PathLike[str] | None = None,
    beads: str | None = None,
    infill: float | None = None,
) -> Json:
    """Make a curve object of paths for a tool on each of the last layers of an object, in a collection of their own.

    Parameters
    ----------
    obj : as for :func:`layer_export`
    step, fill : see :class:`PathSettings`
    path : write them to this file (.csv, .obj, .gcode) as well
    machine : name of a printer, or .toml file of one, see :class:`Machine`; None for ``marlin`` in a program
    beads : make a mesh of the beads as wide and as high as they are printed, in colours of their "layer", "height",
        "tilt" or "speed"
    infill : share of the volume between walls and skins that beads fill, 1 for all; None for the machine's

    Returns a dict with `collection`, `paths` (their number), `length`, `files`, `warnings`, and what
    :func:`print_facts` reports.

    Raises SynchError with one line that names the element and the remedy; nothing is made.
    """
    return run(PathsJob(obj, PathSettings(step, fill, machine_of(machine, path, infill)), path, beads))


def layer_volume(obj: bpy.types.Object, path: str | PathLike[str], resolution: int = 128) -> Json:
    """Write the pattern of the last layers of an object to an OpenVDB file, and make a volume object that shows it.

    Parameters
    ----------
    obj : as for :func:`layer_export`
    path : .vdb, with the grid `pattern`: cos(phase), 1 on the layers
    resolution : voxels along the longest side

    Returns a dict with `volume_object`, `voxels` (inside) and `files`.

    Raises SynchError with one line that names the element and the remedy; nothing is made.
    """
    return run(VolumeJob(obj, path, resolution))


class _OutputJob:
    """An output of an object's last layers, as objects and as a file; see :mod:`..jobs.job`."""

    def __init__(self, obj):
        obj = _solid(obj)
        self.link = ObjectLink.to(obj)
        with meshes.object_mode(obj):
            self._layering = memory.recall_layers(obj)

    def write(self, result):
        """Make objects and files of a result, where the layers are now; returns the report."""
        obj = self.link.found
        with meshes.object_mode(obj), whole_or_nothing():
            layering = memory.recall_layers(obj)
            if layering.pattern is not self._layering.pattern:
                raise SynchError(f"the layers of {obj.name} were solved again meanwhile: run again")
            if self._path is not None:
                keep_file(obj, self._path)
            with self._file(layering, result) as facts:
                made = self._make(obj, layering, result)
                warnings = [*made.get("warnings", ()), *facts.get("program", {}).get("warnings", ())]
                facts |= made | ({"warnings": warnings} if "warnings" in made else {})
                return {"status": "made", "command": self.command, "object": obj.name, **facts}


def machine_of(machine, path=None, infill=None):
    """The :class:`Machine` of a name or of a file whose name may begin with //; without one, the usual machine where a
    program is written to a path, else one that does not limit anything. A share of infill replaces the machine's."""
    if machine is None:
        is_program = isinstance(path, str | PathLike) and str(path).lower().endswith(files.PROGRAM)
        found = read_machine(USUAL) if is_program else Machine()
    else:
        found = read_machine(machine if isinstance(machine, str) and machine in MACHINES else _absolute(machine))
    return found if infill is None else replace(found, infill=infill)


class PathsJob(_OutputJob):
    """Paths for a tool, as curves and, with a path, in a file."""

    command = "layer_toolpaths"

    def __init__(self, obj, settings, path=None, beads=None):
        if beads is not None and convert_value("beads", str, beads) not in LOOKS:
            raise SettingError(f"the beads {quote_value(beads)} are unknown: use one of {', '.join(LOOKS)}")
        self._path, self._beads = None if path is None else _absolute(path), beads
        if path is not None:
            check_output(self._path, files.PATH_SUFFIXES)
        super().__init__(obj)
        self.request = self._layering.paths(settings)

    def _file(self, layering, paths):
        return nullcontext({"files": []}) if self._path is None else files.paths_file(paths, self._path)

    def _make(self, obj, layering, paths):
        return {
            "collection": files.write_paths(obj, layering, paths, self._beads).name,
            "paths": len(paths.layers),
            "length": float(paths.lines.lengths.sum()),
            "step": self.request.step,
            "fill": self.request.settings.fill,
            **print_facts(paths),
        }


class VolumeJob(_OutputJob):
    """The pattern as a file and a volume object."""

    command = "layer_volume"

    def __init__(self, obj, path, resolution):
        super().__init__(obj)
        self._path = _absolute(path)
        check_volume(self._path, resolution)
        self.request = self._layering.voxels(resolution)

    def _file(self, _layering, voxels):
        return grid_file(voxels, self._path)

    def _make(self, obj, layering, _voxels):
        return {"volume_object": make_volume(obj, layering, self._path).name}


def _solid(obj):
    """The object whose layers an object shows; SynchError if it has none or is not usable."""
    reason = no_object(obj)
    if reason:
        raise SynchError(reason)
    return solid_of(obj)


def _absolute(path):
    """A path that may begin with //, for the folder of the .blend file."""
    if check_path(path).startswith("//") and not bpy.data.filepath:
        raise SettingError(f"{path} begins with //, the folder of a .blend that is not saved: save it first")
    return bpy.path.abspath(str(path))
