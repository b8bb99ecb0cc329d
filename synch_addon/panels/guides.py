# SPDX-License-Identifier: GPL-3.0-or-later
"""Guidance in the panel, and the operators that add and remove the guides of a blend."""

import bpy

from ..blender.registration import register_all
from ..settings.guide_list import NAME_PROPERTIES
from .row_operators import RemoveRow, RowOperator


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


class SYNCH_OT_guide_add(RowOperator, bpy.types.Operator):
    """Add a guide to the blend"""

    bl_idname = "synch.guide_add"
    bl_label = "Add Guide"

    def execute(self, context):
        context.active_object.synch.guides.add()
        return {"FINISHED"}


class SYNCH_OT_guide_remove(RemoveRow, bpy.types.Operator):
    """Remove this guide from the blend"""

    bl_idname = "synch.guide_remove"
    bl_label = "Remove Guide"

    def rows(self, obj):
        return obj.synch.guides


register, unregister = register_all((SYNCH_OT_guide_add, SYNCH_OT_guide_remove))
