# SPDX-License-Identifier: GPL-3.0-or-later
"""The box "Bake" of the sidebar tab; its settings are the scene's."""

import bpy

from . import jobs
from .bake_index import pattern_kind
from .bake_settings import BakeProperties
from .panels import SidebarPanel, property_column
from .registration import keeping
from .scene_io import refusal


class SynchBake(BakeProperties, bpy.types.PropertyGroup):
    """Settings of bakes, kept in the file."""


class SYNCH_PT_bake(SidebarPanel, bpy.types.Panel):
    """The pattern as images"""

    bl_label = "Bake"
    bl_parent_id = "SYNCH_PT_fields"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 4

    @classmethod
    def poll(cls, context):
        obj = context.active_object
        return refusal(obj) is None and pattern_kind(obj) is not None and jobs.running is None

    def draw(self, context):
        draw_bake(self.layout, context.scene.synch_bake, context.active_object)
        self.layout.operator("synch.bake", icon="RENDER_STILL")


def draw_bake(layout, settings, obj):
    """Settings of a bake; ``settings`` are the scene's or an operator's."""
    layout.column(align=True).grid_flow(columns=3, align=True).prop(settings, "maps")
    column = property_column(layout)
    for name in ("size", "margin", "samples"):
        column.prop(settings, name)
    column.prop_search(settings, "uv_map", obj.data, "uv_layers", icon="GROUP_UVS")
    column.prop(settings, "unwrap")
    column.prop(settings, "folder", placeholder="in the .blend")
    column.prop(settings, "naming")
    column.prop(settings, "file_format")
    column.prop(settings, "material")
    row = column.row()
    row.enabled = settings.material and "HEIGHT" in settings.maps
    row.prop(settings, "displacement")


register, unregister = keeping((SynchBake, SYNCH_PT_bake), (bpy.types.Scene, "synch_bake", SynchBake))
