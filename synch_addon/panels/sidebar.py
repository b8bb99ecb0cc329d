# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidebar tab "Synch" of the 3D View."""

from textwrap import wrap

import bpy

from ...core.settings.solver import SolverSettings
from ...core.settings.surface import SurfaceSettings
from ..blender.meshes import measured_key, refusal
from ..blender.modifiers import carries, is_of_filaments
from ..blender.pattern_surface import changing_later
from ..blender.phases import pattern_kind
from ..blender.registration import register_all
from ..blender.translations import translate
from ..jobs.queue import queue
from ..patterns import memory
from ..patterns.live import live
from ..patterns.other_settings import shows_other_settings
from ..patterns.pin_costs import cost_line
from ..patterns.refine import draw_expected_spacing, draw_warning
from ..patterns.symmetry import mirror_axes
from ..settings.fields import MESH_NAMES, RECORDS, original_of, source_of
from ..settings.preferences import is_simple, preferences
from ..solids.links import solid_of
from .guides import draw_guidance, draw_strokes
from .painting import KIND_LABELS, draw_density, draw_map, draw_painting
from .progress import draw_work, is_boxed
from .row_operators import can_set, meshes_selected
from .setting_presets import SYNCH_PT_presets
from .setting_rows import draw_automatic, draw_setting, draw_settings, property_column, skip

# Letters that fit into a line of the panel at its default width.
_LINE = 30


# What the redo panel shows of a command's settings: what one changes after a look at the result.
_REDONE = {
    "directions": ("guidance", "symmetry", "angle", "boundary", "mirror", "singularities"),
    "stripes": ("spacing", "branching", "guidance", "symmetry", "angle", "boundary", "mirror", "singularities"),
    "quads": ("spacing", "branching", "aspect", "guidance", "angle", "boundary", "mirror", "singularities"),
    "quad_mesh": (
        "faces",
        "spacing",
        "branching",
        "loops",
        "guidance",
        "angle",
        "mirror",
        "singularities",
        "smoothing",
    ),
}


def draw_redo(layout, operator):
    """The settings of an operator in the redo panel."""
    column = property_column(layout)
    for name in _REDONE[operator.command]:
        if name == "mirror":
            draw_mirror(column, operator, range(3))
        elif name != "spacing" or not getattr(operator, "faces", 0) or operator.command != "quad_mesh":
            draw_setting(column, operator, name, RECORDS[name].zero, _shared_name(name))


def _shared_name(name):
    """The panel's name of a setting that an object keeps for quad meshes apart, None of others."""
    return name.capitalize() if name in MESH_NAMES else None


def draw_mirror(column, settings, axes):
    """Axes of the mirror that can be chosen."""
    row = column.row(align=True, heading="Mirror")
    for axis in axes:
        row.prop(settings, "mirror", index=axis, text="XYZ"[axis], toggle=True)


def draw_share(column, settings, name):
    """Branching or singularities of what the panel makes: an object keeps those of quad meshes apart."""
    stored = MESH_NAMES[name] if settings.id_data.synch_simple.kind == "quad_mesh" else name
    column.prop(settings, stored, text=_shared_name(name))


def draw_guide(column, made):
    """Draw what lines follow, beyond the settings on top; for a quad mesh, those of its source."""
    obj = original_of(made)
    settings = obj.synch
    if obj.synch_simple.direction != "STROKES":
        draw_strokes(column)
    if obj.synch_simple.direction == "OTHER":
        draw_guidance(column, settings)

    def draw_symmetry(column):
        if made.synch_simple.kind in {"directions", "stripes"}:
            column.prop(settings, "symmetry")

    def draw_group(column):
        if settings.boundary != "FREE":
            column.prop_search(settings, "vertex_group", obj, "vertex_groups")

    own = {"symmetry": draw_symmetry, "vertex_group": draw_group, "guidance": skip, "mirror": skip}
    own["angle_attribute"] = lambda column: draw_map(column, settings, "ANGLE")
    own["singularities"] = lambda column: draw_share(column, made.synch, "singularities")
    draw_settings(column, settings, SurfaceSettings, "directions", own)
    if obj != made:
        return
    split = column.split(factor=0.4)
    label, row = split.row(), split.row(align=True)
    label.alignment = "RIGHT"
    label.label(text="Pin Faces")
    for turns, text in ((1, "+"), (-1, "−"), (0, "0")):
        row.operator("synch.pin", text=text, translate=False).turns = turns
    if settings.pins:
        row.operator("synch.unpin", text="", icon="X")
        if cost_line(obj):
            column.label(text=cost_line(obj), icon="BLANK1", translate=False)


def draw_main(layout, obj):
    """What is made, the button that makes it or how far it is, and what an artist sets first."""
    simple, settings, again = obj.synch_simple, obj.synch, source_of(obj) is not None
    source = original_of(obj)  # whose directions count
    work = next((work for work in queue.works if _is_on_top(work, obj)), None)
    column = layout.column(align=True)
    button, row = column.row(align=True), column.row(align=True)
    button.scale_y = 1.6
    if work is not None:
        draw_work(button, row, work)
    else:
        column.enabled = not queue.holds(obj)
        name = "synch.quad_mesh_again" if again else f"synch.{simple.kind}"
        if shows_other_settings(obj, simple.kind) or (again and memory.is_outdated(obj)):
            text = translate("Update {what}", what=translate(KIND_LABELS[simple.kind]))
            button.operator(name, text=text, icon="FILE_REFRESH", translate=False)
        else:
            button.operator(name, icon_value=layout.enum_item_icon(simple, "kind", simple.kind))
        property_column(row).prop(simple, "kind")
    if again and obj.mode == "EDIT":
        layout.label(text="Leave edit mode to update it", icon="INFO")
    if again:
        layout.label(text=translate("Made of {name}", name=source.name), icon="OBJECT_DATA", translate=False)
    layout = layout.column()
    layout.enabled = can_set(obj)
    draw_shape(layout, obj)
    draw_warning(layout, obj)
    column = property_column(layout)
    if simple.kind == "quad_mesh":
        draw_automatic(column, simple, "faces")
        draw_density(column, obj)
    if simple.kind != "directions" and not (simple.kind == "quad_mesh" and settings.faces):
        draw_spacing(column, simple, settings)
    if again:
        column.prop(settings, "loops")
    column.prop(source.synch_simple, "direction")
    if source.synch_simple.direction == "AXIS":
        column.row().prop(source.synch.guide, "axis", expand=True)
    if source.synch_simple.direction == "STROKES":
        draw_strokes(column)
    if simple.direction == "OTHER" and is_simple():
        column.label(text="Guides: Advanced, Guide", icon="BLANK1")
    is_any = simple.kind != "directions"  # patterns are mirrored on any mesh
    axes = {0, 1, 2} if is_any else {*mirror_axes(source), *(axis for axis in range(3) if settings.mirror[axis])}
    if axes:
        draw_mirror(column, settings, sorted(axes))
    if simple.kind != "directions":
        draw_share(column, settings, "branching")


def draw_spacing(column, simple, settings):
    """How far lines are apart, as a length and as lines across the object; a length that is set is no longer
    automatic."""
    if not (simple.kind == "quad_mesh" and settings.automatic_spacing):  # the face count is enough
        _draw_lines(column, simple)
    if settings.automatic_spacing:
        draw_expected_spacing(column, simple.kind, original_of(simple.id_data))
    else:
        column.prop(settings, "spacing")


def _draw_lines(column, simple):
    row = column.row(align=True)
    row.prop(simple, "lines")
    row.prop(simple, "automatic_spacing", text="Auto", toggle=True)


def draw_solver(layout, settings):
    """Settings of the solver."""

    def only_of_sdp(name):
        return lambda column: settings.method == "SDP" and column.prop(settings, name)

    own = {name: only_of_sdp(name) for name in ("rounding", "target_gap")}
    draw_settings(property_column(layout), settings, SolverSettings, "solver", own)


def draw_unready(layout, obj):
    """Say why an object can carry nothing; whether it cannot."""
    reason = refusal(obj)
    if obj is not None and any(map(is_of_filaments, obj.modifiers)):
        layout.label(text=obj.name, icon="CURVE_DATA", translate=False)
        layout.label(text="Vortex filaments", icon="FORCE_VORTEX")
    elif obj is not None and obj.type in {"CURVE", "VOLUME"}:
        layout.label(text=obj.name, icon=f"{obj.type}_DATA", translate=False)
        if not is_simple():  # there the button follows
            layout.label(text="Vortices: under Make", icon="FORCE_VORTEX")
    elif obj is None:
        layout.label(text="Select a mesh object", icon="INFO")
    elif reason:
        lines = wrap(reason[0].upper() + reason[1:], _LINE)
        for number, line in enumerate(lines):
            layout.label(text=line, icon="BLANK1" if number else "INFO", translate=False)
    elif not obj.visible_get():
        layout.label(text=translate("{name} is hidden", name=obj.name), icon="HIDE_ON", translate=False)
    return bool(reason)


def is_for(work, obj):
    """Whether a job is of an object, or of the one that its quads or layers were made of."""
    return work.obj is not None and work.obj in (obj, original_of(obj), solid_of(obj))


def _is_on_top(work, obj):
    """Whether a job's progress stands in place of the first button of an object."""
    in_box = is_boxed(work) and work.obj in (obj, solid_of(obj))
    return is_for(work, obj) and not work.is_quiet and not in_box


def draw_shape(layout, obj):
    """Of an object with shape keys, the one that is measured, and the lock that chooses the active one."""
    key = measured_key(obj)
    if key is not None:
        row = layout.row(align=True)
        row.label(text=translate("Shape: {shape}", shape=key.name), icon="SHAPEKEY_DATA", translate=False)
        row.prop(obj, "show_only_shape_key", text="", icon="PINNED" if obj.show_only_shape_key else "UNPINNED")


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
        layout, obj = self.layout, context.active_object
        if preferences() is not None:
            layout.row().prop(preferences(), "panel", expand=True)
        if not draw_unready(layout, obj) and not draw_painting(layout, context):
            draw_main(layout, obj)
            if not is_simple():
                row = layout.row()
                row.active = obj.synch_simple.kind in {"stripes", "quads"}  # what follows its settings
                row.prop(context.window_manager, "synch_live", toggle=True, icon="PLAY")
            if live.error:
                layout.label(text=live.error, icon="ERROR", translate=False)
            if meshes_selected(context):
                layout.operator("synch.copy_settings", text="Copy Settings to Selected", icon="COPYDOWN")


class SettingsPanel(SidebarPanel):
    """Mixed into panels of an object's settings, which ``draw_body`` draws; grey while its job runs."""

    @classmethod
    def poll(cls, context):
        return super().poll(context) and refusal(context.active_object) is None

    def draw(self, context):
        self.layout.enabled = can_set(context.active_object)
        self.draw_body(context)


class SYNCH_PT_guide(SettingsPanel, bpy.types.Panel):
    """What lines run along"""

    bl_label = "Guide"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 1

    def draw_body(self, context):
        draw_guide(property_column(self.layout), context.active_object)


class SYNCH_PT_pattern(SettingsPanel, bpy.types.Panel):
    """Where lines lie, and which faces show them"""

    bl_label = "Pattern"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 2

    def draw_body(self, context):
        obj = context.active_object
        kind, settings, column = obj.synch_simple.kind, obj.synch, property_column(self.layout)
        own = {name: skip for name in ("spacing", "branching", "faces", *(("loops",) if source_of(obj) else ()))}
        own["spacing_map"] = lambda column: draw_map(column, settings, "SPACING")
        if kind == "quad_mesh" and settings.automatic_spacing and not settings.faces:
            _draw_lines(column, obj.synch_simple)
        groups = {"pattern": True, "quads": kind in {"quads", "quad_mesh"}, "quad_mesh": kind == "quad_mesh"}
        groups["faces"] = kind != "quad_mesh" and len(obj.data.materials) > 1
        for group in [group for group, is_meant in groups.items() if is_meant]:
            draw_settings(column, settings, SurfaceSettings, group, own)


class DetailsPanel(SidebarPanel):
    """Mixed into panels of the solver's settings, which ``settings`` finds; of an object that can carry nothing, they
    hide with the panel around them."""

    bl_label = "Details"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 9

    def draw(self, context):
        draw_solver(self.layout, self.settings(context))


class SYNCH_PT_solver(DetailsPanel, bpy.types.Panel):
    """How the fields are optimized"""

    bl_parent_id = "SYNCH_PT_pattern"

    @staticmethod
    def settings(context):
        return context.active_object.synch


class SYNCH_PT_make(SidebarPanel, bpy.types.Panel):
    """Results made from patterns, solids and flows"""

    bl_label = "Make"
    bl_order = 4

    def draw(self, context):
        draw_made(self.layout, context.active_object)


def draw_made(layout, obj):
    """Buttons that make lines and meshes of the pattern that an object shows."""
    if refusal(obj) is not None or pattern_kind(obj) is None:
        return
    layout.enabled = can_set(obj)
    row = layout.row(align=True)
    row.operator("synch.isolines", text="Curves", icon="MOD_CURVE")
    row.operator("synch.relief", icon="MOD_DISPLACE")
    if memory.holds(obj) and pattern_kind(obj) == "quads":
        layout.operator("synch.trace_quads", icon="MOD_REMESH")
    if any(one.show_viewport for one in changing_later(obj)) and not any(map(carries, obj.modifiers)):
        layout.operator("synch.carry", icon="MODIFIER")


register, unregister = register_all((SYNCH_PT_fields, SYNCH_PT_guide, SYNCH_PT_pattern, SYNCH_PT_solver, SYNCH_PT_make))
