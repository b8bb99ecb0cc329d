# SPDX-License-Identifier: GPL-3.0-or-later
"""The box "Result" of the sidebar tab: what the last solve found, its variations, its defects."""

import json

import bpy

from . import jobs, memory
from .panels import SidebarPanel, property_column
from .report import counted
from .scene_io import refusal


class SYNCH_PT_result(SidebarPanel, bpy.types.Panel):
    """What the last solve found"""

    bl_label = "Result"
    bl_parent_id = "SYNCH_PT_fields"

    @classmethod
    def poll(cls, context):
        obj = context.active_object
        return refusal(obj) is None and bool(obj.synch.result) and jobs.running is None

    def draw(self, context):
        synch = context.active_object.synch
        draw_figures(self.layout, json.loads(synch.result))
        if memory.holds(context.active_object):
            row = property_column(self.layout).row(align=True)
            row.prop(synch, "variation")
            row.operator("synch.draw_variation", text="", icon="FILE_REFRESH")
            self.layout.operator("synch.place_defect", icon="PIVOT_CURSOR")
            command = json.loads(synch.result)["command"]
            if command == "quads":
                self.layout.operator("synch.trace_quads", icon="MOD_REMESH")
            if command != "directions":
                row = self.layout.row(align=True)
                row.operator("synch.isolines", icon="MOD_CURVE")
                row.operator("synch.relief", icon="MOD_DISPLACE")
        row = self.layout.row(align=True)
        row.operator("synch.select_defects", text="Select", icon="RESTRICT_SELECT_OFF")
        row.operator("synch.next_defect", text="Next", icon="VIEWZOOM")
        row.operator("synch.copy_report", text="Report", icon="COPYDOWN")


def draw_figures(layout, result):
    """Energy, bound and counts; ``result`` is what :func:`report.result_line` keeps."""
    column = layout.column(align=True)
    if result["energy"] is not None:
        column.label(text=f"Energy {result['energy']:.4g}", icon="SORTTIME")
        if result["certificate"] == "proved":
            column.label(text=f"Proved: no field saves more than {result['gap']:.0%}", icon="CHECKMARK")
        elif result["certificate"] == "estimated":
            column.label(text=f"About {result['gap']:.0%} above the bound", icon="QUESTION")
    for kind in ("disclination", "dislocation"):
        column.label(text=counted(result[kind + "s"], kind), icon="DOT")
    column.label(text=f"{result['seconds']:.2f} s, {counted(result['nodes'], 'vertex')}", icon="TIME")


def register():
    bpy.utils.register_class(SYNCH_PT_result)


def unregister():
    bpy.utils.unregister_class(SYNCH_PT_result)
