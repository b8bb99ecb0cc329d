# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that end jobs: with nothing written, or with what is shown."""

import bpy
from bpy.props import IntProperty

from ..jobs.queue import queue


class SYNCH_OT_cancel(bpy.types.Operator):
    """Stop a solve that runs or waits; everything stays as it was"""

    bl_idname = "synch.cancel"
    bl_label = "Cancel"
    bl_options = {"INTERNAL"}

    place: IntProperty(
        name="Place", description="Number of the job in the queue, counted from 0; -1 for all jobs", min=-1
    )

    @classmethod
    def poll(cls, context):
        return queue.running is not None

    def execute(self, context):
        chosen = reversed(queue.works) if self.place < 0 else [queue.works[min(self.place, len(queue.works) - 1)]]
        for work in list(chosen):
            queue.cancel(work)
        return {"FINISHED"}


class SYNCH_OT_keep(bpy.types.Operator):
    """Stop the solve and keep what it shows now"""

    bl_idname = "synch.keep"
    bl_label = "Good Enough"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context):
        return queue.running is not None and queue.running.shows_result

    def execute(self, context):
        queue.keep(queue.running)
        return {"FINISHED"}


CLASSES = (SYNCH_OT_cancel, SYNCH_OT_keep)
