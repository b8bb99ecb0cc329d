# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel "Constraints" below the settings, and the operators that add, remove and move its rows."""

import bpy
from bpy.props import EnumProperty

from ..blender.registration import register_all
from ..settings.fields import original_of
from .row_operators import RowOperator
from .setting_rows import property_column
from .sidebar import SettingsPanel


class _ActiveRowOperator(RowOperator):
    @classmethod
    def poll(cls, context):
        if not super().poll(context):
            return False
        stored = cls.owner(context).synch
        return 0 <= stored.active_constraint < len(stored.constraints)


class SYNCH_OT_constraint_add(RowOperator, bpy.types.Operator):
    """Add a row to the list of constraints"""

    bl_idname = "synch.constraint_add"
    bl_label = "Add Constraint"

    def execute(self, context):
        stored = self.owner(context).synch
        stored.constraints.add()
        stored.active_constraint = len(stored.constraints) - 1
        return {"FINISHED"}


class SYNCH_OT_constraint_remove(_ActiveRowOperator, bpy.types.Operator):
    """Remove the active row"""

    bl_idname = "synch.constraint_remove"
    bl_label = "Remove Constraint"

    def execute(self, context):
        stored = self.owner(context).synch
        stored.constraints.remove(stored.active_constraint)
        stored.active_constraint = max(min(stored.active_constraint, len(stored.constraints) - 1), 0)
        return {"FINISHED"}


class SYNCH_OT_constraint_move(_ActiveRowOperator, bpy.types.Operator):
    """Move the active row up or down"""

    bl_idname = "synch.constraint_move"
    bl_label = "Move Constraint"

    direction: EnumProperty(
        name="Direction", description="Where the row goes", items=(("UP", "Up", ""), ("DOWN", "Down", ""))
    )

    def execute(self, context):
        stored = self.owner(context).synch
        to = stored.active_constraint + (1 if self.direction == "DOWN" else -1)
        if not 0 <= to < len(stored.constraints):
            return {"CANCELLED"}
        stored.constraints.move(stored.active_constraint, to)
        stored.active_constraint = to
        return {"FINISHED"}


class SYNCH_UL_constraints(bpy.types.UIList):
    """One line for each row: where, what, and whether it is used"""

    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index):
        label = bpy.types.UILayout.enum_item_name
        line = layout.row()
        texts = line.split(factor=0.65)
        texts.active = item.enabled
        where = item.place_name or label(item, "where", item.where)
        place_icon = bpy.types.UILayout.enum_item_icon(item, "where", item.where)
        texts.label(text=where, **({"icon": "ERROR"} if item.is_incomplete else {"icon_value": place_icon}))
        texts.label(text=label(item, "what", item.what))
        line.prop(item, "enabled", text="")


class SYNCH_PT_constraints(SettingsPanel, bpy.types.Panel):
    """Conditions on the pattern along lines of the mesh"""

    bl_label = "Constraints"
    bl_parent_id = "SYNCH_PT_guide"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 2

    def draw_body(self, context):
        obj = original_of(context.active_object)
        stored = obj.synch
        line = self.layout.row()
        rows = 4 if len(stored.constraints) > 1 else 2
        line.template_list("SYNCH_UL_constraints", "", stored, "constraints", stored, "active_constraint", rows=rows)
        buttons = line.column(align=True)
        buttons.operator("synch.constraint_add", icon="ADD", text="")
        buttons.operator("synch.constraint_remove", icon="REMOVE", text="")
        if len(stored.constraints) > 1:
            buttons.separator()
            buttons.operator("synch.constraint_move", icon="TRIA_UP", text="").direction = "UP"
            buttons.operator("synch.constraint_move", icon="TRIA_DOWN", text="").direction = "DOWN"
        if 0 <= stored.active_constraint < len(stored.constraints):
            _draw_row(self.layout, stored.constraints[stored.active_constraint], obj)


def _draw_row(layout, item, obj):
    """Settings of a row: only those that count for it."""
    column = property_column(layout)
    column.prop(item, "where")
    name = column.column()
    name.alert = item.is_incomplete
    if item.where in {"BOUNDARY", "GROUP"}:
        name.prop_search(item, "vertex_group", obj, "vertex_groups")
    elif item.where == "CURVE":
        name.prop(item, "curve")
    elif item.where == "ATTRIBUTE":
        name.prop(item, "attribute")
    wishes = column.grid_flow(row_major=True, columns=3, even_columns=True, align=True)
    wishes.use_property_split = False
    for wish in item.possible:
        wishes.prop_enum(item, "what", wish)
    if item.what in {"ANGLE", "PHASE"}:
        column.prop(item, item.what.lower())
    if item.has_weight:
        line = column.row(heading="Soft")
        line.prop(item, "soft", text="")
        weight = line.row()
        weight.active = item.soft
        weight.prop(item, "weight", text="")


register, unregister = register_all(
    (
        SYNCH_OT_constraint_add,
        SYNCH_OT_constraint_remove,
        SYNCH_OT_constraint_move,
        SYNCH_UL_constraints,
        SYNCH_PT_constraints,
    )
)
