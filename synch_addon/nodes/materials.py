# SPDX-License-Identifier: GPL-3.0-or-later
"""The materials that show patterns on an object, placed so that nothing of the user's is lost."""

import math
from collections.abc import Callable
from typing import NamedTuple

import bpy
import numpy as np

from ...core.errors import SettingError, quote_value
from ..blender import attributes
from ..blender.pattern_surface import surface_of
from ..blender.transaction import assign, store, undone_by
from .canvas import Canvas, surface_material
from .globe import GLOBE_NAME, globe_group
from .quads import QUADS_NAME, quads_group
from .stripes import STRIPES_NAME, WARM_IVORY, stripes_group
from .vortices import TUBES_NAME, tubes_group

SPACING = "synch_spacing"


class _Kind(NamedTuple):
    """How a kind of pattern is shown: the name of its node group and material, and the height of its relief.

    The relief is given in spacings: enough for light to catch, too little to look carved.
    """

    name: str
    group: Callable
    relief: float


_KINDS = {
    "stripes": _Kind(STRIPES_NAME, stripes_group, 0.05),
    "quads": _Kind(QUADS_NAME, quads_group, 0.035),
    "globe": _Kind(GLOBE_NAME, globe_group, 0.0),
    "tubes": _Kind(TUBES_NAME, tubes_group, 0.0),
}


def pattern_material(obj, kind, *, spacing=None, assign_faces=False) -> bpy.types.Material:
    """Give a mesh object the material of a `kind` of pattern, one of `_KINDS`, and return it.

    - A slot holds it already (or another material that uses its node group): nothing changes, so
      what the user has made of its look survives a second run.
    - Slots show the other kind of pattern: they get this one instead.
    - The object has no materials: it gets the one of this file, and empty slots are filled with it.
    - It has other materials: ours goes into a new last slot and becomes the active one; faces keep
      theirs, unless `assign_faces` gives all of them to the new slot.

    `spacing` is the length of a period in scene units; the relief of the pattern follows it.
    It is kept as the custom property `synch_spacing` of the object. Without it, a first run takes
    a part of the object's size.
    """
    _store_spacing(obj, spacing)
    _KINDS[kind].group()
    present = next((slot.material for slot in obj.material_slots if _shows(slot.material, _KINDS[kind])), None)
    return _use_material(obj, present or _shared_material(kind), present is None, _KINDS[kind], assign_faces)


def show_material(obj, material, kind, *, assign_faces=False):
    """Give a mesh object this material in place of those that show a pattern; else as :func:`pattern_material`."""
    _store_spacing(obj, None)
    _use_material(obj, material, True, _KINDS[kind], assign_faces)


def show_plain(obj, kind):
    """Give a mesh object the material that patterns of a kind have at first; returns it."""
    material = _shared_material(kind)
    show_material(obj, material, kind)
    return material


def take_over_look(obj, other):
    """Give a mesh object the material that shows a pattern on another one, in the slots where it can be placed."""
    shown = next((slot.material for slot in other.material_slots if shows_pattern(slot.material)), None)
    if shown is not None:
        _place(obj, shown)


def kept_spacing(obj):
    """The length of a period that an object keeps, in scene units; None where it keeps none.

    Raises SettingError for a value that others have written there.
    """
    spacing = obj.get(SPACING)
    if spacing is None:
        return None
    if not isinstance(spacing, float | int) or not 0 < spacing < math.inf:
        raise SettingError(
            f"{obj.name}: its custom property {SPACING} is {quote_value(spacing)}: solve its pattern again"
        )
    return float(spacing)


def pattern_node(obj, kind):
    """The node that shows a `kind` of pattern in a material of an object, the first of them, or None."""
    name = _KINDS[kind].name
    for slot in surface_of(obj).material_slots:
        tree = slot.material and slot.material.node_tree
        for node in tree.nodes if tree else ():
            if _is_of(getattr(node, "node_tree", None), name):
                return node
    return None


def shows_pattern(material):
    """Whether a material shows one of these patterns, which only a solved mesh has."""
    return any(_shows(material, kind) for kind in _KINDS.values())


def new_material(name, kind, draw) -> bpy.types.Material:
    """A material that shows a `kind` of pattern.

    ``draw(canvas, group)`` adds its nodes, one of them the pattern's node group, and returns a dict of expressions or
    values for inputs of a Principled BSDF, and with them "Height" and "Relief", the height in spacings where that is 1.
    """
    kind = _KINDS[kind]
    material, surface, output = surface_material(name)
    # Solid viewport shading cannot show patterns; a calm colour there is better than white.
    material.diffuse_color, material.roughness = WARM_IVORY, 0.6
    tree = material.node_tree
    canvas = Canvas(tree)
    inputs = draw(canvas, kind.group())
    height, relief = inputs.pop("Height"), inputs.pop("Relief")
    (spacing,) = canvas.attribute(SPACING, "Fac")
    spacing.socket.node.attribute_type = "OBJECT"
    distance = (spacing * relief).named("Relief")
    depth = 1 + max(value.depth for value in (height, distance))
    bump = canvas.node("ShaderNodeBump", depth, inputs={"Height": height, "Distance": distance, "Strength": 0.6})
    for number, node in enumerate((surface, output), start=1):
        node.location = (bump.location.x + 220 * number + 80 * (number > 1), 0)
    tree.links.new(bump.outputs["Normal"], surface.inputs["Normal"])
    for socket, value in inputs.items():
        canvas.connect(value, surface.inputs[socket])
    for node in tree.nodes:
        node.select = node.type == "GROUP"
        if node.select:
            tree.nodes.active = node
    return material


def _plain_look(relief):
    """The look of a pattern as it is solved, without a preset."""

    def draw(canvas, group):
        pattern = canvas.group(group, 1)
        return {"Base Color": pattern["Color"], "Roughness": 0.42, "Height": pattern["Height"], "Relief": relief}

    return draw


def _store_spacing(obj, spacing):
    if spacing is not None:
        store(obj, SPACING, float(spacing))
    elif SPACING not in obj and any(obj.dimensions):
        store(obj, SPACING, max(obj.dimensions) / 30.0)


def _shows(material, kind):
    if material is None or material.node_tree is None:
        return False
    return any(_is_of(getattr(node, "node_tree", None), kind.name) for node in material.node_tree.nodes)


def _is_of(tree, name):
    """Whether a node's group is the one of this file that has a name."""
    return tree is not None and tree.name == name and tree.library is None


def _shared_material(kind):
    """The file's own material of a kind, made on first use."""
    name = _KINDS[kind].name
    for material in bpy.data.materials:
        if material.library is None and material.name.startswith(name) and _shows(material, _KINDS[kind]):
            return material
    return new_material(name, kind, _plain_look(_KINDS[kind].relief))


def _use_material(obj, material, needs_slot, kind, assign_faces):
    """Put a material of a :class:`_Kind` into slots of an object if it ``needs_slot``, and return it.

    ``assign_faces`` assigns all faces to its slot, unless all slots show materials of the kind.
    """
    slots = obj.material_slots
    if needs_slot:
        slot = _place(obj, material)
    else:
        slot = next(slot.slot_index for slot in slots if _shows(slot.material, kind))
    if assign_faces and not all(_shows(slot.material, kind) for slot in slots):
        _assign_all_faces(obj, slot)
    return material


def _place(obj, material):
    """Put a material in slots that are free for it, or in a new one; returns the first of them."""
    slots = obj.material_slots
    free = [slot for slot in slots if shows_pattern(slot.material)]
    if not free and all(slot.material is None for slot in slots):
        free = list(slots)
    if not free:
        append_material(obj, material)
        assign(obj, "active_material_index", len(slots) - 1)
        return len(slots) - 1
    for slot in free:
        assign(slot, "material", material)
    return free[0].slot_index


def append_material(obj, material):
    """A new last slot with a material, or None; it goes where the work fails."""
    data, index = obj.data, obj.active_material_index
    materials, count = data.materials, len(data.materials)

    def take_back():
        while len(materials) > count:
            materials.pop(index=len(materials) - 1)
        for user in bpy.data.objects:
            if user.data == data:
                user.data = data  # which makes it have as many slots again
        obj.active_material_index = index

    undone_by(obj, take_back)
    materials.append(material)


def _assign_all_faces(obj, slot):
    attributes.write_attribute(obj, "material_index", "FACE", "INT", np.full(len(obj.data.polygons), slot, np.int32))
    obj.data.update()
