# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that wait for clicks on the active object in a 3D view."""

import bpy
from bpy_extras.view3d_utils import region_2d_to_origin_3d, region_2d_to_vector_3d

from ...core.errors import SynchError
from ..blender import meshes
from ..blender.translations import translate
from ..patterns.picking import PickedSurface
from .field_operator import navigates, over_sidebar
from .ready import ReadyOperator


class PickingOperator(ReadyOperator):
    """Clicks on the surface, as a mixin of operators.

    ``hint`` is shown in the status bar meanwhile. ``begin`` stores the state of the object. ``pick`` acts at a ray and
    returns whether it did: once after each click, and again in place of the last time while the mouse drags.
    ``let_go`` is called when the button is released, ``foretell`` when the mouse moves; both return a line for the
    status bar, None to keep the present one. ``keep`` ends with the changes, ``take_back`` without.
    """

    hint = ""

    def begin(self, obj):
        raise NotImplementedError

    def pick(self, obj, surface, ray, is_moved):
        raise NotImplementedError

    def let_go(self, obj):
        """Nothing is to be said by default."""
        return ""

    def foretell(self, obj, surface, ray):
        """Nothing is to be said by default."""

    def keep(self, obj):
        """Nothing more is to be done by default."""

    def take_back(self, obj):
        raise NotImplementedError

    def invoke(self, context, _event):
        if context.region is None or context.region.type != "WINDOW":
            self.report({"ERROR"}, "this is done by clicks in a 3D view: run it with the mouse over one")
            return {"CANCELLED"}
        obj = context.active_object
        try:
            with meshes.object_mode(obj):
                self.begin(obj)
                self._surface = PickedSurface.of(obj)
        except SynchError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._object_name = obj.name
        self._picked = self._held = False
        context.window_manager.modal_handler_add(self)
        context.workspace.status_text_set(translate(self.hint))
        context.window.cursor_modal_set("CROSSHAIR")
        context.area.tag_redraw()
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        try:
            result = self._step(context, event)
        except SynchError as error:
            self.report({"ERROR"}, str(error))
            result = {"FINISHED"} if self._picked else {"CANCELLED"}
        except Exception:
            self.cancel(context)
            raise
        if result & {"FINISHED", "CANCELLED"}:
            self.cancel(context)
        return result

    def cancel(self, context):
        """However it ends: give the status bar and the pointer back."""
        context.workspace.status_text_set(None)
        context.window.cursor_modal_restore()

    def _step(self, context, event):
        obj = bpy.data.objects.get(self._object_name)
        if obj is None:
            raise SynchError(f"the object {self._object_name} is gone: nothing more can be done on it")
        if event.type in {"RET", "NUMPAD_ENTER", "RIGHTMOUSE"} and event.value == "PRESS":
            if not self._picked:
                return {"CANCELLED"}
            self.keep(obj)
            return {"FINISHED"}
        if event.type == "ESC":
            if self._picked:
                self.take_back(obj)
                context.area.tag_redraw()
            return {"CANCELLED"}
        if event.type == "LEFTMOUSE":
            if self._held and event.value == "RELEASE":
                self._say(context, self.let_go(obj))
            pressed = event.value == "PRESS" and not over_sidebar(context, event)
            self._held = pressed and self._pick(context, event, obj, False)
            return {"RUNNING_MODAL"}
        if event.type == "MOUSEMOVE" and self._held:
            self._pick(context, event, obj, True)
        elif event.type == "MOUSEMOVE" and not over_sidebar(context, event):
            ray = ray_under(context, (event.mouse_region_x, event.mouse_region_y), obj)
            line = self.foretell(obj, self._surface, ray)
            if line is not None:
                self._say(context, line)
        return {"PASS_THROUGH"} if navigates(event) else {"RUNNING_MODAL"}

    def _say(self, context, line):
        context.workspace.status_text_set("   ".join(filter(None, (line, translate(self.hint)))))

    def _pick(self, context, event, obj, is_moved):
        """Pick, and report a refusal in one line; the scene then stays as it was."""
        ray = ray_under(context, (event.mouse_region_x, event.mouse_region_y), obj)
        try:
            done = self.pick(obj, self._surface, ray, is_moved)
        except SynchError as error:
            self.report({"ERROR"}, str(error))
            return False
        self._picked |= done
        context.area.tag_redraw()
        return done


def ray_under(context, mouse, obj):
    """Origin and direction of what is under a pixel of the region, in an object's space."""
    origin = region_2d_to_origin_3d(context.region, context.region_data, mouse)
    towards = region_2d_to_vector_3d(context.region, context.region_data, mouse)
    inverse = obj.matrix_world.inverted()
    return inverse @ origin, inverse.to_3x3() @ towards
