# SPDX-License-Identifier: GPL-3.0-or-later
"""Steps of the user's undo for what is written while no operator of Blender is at work.

Undo leaves a datablock as it is that is the same in the two steps. Where such a one has come to point to something new
since the last step, that is gone after the undo, and Blender crashes. So what is written without a step gets its own
when the user undoes, and is then what is undone; or at once, where nothing could be undone, or something redone.
"""

from contextlib import nullcontext

import bpy
from bpy.app.handlers import load_post, persistent, undo_pre


class _UndoSteps:
    """Steps that are recorded now, or owed until another one is."""

    def __init__(self):
        self._owed = None
        self._handlers = (undo_pre, self._pay), (load_post, self._forget)

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

    def register(self):
        for event, handler in self._handlers:
            event.append(handler)

    def unregister(self):
        for event, handler in self._handlers:
            event.remove(handler)
        self.settle()

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
register, unregister = undo_steps.register, undo_steps.unregister
