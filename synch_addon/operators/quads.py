# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators: a quad pattern on the active mesh, and the mesh of its grid lines."""

import bpy
from bpy.props import IntProperty

from ..blender.meshes import refusal
from ..panels.row_operators import RowOperator
from ..patterns.job import FieldJob
from ..patterns.painted_back import paint_back
from ..patterns.symmetry import toggle_half
from ..settings.fields import (
    DIRECTED_NAMES,
    MESH_NAMES,
    PROPERTY_NAMES,
    MeshProperties,
    SettingProperties,
    source_of,
)
from ..settings.guide_list import stored_guidance
from .field_operator import FieldOperator, take_settings


class SYNCH_OT_quads(FieldOperator, SettingProperties, bpy.types.Operator):
    """Cover the mesh with a pattern of two crossing families of lines along a cross field"""

    bl_idname = "synch.quads"
    bl_label = "Quad Pattern"
    command = "quads"


class _QuadMeshOperator(FieldOperator, MeshProperties, SettingProperties):
    """Mixed into operators that make a mesh of quads."""

    command = "quad_mesh"
    stored_as = MESH_NAMES


class SYNCH_OT_quad_mesh(_QuadMeshOperator, bpy.types.Operator):
    """Make a new mesh of quads along the grid lines of a quad pattern, and hide the active one"""

    bl_idname = "synch.quad_mesh"
    bl_label = "Quad Mesh"


class SYNCH_OT_quad_mesh_again(_QuadMeshOperator, bpy.types.Operator):
    """Make this quad mesh again from its source object, with the settings shown here"""

    bl_idname = "synch.quad_mesh_again"
    bl_label = "Quad Mesh Again"

    @classmethod
    def lacking(cls, obj):
        source = source_of(obj)
        if source is None:
            return f"{obj.name} is not the quad mesh of another object, or that is gone: use Quad Mesh"
        return refusal(source) if obj.mode == "OBJECT" else f"leave edit mode: {obj.name} gets other faces"

    def _take(self, context):
        super()._take(context)
        directed = source_of(context.active_object).synch
        self.guidance = stored_guidance(directed)
        take_settings(self, directed, DIRECTED_NAMES)

    def _target(self, context):
        return source_of(context.active_object) if self._work is None else super()._target(context)

    def _job(self, context):
        made = context.active_object
        source = source_of(made)
        paint_back(made, source)
        is_set = self.properties.is_property_set
        if is_set("spacing") and not is_set("faces"):
            self.faces = 0
        if not is_set("guidance"):
            self.guidance = made.synch.made_along or stored_guidance(source.synch)
        take_settings(self, made.synch, [name for name in PROPERTY_NAMES if not is_set(name)])
        return FieldJob(self.command, source, self._settings(), replaced=made)


class SYNCH_OT_mirror_half(RowOperator, bpy.types.Operator):
    """Mirror the half on the positive side of this axis by a modifier, where the two halves of the mesh differ; once \
more removes it"""

    bl_idname = "synch.mirror_half"
    bl_label = "Mirror a Half"

    axis: IntProperty(name="Axis", description="X, Y or Z as 0, 1 or 2", min=0, max=2)

    def execute(self, context):
        toggle_half(self.owner(context), self.axis)
        return {"FINISHED"}
