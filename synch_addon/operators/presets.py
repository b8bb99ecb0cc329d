# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators: a preset on the active object, solved for it where it has to be; the library of assets."""

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from .. import api
from ..blender.phases import pattern_kind
from ..blender.translations import OURS
from ..jobs.report import count_text
from ..looks import assets, presets
from ..panels.presets import PRESET
from ..settings.fields import SettingProperties
from .field_operator import FieldOperator
from .ready import PatternOperator, PromptOperator, ReadyOperator


class SYNCH_OT_preset(FieldOperator, SettingProperties, bpy.types.Operator):
    """Show a preset on the active object; if its pattern does not fit, one that does is solved"""

    bl_idname = "synch.preset"
    bl_label = "Apply Preset"

    preset: EnumProperty(name="Preset", description="What the object looks like", items=PRESET)
    solve: BoolProperty(
        name="Solve",
        description="Solve the pattern that the preset is made for, even if the object has one that can show it",
        translation_context=OURS,
    )

    solved_for: StringProperty(name="Solved for", options={"HIDDEN", "SKIP_SAVE"})

    @property
    def command(self):
        return self._chosen.kind

    @property
    def _chosen(self):
        return presets.find_preset(self.preset)

    def invoke(self, context, event):
        """From the window: solve in the background where that is needed; the scene's preset, where none is given."""
        chosen = context.scene.synch_preset
        if not self.properties.is_property_set("preset") and chosen in presets.PRESETS:
            self.preset = chosen
        return self._reporting(self._begin, context)

    def execute(self, context):
        return self._reporting(self._execute, context)

    def _begin(self, context):
        if self._fits(context):
            return self._announce_look(context.active_object)
        return super()._begin(context)

    def _execute(self, context):
        if self._fits(context):
            return self._announce_look(context.active_object)
        self._set_preset(context, keep=self.solved_for in ("", self.preset))
        return self._run(context)

    def _fits(self, context):
        return not self.solve and presets.fits(context.active_object, self._chosen)

    def _take(self, context):
        """The settings of the object's panel, but for those of the preset."""
        super()._take(context)
        self._set_preset(context, keep=False)

    def _set_preset(self, context, keep):
        """The preset's settings; those that a script or the redo panel has set for it may be kept."""
        for name, value in presets.solve_settings(context.active_object, self._chosen).items():
            if not (keep and self.properties.is_property_set(name)):
                setattr(self, name, value.upper() if name == "symmetry" else value)
        self.solved_for = self.preset

    def _announce(self, context, report):
        super()._announce(context, report)
        obj = bpy.data.objects[report["object"]]
        presets.store_settings(obj.synch, report["settings"])
        return self._announce_look(obj)

    def _announce_look(self, obj):
        report = api.preset(obj, self.preset)
        self.report({"INFO"}, f"{report['object']}: {report['material']}")
        return {"FINISHED"}

    def draw(self, context):
        column = self.layout.column()
        column.prop(self, "preset")
        column.prop(self, "solve")


class SYNCH_OT_plain_look(PatternOperator, PromptOperator, bpy.types.Operator):
    """Show the pattern in two plain colours again, without a preset"""

    bl_idname = "synch.plain_look"
    bl_label = "Plain Look"
    bl_options = {"REGISTER", "UNDO"}

    def make(self, context):
        obj = context.active_object
        return f"{obj.name}: {presets.show_without_preset(obj).name}"


class SYNCH_OT_number_stripes(ReadyOperator, PromptOperator, bpy.types.Operator):
    """Give each stripe of the last solve a number, and its points a place along it, for materials and relief"""

    bl_idname = "synch.number_stripes"
    bl_label = "Number Stripes"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def lacking(cls, obj):
        if pattern_kind(obj) != "stripes":
            return f"{obj.name} has no stripes: solve them first"
        return None

    def make(self, context):
        obj = context.active_object
        return f"{obj.name}: {count_text(api.number_stripes(obj), 'stripe')}"


class SYNCH_OT_asset_library(PromptOperator, bpy.types.Operator):
    """List the library of presets and node groups that comes with the extension in the preferences"""

    bl_idname = "synch.asset_library"
    bl_label = "Add Asset Library"
    bl_options = {"REGISTER"}

    def make(self, context):
        library = assets.register_library(context.preferences)
        return f"asset library {library.name}: choose it in the asset browser"


CLASSES = (SYNCH_OT_preset, SYNCH_OT_plain_look, SYNCH_OT_number_stripes, SYNCH_OT_asset_library)
