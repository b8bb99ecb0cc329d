# SPDX-License-Identifier: GPL-3.0-or-later
"""The tool that draws guide strokes: its place in the toolbar, and how strokes are shown meanwhile."""

from functools import partial

import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

from ..blender.registration import Registration
from ..jobs.lru_cache import LruCache
from ..patterns.guide_strokes import state_of, strokes_of
from ..settings.fields import original_of
from .guides import TOOL, is_drawing
from .overlay import WISH_COLORS
from .overlay_view import nearer

# In pixels; what is hidden by the surface is shown this strongly.
_WIDTH, _HIDDEN = 4.0, 0.15
# Strokes are chords of the surface, which bulges over them: they are drawn nearer by this share of their distance.
_NEARER = 8e-3

_read = LruCache(8)


class SynchStrokesTool(bpy.types.WorkSpaceTool):
    bl_space_type = "VIEW_3D"
    bl_context_mode = "OBJECT"
    bl_idname = TOOL
    bl_label = "Guide Strokes"
    bl_description = "Draw strokes on the active mesh that stripes follow; Ctrl erases, Shift smooths"
    bl_icon = "ops.curve.draw"
    bl_cursor = "PAINT_CROSS"
    bl_keymap = (
        ("synch.draw_stroke", {"type": "LEFTMOUSE", "value": "PRESS"}, None),
        ("synch.erase_strokes", {"type": "LEFTMOUSE", "value": "PRESS", "ctrl": True}, None),
        ("synch.smooth_strokes", {"type": "LEFTMOUSE", "value": "PRESS", "shift": True}, None),
    )

    @staticmethod
    def draw_settings(context, layout, tool):
        strokes = context.scene.synch_strokes
        layout.row().prop(strokes, "wish", expand=True)
        layout.prop(strokes, "soft")
        row = layout.row()
        row.active = strokes.soft
        row.prop(strokes, "strength")


class _View:
    """Draws the strokes of the active object while the tool is chosen.

    Attributes
    ----------
    path : (p, 3) of the stroke that is being drawn, in the object's space
    changed : (p, 3) of strokes that are being changed, by their keys; None for those that are being erased
    """

    def __init__(self):
        self._handler = None
        self.rest()

    def rest(self):
        """Nothing is drawn or changed any more."""
        self.path, self.changed = np.empty((0, 3)), {}

    def register(self):
        """Begin to draw."""
        self._handler = bpy.types.SpaceView3D.draw_handler_add(self._draw, (), "WINDOW", "POST_VIEW")

    def unregister(self):
        """Draw no longer."""
        bpy.types.SpaceView3D.draw_handler_remove(self._handler, "WINDOW")

    def lines_of(self, obj):
        """[(points, colour)] of the strokes as they are now, of a quad mesh its source's: (p, 3) in its space."""
        owner = original_of(obj)
        strokes = _read.renewed(owner.session_uid, state_of(owner), lambda: strokes_of(owner))
        lines = [(self.changed.get(s.key, s.points), WISH_COLORS[s.wish]) for s in strokes]
        lines.append((self.path, WISH_COLORS[bpy.context.scene.synch_strokes.wish]))
        return [(points, colour) for points, colour in lines if points is not None and len(points) > 1]

    def _draw(self):
        context, obj = bpy.context, bpy.context.active_object
        if obj is None or obj.type != "MESH" or obj.mode != "OBJECT" or not is_drawing(context):
            return
        if not obj.visible_get(view_layer=context.view_layer, viewport=context.space_data):
            return
        region = context.region_data
        draw_lines(
            self.lines_of(obj),
            nearer(region, _NEARER) @ region.view_matrix @ obj.matrix_world,
            context.preferences.system.pixel_size,
        )


def draw_lines(lines, view, pixel):
    """Draw lines into the active framebuffer, faint where something is nearer.

    Parameters
    ----------
    lines : as of :meth:`_View.lines_of`
    view : matrix from their space to that of the view
    pixel : the width of lines of width 1
    """
    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    gpu.state.blend_set("ALPHA")
    with gpu.matrix.push_pop():
        gpu.matrix.load_matrix(view)
        for points, colour in lines:
            batch = batch_for_shader(shader, "LINE_STRIP", {"pos": np.ascontiguousarray(points, np.float32)})
            shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
            shader.uniform_float("lineWidth", _WIDTH * pixel)
            for test, strength in (("NONE", _HIDDEN), ("LESS_EQUAL", 1.0)):
                gpu.state.depth_test_set(test)
                shader.uniform_float("color", (*colour[:3], strength * colour[3]))
                batch.draw(shader)
    gpu.state.depth_test_set("NONE")
    gpu.state.blend_set("NONE")


view = _View()
_registration = Registration(
    (
        partial(bpy.utils.register_tool, SynchStrokesTool, separator=True),
        partial(bpy.utils.unregister_tool, SynchStrokesTool),
    ),
    (view.register, view.unregister),
)
register, unregister = _registration.register, _registration.unregister
