# SPDX-License-Identifier: GPL-3.0-or-later
"""The presets on six shapes, for the product page.

    python docs/make/gallery.py MESHES --folder docs

MESHES holds spot.obj, stanford-bunny.obj, botijo.obj and cheburashka.obj. Needs Blender as a module (bpy).
"""

import tempfile
from pathlib import Path

import bpy
import numpy as np

import synch_fields
from synch_fields.bench.command import arguments
from synch_fields.docs.make.sheets import beside
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import files
from synch_fields.synch_addon.looks.render import render_picture

# Preset, shape, how often it is subdivided, and where it is seen from.
SHAPES = (
    ("zebra", "spot", 1, (215, 12)),
    ("corduroy", "stanford-bunny", 0, (-20, 12)),
    ("wood-cut", "Suzanne", 3, (-22, 8)),
    ("knit", "spot", 2, (150, 12)),
    ("cane", "botijo", 0, (-30, 18)),
    ("fingerprint", "cheburashka", 1, (-25, 12)),
)
# Shapes whose files have Z upwards, which reading turns.
LYING = ("botijo",)
TILE = (400, 380)


def main():
    """Run from the command line."""
    options = arguments(__doc__, "the meshes", "the gallery goes").parse_args()
    synch_fields.register()
    try:
        gallery(options.meshes, options.folder / "gallery.png")
    finally:
        synch_fields.unregister()


def gallery(meshes, path):
    """Each preset on a shape of its own, three in a row."""
    with tempfile.TemporaryDirectory() as folder:
        pictures = []
        for name, shape, level, view in SHAPES:
            obj = opened(meshes, shape, level)
            if shape in LYING:
                obj.rotation_euler.x = -np.pi / 2
                bpy.context.view_layer.update()
            api.preset(obj, name)
            picture = Path(folder) / f"{name}.png"
            pictures.append(render_picture(obj, picture, view=view, resolution=TILE, samples=24, markers=False))
        sheet(pictures, Path(folder), path)


def sheet(pictures, folder, path):
    """Six pictures in two rows, as a small file: three quarters of the size, half of the values."""
    rows = [folder / f"row{start}.png" for start in (0, 3)]
    for start, row in zip((0, 3), rows, strict=True):
        beside(pictures[start : start + 3], row)
    beside(rows, folder / "sheet.png", vertical=True)
    image = bpy.data.images.load(str(folder / "sheet.png"))
    image.scale(*(3 * length // 4 for length in image.size))
    values = np.empty(4 * image.size[0] * image.size[1], np.float32)
    image.pixels.foreach_get(values)
    image.pixels.foreach_set(np.round(values * 127) / 127)
    scene = bpy.context.scene
    scene.view_settings.view_transform = "Standard"
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.compression = "PNG", "RGB", 100
    image.save_render(str(path.absolute()), scene=scene)


def opened(meshes, shape, level):
    """A smooth object of a shape, upright."""
    bpy.ops.wm.read_homefile(use_empty=True)
    if shape == "Suzanne":
        bpy.ops.mesh.primitive_monkey_add()
    else:
        files.open_input(str(meshes / f"{shape}.obj"))
    obj = bpy.context.object if shape == "Suzanne" else files.choose_object(None)
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    bpy.ops.object.transform_apply()  # so that its Z is upwards
    if level:
        obj.modifiers.new("Fine", "SUBSURF").levels = level
        bpy.ops.object.modifier_apply(modifier="Fine")
    obj.data.shade_smooth()
    return obj


if __name__ == "__main__":
    main()
