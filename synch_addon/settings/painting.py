# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps that are painted: which vertex groups they are, and what the brush's weight stands for."""

import math
from typing import NamedTuple

import bpy

from ...core.settings.surface import SurfaceSettings
from ..blender.registration import register_all
from .rna import property_of


class PaintedMap(NamedTuple):
    """A map of an object's settings, which a vertex group may be.

    Attributes
    ----------
    settings : the object's property that holds the settings
    name, full : the settings that name the map, and say what a weight of 1 stands for
    group : what a new vertex group is called
    """

    settings: str
    name: str
    full: str
    group: str

    def of(self, obj):
        """Name of an object's map; "" without one."""
        return getattr(getattr(obj, self.settings), self.name)

    def full_of(self, obj):
        """The value that a weight of 1 stands for on an object."""
        return getattr(getattr(obj, self.settings), self.full)


MAPS = {
    "SPACING": PaintedMap("synch", "spacing_map", "spacing_range", "Spacing"),
    "ANGLE": PaintedMap("synch", "angle_attribute", "angle_range", "Angle"),
    "LAYERS": PaintedMap("synch_layering", "spacing_map", "spacing_range", "Layer Spacing"),
}


def painted_map(obj):
    """The kind of map, a word of :data:`MAPS`, that is being painted on an object, or None."""
    active = obj.vertex_groups.active if obj.mode == "WEIGHT_PAINT" else None
    return next((word for word, map_ in MAPS.items() if active and map_.of(obj) == active.name), None)


def _brush():
    """The settings that hold the painted weight: the brush, or those shared by all brushes."""
    tools = bpy.context.tool_settings
    paint = tools.weight_paint
    shared = getattr(paint, "unified_paint_settings", None) or tools.unified_paint_settings  # moved in Blender 5.0
    return shared if shared.use_unified_weight or paint.brush is None else paint.brush


def _paint(weight):
    _brush().weight = min(max(weight, 0.0), 1.0)


def _full():
    """The value that a weight of 1 stands for in the map being painted."""
    obj = bpy.context.active_object
    return MAPS[painted_map(obj) or "SPACING"].full_of(obj)


def _get_factor(_group):
    return _full() ** _brush().weight


def _set_factor(_group, factor):
    full = _full()
    _paint(0.0 if full == 1 else math.log(factor) / math.log(full))


def _get_angle(_group):
    return _full() * _brush().weight


def _set_angle(_group, angle):
    full = _full()
    _paint(0.0 if full == 0 else angle / full)


class SynchBrush(bpy.types.PropertyGroup):
    """The value that the brush of weight paint mode paints, in the units of the map."""

    factor: property_of(
        SurfaceSettings,
        "spacing_range",
        name="Brush",
        description="Factor on the spacing that the brush paints, between 1 and the range",
        get=_get_factor,
        set=_set_factor,
    )
    angle: property_of(
        SurfaceSettings,
        "angle_range",
        name="Brush",
        description="Angle that the brush paints, between 0 and the range",
        get=_get_angle,
        set=_set_angle,
    )


register, unregister = register_all((SynchBrush,), (bpy.types.WindowManager, "synch_brush", SynchBrush))
