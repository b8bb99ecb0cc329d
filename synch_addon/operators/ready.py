# SPDX-License-Identifier: GPL-3.0-or-later
"""When operators on the active object can run, and how those that are done at once say what they did, or what is
missing: in one line, which greys them out where it is known beforehand."""

from contextlib import contextmanager

import bpy

from ...core.errors import SynchError
from ..blender.meshes import refusal
from ..blender.phases import pattern_kind
from ..jobs.queue import queue


class PromptOperator:
    """Mixed into operators that are done at once: ``make`` returns the line that says what it did."""

    def execute(self, context):
        try:
            with _wait_cursor(context.window):
                line = self.make(context)
        except SynchError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, line)
        return {"FINISHED"}


@contextmanager
def _wait_cursor(window):
    """The pointer of a window that waits: on a large mesh what is done at once takes seconds."""
    if window is None or bpy.app.background:
        yield
        return
    window.cursor_modal_set("WAIT")
    try:
        yield
    finally:
        window.cursor_modal_restore()


class ReadyOperator:
    """Mixed into operators that work on the active mesh object."""

    @classmethod
    def poll(cls, context):
        reason = _unready(context) or cls.lacking(context.active_object)
        if reason:
            cls.poll_message_set(reason)
        return reason is None

    @classmethod
    def lacking(cls, obj):
        """Why there is nothing to be done with an object that is ready, or None."""
        return None


class PatternOperator(ReadyOperator):
    """Mixed into operators that need stripes or quads of the active object."""

    @classmethod
    def lacking(cls, obj):
        if pattern_kind(obj) is None:
            return f"{obj.name} has no pattern: solve stripes or quads on it first"
        return None


def _unready(context):
    """Why the active object cannot be worked on now, in one line, or None."""
    reason = refusal(context.active_object)
    if reason is None and context.mode not in {"OBJECT", "EDIT_MESH"}:
        reason = "leave the present mode: fields are solved in object or edit mode"
    if reason is None and queue.holds(context.active_object):
        reason = f"{context.active_object.name} is being solved: wait for it, or cancel it"
    if reason is None and queue.holds_window:
        reason = "something is being read or baked: wait for it, or cancel it with Esc"
    return reason
