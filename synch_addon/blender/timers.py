# SPDX-License-Identifier: GPL-3.0-or-later
"""Timers of Blender's event loop that run once at a time."""

import bpy


class Timer:
    """A step that Blender calls while the window rests.

    Blender knows a timer by the very object that was registered, and a method is another object each time that it is
    asked for: this keeps one.

    Parameters
    ----------
    step : function without arguments that returns the seconds until its next call, or None for no other
    first : seconds until the first call
    is_persistent : whether it goes on when another file is opened
    """

    def __init__(self, step, first=0.0, is_persistent=False):
        self._step, self._first, self._is_persistent = step, first, is_persistent

    @property
    def runs(self):
        """Whether a call is to come."""
        return bpy.app.timers.is_registered(self._step)

    def start(self):
        """Begin, unless it runs already."""
        if not self.runs:
            bpy.app.timers.register(self._step, first_interval=self._first, persistent=self._is_persistent)

    def stop(self):
        """Make no further call."""
        if self.runs:
            bpy.app.timers.unregister(self._step)
