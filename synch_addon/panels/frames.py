# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of animated patterns as Blender properties, the object's and the operator's, and their panel."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty

from ...core.errors import SynchError
from ...core.settings.surface import SurfaceSettings
from ...core.tasks.surface_source import solve_seconds
from ..blender.modifiers import shows_frames
from ..blender.registration import register_all
from ..blender.translations import OURS
from ..frames.job import HOLD, Span
from ..settings.rna import settings_of
from .progress import draw_begin, draw_estimate
from .row_operators import can_set
from .setting_rows import property_column
from .sidebar import SettingsPanel


class AnimationProperties:
    """What is solved in which frames; mixed into the panel's storage and the operator."""

    pattern: EnumProperty(
        name="Pattern",
        description="What is solved in each frame",
        items=[
            ("STRIPES", "Stripes", "Evenly spaced stripes along a vector or line field"),
            ("QUADS", "Quad Pattern", "Two crossing families of lines along a cross field"),
        ],
        default="STRIPES",
    )
    scene_frames: BoolProperty(name="Scene Range", description="Solve all frames of the scene", default=True)
    first: IntProperty(name="First Frame", description="First frame to solve", default=1)
    last: IntProperty(name="Last Frame", description="Last frame to solve", default=24)
    hold: FloatProperty(
        name="Hold",
        description="How strongly the pattern holds on to the frame before: at 0 it may jump where the mesh moves on, "
        "larger values let it slide more slowly",
        default=HOLD,
        min=0.0,
        soft_max=2.0,
        translation_context=OURS,
    )


class SynchAnimation(AnimationProperties, bpy.types.PropertyGroup):
    """Settings of an object's animated pattern, kept in the file."""


class SYNCH_PT_animation(SettingsPanel, bpy.types.Panel):
    """The pattern in each frame of a moving mesh"""

    bl_label = "Animation"
    bl_parent_id = "SYNCH_PT_make"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 2

    def draw(self, context):
        obj, column = context.active_object, property_column(self.layout)
        settings, column.enabled = obj.synch_animation, can_set(obj)
        column.prop(settings, "pattern")
        column.prop(settings, "scene_frames")
        if not settings.scene_frames:
            column.prop(settings, "first")
            column.prop(settings, "last")
        column.prop(settings, "hold")
        _draw_expected(column, context, settings)
        draw_begin(self.layout, "synch.animate", "Animate", "RENDER_ANIMATION", obj)
        if any(map(shows_frames, obj.modifiers)):
            self.layout.label(text="Animated: a new solve replaces it", icon="INFO")


def _draw_expected(layout, context, settings):
    """About how long the frames take, unless they will be refused."""
    obj = context.active_object
    try:
        span = span_of(settings, context.scene)
    except SynchError:
        return
    method = settings_of(SurfaceSettings, obj.synch, ("method",))
    draw_estimate(layout, "Animate", solve_seconds(span.pattern, method, len(obj.data.vertices), len(span.frames)))


def span_of(settings, scene):
    """The :class:`Span` that properties stand for."""
    first, last = settings.first, settings.last
    if settings.scene_frames:
        first, last = scene.frame_start, scene.frame_end
    return Span(first, last, settings.pattern.lower(), settings.hold)


register, unregister = register_all(
    (SynchAnimation, SYNCH_PT_animation), (bpy.types.Object, "synch_animation", SynchAnimation)
)
