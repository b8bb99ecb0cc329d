# SPDX-License-Identifier: GPL-3.0-or-later
"""Patterns in views that draw no materials: in Solid view, drawn over the surface in the colours of the look.

Nothing of the scene is changed for it, and it goes as soon as a view draws materials by itself.
"""

import bpy
import numpy as np

from ...core.extract.pictures.drawn_phases import DrawnTriangles
from ..blender import attributes, meshes
from ..blender.changes import changes
from ..blender.pattern_surface import surface_of
from ..blender.phases import pattern_kind, read_phases
from ..blender.schema import COLOR, LAYER
from ..jobs.lru_cache import LruCache
from ..jobs.queue import queue
from .look import look_of
from .overlay_view import draw_object, nearer
from .pattern_shader import DrawnPattern, shaders

# Where a map is painted: share of the area that lines fill, their colour, which is seen on all weights, and the share
# of its distance by which the map is drawn nearer, so that a surface that bulges over the mesh does not hide it.
_PAINTED, _ON_WEIGHTS, _NEARER = 0.15, (1.0, 1.0, 1.0, 1.0), 8e-3
# What is kept on the graphics card, of the objects that were drawn last, and the triangles that it was made of.
_drawn, _triangles = LruCache(64), LruCache(64)


def corners_of(obj):
    """Triangles (:class:`DrawnTriangles`) and phases of the pattern that a mesh object shows, in the object's space,
    and whether it is a pattern of quads; None where there is no pattern.

    Where only places have changed since the last time, its triangles and phases are those of then.

    Parameters
    ----------
    obj : bpy.types.Object, also an evaluated one, as modifiers leave it
    """
    kind = pattern_kind(obj)
    if kind is None or not len(obj.data.polygons):
        return None
    phases, polygons = read_phases(obj, kind), meshes.read_polygons(obj)
    state = [array for part in (*phases, polygons) for array in vars(part).values() if isinstance(array, np.ndarray)]
    kept = _triangles.get(obj.session_uid)
    if kept is None or not _are_equal(kept[0], state):
        kept = state, DrawnTriangles.of(phases, polygons)
        _triangles.put(obj.session_uid, kept)
    places = attributes.read_values(obj, "position", "POINT").astype(float)
    return kept[1].places(places), kept[1].phases, kind == "quads"


def _are_equal(first, second):
    return len(first) == len(second) and all(map(np.array_equal, first, second))


def shows(context):
    """Whether patterns are drawn in the view of a context."""
    space = context.space_data
    solid = space.shading.type == "SOLID" and not space.shading.show_xray
    return solid and space.overlay.show_overlays and context.scene.synch_overlay.pattern


def shown_objects(context):
    """The objects whose patterns are drawn in the view of a context."""
    running = queue.running
    for obj in context.visible_objects:
        if obj.type != "MESH" or obj.mode == "EDIT" or obj.display_type not in {"SOLID", "TEXTURED"}:
            continue
        hidden = running is not None and running.picture is not None and running.obj == obj
        if not hidden and pattern_kind(obj) is not None:
            yield obj


def layer_objects(context):
    """The objects of layers and tubes that are drawn in the view of a context."""
    for obj in context.visible_objects:
        if obj.type == "MESH" and obj.mode != "EDIT" and {LAYER.name, COLOR.name} & set(obj.data.attributes.keys()):
            yield obj


def drawn_pattern(obj, depsgraph):
    """The :class:`DrawnPattern` of an object as its modifiers leave it, kept until it changes; None without one."""

    def make():
        found = corners_of(obj.evaluated_get(depsgraph))
        return None if found is None else DrawnPattern(*found[:2], of_quads=found[2])

    return _drawn.renewed(
        obj.session_uid, (changes.state(obj.data), changes.state(surface_of(obj).data), changes.state(obj)), make
    )


def _shows_faces(overlay, obj):
    """Whether what Blender draws on an object's faces is to be seen between the stripes."""
    return obj.show_wire or overlay.show_wireframes or overlay.show_face_orientation


class _View:
    """Draws the patterns in all 3D views."""

    def __init__(self):
        self._handler = None

    def register(self):
        """Begin to draw."""
        self._handler = bpy.types.SpaceView3D.draw_handler_add(self._draw, (), "WINDOW", "POST_VIEW")

    def unregister(self):
        """Draw no longer."""
        bpy.types.SpaceView3D.draw_handler_remove(self._handler, "WINDOW")
        shaders.forget()

    def _draw(self):
        context = bpy.context
        if not shows(context):
            return
        region, depsgraph = context.region_data, context.evaluated_depsgraph_get()
        for obj in layer_objects(context):
            draw_object(obj, ["LAYERS", "SPHERE"], nearer(region) @ region.view_matrix)
        for obj in shown_objects(context):
            pattern = drawn_pattern(obj, depsgraph)
            if pattern is not None:
                place, matrix = nearer(region), obj.evaluated_get(depsgraph).matrix_world
                color, background, share = look_of(obj)
                if obj.mode == "WEIGHT_PAINT":  # the map that is painted is seen between thin lines
                    draw_object(obj, ["WEIGHTS"], nearer(region, _NEARER) @ region.view_matrix)
                    share, color, place = min(share, _PAINTED), _ON_WEIGHTS, nearer(region, 2 * _NEARER)
                if obj.mode == "WEIGHT_PAINT" or _shows_faces(context.space_data.overlay, obj):
                    background = None
                view = place @ region.view_matrix @ matrix
                pattern.draw(view, region.window_matrix, color, background, share)


view = _View()
register, unregister = view.register, view.unregister
