# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that are a drag of the mouse, from the press of a button to its release: those of the tool that draws
guide strokes.

On a quad mesh they are drawn for the object that it was made of. Nothing of strokes is changed before the release: Esc
leaves no trace, and each drag is one step of undo.
"""

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d, region_2d_to_location_3d
from mathutils import Vector

from ...core.errors import SynchError
from ...core.geometry.drawn import parts, simplify_polyline, smooth_polyline
from ...core.geometry.polylines import polyline_length, resample_polyline
from ..blender.meshes import refusal
from ..blender.translations import translate
from ..panels.overlay_view import distances_on_screen
from ..panels.strokes import view
from ..patterns import guide_strokes
from ..patterns.picking import PickedSurface
from ..settings.fields import original_of
from .picking import ray_under

# In pixels: step between places that are sampled; distance of two samples at which a line is split; largest distance of
# a point that is left out, and longest segment; shortest stroke; how near to strokes the pointer has to be.
_STEP, _JUMP, _OFF, _PIECE, _SHORTEST, _NEAR = 4.0, 40.0, 1.0, 80.0, 6.0, 14.0
# Rounds of smoothing for a drawn stroke, and how far the smoothing tool reaches, in pixels.
_ROUNDS, _REACH = 4, 60.0
# A point is on the surface if it is behind it by less than this share of its distance.
_BEHIND = 0.02


class StrokeOperator:
    """A drag of the mouse, as a mixin of operators.

    Subclasses have ``move``, called for each sample of the drag, and ``finish``, called at its end, which returns a
    line that says what was done, or None for nothing. ``take_back`` is called where Esc ends it, with the object, or
    None where that is gone.
    """

    bl_options = {"UNDO", "INTERNAL"}

    @classmethod
    def poll(cls, context):
        reason = refusal(context.active_object)
        if reason is None and context.mode != "OBJECT":
            reason = "leave the present mode: strokes are drawn in object mode"
        if reason:
            cls.poll_message_set(reason)
        return reason is None

    def invoke(self, context, event):
        if context.region is None or context.region.type != "WINDOW":
            self.report({"ERROR"}, "strokes are drawn in a 3D view: drag in one")
            return {"CANCELLED"}
        obj = context.active_object
        try:
            self._surface = PickedSurface.of(obj)
        except SynchError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._object_name, self._last = obj.name, None
        view.rest()
        self._step(context, event, obj)
        context.window_manager.modal_handler_add(self)
        context.workspace.status_text_set(translate("Release the button: done   Esc: as before"))
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        obj = bpy.data.objects.get(self._object_name)
        if obj is None or event.type in {"ESC", "RIGHTMOUSE"}:
            self.take_back(obj)
            return self._end(context, {"CANCELLED"})
        if event.type in {"MOUSEMOVE", "INBETWEEN_MOUSEMOVE"}:
            self._step(context, event, obj)
        if event.type == "LEFTMOUSE" and event.value == "RELEASE":
            self._step(context, event, obj)
            line = self.finish(context, obj)
            if line is not None:
                self.report({"INFO"}, line)
            return self._end(context, {"CANCELLED"} if line is None else {"FINISHED"})
        return {"RUNNING_MODAL"}

    def take_back(self, obj):
        """Nothing is changed before the end, by default."""

    def cancel(self, context):
        """Show the normal status bar again."""
        view.rest()
        context.workspace.status_text_set(None)

    def _end(self, context, result):
        self.cancel(context)
        context.area.tag_redraw()
        return result

    def _step(self, context, event, obj):
        """Go on to where the pointer is now, in small steps."""
        here = np.array([event.mouse_region_x, event.mouse_region_y], float)
        before = here if self._last is None else self._last
        count = max(int(np.ceil(np.linalg.norm(here - before) / _STEP)), 1)
        for share in np.arange(1, count + 1) / count:
            self.move(context, before + share * (here - before), obj)
        self._last = here
        context.area.tag_redraw()

    def _near(self, context, obj, mouse):
        """Visible strokes near the pointer, each with its points and their (p,) distances from it in pixels."""
        near = []
        for stroke in guide_strokes.strokes_of(original_of(obj)):
            line = view.changed.get(stroke.key, stroke.points)
            if line is None:
                continue
            away = distances_on_screen(context, obj.matrix_world, line, mouse)
            nearest = int(away.argmin())
            if away[nearest] < _NEAR and self._is_seen(context, obj, line[nearest]):
                near.append((stroke, line, away))
        return near

    def _is_seen(self, context, obj, point):
        """Whether the surface does not hide a point of the object's space."""
        pixel = location_3d_to_region_2d(context.region, context.region_data, obj.matrix_world @ Vector(point))
        if pixel is None:
            return False
        origin, towards = ray_under(context, pixel, obj)
        found = self._surface.place_at(origin, towards)
        distance = np.linalg.norm(point - np.array(origin))
        return found is None or np.linalg.norm(found[0] - np.array(origin)) > (1 - _BEHIND) * distance


class SYNCH_OT_draw_stroke(StrokeOperator, bpy.types.Operator):
    """Draw a stroke on the surface that stripes follow"""

    bl_idname = "synch.draw_stroke"
    bl_label = "Draw Stroke"

    def invoke(self, context, event):
        self._places, self._pixels = [], []
        return super().invoke(context, event)

    def move(self, context, mouse, obj):
        found = self._surface.place_at(*ray_under(context, mouse, obj))
        if found is None:
            return
        self._places.append(found[1])
        self._pixels.append(pixel_size(context, obj.matrix_world, mouse, found[0]))
        view.path = np.array(self._places)

    def finish(self, context, obj):
        if not self._places:
            return None
        pixel = float(np.median(self._pixels))
        lines = [
            smooth_polyline(part, _ROUNDS) for part in parts(np.array(self._places), _JUMP * np.array(self._pixels[1:]))
        ]
        lines = [line for line in lines if polyline_length(line) > _SHORTEST * pixel]
        lines = [line[simplify_polyline(line, _OFF * pixel, _PIECE * pixel)] for line in lines]
        if not lines:
            return None
        strokes = context.scene.synch_strokes
        guide_strokes.add(original_of(obj), lines, strokes.wish, strokes.weight)
        return _count(obj)


class SYNCH_OT_erase_strokes(StrokeOperator, bpy.types.Operator):
    """Remove the strokes that the pointer passes over"""

    bl_idname = "synch.erase_strokes"
    bl_label = "Erase Strokes"

    def move(self, context, mouse, obj):
        view.changed |= {stroke.key: None for stroke, _, _ in self._near(context, obj, mouse)}

    def finish(self, context, obj):
        if not view.changed:
            return None
        guide_strokes.remove(original_of(obj), list(view.changed))
        return _count(obj)


class SYNCH_OT_smooth_strokes(StrokeOperator, bpy.types.Operator):
    """Smooth strokes where the pointer passes over them"""

    bl_idname = "synch.smooth_strokes"
    bl_label = "Smooth Strokes"

    def move(self, context, mouse, obj):
        for stroke, line, away in self._near(context, obj, mouse):
            if stroke.key not in view.changed:
                nearest = line[away.argmin()]
                line = resample_polyline(line, _STEP * pixel_size(context, obj.matrix_world, mouse, nearest))
                away = distances_on_screen(context, obj.matrix_world, line, mouse)
            view.changed[stroke.key] = smooth_polyline(line, 1, np.clip(1 - away / _REACH, 0, 1))

    def finish(self, context, obj):
        if not view.changed:
            return None
        lines = {}
        for key, line in view.changed.items():
            line = self._surface.nearest(line)
            pixel = pixel_size(context, obj.matrix_world, self._last, line[len(line) // 2])
            lines[key] = line[simplify_polyline(line, _OFF * pixel, _PIECE * pixel)]
        guide_strokes.replace(original_of(obj), lines)
        return translate("{count} strokes smoothed", count=len(lines))


def _count(obj):
    return translate("{count} strokes on {name}", count=len(guide_strokes.strokes_of(original_of(obj))), name=obj.name)


def pixel_size(context, matrix, mouse, place):
    """Length of a pixel in an object's space, at the depth of a place there."""
    depth = matrix @ Vector(place)
    ends = [region_2d_to_location_3d(context.region, context.region_data, mouse + way, depth) for way in np.eye(2)]
    middle = region_2d_to_location_3d(context.region, context.region_data, mouse, depth)
    inverse = matrix.inverted().to_3x3()
    return float(np.mean([(inverse @ (end - middle)).length for end in ends]))


CLASSES = (SYNCH_OT_draw_stroke, SYNCH_OT_erase_strokes, SYNCH_OT_smooth_strokes)
