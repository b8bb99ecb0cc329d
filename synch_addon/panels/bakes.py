# SPDX-License-Identifier: GPL-3.0-or-later
"""The box "Bake" of the sidebar tab; its settings are the scene's."""

import bpy

from ...core.settings.bake import BakeSettings
from ...core.settings.setting import records
from ..bakes.job import bake_seconds
from ..blender.phases import pattern_kind
from ..blender.registration import register_all
from ..settings.rna import properties_of
from .progress import draw_begin, draw_estimate
from .row_operators import can_set
from .setting_rows import draw_settings, property_column
from .sidebar import SettingsPanel

BAKE_NAMES = tuple(name for name, _ in records(BakeSettings))
BakeProperties = properties_of(BakeSettings, BAKE_NAMES)


class SynchBake(BakeProperties, bpy.types.PropertyGroup):
    """Settings of bakes, kept in the file."""


class SYNCH_PT_bake(SettingsPanel, bpy.types.Panel):
    """The pattern as images"""

    bl_label = "Bake"
    bl_parent_id = "SYNCH_PT_make"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 1

    @classmethod
    def poll(cls, context):
        return super().poll(context) and pattern_kind(context.active_object) is not None

    def draw(self, context):
        settings, obj, column = context.scene.synch_bake, context.active_object, self.layout.column()
        column.enabled = can_set(obj)
        draw_bake(column, settings, obj)
        seconds = bake_seconds(map(str.lower, settings.maps), settings.size, settings.samples)
        draw_estimate(column, "Bake", seconds)
        draw_begin(self.layout, "synch.bake", "Bake", "RENDER_STILL", obj)


def draw_bake(layout, settings, obj):
    """Settings of a bake; ``settings`` are the scene's or an operator's."""
    layout.column(align=True).grid_flow(columns=3, align=True).prop(settings, "maps")
    column = property_column(layout)
    draw_settings(column, settings, BakeSettings, "bake")
    if obj.data.uv_layers:
        column.prop_search(settings, "uv_map", obj.data, "uv_layers", icon="GROUP_UVS")
        column.prop(settings, "unwrap")
    else:
        column.label(text="No UV map: Smart UV Project makes one", icon="INFO")
    column.prop(settings, "folder", placeholder="in the .blend")
    draw_settings(column, settings, BakeSettings, "files")
    row = column.row()
    row.enabled = settings.material and "HEIGHT" in settings.maps
    row.prop(settings, "displacement")


register, unregister = register_all((SynchBake, SYNCH_PT_bake), (bpy.types.Scene, "synch_bake", SynchBake))
