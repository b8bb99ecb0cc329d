# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that read and write field files, in the menus File > Import and File > Export."""

import bpy
from bpy.props import StringProperty
from bpy_extras.io_utils import ExportHelper, ImportHelper

from ...core.files.directions import SUFFIXES
from ...core.settings.surface import SurfaceSettings
from .. import api
from ..blender.schema import DIRECTION
from ..settings.rna import property_of
from .ready import PromptOperator, ReadyOperator

_PATTERN = ";".join("*" + suffix for suffix in SUFFIXES)


class _FieldFileOperator(ReadyOperator, PromptOperator):
    """Mixed into operators that read or write a field file of the active object."""

    filter_glob: StringProperty(default=_PATTERN, options={"HIDDEN"})


class SYNCH_OT_import_field(_FieldFileOperator, ImportHelper, bpy.types.Operator):
    """Read directions on triangles from a file, and let the active object's patterns follow them"""

    bl_idname = "synch.import_field"
    bl_label = "Import Direction Field"
    bl_options = {"REGISTER", "UNDO"}

    def make(self, context):
        obj = context.active_object
        obj.synch.symmetry = api.import_field(obj, self.filepath).upper()
        obj.synch.guidance, obj.synch.guide.vectors = "ATTRIBUTE", DIRECTION.name
        return f"{DIRECTION.name} of {obj.name} is read from {self.filepath}"


class SYNCH_OT_export_field(_FieldFileOperator, ExportHelper, bpy.types.Operator):
    """Write the active object's directions to a file, for each of its triangles"""

    bl_idname = "synch.export_field"
    bl_label = "Export Direction Field"

    filename_ext = SUFFIXES[0]
    symmetry: property_of(SurfaceSettings, "symmetry")

    def invoke(self, context, event):
        self.symmetry = context.active_object.synch.symmetry
        return super().invoke(context, event)

    def check(self, context):
        """Keep the suffix .rosy, which the helper would replace."""
        return not self.filepath.lower().endswith(SUFFIXES) and super().check(context)

    def make(self, context):
        api.export_field(context.active_object, self.filepath, self.symmetry.lower())
        return f"wrote {self.filepath}"


CLASSES = (SYNCH_OT_import_field, SYNCH_OT_export_field)
