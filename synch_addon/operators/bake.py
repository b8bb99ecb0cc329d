# SPDX-License-Identifier: GPL-3.0-or-later
"""Operator: the active object's stripes or quads as images."""

import bpy

from ...core.errors import SynchError
from .. import api
from ..bake_index import pattern_kind
from ..bake_panel import draw_bake
from ..bake_settings import PROPERTY_NAMES, BakeProperties, plain
from .field_operator import progress_of, unready


class SYNCH_OT_bake(BakeProperties, bpy.types.Operator):
    """Bake what the pattern shows into images over a UV map, with Cycles"""

    bl_idname = "synch.bake"
    bl_label = "Bake"
    bl_options = {"REGISTER", "UNDO", "PRESET"}

    @classmethod
    def poll(cls, context):
        reason = unready(context)
        if reason is None and pattern_kind(context.active_object) is None:
            reason = f"{context.active_object.name} has no pattern: solve stripes or quads on it first"
        if reason:
            cls.poll_message_set(reason)
        return reason is None

    def invoke(self, context, event):
        """From the window: take the scene's settings."""
        for name in PROPERTY_NAMES:
            setattr(self, name, getattr(context.scene.synch_bake, name))
        return self.execute(context)

    def execute(self, context):
        manager = context.window_manager
        manager.progress_begin(0, 1)
        try:
            report = api.bake(context.active_object, progress_of(manager), **plain(self))
        except SynchError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            manager.progress_end()
        for warning in report["warnings"]:
            self.report({"WARNING"}, warning)
        self.report({"INFO"}, f"baked {', '.join(report['maps'])} in {report['seconds']:.1f} s")
        return {"FINISHED"}

    def draw(self, context):
        draw_bake(self.layout, self, context.active_object)
