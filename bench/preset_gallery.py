# SPDX-License-Identifier: GPL-3.0-or-later
"""The presets on six shapes, for the product page; and their thumbnails, which ship with the extension.

    python bench/preset_gallery.py MESHES --folder docs [--only gallery | thumbnails]

Writes gallery.png to the folder and the thumbnails to synch_addon/looks/thumbnails. MESHES holds spot.obj,
stanford-bunny.obj, botijo.obj and cheburashka.obj. Needs Blender as a module (bpy).
"""

import tempfile
from pathlib import Path

import bpy
import numpy as np
from command import arguments
from figures import beside
from quad_gallery import plain_material

import synch_fields
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import files
from synch_fields.synch_addon.looks import assets, presets
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
THUMBNAIL = 128
# Stripes or quads across the sphere of a thumbnail, as many as can be told apart in it.
ACROSS, FINE = 11, 16
CLAY = (0.50, 0.44, 0.37, 1.0)


def main():
    """Run from the command line."""
    parser = arguments(__doc__, "the meshes", "the gallery goes")
    parser.add_argument("--only", choices=("gallery", "thumbnails"), help="one of both")
    options = parser.parse_args()
    synch_fields.register()
    try:
        if options.only != "gallery":
            thumbnails()
        if options.only != "thumbnails":
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


def thumbnails():
    """A sphere for each preset, and for each node group of the asset library."""
    assets.THUMBNAILS.mkdir(exist_ok=True)
    for name, preset in presets.PRESETS.items():
        obj = sphere()
        across = FINE if name in ("wood-cut", "fingerprint") else ACROSS
        api.preset(obj, name, spacing=spacing_across(obj, preset.kind, across))
        picture(obj, name)
    for _, name in assets.GROUPS.values():
        obj = sphere()
        kind = "quads" if "quad" in name else "stripes"
        getattr(api, kind)(obj, spacing=spacing_across(obj, kind))
        if "relief" in name:
            obj.active_material = plain_material("Clay", CLAY)
            api.relief(obj, height=0.3 if kind == "stripes" else 0.2, level=2)
        picture(obj, name)


def sphere():
    """A smooth sphere."""
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5, radius=1)
    bpy.context.object.data.shade_smooth()
    return bpy.context.object


def spacing_across(obj, kind, across=ACROSS):
    """The period of so many stripes or quads; one of quads has two."""
    return max(obj.dimensions) / across * (2 if kind == "quads" else 1)


def picture(obj, name):
    size = (THUMBNAIL, THUMBNAIL)
    render_picture(obj, assets.THUMBNAILS / f"{name}.png", resolution=size, samples=96, view=(-25, 22), markers=False)


if __name__ == "__main__":
    main()
