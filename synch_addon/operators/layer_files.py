# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that bring the last layers out of Blender: mesh files, tool paths, and a volume."""

import os
from functools import cache
from pathlib import Path
from zlib import crc32

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ExportHelper

from ...core.errors import SettingError
from ...core.printing.machine import SUFFIX
from ...core.tasks.layer_outputs import FILLS, PathSettings
from .. import api
from ..jobs.queue import queue
from ..jobs.report import count_text
from ..panels.setting_rows import draw_setting, property_column
from ..solids import memory
from ..solids.files import PATH_SUFFIXES
from ..solids.links import solid_of
from ..solids.outputs import PathsJob, VolumeJob, machine_of
from ..solids.report import print_line
from .field_operator import BackgroundOperator
from .ready import PromptOperator

_FILL = EnumProperty(
    name="Fill",
    description="How paths fill a layer",
    items=[
        (FILLS[0], "Contour", "One inside the other, from the rim of each layer inwards"),
        (FILLS[1], "Across X", "In planes across the object's X axis"),
        (FILLS[2], "Across Y", "In planes across the object's Y axis"),
        (FILLS[3], "Across Z", "In planes across the object's Z axis"),
    ],
)
_STEP = FloatProperty(
    name="Step", description="Distance between two paths; 0 for the spacing of the layers", min=0.0, subtype="DISTANCE"
)


_AUTOMATIC, _FILE = "AUTOMATIC", "FILE"
_MACHINES = [
    (_AUTOMATIC, "Automatic", "Marlin in a printer's program, otherwise three axes without limits", 0),
    ("marlin", "Marlin", "A printer with Marlin, three axes", 1),
    ("klipper", "Klipper", "A printer with Klipper, three axes", 2),
    ("clay", "Clay", "A printer of clay with a ram or a screw", 3),
    ("five_axis_ac", "Five Axes AC", "A table that turns around X (A) on one that turns around Z (C)", 4),
    ("five_axis_bc", "Five Axes BC", "A table that turns around Y (B) on one that turns around Z (C)", 5),
    (_FILE, "Another File", "A file that describes a printer (.toml)", 6),
]


def _list_machines(_operator, _context):
    """The shipped machines, and files beside the .blend that may describe others."""
    folder = os.path.dirname(bpy.data.filepath)
    return _items(tuple(sorted(path.name for path in Path(folder).glob(f"*{SUFFIX}")) if folder else ()))


@cache  # Blender keeps no reference to the texts of items that a function returns
def _items(names):
    tip = "A printer that a file beside the .blend describes"
    # Blender keeps a chosen item by its number, which is by the name alone: other files come and go.
    own = [(f"//{name}", name, tip, len(_MACHINES) + crc32(os.fsencode(name)) % 2**30) for name in names]
    return [*_MACHINES, *own]


_MACHINE = EnumProperty(name="Machine", description="The printer that the paths are for", items=_list_machines)
_MACHINE_FILE = StringProperty(name="File", description="A file that describes a printer (.toml)", subtype="FILE_PATH")


_INFILL = FloatProperty(
    name="Infill",
    description="Share of the volume between walls and skins that paths fill; 1 for what the machine's file says",
    default=1.0,
    min=0.0,
    max=1.0,
    subtype="FACTOR",
)


_BEADS = EnumProperty(
    name="Beads",
    description="Also make a mesh of the beads, as wide and as high as they are printed",
    items=[
        ("NONE", "None", "Curves alone"),
        ("LAYER", "Layers", "Colours that alternate from layer to layer"),
        ("HEIGHT", "Height", "Blue where beads are low, red where they are high"),
        ("TILT", "Tilt", "Blue where layers lie level, red where they are steep"),
        ("SPEED", "Speed", "Blue where beads are printed slowly, red where fast"),
    ],
)


def _draw_paths(layout, operator, names):
    """Settings of tool paths of an operator."""
    column = property_column(layout)
    for name in names:
        draw_setting(column, operator, name, "As layers" if name == "step" else "")
        if name == "machine" and operator.machine == _FILE:
            column.prop(operator, "machine_file")


class _LayerOperator:
    """Mixed into operators that need layers that were solved."""

    @classmethod
    def poll(cls, context):
        obj = solid_of(context.active_object)
        name = obj.name if obj is not None else "the active object"
        reason = None
        if not memory.holds_layers(obj):
            reason = f"no layers of {name} are in memory ({memory.KEPT_SOLIDS}): solve them first"
        elif queue.holds(obj):
            reason = f"{name} is being solved: wait for it, or cancel it"
        if reason:
            cls.poll_message_set(reason)
        return reason is None


class _NamedFile(ExportHelper):
    """Mixed into operators that ask for a file: it is offered the name of the object, beside the .blend."""

    def invoke(self, context, event):
        if not self.filepath:
            name = bpy.path.clean_name(solid_of(context.active_object).name) + self.filename_ext
            self.filepath = os.path.join(os.path.dirname(bpy.data.filepath), name)
        return super().invoke(context, event)


class _FileOperator(_LayerOperator, BackgroundOperator, _NamedFile):
    """Mixed into operators that solve for a file, once the user has named it."""

    _is_asked = False

    def invoke(self, context, event):
        self._is_asked = True
        return _NamedFile.invoke(self, context, event)

    def execute(self, context):
        """From the window, when the file is named, solve in the background; from a script to the end."""
        if self._is_asked and not bpy.app.background:
            self._is_asked = False
            return self._reporting(self._start, context)
        return super().execute(context)


class SYNCH_OT_layer_export(_NamedFile, _LayerOperator, PromptOperator, bpy.types.Operator):
    """Write the layers to mesh files, numbered from bottom to top (.stl, .ply or .obj)"""

    bl_idname = "synch.layer_export"
    bl_label = "Export Layers"

    filename_ext = ".stl"
    filter_glob: StringProperty(default="*.stl;*.ply;*.obj", options={"HIDDEN"})
    together: BoolProperty(name="One File", description="All layers in one file, instead of one file for each")

    def check(self, context):
        """Keep the suffixes .ply and .obj, which the helper would replace."""
        return not self.filepath.lower().endswith((".ply", ".obj")) and super().check(context)

    def make(self, context):
        report = api.layer_export(context.active_object, self.filepath, self.together)
        for line in report["warnings"]:
            self.report({"WARNING"}, line)
        files = report["files"]
        return f"wrote {files[0]}" if len(files) == 1 else f"wrote {len(files)} layers, {files[0]} the lowest"


class SYNCH_OT_layer_toolpaths(_LayerOperator, BackgroundOperator, bpy.types.Operator):
    """Make curves for a tool to follow on each layer, one object for each in a collection of their own"""

    bl_idname = "synch.layer_toolpaths"
    bl_label = "Tool Paths"
    bl_options = {"REGISTER", "UNDO"}

    fill: _FILL
    step: _STEP
    machine: _MACHINE
    machine_file: _MACHINE_FILE
    infill: _INFILL
    beads: _BEADS

    def draw(self, _context):
        _draw_paths(self.layout, self, ("fill", "step", "machine", "infill", "beads"))

    def _job(self, context):
        beads = None if self.beads == "NONE" else self.beads.lower()
        return PathsJob(context.active_object, _path_settings(self), beads=beads)

    def _headline(self, report):
        return _report_files(report)


class SYNCH_OT_layer_path_export(_FileOperator, bpy.types.Operator):
    """Make the curves of the tool paths, and write a table (.csv), polylines (.obj) or a printer's program (.gcode)"""

    bl_idname = "synch.layer_path_export"
    bl_label = "Export Tool Paths"
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ".gcode"
    filter_glob: StringProperty(default="*.csv;*.obj;*.gcode", options={"HIDDEN"})
    format: EnumProperty(
        name="Format",
        description="What is written; the file's suffix says the same",
        items=[
            (".gcode", "Printer's Program", "G-code for a printer (.gcode)"),
            (".csv", "Table", "Places, normals, heights and widths (.csv)"),
            (".obj", "Polylines", "Lines for other programs (.obj)"),
        ],
    )
    fill: _FILL
    step: _STEP
    machine: _MACHINE
    machine_file: _MACHINE_FILE
    infill: _INFILL
    _checked = filename_ext

    def draw(self, _context):
        _draw_paths(self.layout, self, ("format", "fill", "step", "machine", "infill"))

    def check(self, _context):
        """Keep format and suffix alike: of the two, what was changed last counts."""
        before, (stem, suffix) = (self.filepath, self.format), os.path.splitext(self.filepath)
        if self.format == self._checked and suffix.lower() in PATH_SUFFIXES:
            self.format = suffix.lower()
        elif suffix.lower() != self.format:
            self.filepath = (stem if suffix.lower() in PATH_SUFFIXES else self.filepath) + self.format
        self._checked = self.format
        return (self.filepath, self.format) != before

    def _job(self, context):
        return PathsJob(
            context.active_object,
            _path_settings(self, self.filepath),
            self.filepath,
        )

    def _headline(self, report):
        return _report_files(report)


class SYNCH_OT_layer_volume(_FileOperator, bpy.types.Operator):
    """Write the pattern to an OpenVDB file, and make a volume object that shows the layers as sheets of smoke"""

    bl_idname = "synch.layer_volume"
    bl_label = "Volume of the Layers"
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ".vdb"
    filter_glob: StringProperty(default="*.vdb", options={"HIDDEN"})
    resolution: IntProperty(
        name="Resolution", description="Voxels along the longest side", default=128, min=2, soft_max=512
    )

    def _job(self, context):
        return VolumeJob(context.active_object, self.filepath, self.resolution)

    def _headline(self, report):
        return f"{report['volume_object']}: {count_text(report['voxels'], 'voxel')}"


def _path_settings(operator, path=None):
    """The :class:`PathSettings` of an operator that may write to a path."""
    infill, machine = None if operator.infill == 1 else operator.infill, operator.machine
    if machine == _FILE and not operator.machine_file:
        raise SettingError("the machine's file has no name: choose the file, or another machine")
    chosen = {_AUTOMATIC: None, _FILE: operator.machine_file}.get(machine, machine)
    return PathSettings(operator.step or None, operator.fill, machine_of(chosen, path, infill))


def _report_files(report):
    paths = f"{report['collection']}: {print_line(report)}"
    return ", wrote ".join([paths, *report["files"]])


CLASSES = (SYNCH_OT_layer_export, SYNCH_OT_layer_toolpaths, SYNCH_OT_layer_path_export, SYNCH_OT_layer_volume)
