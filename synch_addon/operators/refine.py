# SPDX-License-Identifier: GPL-3.0-or-later
"""Operator: subdivide a mesh that is too coarse for the spacing of its pattern."""

import bpy
from bpy.props import IntProperty

from .. import api
from ..patterns import refine
from .ready import PromptOperator, ReadyOperator


class SYNCH_OT_refine(ReadyOperator, PromptOperator, bpy.types.Operator):
    """Subdivide the mesh, so that it carries the spacing: smoothly where it looks smooth, else without changing its \
shape. UV maps, groups and attributes go over; a pattern on it has to be solved again"""

    bl_idname = "synch.refine"
    bl_label = "Subdivide for Spacing"
    bl_options = {"REGISTER", "UNDO"}

    levels: IntProperty(
        name="Level",
        description="How often every edge is halved; by default as often as the spacing needs",
        default=1,
        min=1,
        max=refine.MOST_LEVELS,
    )

    @classmethod
    def lacking(cls, obj):
        if obj.data.shape_keys:
            return f"{obj.name} has shape keys, which subdivision would lose: apply them first"
        return None

    def make(self, context):
        levels = self.levels if self.properties.is_property_set("levels") else None
        report = api.refine(context.active_object, levels)
        self.levels = report["levels"]
        return f"{report['object']} has {report['faces']:,} faces, before {report['faces_before']:,}"
