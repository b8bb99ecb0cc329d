# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that choose where directions turn: by a click, and nowhere any more."""

import bpy
from bpy.props import IntProperty

from ...core.settings.pins import parse_pins, text_of_pins
from ..panels.row_operators import RowOperator
from ..patterns.pin_costs import PinCosts, cost_line
from .picking import PickingOperator


class SYNCH_OT_pin(PickingOperator, bpy.types.Operator):
    """Click on the surface to choose around which face directions turn, and how often; drag to move it, Enter ends, \
Esc undoes. Solve again, or let Live follow"""

    bl_idname = "synch.pin"
    bl_label = "Pin a Swirl Point"
    bl_options = {"REGISTER", "UNDO"}
    hint = "Click: pin a face   Drag: move it   Enter: done   Esc: as before"

    turns: IntProperty(
        name="Turns",
        description="How often directions turn: halves for lines, quarters for crosses, 0 for a face without a swirl "
        "point",
        default=1,
    )

    def begin(self, obj):
        overlay = bpy.context.scene.synch_overlay
        self._costs, self._shown = PinCosts(obj), (overlay.show, overlay.constraints)
        self._before = self._others = obj.synch.pins

    def pick(self, obj, surface, ray, is_moved):
        face = surface.face_at(*ray)
        if face is None:
            return False
        if not is_moved:
            self._others = obj.synch.pins
        obj.synch.pins = text_of_pins(parse_pins(self._others) | {face: self.turns})
        overlay = bpy.context.scene.synch_overlay
        overlay.show = overlay.constraints = True
        return True

    def let_go(self, obj):
        self._costs.compute(obj)
        return cost_line(obj)

    def take_back(self, obj):
        overlay = bpy.context.scene.synch_overlay
        overlay.show, overlay.constraints = self._shown
        obj.synch.pins = self._before


class SYNCH_OT_unpin(RowOperator, bpy.types.Operator):
    """Let directions turn where they want"""

    bl_idname = "synch.unpin"
    bl_label = "Clear Pins"

    def execute(self, context):
        context.active_object.synch.pins = ""
        return {"FINISHED"}


CLASSES = (SYNCH_OT_pin, SYNCH_OT_unpin)
