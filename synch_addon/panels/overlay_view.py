# SPDX-License-Identifier: GPL-3.0-or-later
"""The overlay of the active object in the 3D View: its switch, its panel and its drawing.

Nothing here solves or changes anything. A part is computed when it is first drawn, and again when the mesh
or a setting that it depends on has changed.
"""

from functools import lru_cache

import bpy
import gpu
import numpy as np
from bpy.props import BoolProperty, EnumProperty, IntProperty
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix, Vector

from ..blender.changes import changes
from ..blender.pattern_surface import surface_of
from ..blender.registration import register_all
from ..blender.schema import LAYER
from ..jobs.kept_results import read_result_or_empty
from ..jobs.lru_cache import LruCache
from ..jobs.queue import queue
from ..patterns.loops import shown_edge
from .overlay import (
    constraint_lines,
    defect_points,
    direction_lines,
    direction_marks,
    layer_faces,
    loop_faces,
    painted_weights,
    pin_points,
    spacing_errors,
    sphere_faces,
)
from .pattern_shader import draw_dots, shaders
from .setting_rows import property_column
from .sidebar import SidebarPanel

# Everything is drawn nearer by this share of its distance, so that it does not fight with the faces.
NEARER = 2e-3
# In pixels.
LINE_WIDTHS = {"MARKS": 1.5, "STREAMLINES": 1.5, "CONSTRAINTS": 3.0}
POINT_SIZES = {"PINS": 18.0, "DEFECTS": 10.0}
# Dots of defects get smaller where lines are near to one another on the screen: share of their distance, and pixels.
_DOT_SHARE, _SMALLEST_DOT = 0.6, 4.0
_SHADERS = {"TRIS": "SMOOTH_COLOR", "LINES": "POLYLINE_UNIFORM_COLOR"}

# In the order of drawing.
_PARTS = {
    "LAYERS": layer_faces,
    "SPHERE": sphere_faces,
    "WEIGHTS": painted_weights,
    "SPACING": spacing_errors,
    "LOOP": loop_faces,
    "MARKS": direction_marks,
    "STREAMLINES": direction_lines,
    "CONSTRAINTS": constraint_lines,
    "PINS": pin_points,
    "DEFECTS": defect_points,
}

# Of the last four objects that were drawn.
_layers = LruCache(4 * len(_PARTS))


class SynchOverlay(bpy.types.PropertyGroup):
    """What is shown in a scene."""

    show: BoolProperty(name="Overlay", description="Draw the field of the active object over it")
    defects: BoolProperty(
        name="Dots",
        description="Draw swirl points and line ends of the active object as dots. Click one to select its face, drag "
        "it to move it",
        default=True,
    )
    pattern: BoolProperty(
        name="Solid", description="Draw patterns in Solid view too, which shows no materials by itself", default=True
    )
    directions: EnumProperty(
        name="Directions",
        description="How directions are drawn",
        items=[
            ("NONE", "None", "Do not draw directions"),
            ("MARKS", "Marks", "A line, cross or arrow at the vertices"),
            ("STREAMLINES", "Streamlines", "Lines that follow the directions"),
        ],
        default="MARKS",
    )
    constraints: BoolProperty(
        name="Constraints",
        description="Edges of the constraint list, coloured by the kind of constraint, and pinned faces",
        default=True,
    )
    spacing: BoolProperty(
        name="Spacing Error",
        description="Faces in colours: red where lines are further apart than asked, blue where they are nearer, white "
        "where they are as asked; full from one and a half times on",
    )
    loop: BoolProperty(name="Loop", description="The loop of quads that was last clicked on, spirals in another colour")

    @property
    def parts(self):
        """Names of the parts to draw."""
        chosen = {"DEFECTS"} if self.defects else set()
        if self.show:
            chosen |= {self.directions, "PINS" if self.constraints else ""}
            chosen |= {part for part in ("CONSTRAINTS", "SPACING", "LOOP") if getattr(self, part.lower())}
        return [part for part in _PARTS if part in chosen]


class SynchLoop(bpy.types.PropertyGroup):
    """The loop of quads of an object that is shown."""

    edge: IntProperty(min=-1, default=-1, description="An edge that the loop passes through; -1 for none")


class SYNCH_PT_overlay(SidebarPanel, bpy.types.Panel):
    """What is drawn over the active object"""

    bl_label = "Overlay"
    bl_parent_id = "SYNCH_PT_result"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 2

    def draw_header(self, context):
        self.layout.prop(context.scene.synch_overlay, "show", text="")

    def draw(self, context):
        overlay = context.scene.synch_overlay
        column = property_column(self.layout)
        column.active = overlay.show
        column.prop(overlay, "directions")
        column.prop(overlay, "constraints")
        column.prop(overlay, "spacing")
        row = column.row(align=True)
        row.prop(overlay, "loop")
        row.operator("synch.show_loop", text="", icon="EYEDROPPER")


def shown_object(context):
    """The object whose field is drawn in the view of a context, or None."""
    obj, space = context.active_object, context.space_data
    if not context.scene.synch_overlay.parts or not space.overlay.show_overlays:
        return None
    if obj is None or obj.type != "MESH" or obj.mode == "EDIT":  # in edit mode the attributes are not there
        return None
    running = queue.running
    if running is not None and running.picture is not None and running.obj == obj:  # that is drawn in its place
        return None
    return obj if obj.visible_get(view_layer=context.view_layer, viewport=space) else None


def key(obj):
    """A value that stays equal while the drawn parts of an object need not be computed again."""
    linear = np.array(obj.matrix_world.to_3x3())
    scale = linear.T @ linear
    proportions = (scale / max(np.trace(scale), np.finfo(float).tiny)).round(3) + 0.0
    rows = tuple((row.where, row.what, row.vertex_group, row.enabled) for row in obj.synch.constraints)
    painted = obj.mode == "WEIGHT_PAINT" and obj.vertex_groups.active_index
    settings = (
        painted,
        obj.synch.symmetry,
        obj.synch.boundary,
        obj.synch.vertex_group,
        rows,
        shown_edge(obj),
        obj.synch.pins,
    )
    # Layers are drawn as modifiers leave them, and dots on the shape that they show.
    is_shaped = LAYER.name in obj.data.attributes or obj.data.shape_keys or len(obj.modifiers)
    shape = changes.state(obj) if is_shaped else None
    return changes.state(obj.data), changes.state(surface_of(obj).data), shape, proportions.tobytes(), *settings


def layers(obj, part):
    """[(batch, kind, colour)] of a part of an object, kept as long as its key is the same.

    The colours of triangles are in their batch.
    """

    def make():
        return [_layer(points, colour) for points, colour in _PARTS[part](obj)]

    return _layers.renewed((obj.session_uid, part), key(obj), make)


def _layer(points, colour):
    kind = "TRIS" if np.ndim(colour) > 1 else "LINES" if points.ndim == 3 else "POINTS"
    values = {"pos": np.ascontiguousarray(points, np.float32).reshape(-1, 3)}
    if kind == "TRIS":
        values["color"] = np.broadcast_to(np.reshape(np.float32(colour), (len(points), -1, 4)), (len(points), 3, 4))
        values["color"] = values["color"].reshape(-1, 4)
    return batch_for_shader(shaders.dots if kind == "POINTS" else _shader(kind), kind, values), kind, colour


def _shader(kind):
    return gpu.shader.from_builtin(_SHADERS[kind])


def distances_on_screen(context, matrix, points, mouse):
    """(p,) pixels from a place of the region to (p, 3) points of an object's space; infinite behind the viewer."""
    seen = np.column_stack([points, np.ones(len(points))]) @ np.array(context.region_data.perspective_matrix @ matrix).T
    ahead = seen[:, 3] > 0
    size = np.array([context.region.width, context.region.height]) / 2
    pixels = size * (1 + seen[:, :2] / np.where(ahead, seen[:, 3], 1)[:, None])
    return np.where(ahead, np.linalg.norm(pixels - mouse, axis=1), np.inf)


def nearer(view, share=NEARER):
    """The transform of view space that brings everything nearer by a share of its distance without moving it on the
    screen."""
    if view.is_perspective:
        return Matrix.Diagonal((1 - share, 1 - share, 1 - share, 1))
    return Matrix.Translation((0, 0, share * view.view_distance))


def draw_object(obj, parts, view_matrix, pixel=1.0):
    """Draw parts of an object into the active framebuffer, hidden by what is nearer."""
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_test_set("LESS_EQUAL")
    with gpu.matrix.push_pop():
        gpu.matrix.load_matrix(view_matrix @ obj.matrix_world)
        for part in parts:
            for batch, kind, colour in layers(obj, part):
                if kind == "POINTS":
                    projection = gpu.matrix.get_projection_matrix()
                    size = POINT_SIZES[part] * pixel
                    if part == "DEFECTS":
                        lines = _pixels_between_lines(obj, projection @ view_matrix, projection[1][1])
                        size = min(size, max(_DOT_SHARE * lines, _SMALLEST_DOT * pixel))
                    draw_dots(batch, colour, size, view_matrix @ obj.matrix_world, projection)
                    continue
                shader = _shader(kind)
                if kind == "LINES":
                    shader.uniform_float("color", colour)
                    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
                    shader.uniform_float("lineWidth", LINE_WIDTHS[part] * pixel)
                batch.draw(shader)
    gpu.state.depth_test_set("NONE")
    gpu.state.blend_set("NONE")


def _pixels_between_lines(obj, perspective, scale):
    """Pixels from one line of an object's pattern to the next, in the middle of its box; infinite where that is behind
    the viewer, or nothing is known of lines.

    ``perspective`` leads from the scene to the screen, and ``scale`` is how it enlarges heights.
    """
    spacing = _kept_spacing(obj.synch.result)
    middle = obj.matrix_world @ (sum((Vector(corner) for corner in obj.bound_box), Vector()) / 8)
    depth = (perspective @ Vector((*middle, 1.0))).w
    if not spacing or depth <= 0:
        return np.inf
    return spacing * scale * gpu.state.viewport_get()[3] / (2 * depth)


@lru_cache(maxsize=16)
def _kept_spacing(line):
    """The spacing of the pattern that the line of a result is of, None without one."""
    result = read_result_or_empty(line)
    return None if result.get("command") == "directions" else (result.get("settings") or {}).get("spacing")


_register, _unregister = register_all(
    (SynchOverlay, SynchLoop, SYNCH_PT_overlay),
    (bpy.types.Scene, "synch_overlay", SynchOverlay),
    (bpy.types.Object, "synch_loop", SynchLoop),
)


class _View:
    """Draws the overlay of the active object in all 3D views."""

    def __init__(self):
        self._handler = None

    def register(self):
        """Register the settings and begin to draw."""
        _register()
        self._handler = bpy.types.SpaceView3D.draw_handler_add(self._draw, (), "WINDOW", "POST_VIEW")

    def unregister(self):
        """Draw no longer."""
        bpy.types.SpaceView3D.draw_handler_remove(self._handler, "WINDOW")
        _unregister()

    def _draw(self):
        context = bpy.context
        obj = shown_object(context)
        if obj is not None:
            pixel = context.preferences.system.pixel_size
            view = context.region_data
            draw_object(obj, context.scene.synch_overlay.parts, nearer(view) @ view.view_matrix, pixel)


view = _View()
register, unregister = view.register, view.unregister
