# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked values as image files or packed images, and the material that shows them."""

from pathlib import Path

import bpy
import numpy as np

from ...core.files.whole import is_whole_image, unwritten
from ...core.settings.bake import MAPS, SUFFIXES
from ..blender.transaction import assign, at_the_end, keep, only_for_now, set_aside
from ..nodes.canvas import find_node, surface_material
from ..nodes.materials import append_material, kept_spacing
from .shaders import SOURCE, pattern_node, sources

# Custom property of what a bake has made, and may replace: its map, or the object.
_MADE = "synch_baked"
# The kinds of nodes that are kept.
_SURFACE, _OUTPUT = "ShaderNodeBsdfPrincipled", "ShaderNodeOutputMaterial"
# Of the material that is baked: the node that scales its relief, in spacings, and what stands for a missing one.
_RELIEF_NODE, _RELIEF = "Relief", 0.05


def file_name(settings, name, map_name):
    """Name of the file or image of an object's map, by the naming of :class:`BakeSettings`."""
    stem = bpy.path.clean_name(settings.naming.format(object=name, map=map_name))
    return stem + SUFFIXES[settings.file_format]


def save(values, path, settings, map_name):
    """Write (size, size, k) values to an image file; grey ones for k = 1.

    Only the colour is encoded for the screen, and only as PNG; everything else is kept as it is.
    """
    with only_for_now():
        _save(values, path, settings, map_name, bpy.data.scenes.new("Synch Bake"))


def _save(values, path, settings, map_name, scene):
    """Write an image file as :func:`save`, by the image settings of a scene, which this changes."""
    kind = MAPS[map_name]
    image_settings = scene.render.image_settings
    image_settings.file_format = "PNG" if settings.file_format == "PNG" else "OPEN_EXR"
    image_settings.color_mode = "BW" if kind.is_grey else "RGB"
    image_settings.color_depth = settings.depth(map_name)
    if settings.file_format == "EXR":
        image_settings.exr_codec = "ZIP"
    scene.view_settings.view_transform = "Standard" if kind.is_color else "Raw"
    scene.view_settings.look = "None"
    size = len(values)
    image = bpy.data.images.new("Synch Bake", size, size, float_buffer=True, is_data=not kind.is_color)
    opaque = np.ones((size, size, 4), np.float32)
    opaque[:, :, :3] = values
    image.pixels.foreach_set(opaque.ravel())
    try:
        image.save_render(str(path), scene=scene)
    except RuntimeError as error:
        raise unwritten(path, str(error).strip().splitlines()[0]) from error
    if not is_whole_image(path):
        raise unwritten(path, "only a part arrived")


def pack_image(path, name, map_name):
    """A saved file as an image in the .blend; it takes the place of one that an earlier bake made under its name."""
    older = bpy.data.images.get(name)
    image = bpy.data.images.load(str(path))
    image.pack()
    image.use_fake_user = True  # nothing else may use it, and a file is saved without what is not used
    image.filepath_raw = f"//{name}"
    if older is not None and older.get(_MADE) == map_name:
        set_aside(older)
        at_the_end(lambda: (older.user_remap(image), bpy.data.images.remove(older)))
    return _declared(image, name, map_name)


def load_image(path, map_name):
    """The image of a file."""
    count = len(bpy.data.images)
    image = bpy.data.images.load(str(path), check_existing=True)
    if len(bpy.data.images) == count:
        keep(image)
    return _declared(image, path.name, map_name)


def reload(path):
    """Let the images that show a file show it as it is now."""
    for image in bpy.data.images:
        if image.filepath and Path(bpy.path.abspath(image.filepath, library=image.library)) == path:
            image.reload()


def _declared(image, name, map_name):
    image.name, image[_MADE] = name, map_name
    if not MAPS[map_name].is_color:
        image.colorspace_settings.name = "Non-Color"
    image.alpha_mode = "NONE"
    return image


def show_images(obj, kind, images, uv_map, with_displacement, name):
    """Show images on an object: in the slots that show the pattern, or else in a new last one. Returns the materials.

    Each remembers the material that it replaces, which stays in the file and is what the next bake looks at.
    ``images``: by the names of their maps; ``name``: of a new material.
    """
    shown = [(slot, source) for slot, source in zip(obj.material_slots, sources(obj), strict=True)]
    shown = [(slot, source) for slot, source in shown if pattern_node(source, kind) or _is_made_for(slot.material, obj)]
    if not shown:
        append_material(obj, None)
        shown = [(obj.material_slots[-1], None)]
    made = {source: slot.material for slot, source in shown if _is_made_for(slot.material, obj)}
    for material in made.values():
        keep(material)  # before slots are changed: what takes its place where the work fails comes to them last
    for slot, source in shown:
        if source not in made:
            made[source] = _new_material(obj, source, name)
        assign(slot, "material", made[source])
    for material in made.values():
        _fill(material, obj, images, uv_map, with_displacement)
    return list(made.values())


def _is_made_for(material, obj):
    return material is not None and material.get(_MADE) == obj.name


def _new_material(obj, source, name):
    material, surface, _ = surface_material(name)
    material[_MADE] = obj.name
    if source is not None:
        material[SOURCE] = source
        shader = find_node(source.node_tree, _SURFACE)
        if shader:
            surface.inputs["Roughness"].default_value = shader.inputs["Roughness"].default_value
    return material


def _fill(material, obj, images, uv_map, with_displacement):
    """Build the tree of a material of images anew; its shader stays as it is."""
    tree = material.node_tree
    surface, output = (find_node(tree, kind) or tree.nodes.new(kind) for kind in (_SURFACE, _OUTPUT))
    tree.links.new(surface.outputs[0], output.inputs["Surface"])
    for node in list(tree.nodes):
        if node not in (surface, output):
            tree.nodes.remove(node)
    places = _place_image(tree, "ShaderNodeUVMap", (-900, -200))
    places.uv_map = uv_map
    textures = {}
    for row, name in enumerate(name for name in ("colour", "normal", "height") if name in images):
        texture = _place_image(tree, "ShaderNodeTexImage", (-680, 40 - 300 * row))
        texture.image, texture.label = images[name], name
        tree.links.new(places.outputs[0], texture.inputs["Vector"])
        textures[name] = texture.outputs["Color"]
    if "colour" in textures:
        tree.links.new(textures["colour"], surface.inputs["Base Color"])
    relief = _relief(material.get(SOURCE), obj)
    if "normal" in textures:
        normal = _place_image(tree, "ShaderNodeNormalMap", (-300, -260))
        normal.uv_map = uv_map
        tree.links.new(textures["normal"], normal.inputs["Color"])
        tree.links.new(normal.outputs[0], surface.inputs["Normal"])
    elif "height" in textures and not with_displacement:
        bump = _place_image(tree, "ShaderNodeBump", (-300, -260), Distance=relief)
        tree.links.new(textures["height"], bump.inputs["Height"])
        tree.links.new(bump.outputs[0], surface.inputs["Normal"])
    if with_displacement:
        raised = _place_image(tree, "ShaderNodeDisplacement", (0, -560), Midlevel=0.0, Scale=relief)
        tree.links.new(textures["height"], raised.inputs["Height"])
        tree.links.new(raised.outputs[0], output.inputs["Displacement"])
    material.displacement_method = "BOTH" if with_displacement else "BUMP"


def _place_image(tree, type_name, location, **values):
    node = tree.nodes.new(type_name)
    node.location = location
    for name, value in values.items():
        node.inputs[name].default_value = value
    return node


def _relief(source, obj):
    """How high the pattern is raised by a material of ours, in scene units."""
    nodes = source.node_tree.nodes if source and source.node_tree else ()
    parts = [node.inputs[1].default_value for node in nodes if node.label == _RELIEF_NODE]
    return (kept_spacing(obj) or 0.0) * (parts[0] if parts else _RELIEF)
