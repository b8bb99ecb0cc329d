# SPDX-License-Identifier: GPL-3.0-or-later
"""Operator: a shape to try patterns on, at the 3D cursor."""

import bpy
from bpy.props import EnumProperty, FloatProperty, IntProperty
from bpy_extras.object_utils import AddObjectHelper, add_object_align_init

from ..looks import samples


class SYNCH_OT_add_sample(AddObjectHelper, bpy.types.Operator):
    """Add a shape to try patterns on, with vertex groups and seams for constraints"""

    bl_idname = "synch.add_sample"
    bl_label = "Add Synch Sample"
    bl_options = {"REGISTER", "UNDO", "PRESET"}

    shape: EnumProperty(name="Shape", description="What is added", items=samples.SHAPES)
    size: FloatProperty(
        name="Size",
        description="Longest side of the object",
        subtype="DISTANCE",
        default=2.0,
        min=1e-3,
        soft_max=100.0,
    )
    detail: IntProperty(
        name="Detail",
        description="Each step makes four times as many faces",
        default=samples.DETAIL,
        min=1,
        max=6,
    )

    @classmethod
    def poll(cls, context):
        if context.mode != "OBJECT":
            cls.poll_message_set("leave the present mode: samples are added in object mode")
        return context.mode == "OBJECT"

    def execute(self, context):
        obj = samples.add_sample(self.shape, self.detail, self.size)
        obj.matrix_world = add_object_align_init(context, operator=self)
        self.report({"INFO"}, f"{obj.name}: {len(obj.data.polygons):,} faces")
        return {"FINISHED"}

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        for name in ("shape", "size", "detail", "align", "location", "rotation"):
            layout.prop(self, name)
