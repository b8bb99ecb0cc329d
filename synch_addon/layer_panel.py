# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel "Layers" of the sidebar tab, and the operators that add and remove its groups."""

from types import SimpleNamespace

import bpy
import numpy as np
from bpy.props import IntProperty

from . import jobs
from .layer_links import solid_of
from .layer_properties import GUIDE_NAMES, LENGTHS
from .layers import EDGES_PER_LAYER
from .panels import SidebarPanel, draw_progress, draw_solver, property_column
from .scene_io import refusal
from .solids import estimate
from .translations import said

# Volume, area and bounds of the mesh that was measured last, and what it was known by.
_measured: dict[tuple, SimpleNamespace] = {}


class SYNCH_PT_layers(SidebarPanel, bpy.types.Panel):
    """Evenly spaced layers in the solid that a closed mesh encloses"""

    bl_label = "Layers"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        obj = solid_of(context.active_object)
        reason = refusal(obj)
        if reason:
            self.layout.label(text=reason[0].upper() + reason[1:], icon="INFO")
            return
        if jobs.running is not None:
            draw_progress(self.layout, jobs.running)
            return
        if obj != context.active_object:
            self.layout.label(text=said("Layers of {name}", name=obj.name), icon="OBJECT_DATA")
        row = self.layout.row()
        row.scale_y = 1.3
        row.operator("synch.layers", icon="ALIGN_JUSTIFY")
        _draw_estimate(self.layout, obj)
        draw_layers(self.layout, obj.synch_layering)


def draw_layers(layout, stored):
    """Settings of an object's layers."""
    column = property_column(layout)
    column.prop(stored, "guide")
    for name in GUIDE_NAMES[stored.guide]:
        field = column.row()
        field.alert = not getattr(stored, name)
        field.prop(stored, name)
    for number, row in enumerate(stored.groups):
        line = layout.row(align=True)
        line.prop(row, "group", text="")
        line.prop(row, "wish", text="")
        line.operator("synch.layer_group_remove", text="", icon="X").number = number
    layout.operator("synch.layer_group_add", icon="ADD")
    column = property_column(layout)
    for name, automatic in LENGTHS.items():
        column.prop(stored, automatic)
        line = column.row()
        line.enabled = not getattr(stored, automatic)
        line.prop(stored, name)
    column.prop(stored, "spacing_map")
    if stored.spacing_map:
        column.prop(stored, "spacing_range")
    draw_solver(layout, stored)


def _draw_estimate(layout, obj):
    """How large the solid will be, before it is made."""
    if obj.mode == "EDIT" or len(obj.data.polygons) == 0:
        return
    stored, measures = obj.synch_layering, _measures(obj)
    if measures.volume <= 0:
        return
    expected = estimate(measures, None if stored.automatic_size else stored.size)
    if stored.automatic_size and not stored.automatic_spacing:
        expected = estimate(measures, min(expected.size, stored.spacing / EDGES_PER_LAYER))
    about = said("About {tets:,} tetrahedra, {megabytes:,.0f} MB", tets=expected.tets, megabytes=expected.megabytes)
    layout.label(text=about, icon="MESH_ICOSPHERE")


def _measures(obj):
    """Volume, area and bounds of an object's mesh; measured again where its counts, its box or its scale change."""
    mesh = obj.data
    box = tuple(np.round(np.array(obj.bound_box).ravel(), 6))
    key = (mesh.session_uid, len(mesh.vertices), len(mesh.polygons), box, tuple(obj.matrix_world.to_scale()))
    if key not in _measured:
        _measured.clear()
        mesh.calc_loop_triangles()
        points = np.empty((len(mesh.vertices), 3), np.float32)
        mesh.vertices.foreach_get("co", points.ravel())
        triangles = np.empty((len(mesh.loop_triangles), 3), np.int32)
        mesh.loop_triangles.foreach_get("vertices", triangles.ravel())
        points = (points - points.mean(axis=0)).astype(float) * np.abs(key[-1])
        a, b, c = np.moveaxis(points[triangles], 1, 0)
        normals = np.cross(b - a, c - a)
        _measured[key] = SimpleNamespace(
            volume=abs(float(np.einsum("tx,tx->", a, normals))) / 6,
            area=float(np.linalg.norm(normals, axis=1).sum()) / 2,
            bounds=np.array([points.min(axis=0), points.max(axis=0)]),
        )
    return _measured[key]


class _RowOperator:
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    @classmethod
    def poll(cls, context):
        return refusal(solid_of(context.active_object)) is None and jobs.running is None


class SYNCH_OT_layer_group_add(_RowOperator, bpy.types.Operator):
    """Ask something of the layers on a part of the surface"""

    bl_idname = "synch.layer_group_add"
    bl_label = "Add Group"

    def execute(self, context):
        obj = solid_of(context.active_object)
        row = obj.synch_layering.groups.add()
        if obj.vertex_groups.active:
            row.group = obj.vertex_groups.active.name
        return {"FINISHED"}


class SYNCH_OT_layer_group_remove(_RowOperator, bpy.types.Operator):
    """Ask nothing of the layers there"""

    bl_idname = "synch.layer_group_remove"
    bl_label = "Remove Group"

    number: IntProperty(name="Row", description="Which of the rows, from 0 on", min=0)

    def execute(self, context):
        groups = solid_of(context.active_object).synch_layering.groups
        if self.number >= len(groups):
            return {"CANCELLED"}
        groups.remove(self.number)
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory(
    (SYNCH_OT_layer_group_add, SYNCH_OT_layer_group_remove, SYNCH_PT_layers)
)
