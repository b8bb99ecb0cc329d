# SPDX-License-Identifier: GPL-3.0-or-later
"""Operator: a smooth direction field on the active mesh."""

import bpy

from ..settings.fields import SettingProperties
from .field_operator import FieldOperator


class SYNCH_OT_directions(FieldOperator, SettingProperties, bpy.types.Operator):
    """Find a direction at every vertex and mark the points where it cannot be continuous"""

    bl_idname = "synch.directions"
    bl_label = "Directions"
    command = "directions"
