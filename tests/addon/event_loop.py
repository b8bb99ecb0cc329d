# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""An event loop for operators of the window, where there is none."""

import time
from types import SimpleNamespace

import bpy

from synch_fields.synch_addon.jobs.queue import queue

# Where the view of a loop is, and a place beside it.
OVER_VIEW, BESIDE = (50, 50), (500, 50)


class Loop:
    """As much of a window as an operator needs: it is told of its timer and of what keys do to it."""

    def __init__(self):
        self.window = None
        self.window_manager = self.workspace = self
        self.windows, self.timers, self.handlers = [], 0, 0
        self.areas = [SimpleNamespace(type="VIEW_3D", x=0, y=0, width=100, height=100, regions=[])]
        self.status = None
        self.screen = self
        self.longest = 0.0

    def event_timer_add(self, seconds, window):
        self.timers += 1
        return self.timers

    def event_timer_remove(self, timer):
        self.timers -= 1

    def modal_handler_add(self, operator):
        self.handlers += 1

    def status_text_set(self, text):
        self.status = text

    @property
    def free(self):
        """Whether the window is as it was before an operator took it."""
        return (self.timers, self.status) == (0, None)

    @property
    def active_object(self):
        return bpy.context.active_object

    def send(self, operator, kind, value="NOTHING", place=OVER_VIEW):
        start = time.perf_counter()
        result = operator.modal(self, SimpleNamespace(type=kind, value=value, mouse_x=place[0], mouse_y=place[1]))
        self.longest = max(self.longest, time.perf_counter() - start)
        return result

    def run(self, operator, until=lambda: False):
        """Until the operator ends, or something has happened; returns what it gave at last."""
        result = {"PASS_THROUGH"}
        while result & {"PASS_THROUGH", "RUNNING_MODAL"} and not until():
            time.sleep(0.01)
            result = self.send(operator, "TIMER")
        return result


class Recorded:
    """Mixed into an operator that is none of Blender's: what it reports is kept."""

    def __init__(self):
        self.reports = []

    def report(self, kind, text):
        self.reports.append((kind, text))


def by_the_worker(job):
    """The work of a job that the child has solved, whatever came of it; nothing is written."""
    work = queue.add(job, "Job")
    while not work.is_over:
        time.sleep(0.01)
        queue.advance()
    return work


def begun(operator):
    """An operator whose job has been queued from a loop of its own, and the loop before it."""
    loop = Loop()
    assert operator._start(loop) == {"RUNNING_MODAL"}
    assert loop.timers == loop.handlers == 1
    return loop, operator
