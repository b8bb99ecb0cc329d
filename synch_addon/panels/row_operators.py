# SPDX-License-Identifier: GPL-3.0-or-later
"""What operators share that change the lists in panels."""

from bpy.props import IntProperty

from ..blender.meshes import refusal
from ..jobs.queue import queue
from ..settings.fields import original_of


def can_set(obj):
    """Whether an object's settings can be changed now."""
    return refusal(obj) is None and not queue.holds(original_of(obj)) and not queue.holds_window


def others_selected(context):
    """The selected objects beside the active one that can be worked on now."""
    return list(filter(can_set, meshes_selected(context)))


def meshes_selected(context):
    """The selected objects beside the active one that can be worked on, if need be after their jobs."""
    return [obj for obj in context.selected_objects if obj != context.active_object and refusal(obj) is None]


class RowOperator:
    """Mixed into operators that change a list of the active object, of a quad mesh its source's, or of the object that
    ``owner`` finds."""

    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    @classmethod
    def poll(cls, context):
        return can_set(cls.owner(context))

    @staticmethod
    def owner(context):
        """The object whose list it is."""
        obj = context.active_object
        return None if refusal(obj) is not None else original_of(obj)


class RemoveRow(RowOperator):
    """Mixed into operators that remove a row of the list that ``rows`` finds."""

    number: IntProperty(name="Row", description="Which of the rows, from 0 on", min=0)

    def execute(self, context):
        rows = self.rows(self.owner(context))
        if self.number >= len(rows):
            return {"CANCELLED"}
        rows.remove(self.number)
        return {"FINISHED"}
