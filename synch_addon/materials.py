# SPDX-License-Identifier: GPL-3.0-or-later
"""The materials that show patterns on an object, placed so that nothing of the user's is lost."""

from collections.abc import Callable
from typing import NamedTuple

import bpy
import numpy as np

from .globe import GLOBE_NAME, globe_group
from .nodes import STRIPES_NAME, WARM_IVORY, stripes_group
from .quad_profiles import QUADS_NAME, quads_group
from .vortex_nodes import TUBES_NAME, tubes_group

_SPACING = "synch_spacing"


class _Look(NamedTuple):
    """What shows a kind of pattern: the name of its node group and material, and the height of its relief.

    The relief is given in spacings: enough for light to catch, too little to look carved.
    """

    name: str
    group: Callable
    relief: float


_LOOKS = {
    "stripes": _Look(STRIPES_NAME, stripes_group, 0.05),
    "quads": _Look(QUADS_NAME, quads_group, 0.035),
    "globe": _Look(GLOBE_NAME, globe_group, 0.0),
    "tubes": _Look(TUBES_NAME, tubes_group, 0.0),
}


def pattern_material(obj, kind, *, spacing=None, assign_faces=False) -> bpy.types.Material:
    """Give a mesh object the material of a `kind` of pattern, one of `_LOOKS`, and return it.

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
    look = _LOOKS[kind]
    look.group()
    present = next((slot for slot in obj.material_slots if _shows(slot.material, look)), None)
    material = present.material if present else _shared_material(look)
    slot = present.slot_index if present else _place(obj, material)
    if assign_faces and not all(_shows(slot.material, look) for slot in obj.material_slots):
        _assign_all_faces(obj, slot)
    return material


def shows_pattern(material):
    """Whether a material shows one of these patterns, which only a solved mesh has."""
    return any(_shows(material, look) for look in _LOOKS.values())


def _store_spacing(obj, spacing):
    if spacing is not None:
        obj[_SPACING] = float(spacing)
    elif _SPACING not in obj and any(obj.dimensions):
        obj[_SPACING] = max(obj.dimensions) / 30.0


def _shows(material, look):
    if material is None or material.node_tree is None:
        return False
    trees = [getattr(node, "node_tree", None) for node in material.node_tree.nodes]
    return any(tree is not None and tree.name == look.name and tree.library is None for tree in trees)


def _shared_material(look):
    """The file's own material of a look, made on first use."""
    for material in bpy.data.materials:
        if material.library is None and material.name.startswith(look.name) and _shows(material, look):
            return material
    return _new_material(look)


def _new_material(look):
    material = bpy.data.materials.new(look.name)
    if material.node_tree is None:
        material.use_nodes = True
    # Solid viewport shading cannot show patterns; the ground colour there is calmer than white.
    material.diffuse_color = WARM_IVORY
    material.roughness = 0.6
    tree = material.node_tree
    surface = tree.nodes["Principled BSDF"]
    surface.location = (0, 0)
    surface.inputs["Roughness"].default_value = 0.42
    tree.nodes["Material Output"].location = (320, 0)
    pattern = tree.nodes.new("ShaderNodeGroup")
    pattern.node_tree = look.group()
    pattern.location, pattern.width = (-520, 0), 200
    tree.links.new(pattern.outputs["Color"], surface.inputs["Base Color"])
    bump = _add_bump(tree, look.relief)
    tree.links.new(pattern.outputs["Height"], bump.inputs["Height"])
    tree.links.new(bump.outputs["Normal"], surface.inputs["Normal"])
    for node in tree.nodes:
        node.select = node == pattern
    tree.nodes.active = pattern
    return material


def _add_bump(tree, part):
    """A Bump node whose distance is a part of the spacing of the object that it is seen on."""
    spacing = tree.nodes.new("ShaderNodeAttribute")
    spacing.attribute_type, spacing.attribute_name = "OBJECT", _SPACING
    spacing.label, spacing.location = "Spacing", (-520, -320)
    relief = tree.nodes.new("ShaderNodeMath")
    relief.operation, relief.label, relief.location = "MULTIPLY", "Relief", (-340, -320)
    relief.inputs[1].default_value = part
    bump = tree.nodes.new("ShaderNodeBump")
    bump.location = (-170, -200)
    bump.inputs["Strength"].default_value = 0.6
    tree.links.new(spacing.outputs["Fac"], relief.inputs[0])
    tree.links.new(relief.outputs[0], bump.inputs["Distance"])
    return bump


def _place(obj, material):
    """Put a material in slots that are free for it, or in a new one; returns the first of them."""
    slots = obj.material_slots
    free = [slot for slot in slots if any(_shows(slot.material, look) for look in _LOOKS.values())]
    if not free and all(slot.material is None for slot in slots):
        free = list(slots)
    if not free:
        obj.data.materials.append(material)
        obj.active_material_index = len(slots) - 1
        return len(slots) - 1
    for slot in free:
        slot.material = material
    return free[0].slot_index


def _assign_all_faces(obj, slot):
    mesh = obj.data
    indices = mesh.attributes.get("material_index") or mesh.attributes.new("material_index", "INT", "FACE")
    indices.data.foreach_set("value", np.full(len(mesh.polygons), slot, np.int32))
    mesh.update()
