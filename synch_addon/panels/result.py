# SPDX-License-Identifier: GPL-3.0-or-later
"""The box "Result" of the sidebar tab: what the last solve found, its variations, its defects."""

import bpy

from ..blender.defect_empties import collection_of_defects
from ..blender.modifiers import shows_frames
from ..blender.phases import pattern_kind
from ..blender.registration import register_all
from ..blender.schema import KEPT
from ..blender.translations import translate, translate_count
from ..jobs.kept_results import read_result_or_empty
from ..patterns import memory
from ..patterns.refine import as_length
from ..settings.fields import source_of
from ..settings.preferences import is_simple
from ..solids.links import solid_of
from .row_operators import can_set
from .setting_rows import property_column
from .sidebar import SettingsPanel
from .thumbnails import draw_variations

# What is said of each kind of place where the surface is not the mesh.
FINDINGS = {
    "joined_vertices": "Joined vertices: {count}",
    "lost_vertices": "Vertices without a place: {count}",
    "flat_faces": "Faces without area: {count}",
    "doubled_faces": "Doubled faces: {count}",
    "non_manifold_edges": "Edges with three faces or more: {count}",
    "pinched_vertices": "Pinched vertices: {count}",
    "turned_faces": "Faces wound the other way: {count}",
    "one_sided_edges": "One-sided, cut along edges: {count}",
}

# Operators by what they solve.
SOLVES = {name: f"synch.{name}" for name in ("directions", "stripes", "quads", "quad_mesh")}
PLACING = "SYNCH_OT_place_defect"
# Energy for each vertex that is as good as none: what rounding leaves.
PERFECT = 1e-12
# Share of the energy up to which a variation is as good as the best.
_SAME = 5e-4


class SYNCH_PT_result(SettingsPanel, bpy.types.Panel):
    """What the last solve found"""

    bl_label = "Result"
    bl_order = 3
    in_simple = True

    def draw(self, context):
        """What only shows can be changed while a job runs; the rest is grey."""
        obj, result = context.active_object, _found(context)
        has_pattern = pattern_kind(obj) is not None
        if has_pattern:
            draw_shading(self.layout, context)
        if has_pattern or result.get("command") == "directions":
            draw_shown_defects(self.layout, obj, context.scene.synch_overlay)
        self.draw_body(context)

    def draw_body(self, context):
        layout, obj, result = self.layout.column(), context.active_object, _found(context)
        layout.enabled = can_set(obj)
        if not result:
            draw_nothing_found(layout, obj)
            return
        if memory.is_outdated(obj) and not source_of(obj):  # of a quad mesh the first button says it
            row = layout.row()
            row.alert = True
            row.operator(SOLVES[result["command"]], text="Mesh Changed: Solve Again", icon="FILE_REFRESH")
        if result["command"] == "quad_mesh":
            draw_quad_figures(layout, obj, result)
            return
        held, simple = memory.holds(obj), is_simple()
        if held:
            draw_variations(layout, obj, result)
            row = property_column(layout).row(align=True)
            slider = row.row(align=True)
            slider.enabled = memory.solve_of(obj).varies
            slider.prop(obj.synch_shown, "variation")
            row.operator("synch.draw_variation", text="", icon="FILE_REFRESH")
            draw_cost(layout, obj, result)
        elif result["command"] in KEPT:
            layout.label(text="Variations are not saved in files", icon="INFO")
            layout.operator("synch.find_variations", icon="FILE_REFRESH")
        if not simple and result["command"] != "directions":
            draw_favourites(layout, obj.synch.favourites)
        if not simple:
            if held:
                placing = any(operator.bl_idname == PLACING for operator in context.window.modal_operators)
                layout.operator("synch.place_defect", icon="PIVOT_CURSOR", depress=placing)
            row = layout.row(align=True)
            row.operator("synch.select_defects", text="Select Defects", icon="RESTRICT_SELECT_OFF")
            row.operator("synch.next_defect", text="Next Defect", icon="VIEWZOOM")


class SYNCH_PT_figures(SettingsPanel, bpy.types.Panel):
    """Energy, proof and counts of the last solve, and where the mesh is not manifold"""

    bl_label = "Details"
    bl_parent_id = "SYNCH_PT_result"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 1

    @classmethod
    def poll(cls, context):
        return super().poll(context) and bool(_found(context))

    def draw_body(self, context):
        obj, result = context.active_object, _found(context)
        draw_figures(self.layout, result, memory.holds(obj), len(obj.data.polygons))
        draw_findings(self.layout, result.get("carrier", {}))


def _found(context):
    """What the panel keeps of the active object's last solve; empty without one."""
    return read_result_or_empty(context.active_object.synch.result)


def draw_nothing_found(layout, obj):
    """Say that an object has no result, that it is animated, or whose layers it shows."""
    solid = solid_of(obj)
    if any(map(shows_frames, obj.modifiers)):
        layout.label(text="Animated: a new solve replaces it", icon="INFO")
    elif solid == obj:
        layout.label(text="Not solved yet", icon="INFO")
    else:
        layout.label(text=translate("Layers of {name}", name=solid.name), icon="ALIGN_JUSTIFY", translate=False)


def draw_shown_defects(layout, obj, overlay):
    """How the defects of an object are seen: as dots, and as empties."""
    split, defects = layout.split(factor=0.4), collection_of_defects(obj)
    label, row = split.row(), split.row(align=True)
    label.alignment = "RIGHT"
    label.label(text="Defects")
    row.prop(overlay, "defects", toggle=True, icon="DOT")
    if defects is not None:
        row.prop(defects, "hide_viewport", text="Empties", toggle=True, invert_checkbox=True, icon="EMPTY_AXIS")


def draw_cost(layout, obj, result):
    """Draw by how much the shown variation has more energy than the solution; the line is always there."""
    solved = memory.solve_of(obj)
    best = solved.shown.solution
    if best is not None and best.energy > 0:
        more = result["energy"] / best.energy - 1
        text = translate("{more:+.1%} energy, against the best", more=more)
        if abs(more) < _SAME:
            early = solved.report.ended_early
            text = translate("Ended early, before the best" if early else "The best of this solve")
        layout.label(text=text, icon="BLANK1", translate=False)


def draw_quad_figures(layout, obj, result):
    """Faces and irregular vertices of a quad mesh."""
    made = result.get("quad_mesh")
    if made is not None:
        faces = translate("{faces:,} faces, {quads:.0%} quads", faces=len(obj.data.polygons), quads=made["quad_share"])
        layout.label(text=faces, icon="MESH_GRID", translate=False)
        irregular = translate("{count:,} irregular vertices", count=made["irregular_vertices"])
        layout.label(text=irregular, icon="DOT", translate=False)


def draw_findings(layout, findings):
    """Draw a button for each kind of difference between the mesh and the surface that was solved on, with its count."""
    column = layout.column(align=True)
    for name, count in findings.items():
        text = translate(FINDINGS[name], count=count)
        column.operator("synch.select_places", text=text, icon="RESTRICT_SELECT_OFF").finding = name


def draw_shading(layout, context):
    """How the view shows the pattern: as ink over Solid, or by its material."""
    shading = context.space_data.shading
    row = layout.row(align=True)
    row.scale_y = 1.3
    if shading.type in {"MATERIAL", "RENDERED"}:
        row.prop_enum(shading, "type", "SOLID", text="Solid")
    else:
        row.prop(context.scene.synch_overlay, "pattern", text="Solid", toggle=True, icon="SHADING_SOLID")
    row.prop_enum(shading, "type", "MATERIAL", text="Preview")
    row.prop_enum(shading, "type", "RENDERED", text="Rendered")


def draw_favourites(layout, favourites):
    """A button that keeps what is shown, and a row for everything that is kept."""
    layout.operator("synch.keep_favourite", icon="FUND")
    column = layout.column(align=True)
    for favourite in favourites:
        row = column.row(align=True)
        row.operator("synch.show_favourite", text="", icon="HIDE_OFF").name = favourite.name
        row.prop(favourite, "name", text="")
        energy = read_result_or_empty(favourite.result).get("energy")
        row.label(text="" if energy is None else f"{energy:.4g}")
        row.operator("synch.remove_favourite", text="", icon="X").name = favourite.name


def draw_figures(layout, result, held, faces):
    """Energy, bound, counts, evenness, the spacing that was used, and how many faces there are.

    ``result`` is what :func:`kept_results.result_line` keeps. Where its whole report is held, the lines say in their
    tooltips what they mean, and copy it when they are clicked.
    """
    column = layout.column(align=True)

    def line(text, icon, about):
        row = column.row()
        row.alignment = "LEFT"
        if held:
            row.operator("synch.copy_report", text=text, icon=icon, emboss=False).about = about
        else:
            row.label(text=text, icon=icon)

    if result["energy"] is not None:
        perfect = result["energy"] <= PERFECT * result["nodes"]
        text = (
            translate("Energy 0: as even as can be")
            if perfect
            else translate("Energy {energy:.4g}", energy=result["energy"])
        )
        line(text, "SORTTIME", "energy")
        if result["certificate"] == "proved":
            line(translate("Proved: no field saves more than {gap:.0%}", gap=result["gap"]), "CHECKMARK", "proved")
        elif result["certificate"] == "estimated":
            line(translate("About {gap:.0%} above the bound", gap=result["gap"]), "QUESTION", "estimated")
    for kind, word in (("disclination", "swirl point"), ("dislocation", "line end")):
        line(translate_count(result[kind + "s"], word), "DOT", kind)
    if result.get("evenness"):
        low, _, _, _, high = result["evenness"]["spacing"]
        off = result["evenness"]["off_share"]
        length = as_length(result["settings"]["spacing"])
        line(translate("{length} apart on {count:,} faces", length=length, count=faces), "DOT", "spacing")
        line(
            translate("Spacing × {low:.2f} to {high:.2f}, {off:.0%} off", low=low, high=high, off=off),
            "DOT",
            "evenness",
        )
    line(f"{result['seconds']:.2f} s, {translate_count(result['nodes'], 'vertex')}", "TIME", "time")


register, unregister = register_all((SYNCH_PT_result, SYNCH_PT_figures))
