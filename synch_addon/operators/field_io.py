# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that read and write field files, in the menus File > Import and File > Export."""

import bpy
from bpy.props import StringProperty
from bpy_extras.io_utils import ExportHelper, ImportHelper

from ...core.errors import SynchError
from .. import api
from ..field_io import DIRECTIONS, SUFFIXES
from ..settings import SYMMETRY
from .ready import ReadyOperator

_PATTERN = ";".join("*" + suffix for suffix in SUFFIXES)


class _FieldFileOperator(ReadyOperator):
    """Mixed into operators that read or write a field file of the active object."""

    filter_glob: StringProperty(default=_PATTERN, options={"HIDDEN"})

    def execute(self, context):
        try:
            self.report({"INFO"}, self.transfer(context.active_object))
        except SynchError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class SYNCH_OT_import_field(_FieldFileOperator, ImportHelper, bpy.types.Operator):
    """Read directions on triangles from a file, as the active object's directions, and follow them"""

    bl_idname = "synch.import_field"
    bl_label = "Import Direction Field"
    bl_options = {"REGISTER", "UNDO"}

    def transfer(self, obj):
        obj.synch.symmetry = api.import_field(obj, self.filepath).upper()
        obj.synch.guidance, obj.synch.guide.vectors = "ATTRIBUTE", DIRECTIONS
        return f"{DIRECTIONS} of {obj.name} is read from {self.filepath}"


class SYNCH_OT_export_field(_FieldFileOperator, ExportHelper, bpy.types.Operator):
    """Write the active object's directions to a file, for each of its triangles"""

    bl_idname = "synch.export_field"
    bl_label = "Export Direction Field"

    filename_ext = SUFFIXES[0]
    symmetry: SYMMETRY

    def invoke(self, context, event):
        self.symmetry = context.active_object.synch.symmetry
        return super().invoke(context, event)

    def check(self, context):
        """Keep the suffix .rosy, which the helper would replace."""
        return not self.filepath.lower().endswith(SUFFIXES) and super().check(context)

    def transfer(self, obj):
        api.export_field(obj, self.filepath, self.symmetry.lower())
        return f"wrote {self.filepath}"


def _draw_import(menu, context):
    menu.layout.operator(SYNCH_OT_import_field.bl_idname, text="Direction Field (.rawfield, .rosy)")


def _draw_export(menu, context):
    menu.layout.operator(SYNCH_OT_export_field.bl_idname, text="Direction Field (.rawfield, .rosy)")


def register():
    bpy.utils.register_class(SYNCH_OT_import_field)
    bpy.utils.register_class(SYNCH_OT_export_field)
    bpy.types.TOPBAR_MT_file_import.append(_draw_import)
    bpy.types.TOPBAR_MT_file_export.append(_draw_export)


def unregister():
    bpy.types.TOPBAR_MT_file_export.remove(_draw_export)
    bpy.types.TOPBAR_MT_file_import.remove(_draw_import)
    bpy.utils.unregister_class(SYNCH_OT_export_field)
    bpy.utils.unregister_class(SYNCH_OT_import_field)
