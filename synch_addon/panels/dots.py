# SPDX-License-Identifier: GPL-3.0-or-later
"""The dots of the overlay under the mouse: a gizmo finds the one that is pointed at, says what it is, and hands a click
or a drag on to its operator."""

import blf
import bpy
import gpu
import numpy as np
from bpy_extras.view3d_utils import region_2d_to_origin_3d
from gpu_extras.batch import batch_for_shader
from mathutils import Vector

from ..blender.registration import register_all
from ..blender.translations import translate
from ..jobs.lru_cache import LruCache
from .overlay import defect_dots
from .overlay_view import distances_on_screen, key, shown_object
from .pattern_shader import draw_dots, shaders

# In pixels: how near to a dot the mouse has to be, the size of that dot, how far its words are from it.
_NEAR, _SIZE, _BESIDE = 12.0, 16.0, 14.0
_POINTS, _BOX = 11, (0.01, 0.01, 0.01, 1.0)
# A dot is seen if what is before it is nearer by less than this share of its distance.
_BEFORE = 0.01
_WORDS = {"disclination": "Swirl point {index}", "dislocation": "Line end"}

_dots = LruCache(4)


class Pointer:
    """What is pointed at or, where ``is_dragged``, dragged: a place of the region, its colour and words; ``place`` is
    None for nothing."""

    def __init__(self):
        self.place, self.colour, self.text, self.is_dragged = None, (1.0, 1.0, 1.0, 1.0), "", False

    def point(self, region, place, colour=None, text=""):
        """Point at a place of a region, and draw that again if it is another one."""
        if (place, text) != (self.place, self.text):
            self.place, self.colour, self.text = place, colour, text
            region.tag_redraw()

    def draw(self, pixel):
        """Draw a dot and its words into the region, whose pixels the matrices count."""
        batch = batch_for_shader(shaders.dots, "POINTS", {"pos": [(*self.place, 0.0)]})
        matrices = gpu.matrix.get_model_view_matrix(), gpu.matrix.get_projection_matrix()
        gpu.state.blend_set("ALPHA")
        for size, colour in ((_SIZE + 4, (1.0, 1.0, 1.0, 1.0)), (_SIZE, self.colour)):
            draw_dots(batch, colour, size * pixel, *matrices)
        gpu.state.blend_set("NONE")
        blf.size(0, _POINTS * bpy.context.preferences.system.ui_scale)
        left, below = self.place[0] + _BESIDE * pixel, self.place[1] + _BESIDE * pixel
        width, height = blf.dimensions(0, self.text)
        corners = [(left - 6, below - 7), (left + width + 6, below - 7), (left + width + 6, below + height + 6)]
        corners.append((left - 6, below + height + 6))
        plain = gpu.shader.from_builtin("UNIFORM_COLOR")
        plain.uniform_float("color", _BOX)
        batch_for_shader(plain, "TRI_FAN", {"pos": [(*corner, 0.0) for corner in corners]}).draw(plain)
        blf.color(0, 1.0, 1.0, 1.0, 1.0)
        blf.position(0, left, below, 0)
        blf.draw(0, self.text)


pointer = Pointer()


def words_of(kind, index):
    """What a defect is."""
    return translate(_WORDS[kind], index=f"{index:+.3g}")


def dot_at(context, mouse):
    """The dots of the object that is shown, and which of them is under a place of the region, or None."""
    obj = shown_object(context)
    if obj is None or "DEFECTS" not in context.scene.synch_overlay.parts:
        return None
    dots = _dots.renewed(obj.session_uid, key(obj), lambda: defect_dots(obj))
    if not len(dots.places):
        return None
    away = distances_on_screen(context, obj.matrix_world, dots.places, np.array(mouse))
    for number in np.argsort(away)[:3].tolist():
        if away[number] < _NEAR * context.preferences.system.pixel_size:
            if is_seen(context, mouse, obj.matrix_world @ Vector(dots.places[number])):
                return dots, number
    return None


def is_seen(context, mouse, place):
    """Whether no surface hides a place of the scene, which the view shows near a place of the region."""
    origin = region_2d_to_origin_3d(context.region, context.region_data, mouse)
    towards = place - origin
    hit, where, *_ = context.scene.ray_cast(context.evaluated_depsgraph_get(), origin, towards.normalized())
    return not hit or (where - origin).length > (1 - _BEFORE) * towards.length


class SYNCH_GT_dot(bpy.types.Gizmo):
    """The dot under the mouse"""

    bl_idname = "SYNCH_GT_dot"

    def test_select(self, context, location):
        mouse = tuple(map(float, location))
        found = dot_at(context, mouse)
        if found is None:
            pointer.point(context.region, None)
            return -1
        dots, number = found
        operator = self.target_set_operator("synch.drag_defect")
        operator.kind, operator.face = str(dots.kinds[number]), int(dots.faces[number])
        operator.index = float(dots.indices[number])
        place = context.region_data.perspective_matrix @ context.active_object.matrix_world
        place = place @ Vector((*dots.places[number], 1.0))
        size = context.region.width, context.region.height
        on_screen = tuple(side * (1 + seen / place.w) / 2 for side, seen in zip(size, place, strict=False))
        pointer.point(context.region, on_screen, dots.colours[number], words_of(operator.kind, operator.index))
        return 0

    def draw(self, context):
        if pointer.place is not None and (self.is_highlight or pointer.is_dragged):
            pointer.draw(context.preferences.system.pixel_size)


class SYNCH_GGT_dots(bpy.types.GizmoGroup):
    """The dots of the overlay"""

    bl_label = "Synch Dots"
    bl_space_type = "VIEW_3D"
    bl_region_type = "WINDOW"
    bl_options = {"PERSISTENT", "SHOW_MODAL_ALL"}

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT" and shown_object(context) is not None

    def setup(self, context):
        gizmo = self.gizmos.new(SYNCH_GT_dot.bl_idname)
        gizmo.target_set_operator("synch.drag_defect")
        gizmo.use_draw_modal = True


register, unregister = register_all((SYNCH_GT_dot, SYNCH_GGT_dots))
