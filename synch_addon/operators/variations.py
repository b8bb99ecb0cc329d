# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators on the last solve of the active object: other configurations, defects at chosen vertices."""

import random
import time

import bpy
from bpy.props import IntProperty

from ...core.errors import SettingError
from ...core.fields.placement import with_line_ends
from ...core.settings.surface import SurfaceSettings
from .. import api
from ..blender.translations import translate
from ..jobs.report import count_text
from ..patterns import memory
from ..patterns.found_again import DrawnVariationJob, VariationsJob
from ..patterns.numbers import renew_shown
from ..settings.rna import property_of
from .field_operator import BackgroundOperator, ObjectOperator
from .picking import PickingOperator
from .ready import PromptOperator, ReadyOperator

# Numbers that the dice draw: from here on every one is the seed of another search. So many are tried.
_DRAWN, _TRIES = (100, 1_000_000), 4
# Seconds after which what a defect would cost is no longer told before the click.
_SOON = 0.3


class _SolvedOperator(ReadyOperator):
    """Mixed into operators that need a solve of the active object."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def lacking(cls, obj):
        """Why there is nothing to be done with what an object shows, or None."""
        if memory.holds(obj):
            return None
        return f"{obj.name} has no solve in memory (kept for the last {memory.MOST} objects): solve it first"


class _VaryingOperator(_SolvedOperator):
    """Mixed into operators that need a lifted field."""

    @classmethod
    def lacking(cls, obj):
        reason = super().lacking(obj)
        if reason is None and not memory.solve_of(obj).varies:
            return "only the semidefinite method finds variations, in a solve that is not ended early: solve again"
        return reason


class SYNCH_OT_variation(_VaryingOperator, PromptOperator, bpy.types.Operator):
    """Show another near-optimal configuration of defects, from the last solve. On a thumbnail's button: how much more \
energy it has than the best"""

    bl_idname = "synch.variation"
    bl_label = "Variation"

    number: IntProperty(
        name="Variation",
        description="0 is the best result and the next numbers are other good ones; high numbers need a new search",
        min=0,
    )

    def make(self, context):
        return _find_variations(api.vary(context.active_object, self.number))


class SYNCH_OT_trace_quads(_SolvedOperator, PromptOperator, bpy.types.Operator):
    """Make a new mesh of the quads that the object shows, without solving again, and hide the object"""

    bl_idname = "synch.trace_quads"
    bl_label = "Mesh of These Quads"

    smoothing: property_of(SurfaceSettings, "smoothing")

    def invoke(self, context, _event):
        self.smoothing = context.active_object.synch.smoothing
        return self.execute(context)

    def make(self, context):
        return _find_variations(api.trace_quads(context.active_object, self.smoothing))


class SYNCH_OT_draw_variation(_VaryingOperator, BackgroundOperator, bpy.types.Operator):
    """Show another field of nearly the same energy, found by a search that begins at random"""

    bl_idname = "synch.draw_variation"
    bl_label = "Draw Variation"
    bl_options = {"REGISTER", "UNDO"}

    number: IntProperty(
        name="Variation",
        description="Number of the variation that was drawn; 0 draws one at random",
        min=0,
        options={"SKIP_SAVE"},
    )

    def _job(self, context):
        numbers = [self.number] if self.number else [random.randrange(*_DRAWN) for _ in range(_TRIES)]
        return DrawnVariationJob(context.active_object, numbers)

    def _announce(self, context, report):
        self.number = report["variation"]  # the redo panel shows it
        return super()._announce(context, report)

    def _headline(self, report):
        return f"{_find_variations(report)}; {report['more']:+.1%} energy, against the best"


class SYNCH_OT_find_variations(ObjectOperator, bpy.types.Operator):
    """Solve what the object shows once more, with the settings that it was solved with: the pattern stays, and its \
variations, their pictures and placing of defects are there again"""

    bl_idname = "synch.find_variations"
    bl_label = "Find Variations Again"

    @classmethod
    def lacking(cls, obj):
        if memory.holds(obj):
            return f"the variations of {obj.name} are in memory"
        return None if obj.synch.result else f"{obj.name} has no pattern: solve stripes or quads on it first"

    def _job(self, context):
        return VariationsJob(context.active_object)

    def _headline(self, report):
        return _find_variations(report)


class SYNCH_OT_place_defect(_SolvedOperator, PickingOperator, bpy.types.Operator):
    """Click on the surface to put a line end there, where a short stripe begins; drag to move it, click again for \
more; Enter ends, Esc undoes"""

    bl_idname = "synch.place_defect"
    bl_label = "Place Defects"
    hint = "Click: place a defect   Drag: move it   Enter: done   Esc: as before"

    @classmethod
    def lacking(cls, obj):
        reason = super().lacking(obj)
        if reason is None and memory.solve_of(obj).pattern is None:
            return "defects are placed in stripes and quads: solve one of them first"
        return reason

    def begin(self, obj):
        self._before = self._onto = memory.recall(obj)
        self._vertex = self._foretold = None
        self._is_slow = False

    def pick(self, obj, surface, ray, is_moved):
        vertex = surface.vertex_at(*ray)
        if vertex is None or (is_moved and vertex == self._vertex):
            return vertex is not None
        if not is_moved:
            self._onto = memory.recall(obj)
        report = api.place_defects(obj, [vertex], renumber=False, onto=self._onto)
        self.report({"INFO"}, _find_variations(report))
        self._vertex = vertex
        return True

    def foretell(self, obj, surface, ray):
        """A line on what a defect at the pointer would cost, if that is quick to compute."""
        vertex = surface.vertex_at(*ray)
        if self._is_slow or vertex is None or vertex == self._foretold:
            return None
        self._foretold, start = vertex, time.monotonic()
        now = memory.state(obj).pattern
        try:
            then = with_line_ends(now, [vertex])
        except SettingError as error:
            return str(error)
        self._is_slow = time.monotonic() > start + _SOON
        ends = len(then.dislocations) - len(now.dislocations)
        more = then.energy / now.energy - 1 if now.energy > 0 else 0.0
        return translate("Here: {ends:+} line ends, {more:+.1%} energy", ends=ends, more=more)

    def keep(self, obj):
        renew_shown(obj)

    def take_back(self, obj):
        api.show_again(obj, self._before)


def _find_variations(report):
    return f"{report['object']}: energy {report['energy']:.4g}, {count_text(len(report['dislocations']), 'line end')}"


CLASSES = (
    SYNCH_OT_variation,
    SYNCH_OT_draw_variation,
    SYNCH_OT_find_variations,
    SYNCH_OT_place_defect,
    SYNCH_OT_trace_quads,
)
