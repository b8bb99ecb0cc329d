# SPDX-License-Identifier: GPL-3.0-or-later
"""The few choices of the simple panel: names for what the object's settings say, which they change."""

import math

import bpy
from bpy.props import BoolProperty, EnumProperty

from ..blender.registration import register_all

# What each direction asks of the settings: guidance, and the angle by which it is turned.
_DIRECTIONS = {
    "SMOOTH": ("SMOOTH", 0.0),
    "CURVATURE": ("CURVATURE_MIN", 0.0),
    "AXIS": ("AXIS", math.pi / 2),
    "STROKES": ("SMOOTH", 0.0),
}
_DIRECTION_ITEMS = (
    ("SMOOTH", "Smooth", "Lines that turn as little as the shape allows (the smoothest direction field)", 0),
    ("CURVATURE", "Along Curvature", "Lines along ridges, where the surface bends least (principal directions)", 1),
    ("AXIS", "Around an Axis", "Rings around an axis of the object", 2),
    ("STROKES", "Strokes", "Lines that you draw on the surface", 3),
    ("OTHER", "As in Advanced", "What the settings under Advanced ask for", 4),
)
_KIND_ITEMS = (
    ("stripes", "Stripes", "Even stripes over the surface", "MOD_WAVE", 0),
    ("quads", "Quads", "A grid of squares over the surface", "MESH_GRID", 1),
    ("quad_mesh", "Quad Mesh", "A new mesh of quads, and the object is hidden", "MOD_REMESH", 2),
)


def _get_direction(simple):
    stored = simple.id_data.synch
    asked = stored.guidance, stored.angle
    for number, (name, (guidance, angle)) in enumerate(_DIRECTIONS.items()):
        if asked[0] == guidance and math.isclose(asked[1], angle, abs_tol=1e-6):
            return number if name != "SMOOTH" or not simple.draws else list(_DIRECTIONS).index("STROKES")
    return len(_DIRECTIONS)


def _set_direction(simple, number):
    if number < len(_DIRECTIONS):
        name = list(_DIRECTIONS)[number]
        simple.draws = name == "STROKES"
        stored = simple.id_data.synch
        stored.guidance, stored.angle = _DIRECTIONS[name]


class SynchSimple(bpy.types.PropertyGroup):
    """What the simple panel makes of an object."""

    kind: EnumProperty(name="Make", description="What the button makes", items=_KIND_ITEMS)
    direction: EnumProperty(
        name="Direction",
        description="What lines follow",
        items=_DIRECTION_ITEMS,
        get=_get_direction,
        set=_set_direction,
    )
    draws: BoolProperty(name="Strokes", description="Whether lines follow strokes that are drawn")


register, unregister = register_all((SynchSimple,), (bpy.types.Object, "synch_simple", SynchSimple))
