# SPDX-License-Identifier: GPL-3.0-or-later
"""Operator: evenly spaced stripes on the active mesh."""

import bpy

from ..panels.sidebar import draw_directions, draw_faces, draw_pattern
from ..settings.fields import SettingProperties
from .field_operator import FieldOperator


class SYNCH_OT_stripes(FieldOperator, SettingProperties, bpy.types.Operator):
    """Cover the mesh with evenly spaced stripes along a direction field, branching where they must"""

    bl_idname = "synch.stripes"
    bl_label = "Stripes"
    command = "stripes"

    def draw(self, context):
        draw_directions(self.layout, self, context.active_object)
        draw_pattern(self.layout, self)
        draw_faces(self.layout, self)
