# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator that shows a loop of quads."""

import bpy

from ...core.errors import SynchError
from ..blender.translations import translate
from ..patterns.loops import loops_of, shown_edge
from .picking import PickingOperator


class SYNCH_OT_show_loop(PickingOperator, bpy.types.Operator):
    """Click near an edge to show the loop of quads through it; Enter keeps it in the overlay, Esc does not"""

    bl_idname = "synch.show_loop"
    bl_label = "Show Loop"
    hint = "Click near an edge: show its loop   Enter: done   Esc: as before"

    @classmethod
    def lacking(cls, obj):
        return "leave edit mode: loops are shown in object mode" if obj.mode == "EDIT" else None

    def begin(self, obj):
        overlay = bpy.context.scene.synch_overlay
        self._loops = loops_of(obj)
        if not len(self._loops.lengths):
            raise SynchError(f"{obj.name} has no quads: loops are rows of quads")
        self._before = overlay.show, overlay.loop, shown_edge(obj)

    def pick(self, obj, surface, ray, is_moved):
        side = surface.side_at(*ray)
        if side is None:
            return False
        corner = obj.data.polygons[side[0]].loop_start + side[1]
        loop = self._loops.corner_loops[corner]
        if loop < 0:
            raise SynchError("no loop passes through this edge: it has no quad beside it")
        overlay = bpy.context.scene.synch_overlay
        overlay.show = overlay.loop = True
        obj.synch_loop.edge = obj.data.loops[corner].edge_index
        obj.update_tag()
        text = "A spiral of {count} quads" if self._loops.spirals[loop] else "A loop of {count} quads"
        self.report({"INFO"}, translate(text, count=self._loops.lengths[loop]))
        return True

    def take_back(self, obj):
        overlay = bpy.context.scene.synch_overlay
        overlay.show, overlay.loop, obj.synch_loop.edge = self._before


CLASSES = (SYNCH_OT_show_loop,)
