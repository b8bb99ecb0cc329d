# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel "Layers" of the sidebar tab, and the operators that add and remove its groups."""

from functools import partial

import bpy

from ...core.geometry.filling.lengths import MOST_TETS, estimate
from ...core.geometry.filling.thin_walls import MOST
from ...core.settings.layers import LayerSettings
from ...core.tasks.solid_memory import is_searched, layer_memory
from ...core.tasks.solids import TET_SECONDS
from ..blender.meshes import refusal
from ..blender.modifiers import input_property
from ..blender.registration import register_all
from ..blender.translations import OURS, translate
from ..jobs.queue import queue
from ..nodes.layers import opening_modifier
from ..solids.expected import expected_lengths, measures_of
from ..solids.links import solid_of
from ..solids.properties import GUIDE_NAMES, LENGTHS, OPTIONAL_NAMES, given_lengths
from .painting import draw_map
from .progress import draw_begin, draw_estimate
from .row_operators import RemoveRow, RowOperator
from .setting_rows import draw_automatic, draw_settings, property_column
from .sidebar import DetailsPanel, SidebarPanel, draw_unready


class SYNCH_PT_layers(SidebarPanel, bpy.types.Panel):
    """Evenly spaced layers in the solid that a closed mesh encloses"""

    bl_label = "Layers"
    bl_translation_context = OURS
    bl_parent_id = "SYNCH_PT_make"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 3

    def draw(self, context):
        obj = solid_of(context.active_object)
        if (obj == context.active_object or refusal(obj)) and draw_unready(self.layout, obj):
            return
        if obj != context.active_object:
            self.layout.label(text=translate("Layers of {name}", name=obj.name), icon="OBJECT_DATA")
        row = self.layout.row()
        row.scale_y = 1.3
        draw_begin(row, "synch.layers", "Layers", "ALIGN_JUSTIFY", obj)
        column = self.layout.column()
        column.enabled = not queue.holds(obj)
        _draw_expected(column, obj)
        draw_opening(column, context.active_object)
        draw_layers(column, obj.synch_layering)


class SYNCH_PT_layer_solver(DetailsPanel, bpy.types.Panel):
    """How the fields of layers are optimized"""

    bl_parent_id = "SYNCH_PT_layers"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and refusal(solid_of(context.active_object)) is None

    @staticmethod
    def settings(context):
        return solid_of(context.active_object).synch_layering


def draw_opening(layout, obj):
    """Sliders that cut layers open and peel them, where the active object is one of layers."""
    modifier = opening_modifier(obj)
    if modifier is None:
        return
    column = layout.column(align=True)
    for name in ("Cut Open", "Peel"):
        column.prop(*input_property(modifier, name), text=name, slider=True)


def draw_layers(layout, stored):
    """Settings of an object's layers."""
    column = property_column(layout)
    column.prop(stored, "guide")
    for name in GUIDE_NAMES[stored.guide]:
        field = column.row()
        field.alert = name not in OPTIONAL_NAMES and not getattr(stored, name)
        field.prop(stored, name)
    for number, row in enumerate(stored.groups):
        line = layout.row(align=True)
        line.prop(row, "group", text="")
        line.prop(row, "wish", text="")
        if row.wish == "LAYER":
            line.prop(row, "offset", text="")
        line.operator("synch.layer_group_remove", text="", icon="X").number = number
    layout.operator("synch.layer_group_add", icon="ADD")
    own = {name: partial(draw_automatic, settings=stored, name=f"shown_{name}") for name in LENGTHS}
    own["spacing_map"] = partial(draw_map, settings=stored, target="LAYERS")
    draw_settings(property_column(layout), stored, LayerSettings, "layers", own)


def _draw_expected(layout, obj):
    """How large the solid will be and how long its layers take, before they are made."""
    stored = obj.synch_layering
    lengths, measures = expected_lengths(obj, **given_lengths(stored)), measures_of(obj)
    if lengths is None:
        return
    tets = estimate(measures, lengths.size).tets
    searched = is_searched(stored.guide == "AXIS", not stored.spacing_map, len(stored.groups))
    size = layer_memory(measures, lengths, searched).expected
    layout.label(text=translate("About {tets:,} tetrahedra", tets=tets), icon="MESH_ICOSPHERE")
    if len(stored.groups):
        line = translate("Up to {tets:,} with thin walls", tets=min(round(MOST * tets), MOST_TETS))
        layout.label(text=line, icon="BLANK1")
    draw_estimate(layout, "Layers", TET_SECONDS * tets, size / 2**20)


class _GroupOperator:
    """Mixed into operators on the groups of the solid whose layers the active object shows."""

    @staticmethod
    def owner(context):
        return solid_of(context.active_object)


class SYNCH_OT_layer_group_add(_GroupOperator, RowOperator, bpy.types.Operator):
    """Add a condition on the layers at a part of the surface"""

    bl_idname = "synch.layer_group_add"
    bl_label = "Add Group"

    def execute(self, context):
        obj = self.owner(context)
        row = obj.synch_layering.groups.add()
        if obj.vertex_groups.active:
            row.group = obj.vertex_groups.active.name
        return {"FINISHED"}


class SYNCH_OT_layer_group_remove(_GroupOperator, RemoveRow, bpy.types.Operator):
    """Ask nothing of the layers there"""

    bl_idname = "synch.layer_group_remove"
    bl_label = "Remove Group"

    def rows(self, obj):
        return obj.synch_layering.groups


register, unregister = register_all(
    (SYNCH_OT_layer_group_add, SYNCH_OT_layer_group_remove, SYNCH_PT_layers, SYNCH_PT_layer_solver)
)
