# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators: a quad pattern on the active mesh, and the mesh of its grid lines."""

import bpy

from ..panels.sidebar import draw_directions, draw_faces, draw_pattern, draw_quad_mesh, draw_quads
from ..settings.fields import MESH_NAMES, MeshProperties, SettingProperties
from .field_operator import FieldOperator


class SYNCH_OT_quads(FieldOperator, SettingProperties, bpy.types.Operator):
    """Cover the mesh with a pattern of two crossing families of lines along a cross field"""

    bl_idname = "synch.quads"
    bl_label = "Quads"
    command = "quads"

    def draw(self, context):
        draw_directions(self.layout, self, context.active_object, of_quads=True)
        draw_pattern(self.layout, self)
        draw_quads(self.layout, self)
        draw_faces(self.layout, self)


class SYNCH_OT_quad_mesh(FieldOperator, MeshProperties, SettingProperties, bpy.types.Operator):
    """Make a new mesh of quads along the grid lines of a quad pattern, and hide the active one"""

    bl_idname = "synch.quad_mesh"
    bl_label = "Quad Mesh"
    command = "quad_mesh"

    stored_as = MESH_NAMES

    def draw(self, context):
        draw_directions(self.layout, self, context.active_object, of_quads=True)
        draw_pattern(self.layout, self)
        draw_quads(self.layout, self)
        draw_quad_mesh(self.layout, self)
