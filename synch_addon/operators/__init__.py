# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators ``synch.directions`` and ``synch.stripes``."""

import bpy

from .. import jobs
from . import directions, stripes

_CLASSES = (directions.SYNCH_OT_directions, stripes.SYNCH_OT_stripes)


def register():
    for operator in _CLASSES:
        bpy.utils.register_class(operator)


def unregister():
    jobs.stop()
    for operator in reversed(_CLASSES):
        bpy.utils.unregister_class(operator)
