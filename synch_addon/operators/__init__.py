# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators ``synch.directions`` and ``synch.stripes``, and those that read and write field files."""

import bpy

from .. import jobs
from . import directions, field_io, stripes

_CLASSES = (directions.SYNCH_OT_directions, stripes.SYNCH_OT_stripes)


def register():
    for operator in _CLASSES:
        bpy.utils.register_class(operator)
    field_io.register()


def unregister():
    jobs.stop()
    field_io.unregister()
    for operator in reversed(_CLASSES):
        bpy.utils.unregister_class(operator)
