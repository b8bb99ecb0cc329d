# SPDX-License-Identifier: GPL-3.0-or-later
"""What a click on a dot of the overlay and a drag of it do: select its empty, or move the defect."""

import time

import bpy
from bpy.props import FloatProperty, IntProperty, StringProperty

from ...core.errors import SettingError, SynchError
from ...core.fields.mirror import mirrored_moves
from ...core.settings.pins import parse_pins, text_of_pins
from ...core.settings.surface import SYMMETRY_ORDERS
from .. import api
from ..blender import meshes
from ..blender.defect_empties import COLORS, defect_empties
from ..blender.pattern_surface import faces_of_object
from ..blender.translations import operator_error, translate
from ..panels.dots import pointer, words_of
from ..panels.overlay import defect_dots
from ..patterns import memory
from ..patterns.numbers import renew_shown
from .picking import ray_under
from .ready import ReadyOperator
from .strokes import StrokeOperator

# Pixels up to which a drag is a click, and seconds after which a line end moves only when it is let go.
_CLICK, _SOON = 4.0, 0.4


class SYNCH_OT_drag_defect(ReadyOperator, StrokeOperator, bpy.types.Operator):
    """Click: select. Drag: move it to another face; a swirl point is pinned there, all others stay, and the field is \
solved again"""

    bl_idname = "synch.drag_defect"
    bl_label = "Drag Defect"

    kind: StringProperty(description="disclination or dislocation", options={"SKIP_SAVE"})
    face: IntProperty(description="Face that it lies in", options={"SKIP_SAVE"})
    index: FloatProperty(description="How often directions turn, or stripes that begin", options={"SKIP_SAVE"})

    @classmethod
    def lacking(cls, obj):
        if not memory.holds(obj):
            return f"{obj.name} has no solve in memory: solve it again, then defects can be moved"
        return None

    def invoke(self, context, event):
        self._start = event.mouse_region_x, event.mouse_region_y
        self._is_moved = self._is_slow = False  # until the pointer leaves the dot; once a preview has taken too long
        self._target = self.face  # under the pointer
        self._written = self.face  # in which the shown pattern has the defect
        self._onto = None  # the solve that the drag began with
        self._line = ""  # beside the pointer: the change of energy, or an error
        return super().invoke(context, event)

    def move(self, context, mouse, obj):
        away = max(abs(mouse[0] - self._start[0]), abs(mouse[1] - self._start[1]))
        self._is_moved |= away > _CLICK * context.preferences.system.pixel_size
        if not self._is_moved:
            return
        face = self._surface.face_at(*ray_under(context, mouse, obj))
        if face is not None:
            self._target = face

    def _step(self, context, event, obj):
        super()._step(context, event, obj)
        if not self._is_moved:
            return
        if self.kind == "dislocation" and not self._is_slow:
            self._move_line_end(obj)
        colour = COLORS[self.kind][int(self.index < 0)]
        pointer.is_dragged = True
        pointer.point(context.region, tuple(self._last), colour, self._line or words_of(self.kind, self.index))

    def _move_line_end(self, obj):
        """Show the pattern with the line end where the pointer is."""
        if self._target == self._written:
            return
        start = time.monotonic()
        self._onto = memory.recall(obj) if self._onto is None else self._onto
        try:
            if self._target == self.face:
                api.show_again(obj, self._onto)
                self._line = ""
            else:
                before = self._onto.plain["energy"]
                report = api.move_defect(obj, self.face, self._target, renumber=False, onto=self._onto)
                more = report["energy"] / before - 1 if before > 0 else 0.0
                self._line = translate("{more:+.1%} energy", more=more)
            self._written = self._target
        except SynchError as error:
            self._line = str(error)
        self._is_slow = time.monotonic() > start + _SOON

    def cancel(self, context):
        super().cancel(context)
        pointer.place, pointer.is_dragged = None, False

    def take_back(self, obj):
        if obj is not None and self._written != self.face:
            api.show_again(obj, self._onto)

    def finish(self, context, obj):
        """After a click select the defect, after a drag move it; returns the line for the status bar, None if nothing
        has changed."""
        if not self._is_moved:
            return self._select(context, obj)
        if self.kind == "disclination":
            return None if self._target == self.face else self._pin(context, obj)
        self._move_line_end(obj)
        if self._written == self.face:
            if self._line:
                self.report({"WARNING"}, self._line)
            return None
        renew_shown(obj)
        return f"{obj.name}: {words_of(self.kind, self.index)}, {self._line}"

    def _select(self, context, obj):
        """Select the face of the defect, and its empty in place of the object if that is shown."""
        asked = self.kind, self.face
        empties = [empty for empty in defect_empties(obj) if (empty["synch_kind"], empty["synch_face"]) == asked]
        shown = [empty for empty in empties if empty.visible_get()]
        for other in context.selected_objects:
            other.select_set(other == obj and not shown)
        for empty in shown:
            empty.select_set(True)
        try:
            with meshes.object_mode(obj):
                meshes.select_faces(obj, faces_of_object(obj, [self.face]))
        except SynchError:  # modifiers have made the face
            pass
        return translate(
            "{name}: {what} in face {face}", name=obj.name, what=words_of(self.kind, self.index), face=self.face
        )

    def _pin(self, context, obj):
        """Pin all swirl points where they are, but this one and its mirror images where it was let go, and solve
        again."""
        request, dots, before = memory.solve_of(obj).request, defect_dots(obj), obj.synch.pins
        order = SYMMETRY_ORDERS[request.settings.symmetry]
        swirls = dots.kinds == "disclination"
        pins = dict(zip(dots.faces[swirls].tolist(), (order * dots.indices[swirls]).round().astype(int), strict=True))
        try:
            moves = mirrored_moves(request.mirrors, request.given.polygons, self.face, self._target)
        except SettingError as error:
            self.report({"WARNING"}, str(error))
            return None
        moved = {end: pins.pop(start) for start, end in moves.items() if start in pins}
        if pins.keys() & moved.keys():
            self.report({"WARNING"}, translate("There is another swirl point: choose another face"))
            return None
        unturned = {face: 0 for face, own in parse_pins(before).items() if own == 0}
        obj.synch.pins = text_of_pins(unturned | pins | moved)
        try:
            if not context.window_manager.synch_live:
                with context.temp_override(active_object=obj, object=obj, selected_objects=[obj]):
                    getattr(bpy.ops.synch, request.command)("INVOKE_DEFAULT")
        except RuntimeError as error:
            obj.synch.pins = before
            self.report({"ERROR"}, operator_error(error))
            return None
        return translate("{name}: {count} swirl points are pinned", name=obj.name, count=len(pins) + len(moved))


CLASSES = (SYNCH_OT_drag_defect,)
