# SPDX-License-Identifier: GPL-3.0-or-later
"""Operator: one object's settings for others."""

import bpy

from ..blender.meshes import refusal
from ..blender.translations import said
from ..panels.row_operators import can_set

# What an object was found to have, rather than what is asked of it.
_OWN = {"rna_type", "result", "favourites"}


def selected_meshes(context):
    """The selected objects that can carry a field, the active one first where it is one of them."""
    found = [obj for obj in context.selected_objects if refusal(obj) is None]
    return sorted(found, key=lambda obj: obj != context.active_object)


class SYNCH_OT_copy_settings(bpy.types.Operator):
    """Give the other selected objects the active one's settings, guides and constraints"""

    bl_idname = "synch.copy_settings"
    bl_label = "Copy Settings to Selected"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if not can_set(context.active_object):
            return False
        if not _others(context):
            cls.poll_message_set(said("select other meshes too: they get the settings of the active one"))
            return False
        return True

    def execute(self, context):
        others = _others(context)
        for obj in others:
            copy_properties(context.active_object.synch, obj.synch)
        names = ", ".join(obj.name for obj in others[:4]) + (" ..." if len(others) > 4 else "")
        self.report({"INFO"}, said("settings of {name} given to {names}", name=context.active_object.name, names=names))
        return {"FINISHED"}


def _others(context):
    return [obj for obj in selected_meshes(context) if obj != context.active_object and can_set(obj)]


def copy_properties(given, taker):
    """Make a group of properties, with the groups and lists in it, equal to another one of its kind.

    What a solve left is not taken over.
    """
    for name, kind in given.bl_rna.properties.items():
        if name in _OWN:
            continue
        value = getattr(given, name)
        if kind.type == "COLLECTION":
            rows = getattr(taker, name)
            rows.clear()
            for row in value:
                copy_properties(row, rows.add())
        elif isinstance(value, bpy.types.PropertyGroup):
            copy_properties(value, getattr(taker, name))
        elif not kind.is_readonly:
            setattr(taker, name, value)
