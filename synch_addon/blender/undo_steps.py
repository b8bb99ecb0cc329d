# SPDX-License-Identifier: GPL-3.0-or-later
"""Undo steps for results that are written before an operator ends, at which Blender would make a step.

Undo does not touch a datablock that is equal in the two steps. If such a datablock was changed after the last step and
points to a new one, undo removes the new one, the pointer stays, and Blender crashes. So such a result gets a step of
its own, which the user's next undo takes back. The step is made just before that undo, since most often an operator
ends earlier and makes one; it is made at once if there is nothing to undo, or something to redo.
"""

from contextlib import nullcontext

import bpy
from bpy.app.handlers import load_post, persistent, undo_pre

from .registration import register_handlers


class _UndoSteps:
    """Steps that are recorded now, or owed until another one is."""

    def __init__(self):
        self._owed = None
        self.handlers = (undo_pre, self._pay), (load_post, self._forget)

    def push(self, name):
        """Record all that was written as a step."""
        self.settle()
        with _window():
            bpy.ops.ed.undo_push(message=name)

    def owe(self, name):
        """Record what was written before the user can undo or redo anything, unless :meth:`push` does it before."""
        self._owed = name
        with _window():
            if bpy.ops.ed.redo.poll() or not bpy.ops.ed.undo.poll():
                self.push(name)

    def settle(self):
        """Owe nothing: Blender is about to record a step."""
        self._owed = None

    @persistent
    def _pay(self, *_):
        if self._owed is not None:
            self.push(self._owed)

    @persistent
    def _forget(self, *_):
        self.settle()


def _window():
    """A context of a window, which timers and handlers may lack."""
    windows = bpy.context.window_manager.windows
    return bpy.context.temp_override(window=bpy.context.window or windows[0]) if len(windows) else nullcontext()


undo_steps = _UndoSteps()
register, unregister = register_handlers(*undo_steps.handlers)
