# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""An event loop for operators of the window, where there is none."""

import time
from types import SimpleNamespace

import bpy


class Loop:
    """As much of a window as an operator needs: it is told of its timer and of what keys do to it."""

    def __init__(self):
        self.window = None
        self.window_manager = self.workspace = self
        self.windows, self.areas, self.timers, self.handlers = [], [], 0, 0
        self.status, self.cursors = None, 0
        self.screen = self
        self.longest = 0.0

    def event_timer_add(self, seconds, window):
        self.timers += 1

    def event_timer_remove(self, timer):
        self.timers -= 1

    def modal_handler_add(self, operator):
        self.handlers += 1

    def progress_begin(self, low, high):
        self.cursors += 1

    def progress_update(self, fraction):
        assert self.cursors == 1

    def progress_end(self):
        self.cursors -= 1

    def status_text_set(self, text):
        self.status = text

    @property
    def free(self):
        """Whether the window is as it was before an operator took it."""
        return (self.timers, self.cursors, self.status) == (0, 0, None)

    @property
    def active_object(self):
        return bpy.context.active_object

    def send(self, operator, kind, value="NOTHING"):
        start = time.perf_counter()
        result = operator.modal(self, SimpleNamespace(type=kind, value=value, mouse_x=0, mouse_y=0))
        self.longest = max(self.longest, time.perf_counter() - start)
        return result

    def run(self, operator, until=lambda: False):
        """Until the operator ends, or something has happened; returns what it gave at last."""
        result = {"RUNNING_MODAL"}
        while result == {"RUNNING_MODAL"} and not until():
            time.sleep(0.01)
            result = self.send(operator, "TIMER")
        return result


class Recorded:
    """Mixed into an operator that is none of Blender's: what it reports is kept."""

    def __init__(self):
        self.reports = []

    def report(self, kind, text):
        self.reports.append((kind, text))


def begun(operator):
    """An operator whose job has been started in a loop of its own, and the loop before it."""
    loop = Loop()
    assert operator._start(loop) == {"RUNNING_MODAL"}
    assert loop.timers == loop.handlers == loop.cursors == 1
    return loop, operator
