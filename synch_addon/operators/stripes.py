# SPDX-License-Identifier: GPL-3.0-or-later
"""Operator: evenly spaced stripes on the active mesh."""

import bpy

from ..settings.fields import SettingProperties
from .field_operator import FieldOperator


class SYNCH_OT_stripes(FieldOperator, SettingProperties, bpy.types.Operator):
    """Cover the mesh with evenly spaced stripes along a direction field, branching where they must"""

    bl_idname = "synch.stripes"
    bl_label = "Stripes"
    command = "stripes"
