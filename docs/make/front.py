# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The six pictures of the README: `python docs/make/front.py MESHES [--folder docs]`.

Three are rendered by the command line and halved, directions as streamlines; layers and vortices are cut out of the
pictures of their pages.
"""

import argparse
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np

import synch_fields
from synch_fields.core.extract import evenly_traced
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import attributes, files, meshes
from synch_fields.synch_addon.blender.schema import DIRECTION
from synch_fields.synch_addon.looks.render import render_picture
from synch_fields.synch_addon.nodes.canvas import surface_material
from synch_fields.synch_addon.nodes.stripes import INK_BLUE, WARM_IVORY

COMMANDS = {
    "stripes": ["stripes", "stanford-bunny.obj", "--view", "-20", "12"],
    "quads": ["quads", "spot.obj", "--view", "205", "12"],
    "quad_mesh": ["quad_mesh", "spot.obj", "--faces", "1500", "--view", "205", "12"],
}
# Pictures that are cut out, and the pixels from left and from the bottom.
CUT = {"layers": ("paper/figure3.png", (1680, 22, 2240, 442)), "vortices": ("vortices.png", (0, 0, 960, 720))}
# Where directions are shown, from where, at most how many streamlines, and their radius over the longest side.
SHOWN, VIEW, STREAMLINES, RADIUS = "fertility.obj", (-20, 10), 400, 0.004
# Width and height of the pictures.
SIZE = 600, 450


def pixels(path):
    """(height, width, 4) of a picture, from the bottom."""
    image = bpy.data.images.load(str(path))
    values = np.empty(image.size[0] * image.size[1] * 4, np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(image.size[1], image.size[0], 4)


def save(values, path):
    """Write a picture of this script's size; a larger one is made smaller."""
    image = bpy.data.images.new(path.stem, values.shape[1], values.shape[0])
    image.pixels.foreach_set(np.ascontiguousarray(values).ravel())
    image.scale(*SIZE)
    image.filepath_raw, image.file_format = str(path), "PNG"
    image.save()


def directions(path, picture):
    """Render the streamlines of a smooth line field as tubes on the shape of a file."""
    synch_fields.register()
    obj = files.open_object(path)
    obj.data.shade_smooth()
    api.directions(obj)
    given = meshes.read_mesh(obj)
    vectors = attributes.read_vectors(obj, DIRECTION.name, given)
    lines = evenly_traced(given.mesh, vectors, 2, STREAMLINES).segments(given.mesh)
    for name, color in (("Surface", WARM_IVORY), ("Streamlines", INK_BLUE)):
        material, surface, _ = surface_material(name)
        surface.inputs["Base Color"].default_value = color
        obj.data.materials.append(material)
    add_tubes(obj, lines, RADIUS * max(obj.dimensions))
    render_picture(obj, picture, view=VIEW, resolution=(2 * SIZE[0], 2 * SIZE[1]), samples=24, markers=False)
    synch_fields.unregister()


def add_tubes(obj, lines, radius):
    """Join tubes around (n, 2, 3) segments to an object, in its second material."""
    curve = bpy.data.curves.new("Tubes", "CURVE")
    curve.dimensions, curve.bevel_depth, curve.bevel_resolution = "3D", radius, 3
    for ends in lines:
        spline = curve.splines.new("POLY")
        spline.points.add(1)
        spline.points.foreach_set("co", np.column_stack([ends, np.ones(2)]).astype(np.float32).ravel())
    source = bpy.data.objects.new("Tubes", curve)
    bpy.context.scene.collection.objects.link(source)
    mesh = bpy.data.meshes.new_from_object(source.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    bpy.data.objects.remove(source)
    mesh.materials.append(obj.data.materials[1])
    mesh.shade_smooth()
    tubes = bpy.data.objects.new("Tubes", mesh)
    tubes.matrix_world = obj.matrix_world
    bpy.context.scene.collection.objects.link(tubes)
    with bpy.context.temp_override(active_object=obj, selected_editable_objects=[obj, tubes]):
        bpy.ops.object.join()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("meshes", type=Path)
    parser.add_argument("--folder", type=Path, default=Path("docs"))
    options = parser.parse_args()
    made = options.folder / "makes"
    made.mkdir(parents=True, exist_ok=True)
    for name, (command, mesh, *flags) in COMMANDS.items():
        picture = made / f"{name}.png"
        arguments = [command, str(options.meshes / mesh), *flags, "--render", str(picture), "--quiet"]
        subprocess.run([sys.executable, "-m", "synch_fields", *arguments], check=True)
        save(pixels(picture), picture)
    directions(options.meshes / SHOWN, made / "directions.png")
    save(pixels(made / "directions.png"), made / "directions.png")
    for name, (whole, (left, bottom, right, top)) in CUT.items():
        save(pixels(options.folder / whole)[bottom:top, left:right], made / f"{name}.png")


if __name__ == "__main__":
    main()
