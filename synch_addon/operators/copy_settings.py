# SPDX-License-Identifier: GPL-3.0-or-later
"""Operator: one object's settings for others."""

import bpy

from ..blender.translations import translate
from ..panels.row_operators import can_set, others_selected

# What an object was found to have, or of a quad mesh what it was made of, rather than what is asked of it.
_OWN = {"rna_type", "result", "favourites", "pins", "source", "made_along", "made_from"}


class SYNCH_OT_copy_settings(bpy.types.Operator):
    """Give the other selected objects the active one's settings, guides and constraints"""

    bl_idname = "synch.copy_settings"
    bl_label = "Copy Settings to Selected"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if not can_set(context.active_object):
            return False
        if not others_selected(context):
            cls.poll_message_set("select other meshes too: they get the settings of the active one")
            return False
        return True

    def execute(self, context):
        others = others_selected(context)
        for obj in others:
            copy_properties(context.active_object.synch, obj.synch)
        names = ", ".join(obj.name for obj in others[:4]) + (" ..." if len(others) > 4 else "")
        self.report(
            {"INFO"}, translate("settings of {name} given to {names}", name=context.active_object.name, names=names)
        )
        return {"FINISHED"}


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
