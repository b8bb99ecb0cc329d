# SPDX-License-Identifier: GPL-3.0-or-later
"""Operator: the active object's stripes or quads as images."""

import bpy

from ...core.settings.bake import BakeSettings
from ..bakes.job import BakeJob
from ..panels.bakes import BAKE_NAMES, BakeProperties, draw_bake
from ..settings.rna import settings_of
from .field_operator import BackgroundOperator
from .ready import PatternOperator


class SYNCH_OT_bake(PatternOperator, BackgroundOperator, BakeProperties, bpy.types.Operator):
    """Bake what the pattern shows into images over a UV map, with Cycles in the background; Esc cancels"""

    bl_idname = "synch.bake"
    bl_label = "Bake"
    _elsewhere = False

    def _take(self, context):
        for name in BAKE_NAMES:
            setattr(self, name, getattr(context.scene.synch_bake, name))
        self.unwrap |= not context.active_object.data.uv_layers

    def _job(self, context):
        settings = settings_of(BakeSettings, self, BAKE_NAMES)
        return BakeJob(context.active_object, settings, self._elsewhere)

    def _start(self, context):
        self._elsewhere = True  # only now: the redo panel runs this operator to its end
        try:
            return super()._start(context)
        finally:
            self._elsewhere = False

    def _headline(self, report):
        is_packed = any("image" in entry for entry in report["maps"].values())
        where = "as images in this file: open them in the Image Editor" if is_packed else "as files"
        return f"baked {', '.join(report['maps'])} in {report['seconds']:.1f} s, {where}"

    def draw(self, context):
        draw_bake(self.layout, self, context.active_object)
