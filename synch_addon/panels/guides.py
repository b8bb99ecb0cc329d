# SPDX-License-Identifier: GPL-3.0-or-later
"""Guidance and guide strokes in the panel, and the operators that add and remove the guides of a blend."""

import bpy

from ..blender.registration import register_all
from ..settings.guide_list import NAME_PROPERTIES, UNGUIDED
from .row_operators import RemoveRow, RowOperator

TOOL = "synch.strokes"


def is_drawing(context):
    """Whether the tool for guide strokes is chosen in the views of a window."""
    tool = context.workspace.tools.from_space_view3d_mode("OBJECT", create=False)
    return tool is not None and tool.idname == TOOL


def draw_strokes(column):
    """The button that chooses the tool for guide strokes, and what is asked of those that are drawn."""
    context = bpy.context
    if context.mode != "OBJECT":
        return
    drawing = is_drawing(context)
    text = "Done Drawing" if drawing else "Draw Strokes"
    button = column.operator("wm.tool_set_by_id", text=text, icon="GREASEPENCIL", depress=drawing)
    button.name = "builtin.select_box" if drawing else TOOL
    if drawing:
        strokes = context.scene.synch_strokes
        wishes = column.row()
        wishes.use_property_split = False  # beside a label they would be cut off
        wishes.prop(strokes, "wish", expand=True)
        line = column.row(heading="Soft")
        line.prop(strokes, "soft", text="")
        strength = line.row()
        strength.active = strokes.soft
        strength.prop(strokes, "strength", text="")
        column.label(text="Ctrl: erase   Shift: smooth", icon="INFO")


def draw_guidance(column, stored):
    """The object's guidance, with the settings that count for it."""
    column.prop(stored, "guidance")
    if stored.guidance == "BLEND":
        for number, guide in enumerate(stored.guides):
            _draw_row(column, guide, number)
        column.operator("synch.guide_add", icon="ADD")
    elif stored.guidance not in UNGUIDED:
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
        self.owner(context).synch.guides.add()
        return {"FINISHED"}


class SYNCH_OT_guide_remove(RemoveRow, bpy.types.Operator):
    """Remove this guide from the blend"""

    bl_idname = "synch.guide_remove"
    bl_label = "Remove Guide"

    def rows(self, obj):
        return obj.synch.guides


register, unregister = register_all((SYNCH_OT_guide_add, SYNCH_OT_guide_remove))
