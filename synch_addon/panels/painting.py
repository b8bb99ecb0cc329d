# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps in the panels: a button that paints one, and meanwhile the brush's value in units, and the way back."""

import math

import bpy

from ..blender.translations import translate
from ..patterns.refine import as_length
from ..settings.fields import source_of
from ..settings.painting import MAPS, painted_map
from .row_operators import can_set

KIND_LABELS = {"stripes": "Stripes", "quads": "Quad Pattern", "quad_mesh": "Quad Mesh", "directions": "Directions"}


def draw_map(column, settings, target):
    """A map of settings and what a weight of 1 stands for, and for those of the active object a button that paints it.

    Parameters
    ----------
    column : UILayout
    settings : the object's, or an operator's
    target : the word of the map in :data:`MAPS`
    """
    row = column.row(align=True)
    row.prop(settings, MAPS[target].name)
    if settings.id_data == bpy.context.active_object:
        row.operator("synch.paint_map", text="", icon="WPAINT_HLT").target = target
    if getattr(settings, MAPS[target].name):
        column.prop(settings, MAPS[target].full, text="Range")


def draw_painting(layout, context):
    """The brush while a map of the active object is painted; whether one is."""
    obj = context.active_object
    target = painted_map(obj)
    if target is None:
        return False
    chosen, brush = MAPS[target], context.window_manager.synch_brush
    settings = getattr(obj, chosen.settings)
    box = layout.box().column()
    box.label(text=obj.vertex_groups.active.name, icon="WPAINT_HLT", translate=False)
    column = box.column()
    column.use_property_split, column.use_property_decorate = True, False
    column.prop(brush, "angle" if target == "ANGLE" else "factor")
    column.prop(settings, chosen.full, text="Range")
    box.label(text=_painted_line(context, settings, target), translate=False)
    box.operator("synch.done_painting", icon="CHECKMARK")
    if target != "LAYERS" and can_set(obj):
        kind = obj.synch_simple.kind
        text = translate(KIND_LABELS[kind])
        text = text if source_of(obj) is None else translate("Update {what}", what=text)
        icon = box.enum_item_icon(obj.synch_simple, "kind", kind)
        box.operator("synch.done_painting", text=text, icon_value=icon, translate=False).solves = True
    return True


def draw_density(column, obj):
    """The map of spacing of what becomes a quad mesh, and the button that paints it."""
    if obj.synch.spacing_map:
        row = column.row(align=True)
        row.prop(obj.synch, "spacing_map", text="Density")
        row.operator("synch.paint_map", text="", icon="WPAINT_HLT").target = "SPACING"
    else:
        column.operator("synch.paint_map", text="Paint Density", icon="WPAINT_HLT").target = "SPACING"


def _painted_line(context, settings, target):
    """What the brush paints, in units, such as "0.50 × spacing = 0.05 m"."""
    brush = context.window_manager.synch_brush
    if target == "ANGLE":
        return translate("Paints a turn by {angle:.0f}°", angle=math.degrees(brush.angle))
    line = translate("Paints {factor:.2f} × spacing", factor=brush.factor)
    if settings.automatic_spacing:
        return line
    return f"{line} = {as_length(brush.factor * settings.spacing)}"
