# SPDX-License-Identifier: GPL-3.0-or-later
"""The material that shows stripes on an object, placed so that nothing of the user's is lost."""

import bpy
import numpy as np

from .nodes import STRIPES_NAME, WARM_IVORY, stripes_group

_SPACING = "synch_spacing"
# Height of a stripe over the ground, in periods: enough for light to catch, too little to look carved.
_RELIEF = 0.05


def stripes_material(obj, *, spacing=None, assign_faces=False) -> bpy.types.Material:
    """Give a mesh object the material "Synch Stripes" and return it.

    - A slot holds it already (or another material that uses its node group): nothing changes, so
      what the user has made of its look survives a second run.
    - The object has no materials: it gets the one of this file, and empty slots are filled with it.
    - It has other materials: ours goes into a new last slot and becomes the active one; faces keep
      theirs, unless `assign_faces` gives all of them to the new slot.

    `spacing` is the distance between stripes in scene units; the relief of the stripes follows it.
    It is kept as the custom property `synch_spacing` of the object. Without it, a first run takes
    a part of the object's size.
    """
    _store_spacing(obj, spacing)
    stripes_group()
    present = next((slot for slot in obj.material_slots if _shows_stripes(slot.material)), None)
    if present:
        if assign_faces:
            _assign_all_faces(obj, present.slot_index)
        return present.material
    material = _shared_material()
    _add_to_slots(obj, material, assign_faces)
    return material


def _store_spacing(obj, spacing):
    if spacing is not None:
        obj[_SPACING] = float(spacing)
    elif _SPACING not in obj and any(obj.dimensions):
        obj[_SPACING] = max(obj.dimensions) / 30.0


def _shows_stripes(material):
    if material is None or material.node_tree is None:
        return False
    return any(getattr(node, "node_tree", None) == stripes_group() for node in material.node_tree.nodes)


def _shared_material():
    """The file's own stripes material, made on first use."""
    for material in bpy.data.materials:
        if material.library is None and material.name.startswith(STRIPES_NAME) and _shows_stripes(material):
            return material
    return _new_material()


def _new_material():
    material = bpy.data.materials.new(STRIPES_NAME)
    if material.node_tree is None:
        material.use_nodes = True
    # Solid viewport shading cannot show stripes; the ground colour there is calmer than white.
    material.diffuse_color = WARM_IVORY
    material.roughness = 0.6
    tree = material.node_tree
    surface = tree.nodes["Principled BSDF"]
    surface.location = (0, 0)
    surface.inputs["Roughness"].default_value = 0.42
    tree.nodes["Material Output"].location = (320, 0)
    stripes = tree.nodes.new("ShaderNodeGroup")
    stripes.node_tree = stripes_group()
    stripes.location, stripes.width = (-520, 0), 200
    tree.links.new(stripes.outputs["Color"], surface.inputs["Base Color"])
    bump = _add_bump(tree)
    tree.links.new(stripes.outputs["Height"], bump.inputs["Height"])
    tree.links.new(bump.outputs["Normal"], surface.inputs["Normal"])
    for node in tree.nodes:
        node.select = node == stripes
    tree.nodes.active = stripes
    return material


def _add_bump(tree):
    """A Bump node whose distance is a part of the spacing of the object that it is seen on."""
    spacing = tree.nodes.new("ShaderNodeAttribute")
    spacing.attribute_type, spacing.attribute_name = "OBJECT", _SPACING
    spacing.label, spacing.location = "Spacing", (-520, -320)
    relief = tree.nodes.new("ShaderNodeMath")
    relief.operation, relief.label, relief.location = "MULTIPLY", "Relief", (-340, -320)
    relief.inputs[1].default_value = _RELIEF
    bump = tree.nodes.new("ShaderNodeBump")
    bump.location = (-170, -200)
    bump.inputs["Strength"].default_value = 0.6
    tree.links.new(spacing.outputs["Fac"], relief.inputs[0])
    tree.links.new(relief.outputs[0], bump.inputs["Distance"])
    return bump


def _add_to_slots(obj, material, assign_faces):
    slots = obj.material_slots
    if len(slots) and all(slot.material is None for slot in slots):
        for slot in slots:
            slot.material = material
        return
    obj.data.materials.append(material)
    obj.active_material_index = len(slots) - 1
    if assign_faces:
        _assign_all_faces(obj, len(slots) - 1)


def _assign_all_faces(obj, slot):
    mesh = obj.data
    indices = mesh.attributes.get("material_index") or mesh.attributes.new("material_index", "INT", "FACE")
    indices.data.foreach_set("value", np.full(len(mesh.polygons), slot, np.int32))
    mesh.update()
