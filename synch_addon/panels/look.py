# SPDX-License-Identifier: GPL-3.0-or-later
"""The look of a pattern in the box "Result": colours, width, softness and profile of the node in its material."""

import bpy
from bpy.props import EnumProperty

from ..blender.phases import pattern_kind
from ..blender.registration import register_all
from ..nodes import quads, stripe_profiles
from ..nodes.materials import pattern_node
from ..nodes.stripes import INK_BLUE, WARM_IVORY
from .setting_rows import property_column

# Inputs of the node in the order in which they are drawn, with what is said of them.
_COLORS, _SHAPE = ("Color", "Background"), ("Width", "Softness")


def _profile(names, kind):
    """A property of an object that is the profile of a kind of pattern in its material."""

    def get(look):
        node = pattern_node(look.id_data, kind)
        return 0 if node is None else min(max(node.inputs["Profile"].default_value, 0), len(names) - 1)

    def set_(look, number):
        pattern_node(look.id_data, kind).inputs["Profile"].default_value = number

    items = [(name.upper().replace(" ", "_"), name.capitalize(), "", number) for number, name in enumerate(names)]
    tip = "Height of the pattern across a stripe or a quad, which light shows"
    return EnumProperty(name="Profile", description=tip, items=items, get=get, set=set_)


class SynchLook(bpy.types.PropertyGroup):
    """Names for numbers in the node that shows an object's pattern."""

    stripes: _profile(stripe_profiles.PROFILES, "stripes")
    quads: _profile(quads.PROFILES, "quads")


def look_of(obj):
    """The colours of an object's pattern and between it, and the share of the area that it fills, as far as its node
    holds them; of a width that varies, its mean."""
    kind = pattern_kind(obj)
    node = None if kind is None else pattern_node(obj, kind)
    if node is None:
        return INK_BLUE, WARM_IVORY, 0.5
    colors = [_color_socket(node, name) for name in _COLORS]
    given = [
        standard if socket is None else tuple(socket.default_value)
        for socket, standard in zip(colors, (INK_BLUE, WARM_IVORY), strict=True)
    ]
    return (*given, min(max(node.inputs["Width"].default_value, 0.0), 1.0))


def _color_socket(node, name):
    """What holds a colour of a pattern's node: its input, or a plain colour that leads there; None where other nodes
    make it."""
    socket = node.inputs[name]
    if not socket.is_linked:
        return socket
    source = socket.links[0].from_node
    return source.outputs[0] if source.bl_idname == "ShaderNodeRGB" else None


def draw_look(layout, obj):
    """Draw the inputs of the node that shows an object's pattern, except those that other nodes make."""
    kind = pattern_kind(obj)
    node = None if kind is None else pattern_node(obj, kind)
    if node is None:
        return
    column = layout.column(align=True)
    free = {name for name in ("Profile", *_SHAPE) if not node.inputs[name].is_linked}
    row = column.row(align=True)
    for socket in (_color_socket(node, name) for name in _COLORS):
        if socket is not None:
            row.prop(socket, "default_value", text="")
    if "Profile" in free:
        property_column(column).prop(obj.synch_look, kind)
    row = column.row(align=True)
    for name in _SHAPE:
        if name in free:
            row.prop(node.inputs[name], "default_value", text=name, slider=True)


register, unregister = register_all((SynchLook,), (bpy.types.Object, "synch_look", SynchLook))
