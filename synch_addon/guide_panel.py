# SPDX-License-Identifier: GPL-3.0-or-later
"""Guidance in the panel, and the operators that add and remove the guides of a blend."""

import bpy
from bpy.props import IntProperty

from . import jobs
from .guide_list import NAME_PROPERTIES
from .scene_io import refusal


def draw_guidance(column, stored):
    """The object's guidance, with the settings that count for it."""
    column.prop(stored, "guidance")
    if stored.guidance == "BLEND":
        for number, guide in enumerate(stored.guides):
            _draw_row(column, guide, number)
        column.operator("synch.guide_add", icon="ADD")
    elif stored.guidance != "SMOOTH":
        _draw_name(column, stored.guide, stored.guidance)
        if stored.guidance != "ATTRIBUTE":  # taken exactly as it is
            column.prop(stored.guide, "strength")


def _draw_row(column, guide, number):
    box = column.box().column()
    line = box.row(align=True)
    line.prop(guide, "kind", text="")
    line.prop(guide, "strength", text="")
    line.operator("synch.guide_remove", icon="X", text="").number = number
    _draw_name(box, guide, guide.kind)


def _draw_name(column, guide, kind):
    if kind not in NAME_PROPERTIES:
        return
    line = column.row()
    name = NAME_PROPERTIES[kind]
    line.alert = name != "uv_map" and not getattr(guide, name)
    line.prop(guide, name)


class _GuideOperator:
    """Mixed into operators that change the active object's blend."""

    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    @classmethod
    def poll(cls, context):
        return refusal(context.active_object) is None and jobs.running is None


class SYNCH_OT_guide_add(_GuideOperator, bpy.types.Operator):
    """Add a guide to the blend"""

    bl_idname = "synch.guide_add"
    bl_label = "Add Guide"

    def execute(self, context):
        context.active_object.synch.guides.add()
        return {"FINISHED"}


class SYNCH_OT_guide_remove(_GuideOperator, bpy.types.Operator):
    """Remove this guide from the blend"""

    bl_idname = "synch.guide_remove"
    bl_label = "Remove Guide"

    number: IntProperty(name="Number", description="Which guide, counted from 0", min=0)

    def execute(self, context):
        guides = context.active_object.synch.guides
        if self.number >= len(guides):
            return {"CANCELLED"}
        guides.remove(self.number)
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((SYNCH_OT_guide_add, SYNCH_OT_guide_remove))
