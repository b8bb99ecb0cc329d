# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that keep variations under names, show them again and remove them."""

import bpy
from bpy.props import StringProperty

from ..blender.phases import pattern_kind
from ..patterns import favourites
from .ready import PromptOperator, ReadyOperator


class _FavouriteOperator(ReadyOperator, PromptOperator):
    """Mixed into operators on the favourite of a name."""

    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(name="Name", description="What the favourite is called")

    @classmethod
    def lacking(cls, obj):
        """Why there is nothing to be done with an object's favourites, or None."""
        return None if obj.synch.favourites else f"{obj.name} has no favourites: keep a variation first"


class SYNCH_OT_keep_favourite(_FavouriteOperator, bpy.types.Operator):
    """Keep the variation that is shown, as attributes of the mesh: it can be shown again at any time, also after \
the file was saved and opened"""

    bl_idname = "synch.keep_favourite"
    bl_label = "Keep as Favourite"

    @classmethod
    def lacking(cls, obj):
        if pattern_kind(obj) is None or not obj.synch.result:
            return f"{obj.name} shows no pattern: solve stripes or quads on it first"
        return None

    def make(self, context):
        self.name = favourites.keep(context.active_object, self.name)
        return f"{self.name} is kept"


class SYNCH_OT_show_favourite(_FavouriteOperator, bpy.types.Operator):
    """Show this favourite again, without a solve"""

    bl_idname = "synch.show_favourite"
    bl_label = "Show Favourite"

    def make(self, context):
        result = favourites.show(context.active_object, self.name)
        return f"{self.name}: energy {result['energy']:.4g}, {result['dislocations']} dislocations"


class SYNCH_OT_remove_favourite(_FavouriteOperator, bpy.types.Operator):
    """Remove this favourite and its attributes; the pattern on the object stays"""

    bl_idname = "synch.remove_favourite"
    bl_label = "Remove Favourite"

    def make(self, context):
        favourites.remove(context.active_object, self.name)
        return f"{self.name} is removed"


CLASSES = (SYNCH_OT_keep_favourite, SYNCH_OT_show_favourite, SYNCH_OT_remove_favourite)
