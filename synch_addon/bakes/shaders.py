# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials that glow with what is to be baked: copies of an object's own, with something else at their output.

- *Mask and height* are the outputs Factor and Height of the pattern's node group, with the settings that it has in the
  material of each face; faces whose material does not show the pattern have those of the first material that does.
- *Colour* is what is linked to the base colour of the first shader on the way to the output.
- *Phase*: two values from -1 to 1, kept as (1 + value) / 2, that are continuous wherever the pattern is. From face to
  face theta of stripes may change its sign, so they are cos(theta) and |sin(theta)|, or sin(theta) itself where no sign
  ever changes (directions of the symmetry "vector"); their angle is the distance from the middle of a stripe. The two
  phases of quads may change places too, so they are the greater and the lesser of cos(x) and cos(y).
"""

import bpy

from ...core.errors import SettingError
from ..nodes.canvas import Canvas, Expression
from ..nodes.quads import QUADS_NAME, quads_group
from ..nodes.stripes import STRIPES_NAME, stripes_group

_GROUPS = {"stripes": (STRIPES_NAME, stripes_group), "quads": (QUADS_NAME, quads_group)}
# Custom property of a material of baked images: the one that they were baked from.
SOURCE = "synch_source"
_COLOR_INPUTS = ("Base Color", "Color")


def sources(obj):
    """The materials that an object's slots show, or were baked from; None in empty slots."""
    return [slot.material and (slot.material.get(SOURCE) or slot.material) for slot in obj.material_slots]


def pattern_node(material, kind):
    """The node of a material's tree that shows a `kind` of pattern, "stripes" or "quads", or None."""
    if material is None or material.node_tree is None:
        return None
    name = _GROUPS[kind][0]
    of_group = (node for node in material.node_tree.nodes if getattr(node, "node_tree", None) is not None)
    return next((node for node in of_group if node.node_tree.name == name), None)


def as_rendered(materials):
    """Copies of an object's materials as they are; plain ones for empty slots."""
    return [_copy(material) for material in materials]


def glowing_colours(materials, kind):
    """Copies that glow with their base colour."""
    copies = as_rendered(materials)
    for material in copies:
        output = _output(material)
        color = _base_color(output)
        if color is None:
            node = pattern_node(material, kind)
            color = node.outputs["Color"] if node else tuple(material.diffuse_color)
        _glow(material, color)
    return copies


def glowing_pattern(materials, kind):
    """Copies that glow with mask and height in red and green."""
    return _glowing(materials, kind, lambda canvas, node: _values(canvas, node, "Factor", "Height"))


def phase_channels(kind, is_signed):
    """What the red and green channels of the phase map contain, in words."""
    if kind == "quads":
        return "greater and lesser of cos(x) and cos(y)"
    return "cos(theta) and sin(theta)" if is_signed else "cos(theta) and |sin(theta)|"


def glowing_phase(materials, kind, is_signed):
    """Copies that glow with the two values of the phase."""

    def encoded(canvas, node):
        if kind == "quads":
            cosines = [phase.cosine() for phase in _values(canvas, node, "Phase X", "Phase Y")]
            both = cosines[0].maximum(cosines[1]), cosines[0].minimum(cosines[1])
        else:
            (phase,) = _values(canvas, node, "Phase")
            both = phase.cosine(), phase.sine() if is_signed else abs(phase.sine())
        return [value * 0.5 + 0.5 for value in both]

    return _glowing(materials, kind, encoded)


def glowing_attributes(*names):
    """A new material that glows with up to three attributes: the first component of each."""
    material = _copy(None)
    canvas = Canvas(material.node_tree)
    _glow_with(material, canvas, [canvas.attribute(name, "Fac")[0] for name in names])
    return material


def _glowing(materials, kind, values):
    """Copies that glow with up to three expressions of the outputs of the pattern's node."""
    reference = next((material for material in materials if pattern_node(material, kind)), None)
    reference = reference or _pattern_material(kind)
    copies = []
    for material in materials:
        copy = _copy(material if pattern_node(material, kind) else reference)
        canvas = Canvas(copy.node_tree)
        _glow_with(copy, canvas, values(canvas, pattern_node(copy, kind)))
        copies.append(copy)
    return copies


def _pattern_material(kind):
    """A material of the file that shows the pattern, or a new one with its standard look."""
    for material in bpy.data.materials:
        if material.library is None and pattern_node(material, kind):
            return material
    material = _copy(None)
    name, group = _GROUPS[kind]
    tree = bpy.data.node_groups.get(name)
    material.node_tree.nodes.new("ShaderNodeGroup").node_tree = tree or group()
    return material


def _copy(material):
    if material is None:
        copy = bpy.data.materials.new("Synch Bake")
    else:
        copy = material.copy()
    if copy.node_tree is None:
        copy.use_nodes = True
    return copy


def _output(material):
    """The node whose surface Cycles renders."""
    tree = material.node_tree
    return tree.get_output_node("CYCLES") or tree.nodes.new("ShaderNodeOutputMaterial")


def _base_color(output):
    """Socket or value of the base colour of the first shader before an output, None without one."""
    waiting, seen = [output.inputs["Surface"]], set()
    while waiting:
        for link in waiting.pop(0).links:
            node = link.from_node
            if node in seen:
                continue
            seen.add(node)
            if node.type == "BSDF_TRANSPARENT":
                continue
            for name in _COLOR_INPUTS:
                if name in node.inputs:
                    color = node.inputs[name]
                    return color.links[0].from_socket if color.is_linked else tuple(color.default_value)
            waiting += [socket for socket in node.inputs if socket.type == "SHADER"]
    return None


def _values(canvas, node, *names):
    for name in names:
        if name not in node.outputs:
            raise SettingError(f"the node group {node.node_tree.name} has no output {name}: solve the pattern again")
    return [Expression(canvas, node.outputs[name], 0) for name in names]


def _glow_with(material, canvas, values):
    """Make a material glow with up to three expressions, in red, green and blue."""
    joined = material.node_tree.nodes.new("ShaderNodeCombineXYZ")
    for value, socket in zip(values, joined.inputs, strict=False):
        canvas.connect(value, socket)
    _glow(material, joined.outputs[0])


def _glow(material, color):
    """Put an emission of a socket's value, or a fixed colour, at a material's output."""
    tree = material.node_tree
    glow = tree.nodes.new("ShaderNodeEmission")
    if isinstance(color, tuple):
        glow.inputs["Color"].default_value = color
    else:
        tree.links.new(color, glow.inputs["Color"])
    tree.links.new(glow.outputs[0], _output(material).inputs["Surface"])
