# SPDX-License-Identifier: GPL-3.0-or-later
"""The box "Vortices" of the sidebar tab: settings, an estimate, what was found, and the choice of a point."""

import math
from functools import partial

import bpy

from ..blender.registration import register_all
from ..blender.translations import translate, translate_count
from ..flows import memory
from ..flows.chosen import expected_solve, settings_that_count
from ..flows.files import can_export
from ..settings.preferences import is_simple
from .progress import draw_begin, draw_estimate
from .setting_rows import draw_automatic, property_column
from .sidebar import DetailsPanel, SidebarPanel


class SYNCH_PT_vortices(SidebarPanel, bpy.types.Panel):
    """Vortex filaments and tubes of a flow in space"""

    bl_label = "Vortices"
    bl_parent_id = "SYNCH_PT_make"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 4

    def draw(self, context):
        settings = context.scene.synch_vortices
        draw_vortices(self.layout, settings, partial(draw_automatic, settings=settings, name="shown_core"))
        _draw_button(self.layout, context)


class SYNCH_PT_simple_vortices(SidebarPanel, bpy.types.Panel):
    """The vortices of a curve or volume, with the settings of the box under Make"""

    bl_label = "Vortices"
    bl_options = {"HIDE_HEADER"}
    bl_order = 1
    in_simple = True

    @classmethod
    def poll(cls, context):
        obj = context.active_object
        return is_simple() and obj is not None and obj.type in {"CURVE", "VOLUME"}

    def draw(self, context):
        _draw_button(self.layout, context)


def _draw_button(layout, context):
    draw_expected(layout, context, context.scene.synch_vortices)
    column = layout.column()
    column.scale_y = 1.3
    draw_begin(column, "synch.clebsch", "Vortices", "FORCE_VORTEX")


class SYNCH_PT_vortex_solver(DetailsPanel, bpy.types.Panel):
    """How the map of a flow is optimized"""

    bl_parent_id = "SYNCH_PT_vortices"

    @staticmethod
    def settings(context):
        return context.scene.synch_vortices


class SYNCH_PT_vortex_result(SidebarPanel, bpy.types.Panel):
    """What the last solve of the active object's vortices found"""

    bl_label = "Result"
    bl_parent_id = "SYNCH_PT_vortices"

    @classmethod
    def poll(cls, context):
        obj = context.active_object
        return super().poll(context) and obj is not None and bool(obj.synch_vortices.figures)

    def draw(self, context):
        obj = context.active_object
        draw_figures(self.layout, obj.synch_vortices.figures)
        if memory.flows.holds(obj):
            draw_choice(self.layout, obj.synch_vortices)
        if can_export(obj):
            self.layout.operator("synch.filament_export", icon="EXPORT")


def draw_vortices(layout, settings, draw_core):
    """What is solved; ``settings`` are the scene's or an operator's, whose core a callable (column) draws."""
    counting = settings_that_count(bpy.context, settings.filepath)
    column = property_column(layout)
    column.prop(settings, "filepath", placeholder="chosen objects")
    column.prop(settings, "show")
    column.prop(settings, "resolution")
    if "core" in counting:
        draw_core(column)
    if "attribute" in counting:
        column.prop(settings, "attribute")
    column.prop(settings, "by")
    column.prop(settings, {"COUNT": "count", "CIRCULATION": "quantum", "SHARE": "share"}[settings.by])
    if settings.show != "FILAMENTS":
        column.prop(settings, "opening")
    column.prop(settings, "smoothing")
    column.prop(settings, "unwrapped")
    column.prop(settings, "use_frames")
    if settings.use_frames:
        row = column.row(align=True)
        row.prop(settings, "frame_start", text="First, Last")
        row.prop(settings, "frame_end", text="")


def draw_expected(layout, context, settings):
    """How many nodes a solve will have, how long it takes and how much memory, where that can be told beforehand."""
    expected = expected_solve(context, settings)
    if expected is None:
        return
    if expected.megabytes is not None:
        is_large = math.prod(expected.shape) > 2_000_000
        text = translate("{sizes} nodes", sizes=" × ".join(map(str, expected.shape)))
        layout.label(text=text, icon="ERROR" if is_large else "INFO")
    draw_estimate(layout, "Vortices", expected.seconds, expected.megabytes)


def draw_figures(layout, found):
    """Energy, bound, counts and what of the vorticity the filaments carry."""
    column = layout.column(align=True)
    column.label(text=translate("Energy {energy:.4g}", energy=found["energy"]), icon="SORTTIME")
    if found["certificate"] == "proved":
        column.label(text=translate("Proved: no map saves more than {gap:.0%}", gap=found["gap"]), icon="CHECKMARK")
    elif found["certificate"] == "estimated":
        column.label(text=translate("About {gap:.0%} above the bound", gap=found["gap"]), icon="QUESTION")
    if found["filaments"] is not None:
        closed = translate("{closed} closed", closed=found["closed"])
        column.label(text=f"{translate_count(found['filaments'], 'filament')}, {closed}", icon="CURVE_DATA")
        column.label(text=translate("{length:.3g} long in all", length=found["length"]), icon="BLANK1")
    if found["vortices"] is not None:
        column.label(text=translate_count(found["vortices"], "vortex"), icon="DOT")
    if found["tubes"] is not None:
        column.label(text=translate_count(found["tubes"], "tube"), icon="MESH_CYLINDER")
    share = found["vorticity_share"]
    if share is not None:
        column.label(text=translate("Circulation {quantum:.4g} each", quantum=found["quantum"]), icon="FORCE_VORTEX")
        column.label(text=translate("{share:.0%} of the vorticity", share=share), icon="BLANK1")
    column.label(text=translate("{seconds:.1f} s, {nodes} nodes", **found), icon="TIME")


def draw_choice(layout, look):
    """The ball with the point of the sphere, and what else is shown at once."""
    row = layout.row()
    row.enabled = look.id_data.mode == "OBJECT"
    row.prop(look, "point", text="")
    column = row.column(align=True)
    column.use_property_split = False
    north, east = look.place
    column.label(text=f"{abs(north):.0f}° {'N' if north >= 0 else 'S'}, {abs(east):.0f}° {'E' if east >= 0 else 'W'}")
    column.prop(look, "opening")
    column.prop(look, "smoothing")
    column.operator("synch.best_vortices", icon="LOOP_BACK")


register, unregister = register_all(
    (SYNCH_PT_vortices, SYNCH_PT_vortex_solver, SYNCH_PT_vortex_result, SYNCH_PT_simple_vortices)
)
