# SPDX-License-Identifier: GPL-3.0-or-later
"""Entries in Blender's own menus, which its search finds too: Add > Mesh, Object, the right-click menu
there, File > Import and File > Export."""

from functools import partial

import bpy

from ..blender.meshes import refusal
from ..blender.registration import Registration, class_steps
from ..looks.samples import SHAPES

# Operators by what they need, with the text of their entry; each group is set off by a line.
_ENTRIES = (
    (
        ("synch.stripes", "Stripes", "MOD_WAVE"),
        ("synch.quads", "Quad Pattern", "MESH_GRID"),
        ("synch.quad_mesh", "Remesh to Quads", "MOD_REMESH"),
        ("synch.directions", "Direction Field", "ORIENTATION_NORMAL"),
    ),
    (("synch.layers", "Layers in the Solid", "ALIGN_JUSTIFY"),),
    (
        ("synch.refine", "Subdivide for Spacing", "MOD_SUBSURF"),
        ("synch.copy_settings", "Copy Settings to Selected", "COPYDOWN"),
    ),
    (
        ("synch.draw_variation", "Another Variation", "FILE_REFRESH"),
        ("synch.place_defect", "Place Defects", "PIVOT_CURSOR"),
        ("synch.select_defects", "Select Defect Faces", "RESTRICT_SELECT_OFF"),
    ),
    (
        ("synch.isolines", "Lines as Curves", "MOD_CURVE"),
        ("synch.relief", "Relief", "MOD_DISPLACE"),
        ("synch.carry", "Carry Through Modifiers", "MODIFIER"),
        ("synch.bake", "Bake to Images", "RENDER_STILL"),
        ("synch.animate", "Animate the Pattern", "RENDER_ANIMATION"),
    ),
)


class SYNCH_MT_samples(bpy.types.Menu):
    """Shapes to try patterns on"""

    bl_label = "Synch Samples"

    def draw(self, context):
        for shape, label, _, icon, _ in SHAPES:
            self.layout.operator("synch.add_sample", text=label, icon=icon).shape = shape


class SYNCH_MT_object(bpy.types.Menu):
    """Stripes, quads and direction fields on the active mesh"""

    bl_label = "Synch Fields"

    def draw(self, context):
        self.layout.operator_context = "INVOKE_DEFAULT"
        for group in _ENTRIES:
            for operator, text, icon in group:
                self.layout.operator(operator, text=text, icon=icon)
            self.layout.separator()
        self.layout.operator("synch.import_field", icon="IMPORT")
        self.layout.operator("synch.export_field", icon="EXPORT")


def _draw_samples(menu, context):
    menu.layout.menu("SYNCH_MT_samples", icon="MOD_WAVE")


def _draw_object(menu, context):
    if refusal(context.active_object) is None:
        menu.layout.separator()
        menu.layout.menu("SYNCH_MT_object", icon="MOD_WAVE")


def _draw_import(menu, context):
    menu.layout.operator("synch.import_field", text="Direction Field (.rawfield, .rosy)")


def _draw_export(menu, context):
    menu.layout.operator("synch.export_field", text="Direction Field (.rawfield, .rosy)")


_ADDED = (
    ("VIEW3D_MT_mesh_add", _draw_samples),
    ("VIEW3D_MT_object", _draw_object),
    ("VIEW3D_MT_object_context_menu", _draw_object),
    ("TOPBAR_MT_file_import", _draw_import),
    ("TOPBAR_MT_file_export", _draw_export),
)


def _append(name, draw):
    getattr(bpy.types, name).append(draw)


def _remove(name, draw):
    getattr(bpy.types, name).remove(draw)


_registration = Registration(
    *class_steps(SYNCH_MT_samples, SYNCH_MT_object),
    *((partial(_append, *entry), partial(_remove, *entry)) for entry in _ADDED),
)
register, unregister = _registration.register, _registration.unregister
