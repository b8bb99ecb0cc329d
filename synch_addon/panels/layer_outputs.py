# SPDX-License-Identifier: GPL-3.0-or-later
"""The box "Print and Show" of the panel "Layers": files, tool paths and a volume of the last layers."""

import bpy

from ..blender.modifiers import input_property
from ..blender.registration import register_all
from ..nodes.beads import SLIDER, beads_modifier
from ..solids import memory
from ..solids.files import beads_of
from ..solids.links import solid_of
from .sidebar import SidebarPanel


class SYNCH_PT_layer_files(SidebarPanel, bpy.types.Panel):
    """Files, tool paths and a volume of the layers that were solved last"""

    bl_label = "Print and Show"
    bl_parent_id = "SYNCH_PT_layers"

    @classmethod
    def poll(cls, context):
        obj = solid_of(context.active_object)
        return super().poll(context) and (memory.holds_layers(obj) or beads_of(obj) is not None)

    def draw(self, context):
        column = self.layout.column(align=True)
        column.operator("synch.layer_export", icon="EXPORT")
        column.operator("synch.layer_toolpaths", icon="CURVE_PATH")
        column.operator("synch.layer_path_export", icon="EXPORT")
        column.operator("synch.layer_volume", icon="VOLUME_DATA")
        beads = beads_of(solid_of(context.active_object))
        modifier = beads_modifier(beads) if beads else None
        if modifier is not None:
            self.layout.prop(*input_property(modifier, SLIDER), text=SLIDER, slider=True)


register, unregister = register_all((SYNCH_PT_layer_files,))
