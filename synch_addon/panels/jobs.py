# SPDX-License-Identifier: GPL-3.0-or-later
"""The box "Jobs" below all others: jobs of other objects than the active one, and of none."""

import bpy

from ..blender.meshes import refusal
from ..blender.registration import register_all
from ..blender.translations import translate
from ..jobs.queue import queue
from .progress import draw_work, is_boxed
from .sidebar import SidebarPanel, is_for

# Jobs that are shown, the others by their number.
SHOWN = 5


class SYNCH_PT_jobs(SidebarPanel, bpy.types.Panel):
    """Jobs that wait or run for other objects, such as vortices"""

    bl_label = "Jobs"
    bl_order = 100  # nothing below moves when it comes and goes
    in_simple = True

    @classmethod
    def poll(cls, context):
        return super().poll(context) and bool(_others(context.active_object) or len(_heard()) > 1)

    def draw(self, context):
        others = _others(context.active_object)
        if len(_heard()) > 1:
            self.layout.operator("synch.cancel", text="Cancel All", icon="X").place = -1
        for work in others[:SHOWN]:
            label, of = translate(work.label), work.obj
            column = self.layout.column(align=True)
            row = column.row()
            icon = "NONE" if work.has_begun else "TIME"
            row.label(text=label if of is None else f"{label}: {of.name}", icon=icon, translate=False)
            if work.has_begun:
                draw_work(column.row(align=True), column.row(align=True), work)
            else:
                row.operator("synch.cancel", text="", icon="X", emboss=False).place = queue.works.index(work)
        if len(others) > SHOWN:
            text = translate("{count} more are waiting", count=len(others) - SHOWN)
            self.layout.label(text=text, translate=False)


def _heard():
    return [work for work in queue.works if not work.is_quiet]


def _others(obj):
    """The jobs that the panel does not show in place of a button."""
    elsewhere = [work for work in _heard() if refusal(obj) is not None or not is_for(work, obj)]
    return [work for work in elsewhere if work.obj is not None or not is_boxed(work)]


register, unregister = register_all((SYNCH_PT_jobs,))
