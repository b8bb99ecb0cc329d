# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators: vortices of a volume, of files, or of curves that stand for filaments, and those of least energy."""

import bpy
from bpy.props import StringProperty
from bpy_extras.io_utils import ExportHelper

from ..flows import memory
from ..flows.choice import choose_point
from ..flows.chosen import flow_of
from ..flows.files import SUFFIXES, can_export, filament_export
from ..flows.job import job_for
from ..flows.properties import VortexProperties, plain
from ..jobs.queue import queue
from ..jobs.report import count_text
from ..panels.setting_rows import draw_setting
from ..panels.vortices import draw_vortices
from .field_operator import BackgroundOperator
from .ready import PromptOperator


class SYNCH_OT_clebsch(BackgroundOperator, VortexProperties, bpy.types.Operator):
    """Show the vortices of a file, of the active volume or mesh, or of the flow that the selected curves induce"""

    bl_idname = "synch.clebsch"
    bl_label = "Vortices"

    @classmethod
    def poll(cls, context):
        reason = None
        if context.mode != "OBJECT":
            reason = "leave the present mode: vortices are made in object mode"
        elif queue.holds(None):
            reason = "vortices are being solved: wait for them, or cancel them"
        if reason:
            cls.poll_message_set(reason)
        return reason is None

    def draw(self, context):
        draw_vortices(self.layout, self, lambda column: draw_setting(column, self, "core", "Auto"))

    def _take(self, context):
        for name in VortexProperties.__annotations__:
            setattr(self, name, getattr(context.scene.synch_vortices, name))

    def _job(self, context):
        return job_for(flow_of(context, self.filepath), plain(self))

    def _headline(self, report):
        return f"{report['object']}: {_find_flow(report)}, {report['times']['total']:.1f} s"


def _find_flow(report):
    if "frames" in report:
        return count_text(len(report["frames"]), "frame")
    counts = [(len(report["filaments"]), "filament")] if "filaments" in report else []
    counts += [(report["tubes"]["pieces"], "tube")] if "tubes" in report else []
    counts += [(len(report["vortices"]), "vortex")] if "vortices" in report else []
    return ", ".join(count_text(*count) for count in counts)


class SYNCH_OT_best_vortices(PromptOperator, bpy.types.Operator):
    """Show the filaments of least energy again, and the tubes seen from the north"""

    bl_idname = "synch.best_vortices"
    bl_label = "Least Energy"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return memory.flows.holds(context.active_object)

    def make(self, context):
        report = choose_point(context.active_object)
        return f"energy {report['energy']:.4g}, {_find_flow(report)}"


class SYNCH_OT_filament_export(PromptOperator, ExportHelper, bpy.types.Operator):
    """Write the filaments or tubes to a file for other programs: .vtp, .vtk, .ply, .obj, .abc, a table .csv"""

    bl_idname = "synch.filament_export"
    bl_label = "Export Vortices"

    filename_ext = ".vtp"
    filter_glob: StringProperty(default=";".join(f"*{suffix}" for suffix in SUFFIXES), options={"HIDDEN"})

    @classmethod
    def poll(cls, context):
        return can_export(context.active_object)

    def check(self, context):
        """Keep the other suffixes, which the helper would replace."""
        return not self.filepath.lower().endswith(SUFFIXES) and super().check(context)

    def make(self, context):
        report = filament_export(context.active_object, self.filepath)
        counts = [count_text(report[name], name[:-1]) for name in ("filaments", "tubes") if name in report]
        return f"wrote {counts[0]} to {report['files'][0]}"


CLASSES = (SYNCH_OT_clebsch, SYNCH_OT_best_vortices, SYNCH_OT_filament_export)
