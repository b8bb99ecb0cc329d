# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes without light that are seen straight from above: maps, diagrams."""

import bpy

WHITE = (1, 1, 1, 1)


def flat_scene(path, width, resolution, samples=16):
    """A white scene from -width / 2 to width / 2, as high as its resolution in pixels asks for."""
    scene = bpy.data.scenes.new("Flat")
    scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.camera.data.type, scene.camera.location.z = "ORTHO", 10
    # The scale is that of the longer side.
    scene.camera.data.ortho_scale = width * max(1, resolution[1] / resolution[0])
    scene.collection.objects.link(scene.camera)
    scene.world = bpy.data.worlds.new("White")
    if scene.world.node_tree is None:
        scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = WHITE
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", samples, False
    scene.render.resolution_x, scene.render.resolution_y = resolution
    scene.render.filepath, scene.view_settings.view_transform = str(path), "Standard"
    return scene


def glowing(color):
    """A material that shows the colours of a node group, or a colour, without light."""
    material = bpy.data.materials.new("Glowing")
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    light = tree.nodes.new("ShaderNodeEmission")
    if isinstance(color, bpy.types.NodeTree):
        node = tree.nodes.new("ShaderNodeGroup")
        node.node_tree = color
        tree.links.new(node.outputs["Color"], light.inputs["Color"])
    else:
        light.inputs["Color"].default_value = color
    tree.links.new(light.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    return material
