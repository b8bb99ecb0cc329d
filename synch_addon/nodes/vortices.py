# SPDX-License-Identifier: GPL-3.0-or-later
"""The node groups of vortices: "Synch Tubes" colours a map to the sphere, "Synch Filaments" makes curves to tubes.

Points of equal colour on a tube are a line along its vortex, so that colours show how it twists.
"""

import math

import bpy

from ..blender import schema
from ..blender.modifiers import FILAMENTS
from .canvas import GeometryCanvas, Socket, add_modifier, group_tree, surface_material
from .globe import SPHERE, globe_group

TUBES_NAME = "Synch Tubes"
_VERSION = 1
# What objects of vortices carry: the circulation, as a custom property of curves too, and a point's color.
STRENGTH, COLOR = schema.STRENGTH.name, schema.COLOR.name
_BRASS, _CRIMSON = (0.60, 0.33, 0.09, 1.0), (0.42, 0.02, 0.05, 1.0)
_TUBES_INPUTS = (
    Socket("Wheel", "Float", "0 for the globe, 1 for hues by longitude in bands of latitude", 0.0, (0.0, 1.0)),
    Socket("Saturation", "Float", "Of the wheel's hues", 0.8, (0.0, 1.0)),
)
_TUBES_OUTPUTS = (
    Socket("Color", "Color", "Color of the point of the sphere that the map shows"),
    Socket("Height", "Float", "Of the globe's land, 0 for the wheel"),
)
_FILAMENTS_INPUTS = (
    Socket("Geometry", "Geometry", "Curves whose radius is the root of how many filaments lie on each other"),
    Socket("Radius", "Float", "Of the tube around one filament", 0.01),
    Socket("Sides", "Int", "Of a tube's cross section", 12, (3, 64)),
    Socket("Circulation", "Float", "Of one filament", 1.0),
    Socket("Color", "Color", "Of one filament", _BRASS),
    Socket("Strongest", "Color", "Of as many as below, or more, on each other", _CRIMSON),
    Socket("Many", "Float", "How many filaments on each other have the last color", 4.0),
    Socket("Material", "Material", "Of the tubes"),
)
_FILAMENTS_OUTPUTS = (Socket("Geometry", "Geometry", "Tubes with their strength and color as attributes"),)


def tubes_group() -> bpy.types.ShaderNodeTree:
    """The node group "Synch Tubes", built when missing and rebuilt in place when outdated."""
    tree, canvas = group_tree(TUBES_NAME, f"{_VERSION}", _TUBES_INPUTS, _TUBES_OUTPUTS)
    globe_tree = globe_group()
    if canvas is None:
        return tree
    with canvas.band("Globe"):
        inputs = canvas.inputs()
        globe = canvas.group(globe_tree)
    with canvas.band("Wheel"):
        (point,) = canvas.attribute(SPHERE, "Vector")
        x, y, z = canvas.separate(point)
        hue = (canvas.math("ARCTAN2", y, x) / (2 * math.pi) + 0.5).named("longitude")
        # Six bands of latitude, every other one darker, and darker towards the south.
        latitude = canvas.math("ARCSINE", z.minimum(1.0).maximum(-1.0))
        band = ((latitude / (math.pi / 6)).ping_pong(1.0) > 0.5).named("band")
        value = ((z * 0.16 + 0.5) * (1.0 - band * 0.2)).named("value")
        parts = dict(enumerate((hue, inputs["Saturation"], value)))
        wheel = canvas.value("ShaderNodeCombineColor", 0, "hue", parts, mode="HSV")
    with canvas.band("Chosen"):
        color = canvas.color_mix(inputs["Wheel"], globe["Color"], wheel)
        canvas.outputs(Color=color, Height=globe["Height"] * (1.0 - inputs["Wheel"]))
    return tree


def filaments_group() -> bpy.types.GeometryNodeTree:
    """The node group "Synch Filaments", built when missing and rebuilt in place when outdated."""
    tree, canvas = group_tree(FILAMENTS, f"{_VERSION}", _FILAMENTS_INPUTS, _FILAMENTS_OUTPUTS, GeometryCanvas)
    if canvas is None:
        return tree
    tree.interface.items_tree["Radius"].subtype = "DISTANCE"
    for name in ("Radius", "Circulation", "Many"):
        tree.interface.items_tree[name].min_value = 0.0
    tree.is_modifier = True
    with canvas.band("How many lie on each other"):
        inputs = canvas.inputs()
        root = canvas.value("GeometryNodeInputRadius", "Radius")
        number = (root * root).named("number")
        strength = (number * inputs["Circulation"]).named("strength")
        share = ((number - 1.0) / (inputs["Many"] - 1.0).maximum(1e-6)).clamped()
        color = canvas.color_mix(share, inputs["Color"], inputs["Strongest"])
    with canvas.band("Attributes"):
        curves = canvas.stored(inputs["Geometry"], STRENGTH, ("POINT", "FLOAT"), strength)
        curves = canvas.stored(curves, COLOR, schema.COLOR.layout, color)
    with canvas.band("Tubes"):
        tubes = _around(canvas, curves, (inputs["Radius"] * root).named("radius"), inputs["Sides"])
        smooth = canvas.value("GeometryNodeSetShadeSmooth", 0, "", {0: tubes})
        values = {"Geometry": smooth, "Material": inputs["Material"]}
        canvas.outputs(Geometry=canvas.value("GeometryNodeSetMaterial", 0, "", values))
    return tree


def _around(canvas, curves, radius, sides):
    """Tubes of a radius around curves. The radius is also stored on the curves: some versions of Curve to Mesh read it
    there, others take it as a scale."""
    thick = canvas.value("GeometryNodeSetCurveRadius", 0, "", {"Curve": curves, "Radius": radius})
    circle = canvas.value("GeometryNodeCurvePrimitiveCircle", "Curve", "", {"Resolution": sides, "Radius": 1.0})
    tubes = canvas.value("GeometryNodeCurveToMesh", "Mesh", "", {"Curve": thick, "Profile Curve": circle})
    sockets = tubes.socket.node.inputs
    if "Scale" in sockets:  # from 5.0 on
        canvas.connect(canvas.value("GeometryNodeInputRadius", "Radius"), sockets["Scale"])
    return tubes


def add_filaments_modifier(obj, radius, circulation):
    """Give a curve object of filaments the tubes and colours of the node group."""
    group = filaments_group()
    material = filament_material()
    add_modifier(obj, group, {"Radius": radius, "Circulation": circulation, "Material": material})
    obj.data.materials.append(material)


def filament_material():
    """The file's own material of filaments, made on first use: the colour that the nodes store, as polished metal."""
    for material in bpy.data.materials:
        if material.library is None and material.get(FILAMENTS):
            return material
    material, surface, _ = surface_material(FILAMENTS)
    material[FILAMENTS] = True
    material.diffuse_color = _BRASS
    tree = material.node_tree
    surface.inputs["Metallic"].default_value, surface.inputs["Roughness"].default_value = 0.55, 0.32
    color = tree.nodes.new("ShaderNodeAttribute")
    color.attribute_name, color.location = COLOR, (-220, 180)
    tree.links.new(color.outputs["Color"], surface.inputs["Base Color"])
    return material
