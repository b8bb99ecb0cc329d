# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators on the last solve of the active object: other configurations, defects at chosen vertices."""

import random

import bpy
from bpy.props import IntProperty
from bpy_extras.view3d_utils import region_2d_to_origin_3d, region_2d_to_vector_3d

from ...core.errors import SynchError
from .. import api
from ..blender import meshes
from ..blender.translations import said
from ..patterns import memory
from ..patterns.numbers import renew_shown
from ..patterns.picking import PickedSurface
from ..settings.fields import SMOOTHING
from .field_operator import navigates, over_sidebar
from .ready import PromptOperator, ReadyOperator

# Numbers that the dice draw: from here on every one is another random projection.
_DRAWN = (100, 1_000_000)


class _SolvedOperator(ReadyOperator):
    """Mixed into operators that need a solve of the active object."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def lacking(cls, obj):
        """Why there is nothing to be done with what an object shows, or None."""
        if memory.holds(obj):
            return None
        text = "{name} has no solve in memory (kept for the last {count} objects): solve it first"
        return said(text, name=obj.name, count=memory.MOST)


class _VaryingOperator(_SolvedOperator):
    """Mixed into operators that need a lifted field."""

    @classmethod
    def lacking(cls, obj):
        reason = super().lacking(obj)
        if reason is None and not memory.solve_of(obj).varies:
            return said("only the semidefinite method finds variations: choose it and solve again")
        return reason


class SYNCH_OT_variation(_VaryingOperator, PromptOperator, bpy.types.Operator):
    """Show another near-optimal configuration of defects, from the last solve"""

    bl_idname = "synch.variation"
    bl_label = "Variation"

    number: IntProperty(
        name="Variation",
        description="0 is the best one, the next are other good ones, high numbers are drawn at random",
        min=0,
    )

    def make(self, context):
        return _found(api.vary(context.active_object, self.number))


class SYNCH_OT_trace_quads(_SolvedOperator, PromptOperator, bpy.types.Operator):
    """Make a new mesh of the quads that the object shows, without solving again, and hide the object"""

    bl_idname = "synch.trace_quads"
    bl_label = "Mesh of These Quads"

    smoothing: SMOOTHING

    def invoke(self, context, _event):
        self.smoothing = context.active_object.synch.smoothing
        return self.execute(context)

    def make(self, context):
        return _found(api.trace_quads(context.active_object, self.smoothing))


class SYNCH_OT_draw_variation(_VaryingOperator, PromptOperator, bpy.types.Operator):
    """Show a configuration of defects that is drawn at random, from the last solve"""

    bl_idname = "synch.draw_variation"
    bl_label = "Draw Variation"

    def make(self, context):
        return _found(api.vary(context.active_object, random.randrange(*_DRAWN)))


class SYNCH_OT_place_defect(_VaryingOperator, bpy.types.Operator):
    """Click on the surface to put a dislocation there, drag to move it, click again for more; Enter ends, Esc undoes"""

    bl_idname = "synch.place_defect"
    bl_label = "Place Defects"

    @classmethod
    def lacking(cls, obj):
        reason = super().lacking(obj)
        if reason is None and memory.solve_of(obj).pattern is None:
            return said("defects are placed in stripes and quads: solve one of them first")
        return reason

    def invoke(self, context, event):
        if context.region is None or context.region.type != "WINDOW":
            self.report({"ERROR"}, "defects are placed in a 3D view: run this with the mouse over one")
            return {"CANCELLED"}
        obj = context.active_object
        try:
            with meshes.object_mode(obj):
                self._before = memory.recall(obj)
                self._surface = PickedSurface.of(obj)
        except SynchError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._object_name = obj.name
        self._vertices, self._held = [], False
        context.window_manager.modal_handler_add(self)
        context.workspace.status_text_set(said("Click: place a defect   Drag: move it   Enter: done   Esc: as before"))
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        try:
            result = self._step(context, event)
        except SynchError as error:
            self.report({"ERROR"}, str(error))
            result = {"FINISHED"} if self._vertices else {"CANCELLED"}
        except Exception:
            self.cancel(context)
            raise
        if result & {"FINISHED", "CANCELLED"}:
            self.cancel(context)
        return result

    def cancel(self, context):
        """However it ends: give the status bar back."""
        context.workspace.status_text_set(None)

    def _step(self, context, event):
        obj = bpy.data.objects.get(self._object_name)
        if obj is None:
            raise SynchError(f"the object {self._object_name} is gone: no more defects can be placed")
        if event.type in {"RET", "NUMPAD_ENTER", "RIGHTMOUSE"} and event.value == "PRESS":
            if not self._vertices:
                return {"CANCELLED"}
            renew_shown(obj)
            return {"FINISHED"}
        if event.type == "ESC":
            if self._vertices:
                api.show_again(obj, self._before)
            return {"CANCELLED"}
        if event.type == "LEFTMOUSE":
            pressed = event.value == "PRESS" and not over_sidebar(context, event)
            self._held = pressed and self._put(context, event, obj, self._vertices)
            return {"RUNNING_MODAL"}
        if event.type == "MOUSEMOVE" and self._held:
            self._put(context, event, obj, self._vertices[:-1])
        return {"PASS_THROUGH"} if navigates(event) else {"RUNNING_MODAL"}

    def _put(self, context, event, obj, others):
        """Put a defect at the vertex under the mouse, beside those at others; returns whether one is there now."""
        vertex = self._surface.vertex_at(*_ray(context, event, obj))
        if vertex is None or vertex in self._vertices:
            return vertex is not None
        vertices = [*others, vertex]
        try:
            report = api.place_defects(obj, vertices, renumber=False)
        except SynchError as error:
            self.report({"ERROR"}, str(error))
            return False
        self.report({"INFO"}, _found(report))
        self._vertices = vertices
        return True


def _found(report):
    return f"energy {report['energy']:.4g}, {len(report['dislocations'])} dislocations"


def _ray(context, event, obj):
    """Origin and direction of what is under the mouse, in an object's space."""
    mouse = event.mouse_region_x, event.mouse_region_y
    origin = region_2d_to_origin_3d(context.region, context.region_data, mouse)
    towards = region_2d_to_vector_3d(context.region, context.region_data, mouse)
    inverse = obj.matrix_world.inverted()
    return inverse @ origin, inverse.to_3x3() @ towards


CLASSES = (SYNCH_OT_variation, SYNCH_OT_draw_variation, SYNCH_OT_place_defect, SYNCH_OT_trace_quads)
