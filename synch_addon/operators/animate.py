# SPDX-License-Identifier: GPL-3.0-or-later
"""Operator: a pattern in each frame of the active mesh's motion."""

import bpy

from ..frames.job import AnimationJob
from ..jobs.report import count_text
from ..panels.frames import AnimationProperties, span_of
from ..settings.fields import SettingProperties
from .field_operator import FieldOperator


class SYNCH_OT_animate(FieldOperator, AnimationProperties, SettingProperties, bpy.types.Operator):
    """Solve the pattern in each frame of a moving or deforming mesh, each frame from the one before"""

    bl_idname = "synch.animate"
    bl_label = "Animate"
    bl_options = {"UNDO"}  # without a redo panel: every change there would solve all frames again

    def _take(self, context):
        super()._take(context)
        for name in AnimationProperties.__annotations__:
            setattr(self, name, getattr(context.active_object.synch_animation, name))

    def _job(self, context):
        return AnimationJob(context.active_object, self._settings(), span_of(self, context.scene))

    def _headline(self, report):
        return f"{report['pattern']} in {count_text(len(report['frames']), 'frame')}"
