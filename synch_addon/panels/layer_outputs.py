# SPDX-License-Identifier: GPL-3.0-or-later
"""The box "Print and Show" of the panel "Layers": files, tool paths and a volume of the last layers."""

import bpy

from ..blender.registration import register_all
from ..solids import memory
from ..solids.links import solid_of
from .sidebar import SidebarPanel


class SYNCH_PT_layer_files(SidebarPanel, bpy.types.Panel):
    """Files, tool paths and a volume of the layers that were solved last"""

    bl_label = "Print and Show"
    bl_parent_id = "SYNCH_PT_layers"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and memory.holds_layers(solid_of(context.active_object))

    def draw(self, context):
        column = self.layout.column(align=True)
        column.operator("synch.layer_export", icon="EXPORT")
        column.operator("synch.layer_toolpaths", icon="CURVE_PATH")
        column.operator("synch.layer_path_export", icon="EXPORT")
        column.operator("synch.layer_volume", icon="VOLUME_DATA")


register, unregister = register_all((SYNCH_PT_layer_files,))
