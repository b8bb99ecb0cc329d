# SPDX-License-Identifier: GPL-3.0-or-later
"""Operator: paint a map of the settings."""

from itertools import chain, count

import bpy
from bpy.props import BoolProperty, EnumProperty

from ..blender.groups import is_group
from ..blender.objects import set_mode
from ..blender.translations import operator_error, translate
from ..panels.row_operators import can_set
from ..patterns.painted_back import paint_back
from ..settings.fields import source_of
from ..settings.painting import MAPS

_TARGETS = (
    ("SPACING", "Spacing", "The factor on the spacing from place to place"),
    ("ANGLE", "Angle", "The angle that is added to the directions from place to place"),
    ("LAYERS", "Layer Spacing", "The factor on the spacing of layers from place to place"),
)

# Range of a new map of spacing: one paints where lines are to be nearer to each other.
_FINER = 0.5


class SYNCH_OT_paint_map(bpy.types.Operator):
    """Paint this map with the brush's value; its vertex group is made if there is none"""

    bl_idname = "synch.paint_map"
    bl_label = "Paint Map"
    bl_options = {"REGISTER", "UNDO"}

    target: EnumProperty(name="Map", description="What is painted", items=_TARGETS)

    @classmethod
    def poll(cls, context):
        return can_set(context.active_object) and bpy.ops.object.mode_set.poll()

    def execute(self, context):
        obj, chosen = context.active_object, MAPS[self.target]
        name = chosen.of(obj)
        if name in obj.data.attributes:
            line = f"{name} is an attribute, and vertex groups are painted: empty the field for a new one"
            self.report({"ERROR"}, line)
            return {"CANCELLED"}
        set_mode(obj, "OBJECT")  # in edit mode groups cannot be changed
        if not (name and is_group(obj, name)):
            group = obj.vertex_groups.new(name=name or _free_name(obj, chosen.group))
            group.add(range(len(obj.data.vertices)), 0.0, "REPLACE")  # without weights all is black
            name = group.name
            settings = getattr(obj, chosen.settings)
            setattr(settings, chosen.name, name)
            usual = settings.bl_rna.properties[chosen.full].default
            if self.target != "ANGLE" and getattr(settings, chosen.full) == usual:
                setattr(settings, chosen.full, _FINER)
        obj.vertex_groups.active = obj.vertex_groups[name]
        set_mode(obj, "WEIGHT_PAINT")
        return {"FINISHED"}


def _free_name(obj, name):
    """A name for a vertex group that no attribute has, which would go first."""
    numbered = (f"{name}.{number:03d}" for number in count(1))
    return next(each for each in chain([name], numbered) if each not in obj.data.attributes)


class SYNCH_OT_done_painting(bpy.types.Operator):
    """Go back to object mode; what was painted on a quad mesh counts when it is made again"""

    bl_idname = "synch.done_painting"
    bl_label = "Done Painting"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    solves: BoolProperty(name="Solve", description="Then make what the panel makes", options={"SKIP_SAVE"})

    @classmethod
    def description(cls, _context, properties):
        return translate("Go back to object mode, and use what was painted") if properties.solves else ""

    @classmethod
    def poll(cls, context):
        return context.mode == "PAINT_WEIGHT"

    def execute(self, context):
        made = context.active_object
        set_mode(made, "OBJECT")
        source = source_of(made)
        if source is not None and source.is_editable and source.data.is_editable:
            paint_back(made, source)
        if self.solves:
            name = "quad_mesh_again" if source is not None else made.synch_simple.kind
            try:
                getattr(bpy.ops.synch, name)("INVOKE_DEFAULT")
            except RuntimeError as error:  # its error, as Blender hands it on
                self.report({"ERROR"}, operator_error(error))
        return {"FINISHED"}
