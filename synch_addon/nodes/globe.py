# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group "Synch Globe": a map to the sphere seen as a globe of seas, lands and ice that is drawn through it.

Where the map covers the sphere once, the whole globe appears once (paper, Figure 7).
"""

import math

import bpy

from ..blender import schema
from .canvas import Socket, group_tree

GLOBE_NAME = "Synch Globe"
SPHERE = schema.SPHERE.name
_VERSION = 1
# Meridians and parallels: their distance in radians.
_STEP = math.pi / 6
# Continents per radius, octaves, and the share of noise above which there is land.
_SCALE, _DETAIL, _ROUGHNESS, _SHORE = 1.35, 9.0, 0.55, 0.53
_ICE_FROM = 0.86

_INPUTS = (
    Socket("Sea", "Color", "Color of the seas", (0.012, 0.085, 0.235, 1.0)),
    Socket("Shallows", "Color", "Color of the seas near land", (0.05, 0.30, 0.42, 1.0)),
    Socket("Lowland", "Color", "Color of land near the sea", (0.095, 0.24, 0.055, 1.0)),
    Socket("Highland", "Color", "Color of land far from the sea", (0.52, 0.36, 0.17, 1.0)),
    Socket("Ice", "Color", "Color around the poles", (0.88, 0.91, 0.94, 1.0)),
    Socket("Lines", "Float", "How much meridians and parallels are seen", 0.45, (0.0, 1.0)),
    Socket("Width", "Float", "Part of the way between two of them that a line takes", 0.05, (0.0, 1.0)),
)
_OUTPUTS = (
    Socket("Color", "Color", "Color of the globe at the point that the map shows"),
    Socket("Height", "Float", "0 in the sea, growing on land to 1"),
)


def globe_group() -> bpy.types.ShaderNodeTree:
    """The node group "Synch Globe", built when missing and rebuilt in place when outdated."""
    tree, canvas = group_tree(GLOBE_NAME, f"{_VERSION}", _INPUTS, _OUTPUTS)
    if canvas is None:
        return tree
    with canvas.band("Point of the sphere"):
        inputs = canvas.inputs()
        (point,) = canvas.attribute(SPHERE, "Vector")
        point = canvas.value("ShaderNodeVectorMath", 0, "unit", {0: point}, operation="NORMALIZE")
        x, y, z = canvas.separate(point)
    with canvas.band("Continents"):
        values = {"Vector": point, "Scale": _SCALE, "Detail": _DETAIL, "Roughness": _ROUGHNESS}
        noise = canvas.value("ShaderNodeTexNoise", 0, "continents", values)
        height = ((noise - _SHORE) * 9.0).named("above the sea")
        land = (height * 14.0 + 0.5).clamped().named("land")
        sea_color = canvas.color_mix((height * 2.2 + 1.0).clamped(), inputs["Sea"], inputs["Shallows"])
        land_color = canvas.color_mix((height * 1.1).clamped(), inputs["Lowland"], inputs["Highland"])
        color = canvas.color_mix(land, sea_color, land_color)
        ice = ((abs(z) + height * 0.06 - _ICE_FROM) * 30.0).clamped().named("ice")
        color = canvas.color_mix(ice, color, inputs["Ice"])
    with canvas.band("Meridians and parallels"):
        latitude = canvas.math("ARCSINE", z.minimum(1.0).maximum(-1.0))
        longitude = canvas.math("ARCTAN2", y, x)
        # Meridians become narrower towards the poles, where they would cover everything.
        round_the_axis = (1.0 - z * z).maximum(0.0).root().named("cosine of the latitude")
        lines = _line(latitude, inputs["Width"], 1.0).maximum(_line(longitude, inputs["Width"], round_the_axis))
        shade = (lines * inputs["Lines"]).named("lines")
        canvas.outputs(Color=canvas.color_mix(shade, color, inputs["Ice"]), Height=(height * land).clamped())
    return tree


def _line(angle, width, stretch):
    """1 on multiples of the step, 0 beside them; distances count ``stretch`` times."""
    away = (angle / _STEP).named("steps")
    # PINGPONG by a half: distance to the nearest whole number.
    distance = away.ping_pong(0.5) * stretch
    return ((width * 0.5 - distance) / (width * 0.25).maximum(1e-4) + 0.5).clamped()
