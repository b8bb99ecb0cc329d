# SPDX-License-Identifier: GPL-3.0-or-later
"""The look of layers: coloured from bottom to top, every other one darker, cut open, and peeled from the top."""

import bpy
import numpy as np

from ..blender.modifiers import modifier_of
from ..blender.schema import LAYER
from ..blender.transaction import store
from .canvas import Expression, GeometryCanvas, Socket, add_modifier, group_tree, surface_material

LAYERS_NAME = "Synch Layers"
CURVES_NAME = "Synch Dislocations"
OPEN_NAME = "Synch Open Layers"
COUNT = "synch_layer_count"
# In the stamp of the group: raise it when what is built here changes.
VERSION = 1
# From the bottom to the top: deep blue, teal, sand, coral; linear.
_COLORS = (
    (0.0, (0.012, 0.045, 0.16, 1.0)),
    (0.35, (0.03, 0.27, 0.32, 1.0)),
    (0.7, (0.80, 0.62, 0.32, 1.0)),
    (1.0, (0.72, 0.13, 0.06, 1.0)),
)
_CURVE_COLOR = (1.0, 0.04, 0.02, 1.0)
_INPUTS = (
    Socket("Alternate", "Float", "How much darker every other layer is", 0.45, (0.0, 1.0)),
    Socket("Cut", "Float", "Part of the object that is cut away along X, from the right", 0.0, (0.0, 1.0)),
)
_OUTPUTS = (
    Socket("Height", "Float", "0 at the lowest layer, 1 at the highest"),
    Socket("Shade", "Float", "1, less on every other layer"),
    Socket("Visible", "Float", "0 where the object is cut away"),
)


_OPEN_INPUTS = (
    Socket("Geometry", "Geometry", "The layers"),
    Socket("Cut Open", "Float", "Part of the object that is cut away along X, from the right", 0.0, (0.0, 1.0)),
    Socket("Peel", "Float", "Part of the layers that is taken off, from the top", 0.0, (0.0, 1.0)),
)
_OPEN_OUTPUTS = (Socket("Geometry", "Geometry", "What is left of them"),)


def open_layers(obj):
    """Give an object of layers the modifier that cuts them open and peels them, if it has none."""
    if opening_modifier(obj) is None:
        add_modifier(obj, open_layers_group(), {})


def opening_modifier(obj):
    """The modifier of :func:`open_layers`, or None."""
    return modifier_of(obj, OPEN_NAME)


def open_layers_group():
    """The geometry node group "Synch Open Layers", built when missing and rebuilt in place when outdated."""
    tree, canvas = group_tree(OPEN_NAME, f"{VERSION}", _OPEN_INPUTS, _OPEN_OUTPUTS, GeometryCanvas)
    if canvas is None:
        return tree
    tree.is_modifier = True
    inputs = canvas.inputs()
    (layer,) = canvas.attribute(LAYER.name, "Fac")
    values = {"Geometry": inputs["Geometry"], 2: layer}
    last = canvas.value("GeometryNodeAttributeStatistic", "Max", "layers", values, data_type="FLOAT", domain="FACE")
    box = canvas.node("GeometryNodeBoundBox", 1, "", {"Geometry": inputs["Geometry"]})
    low, high = (canvas.separate(Expression(canvas, box.outputs[side], 1))[0] for side in ("Min", "Max"))
    x, _, _ = canvas.separate(canvas.value("GeometryNodeInputPosition", "Position"))
    # The margins keep all faces where both sliders are 0.
    is_cut = (x > high - (high - low) * (inputs["Cut Open"] - 1e-4)).named("cut away?")
    is_peeled = (layer > last - (last + 1.0) * inputs["Peel"] + 1e-3).named("peeled?")
    gone = is_cut.maximum(is_peeled)
    values = {"Geometry": inputs["Geometry"], "Selection": gone}
    canvas.outputs(Geometry=canvas.value("GeometryNodeDeleteGeometry", "Geometry", "", values, domain="FACE"))
    return tree


def layer_material(obj, count):
    """Give an object of layers its material, if it has none, and the number of layers."""
    store(obj, COUNT, count)
    layers_group()
    _add_material(obj, LAYERS_NAME, _new_layer_material)


def curve_material(obj):
    """Give an object of dislocation curves its material, if it has none."""
    _add_material(obj, CURVES_NAME, _new_curve_material)


def _add_material(obj, name, new):
    """Give an object without a material the file's material of a name, made by ``new()`` if the file has none."""
    if not any(slot.material for slot in obj.material_slots):
        material = bpy.data.materials.get(name) or new()
        obj.data.materials.clear()
        obj.data.materials.append(material)


def layer_colors(layers):
    """(k, 4) what the material shows of layers by their numbers, for views that draw no materials."""
    heights = layers / max(layers.max(initial=1), 1)
    places, colors = zip(*_COLORS, strict=True)
    found = np.column_stack([np.interp(heights, places, channel) for channel in zip(*colors, strict=True)])
    found[:, :3] *= 1 - _INPUTS[0].default * (layers % 2)[:, None]
    return found


def layers_group():
    """The node group "Synch Layers", built when missing and rebuilt in place when outdated."""
    tree, canvas = group_tree(LAYERS_NAME, f"{VERSION}", _INPUTS, _OUTPUTS)
    if canvas is None:
        return tree
    inputs = canvas.inputs()
    (layer,) = canvas.attribute(LAYER.name, "Fac")
    count = canvas.place("ShaderNodeAttribute", 0, "number of layers")
    count.attribute_type, count.attribute_name = "OBJECT", COUNT
    total = Expression(canvas, count.outputs["Fac"], 0)
    height = (layer / (total - 1.0).maximum(1.0)).named("height")
    odd = (layer.ping_pong(1.0)).named("odd?")
    shade = (1.0 - odd * inputs["Alternate"]).named("shade")
    x, _, _ = canvas.separate(canvas.value("ShaderNodeTexCoord", "Generated", "place in the object's box"))
    visible = (x < 1.0 - inputs["Cut"] + 1e-4).named("kept?")
    canvas.outputs(Height=height, Shade=shade, Visible=visible)
    return tree


def _new_layer_material():
    material, surface, output = surface_material(LAYERS_NAME)
    material.diffuse_color = _COLORS[1][1]
    tree = material.node_tree
    surface.inputs["Roughness"].default_value = 0.55
    surface.location, output.location = (60, 0), (560, 0)
    group = tree.nodes.new("ShaderNodeGroup")
    group.node_tree, group.location, group.width = layers_group(), (-760, 0), 180
    ramp = tree.nodes.new("ShaderNodeValToRGB")
    ramp.location = (-540, 120)
    elements = ramp.color_ramp.elements
    for place, _ in _COLORS[1:-1]:
        elements.new(place)
    for element, (place, color) in zip(elements, _COLORS, strict=True):
        element.position, element.color = place, color
    shaded = tree.nodes.new("ShaderNodeVectorMath")
    shaded.operation, shaded.location = "SCALE", (-180, 60)
    clear = tree.nodes.new("ShaderNodeBsdfTransparent")
    clear.location = (60, 120)
    mixed = tree.nodes.new("ShaderNodeMixShader")
    mixed.location = (360, 60)
    links = tree.links
    links.new(group.outputs["Height"], ramp.inputs["Fac"])
    links.new(ramp.outputs["Color"], shaded.inputs[0])
    links.new(group.outputs["Shade"], shaded.inputs["Scale"])
    links.new(shaded.outputs["Vector"], surface.inputs["Base Color"])
    links.new(group.outputs["Visible"], mixed.inputs[0])
    links.new(clear.outputs[0], mixed.inputs[1])
    links.new(surface.outputs[0], mixed.inputs[2])
    links.new(mixed.outputs[0], output.inputs["Surface"])
    return material


def _new_curve_material():
    material, surface, _ = surface_material(CURVES_NAME)
    material.diffuse_color = _CURVE_COLOR
    surface.inputs["Base Color"].default_value = _CURVE_COLOR
    surface.inputs["Roughness"].default_value = 0.4
    return material
