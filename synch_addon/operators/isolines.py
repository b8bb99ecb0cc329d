# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that make something of the active object's pattern: a curve object of its lines, relief, and what carries
it through modifiers."""

from dataclasses import asdict

import bpy
from bpy.props import BoolProperty, FloatProperty, IntProperty

from ...core.settings.lines import LineSettings
from ...core.settings.setting import records
from .. import api
from ..jobs.report import count_text
from ..panels.setting_rows import draw_setting, property_column
from ..settings.rna import properties_of, settings_of
from .ready import PatternOperator, PromptOperator

LINE_NAMES = tuple(name for name, _ in records(LineSettings))
LineProperties = properties_of(LineSettings, LINE_NAMES)


class SYNCH_OT_isolines(PatternOperator, PromptOperator, LineProperties, bpy.types.Operator):
    """Make a curve object of the lines of the pattern: stripes by their middles or edges, quads by their grid"""

    bl_idname = "synch.isolines"
    bl_label = "Lines as Curves"
    bl_options = {"REGISTER", "UNDO", "PRESET"}

    def draw(self, _context):
        column = property_column(self.layout)
        for name, record in records(LineSettings):
            draw_setting(column, self, name, record.zero)

    def make(self, context):
        settings = settings_of(LineSettings, self, LINE_NAMES)
        report = api.isolines(context.active_object, **asdict(settings))
        bpy.data.objects[report["object"]].select_set(True)  # its outline shows what was made
        return f"{report['object']}: {count_text(report['lines'], 'line')}"


class SYNCH_OT_relief(PatternOperator, PromptOperator, bpy.types.Operator):
    """Raise the surface by the pattern, with a modifier that subdivides it; its inputs can be changed at any time"""

    bl_idname = "synch.relief"
    bl_label = "Relief"
    bl_options = {"REGISTER", "UNDO", "PRESET"}

    height: FloatProperty(
        name="Height",
        description="Height of the pattern above the surface, in spacings; below 0 it is cut in",
        default=0.15,
        soft_min=-0.5,
        soft_max=0.5,
    )
    width: FloatProperty(
        name="Width",
        description="Raised part of a period, or of the area of quads",
        default=0.5,
        min=0.0,
        max=1.0,
    )
    profile: IntProperty(
        name="Profile",
        description="Stripes: sine, square, triangle, rounded, thread. Quads: grid lines, checker, weave, dots",
        min=0,
        max=4,
    )
    level: IntProperty(
        name="Level",
        description="How often the mesh is subdivided; by default as often as its edges need",
        min=0,
        max=6,
    )
    smooth: BoolProperty(name="Smooth", description="Round the surface while it is subdivided")

    def make(self, context):
        level = self.level if self.properties.is_property_set("level") else None
        report = api.relief(context.active_object, self.height, self.width, self.profile, level, self.smooth)
        self.level = report["level"]
        return f"{report['modifier']}: {report['profile']}, subdivided {report['level']} times"


class SYNCH_OT_carry(PatternOperator, PromptOperator, bpy.types.Operator):
    """Carry the pattern through the modifiers before, such as Subdivision, Mirror and Solidify: directions, phases \
and pattern are made anew at the vertices that they leave"""

    bl_idname = "synch.carry"
    bl_label = "Carry Through Modifiers"
    bl_options = {"REGISTER", "UNDO"}

    def make(self, context):
        report = api.carry(context.active_object)
        return f"{report['modifier']}: after the other modifiers"


CLASSES = (SYNCH_OT_isolines, SYNCH_OT_relief, SYNCH_OT_carry)
