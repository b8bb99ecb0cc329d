# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidebar tab "Synch" of the 3D View."""

import bpy

from ...core.settings.setting import records
from ...core.settings.solver import SolverSettings
from ...core.settings.surface import SurfaceSettings
from ..blender.meshes import measured_key, refusal
from ..blender.modifiers import is_of_filaments
from ..blender.registration import register_all
from ..blender.translations import translate
from ..jobs.queue import queue
from ..patterns.live import live
from ..patterns.pin_costs import cost_line
from ..patterns.refine import draw_told, draw_warning
from ..patterns.symmetry import mirror_axes
from ..settings.fields import MESH_NAMES, source_of
from ..settings.preferences import is_simple, preferences
from .guides import draw_guidance
from .painting import draw_map, draw_painting
from .row_operators import can_set, others_selected
from .setting_presets import SYNCH_PT_presets

# Jobs of the row that are shown, the others by their number.
SHOWN_JOBS = 5


def draw_settings(column, settings, kind, group, own=None):
    """Draw the settings of a group of the panel, in the order of their declaration.

    Parameters
    ----------
    column : UILayout
    settings : the object's, or an operator's
    kind : class of the settings
    group : of the panel, as the records have it
    own : by name, callables (column) that draw a setting in a way of their own
    """
    own = own or {}
    for name, record in records(kind):
        if record.group != group or record.part_of:
            continue
        if name in own:
            own[name](column)
        else:
            column.prop(settings, name)


def draw_directions(layout, settings, obj, of_quads=False):
    """Settings of the direction field; ``settings`` are the object's or an operator's. Quads have no symmetry."""

    def draw_symmetry(column):
        if not of_quads:
            column.prop(settings, "symmetry")

    def draw_guides(column):
        if hasattr(settings, "guides"):
            draw_guidance(column, settings)
        else:
            column.prop(settings, "guidance")

    def draw_group(column):
        if settings.boundary != "FREE":
            column.prop_search(settings, "vertex_group", obj, "vertex_groups")

    def draw_mirror(column):
        row = column.row(align=True, heading="Mirror")
        for number, axis in enumerate("XYZ"):
            row.prop(settings, "mirror", index=number, text=axis, toggle=True)

    column = property_column(layout)
    own = {"symmetry": draw_symmetry, "guidance": draw_guides, "vertex_group": draw_group, "mirror": draw_mirror}
    own["angle_attribute"] = lambda column: draw_map(column, settings, "ANGLE")
    draw_settings(column, settings, SurfaceSettings, "directions", own)
    if hasattr(settings, "pins"):
        draw_pins(column, settings, obj)


def draw_pins(column, settings, obj):
    """Buttons that pin faces, and what the pins cost."""
    row = column.row(align=True, heading="Pin")
    for turns, text in ((1, "+"), (-1, "−"), (0, "0")):
        row.operator("synch.pin", text=text, translate=False).turns = turns
    if settings.pins:
        row.operator("synch.unpin", text="", icon="X")
        if cost_line(obj):
            column.label(text=cost_line(obj), icon="BLANK1", translate=False)


def draw_simple(layout, obj):
    """What an artist sets first, and the button that makes what was chosen last."""
    simple, settings = obj.synch_simple, obj.synch
    if source_of(obj) is not None:
        draw_again(layout, obj)
        return
    row = layout.row(align=True)
    row.scale_y = 1.3
    icon = layout.enum_item_icon(simple, "kind", simple.kind)
    row.operator(f"synch.{simple.kind}", icon_value=icon)
    row.prop(simple, "kind", text="", icon_only=True)
    draw_warning(layout, obj)
    column = property_column(layout)
    if simple.kind == "quad_mesh":
        column.prop(settings, "faces")
    if simple.kind != "quad_mesh" or not settings.faces:
        draw_automatic(column, settings, "spacing", "automatic_spacing")
        draw_told(column, simple.kind, obj)
    column.prop(simple, "direction")
    if simple.direction == "AXIS":
        column.row().prop(settings.guide, "axis", expand=True)
    axes = {*mirror_axes(obj), *(axis for axis in range(3) if settings.mirror[axis])}
    if axes:
        row = column.row(align=True, heading="Mirror")
        for axis in sorted(axes):
            row.prop(settings, "mirror", index=axis, text="XYZ"[axis], toggle=True)
    column.prop(settings, "mesh_branching" if simple.kind == "quad_mesh" else "branching", text="Branching")


def draw_again(layout, obj):
    """The button that makes a quad mesh anew from its source, and what an artist changes for it."""
    layout.label(text=translate("Made of {name}", name=source_of(obj).name), icon="OBJECT_DATA", translate=False)
    row = layout.row()
    row.scale_y = 1.3
    row.operator("synch.quad_mesh_again", icon="MOD_REMESH")
    settings, column = obj.synch, property_column(layout)
    column.prop(settings, "faces")
    if not settings.faces:
        draw_automatic(column, settings, "spacing", "automatic_spacing")
    column.prop(settings, "loops")
    column.prop(settings, "mesh_branching", text="Branching")


def draw_pattern(layout, settings):
    """Settings of a pattern, below those of the directions."""

    def draw_spacing(column):
        if hasattr(settings, "automatic_spacing"):
            draw_automatic(column, settings, "spacing", "automatic_spacing")
            draw_told(column, "stripes", settings.id_data)
        else:
            column.prop(settings, "spacing")

    own = {"spacing": draw_spacing, "spacing_map": lambda column: draw_map(column, settings, "SPACING")}
    draw_settings(property_column(layout), settings, SurfaceSettings, "pattern", own)


def draw_automatic(column, settings, name, automatic):
    """A setting below the one that makes it automatic, which is shown where that is not chosen."""
    column.prop(settings, automatic)
    if not getattr(settings, automatic):
        column.prop(settings, name)


def draw_faces(layout, settings):
    """Which faces show the pattern."""
    draw_settings(property_column(layout), settings, SurfaceSettings, "faces")


def draw_quads(layout, settings):
    """What only quads have."""
    draw_settings(property_column(layout), settings, SurfaceSettings, "quads")


def draw_quad_mesh(layout, settings):
    """Settings of the mesh of quads; an object keeps some of them apart from those of patterns."""
    column = property_column(layout)
    draw_settings(column, settings, SurfaceSettings, "quad_mesh")
    for name in MESH_NAMES.values():
        if hasattr(settings, name):
            column.prop(settings, name)


def draw_solver(layout, settings):
    """Settings of the solver."""

    def only_of_sdp(name):
        return lambda column: settings.method == "SDP" and column.prop(settings, name)

    own = {name: only_of_sdp(name) for name in ("rounding", "target_gap")}
    draw_settings(property_column(layout), settings, SolverSettings, "solver", own)


def property_column(layout):
    """A column of settings with their names on the left, as in Blender's own panels."""
    column = layout.column()
    column.use_property_split = True
    column.use_property_decorate = False
    return column


def draw_unready(layout, obj):
    """Say why an object can carry nothing, or that its job is on its way; whether there is either."""
    reason = refusal(obj)
    if obj is not None and any(map(is_of_filaments, obj.modifiers)):
        layout.label(text=translate("{name}: vortex filaments", name=obj.name), icon="FORCE_VORTEX", translate=False)
    elif reason:
        layout.label(text=reason[0].upper() + reason[1:], icon="INFO", translate=False)
    elif not obj.visible_get():
        layout.label(text=translate("{name} is hidden", name=obj.name), icon="HIDE_ON", translate=False)
    return bool(reason) or queue.holds(obj)


def draw_shape(layout, obj):
    """Of an object with shape keys, the one that is measured, and the lock that chooses the active one."""
    key = measured_key(obj)
    if key is not None:
        row = layout.row(align=True)
        row.label(text=translate("Measured: {shape}", shape=key.name), icon="SHAPEKEY_DATA", translate=False)
        row.prop(obj, "show_only_shape_key", text="", icon="PINNED" if obj.show_only_shape_key else "UNPINNED")


def draw_row(layout):
    """The job that runs with a bar, and those that wait for their turn."""
    shown = [(place, work) for place, work in enumerate(queue.works) if not work.is_quiet]
    for place, work in shown[:SHOWN_JOBS]:
        link = work.job.link
        obj = None if link is None else link.present
        name = translate(work.label) if obj is None else f"{translate(work.label)}: {obj.name}"
        box = layout.box().column(align=True)
        row = box.row()
        row.label(text=name, translate=False)
        if place:
            row.label(text=translate("waiting"), translate=False)
            row.operator("synch.cancel", text="", icon="X").place = place
            continue
        row.label(text=work.times, translate=False)
        box.progress(factor=work.fraction, text=work.line)
        row = box.row(align=True)
        if work.can_be_kept:
            row.operator("synch.keep", icon="CHECKMARK")
        row.operator("synch.cancel", text="" if work.picture is None else "Discard", icon="X").place = place
    if len(shown) > 1:
        row = layout.row()
        if len(shown) > SHOWN_JOBS:
            row.label(text=translate("{count} more are waiting", count=len(shown) - SHOWN_JOBS), translate=False)
        row.operator("synch.cancel", text="Cancel All", icon="X").place = -1


class SidebarPanel:
    """Mixed into panels of the tab; those that are not ``in_simple`` hide where the simple panel is shown."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Synch"
    in_simple = False

    @classmethod
    def poll(cls, context):
        return cls.in_simple or not is_simple()


class SYNCH_PT_fields(SidebarPanel, bpy.types.Panel):
    """Direction fields, stripes and quads"""

    bl_label = "Synch Fields"
    in_simple = True

    def draw_header_preset(self, context):
        if can_set(context.active_object):
            SYNCH_PT_presets.draw_panel_header(self.layout)

    def draw(self, context):
        if preferences() is not None:
            self.layout.row().prop(preferences(), "panel", expand=True)
        draw_row(self.layout)
        obj = context.active_object
        if draw_unready(self.layout, obj) or draw_painting(self.layout, context):
            return
        draw_shape(self.layout, obj)
        if is_simple():
            draw_simple(self.layout, obj)
            return
        if source_of(obj) is not None:
            draw_again(self.layout, obj)
        column = self.layout.column(align=True)
        column.scale_y = 1.3
        row = column.row(align=True)
        row.operator("synch.stripes", icon="MOD_WAVE")
        row.operator("synch.quads", icon="MESH_GRID")
        row = column.row(align=True)
        row.operator("synch.directions", icon="ORIENTATION_NORMAL")
        row.operator("synch.quad_mesh", icon="MOD_REMESH")
        self.layout.prop(context.window_manager, "synch_live", toggle=True, icon="PLAY")
        if live.error:
            self.layout.label(text=live.error, icon="ERROR", translate=False)
        draw_warning(self.layout, obj)
        others = len(others_selected(context))
        if others:
            text = translate("Copy Settings to {count} Others", count=others)
            self.layout.operator("synch.copy_settings", text=text, icon="COPYDOWN")


class SettingsPanel(SidebarPanel):
    """Mixed into panels of an object's settings, which hide while there is nothing to set."""

    bl_parent_id = "SYNCH_PT_fields"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and can_set(context.active_object)


class SYNCH_PT_directions(SettingsPanel, bpy.types.Panel):
    """What the stripes run along"""

    bl_label = "Directions"
    bl_order = 1

    def draw(self, context):
        obj = context.active_object
        draw_directions(self.layout, obj.synch, obj)


class SYNCH_PT_pattern(SettingsPanel, bpy.types.Panel):
    """How far stripes are from one another, and which faces show them"""

    bl_label = "Pattern"
    bl_order = 3

    def draw(self, context):
        obj = context.active_object
        draw_pattern(self.layout, obj.synch)
        if len(obj.data.materials) > 1:
            draw_faces(self.layout, obj.synch)


class SYNCH_PT_quads(SettingsPanel, bpy.types.Panel):
    """What only quads have"""

    bl_label = "Quads"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 3

    def draw(self, context):
        settings = context.active_object.synch
        draw_quads(self.layout, settings)
        draw_quad_mesh(self.layout, settings)


class SYNCH_PT_solver(SettingsPanel, bpy.types.Panel):
    """How the fields are optimized"""

    bl_label = "Solver"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 4  # below the constraints

    def draw(self, context):
        draw_solver(self.layout, context.active_object.synch)


register, unregister = register_all(
    (SYNCH_PT_fields, SYNCH_PT_directions, SYNCH_PT_pattern, SYNCH_PT_quads, SYNCH_PT_solver)
)
