# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator of stripes as the window runs it, and the child that solves for it."""

import os

from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.synch_addon.jobs.queue import queue
from synch_fields.synch_addon.operators import field_operator

from ..event_loop import Recorded


class Stripes(Recorded, field_operator.FieldOperator):
    """The operator as the window runs it, without being one of Blender's."""

    bl_label, command = "Stripes", "stripes"

    def __init__(self, **settings):
        super().__init__()
        self.settings, self.spacing = SurfaceSettings(**{"spacing": 0.4} | settings), 0.0

    def _settings(self):
        return self.settings


def child():
    """The process number of the worker, which is there."""
    return queue._worker.number


def is_alive(number):
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return False
    return True


def in_work():
    """Whether the job that runs has begun to solve."""
    return queue.running.fraction > 0
