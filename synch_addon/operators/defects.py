# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that find the defects of the active object: select their faces, look at one after the other, and copy
the report of the last solve."""

import bpy
from bpy.props import StringProperty

from ...core.errors import SynchError
from ...core.files.json_text import json_text
from ..blender import meshes
from ..blender.defect_empties import defect_empties
from ..blender.objects import set_mode
from ..blender.pattern_surface import faces_of_object
from ..blender.translations import translate
from ..patterns import memory
from .ready import PromptOperator, ReadyOperator

# Distance from which a defect is looked at, in sizes of its empty.
_VIEWED = 30
_SELECT = {"vertex": meshes.select_vertices, "edge": meshes.select_edges, "face": meshes.select_faces}
# What the figures of the box Result mean.
_MEANINGS = {
    "energy": "How far the stripes are from even and aligned with the directions: 0 is a perfect pattern",
    "proved": "No field at all on this mesh has less energy than this one by more than this share: its bound is "
    "proved by a factorization in double precision",
    "estimated": "How much of the energy lies above the lower bound; the bound is estimated, not proved",
    "disclination": "Points around which the directions turn (disclinations): by a half for lines, by a quarter for "
    "crosses",
    "dislocation": "Points where a stripe begins or ends (dislocations)",
    "evenness": "How many times as far apart as asked lines are, on all but a hundredth of the surface at either end, "
    "and on how much of it they are off by more than a quarter; Spacing Error in the overlay shows where",
    "spacing": "The distance between lines that the last solve used, and the mesh's number of faces",
    "time": "How long the last solve took, and on how many vertices",
}


class _DefectOperator(ReadyOperator):
    """Mixed into operators that need the active object's defect empties."""

    @classmethod
    def lacking(cls, obj):
        if not defect_empties(obj):
            return f"{obj.name} has no defects: its field is continuous, or not solved yet"
        return None


class SYNCH_OT_select_defects(_DefectOperator, PromptOperator, bpy.types.Operator):
    """Select the faces that hold a defect, in edit mode"""

    bl_idname = "synch.select_defects"
    bl_label = "Select Defect Faces"
    bl_options = {"REGISTER", "UNDO"}

    def make(self, context):
        obj = context.active_object
        faces = sorted({empty["synch_face"] for empty in defect_empties(obj)})
        with meshes.object_mode(obj):
            faces = faces_of_object(obj, faces)
            meshes.select_faces(obj, faces)
        set_mode(obj, "EDIT")
        return f"{len(faces)} faces selected"


class SYNCH_OT_select_places(ReadyOperator, PromptOperator, bpy.types.Operator):
    """Select, in edit mode, where the repaired copy that was solved on differs from the mesh"""

    bl_idname = "synch.select_places"
    bl_label = "Select Places"
    bl_options = {"REGISTER", "UNDO"}

    finding: StringProperty(description="Which kind of place", options={"HIDDEN", "SKIP_SAVE"})

    def make(self, context):
        obj = context.active_object
        with meshes.object_mode(obj):
            found = {finding.name: finding for finding in meshes.read_mesh(obj).findings}.get(self.finding)
            if found is None:
                raise SynchError(f"{obj.name} has no such place any more: solve it again")
            _SELECT[found.kind](obj, found.elements)
        set_mode(obj, "EDIT")
        return found.line


class SYNCH_OT_next_defect(_DefectOperator, PromptOperator, bpy.types.Operator):
    """Turn the view to the next defect and look at it from close by"""

    bl_idname = "synch.next_defect"
    bl_label = "Frame Next Defect"

    def make(self, context):
        view = getattr(context.space_data, "region_3d", None)
        if view is None:
            raise SynchError("there is no 3D view to turn: run this in one")
        obj = context.active_object
        empties = sorted(defect_empties(obj), key=lambda empty: empty.name)
        # The one after the defect that the view is at.
        places = [place_of(empty) for empty in empties]
        apart = [(place.translation - view.view_location).length for place in places]
        near = min(range(len(empties)), key=apart.__getitem__)
        at_one = apart[near] < 1e-4 * max(view.view_distance, 1e-9)
        number = (near + 1) % len(empties) if at_one else 0
        empty, place = empties[number], places[number]
        view.view_location = place.translation
        view.view_rotation = place.to_quaternion()  # an empty's Z is the normal of its face
        view.view_distance = _VIEWED * empty.empty_display_size * max(place.to_scale())
        return empty.name


def place_of(empty):
    """The matrix of an empty in the world. Blender does not compute that of a hidden one, which gets its place on the
    object without deformation."""
    return empty.matrix_world if empty.visible_get() else empty.parent.matrix_world @ empty.matrix_basis


class SYNCH_OT_copy_report(ReadyOperator, bpy.types.Operator):
    """Copy the full report of the last solve to the clipboard, as JSON"""

    bl_idname = "synch.copy_report"
    bl_label = "Copy Report"

    about: StringProperty(description="Figure whose meaning the tooltip says", options={"HIDDEN", "SKIP_SAVE"})

    @classmethod
    def description(cls, context, properties):
        meaning = _MEANINGS.get(properties.about)
        if not meaning:
            return translate(cls.__doc__)
        return translate("{meaning}.\nClick to copy the full report as JSON", meaning=translate(meaning))

    @classmethod
    def lacking(cls, obj):
        if not memory.holds(obj):
            return "the report is kept while the file stays open: solve again to have one"
        return None

    def execute(self, context):
        report = memory.state(context.active_object).plain
        context.window_manager.clipboard = json_text(report, indent=2)
        return {"FINISHED"}


CLASSES = (SYNCH_OT_select_defects, SYNCH_OT_select_places, SYNCH_OT_next_defect, SYNCH_OT_copy_report)
