# SPDX-License-Identifier: GPL-3.0-or-later
"""The bunny with baked stripes: rendered from the images, the images, and one closely at the centre of a dislocation.

    python docs/make/bake.py MESHES --folder docs

Prints how long each map takes at 2048 pixels; the last picture is a part of the colour at 4096. MESHES holds
stanford-bunny.obj. Needs Blender as a module (bpy).
"""

import tempfile
from pathlib import Path

import bpy
import numpy as np
from scipy.ndimage import distance_transform_edt

import synch_fields
from synch_fields.bench.command import arguments
from synch_fields.bench.tables import Column, print_table
from synch_fields.core.settings.bake import MAPS, NEW_MAP
from synch_fields.docs.make.sheets import beside
from synch_fields.synch_addon import api
from synch_fields.synch_addon.bakes.scene_copy import read_uv
from synch_fields.synch_addon.blender import files, meshes
from synch_fields.synch_addon.looks.render import render_picture

SIZE, CLOSE_SIZE = 2048, 4096
COLUMNS = (Column("s", "seconds", ".1f"), Column("MB", "mb", ".2f"))
# Of each picture in the row, and how many times the pixels of the close one are enlarged.
TILE, TIMES = 512, 4
LABELS = ("rendered from the images", "colour image", "normal image", "a line end, enlarged")


def main():
    """Run from the command line."""
    options = arguments(__doc__, "the mesh", "the picture goes").parse_args()
    synch_fields.register()
    try:
        make(options)
    finally:
        synch_fields.unregister()


def make(options):
    """Bake, render, and make the row of pictures."""
    obj = files.open_object(options.meshes / "stanford-bunny.obj")
    solved = api.stripes(obj, assign_material=True)
    with tempfile.TemporaryDirectory() as folder:
        settings = dict(unwrap=True, folder=folder)
        report = api.bake(obj, maps=list(MAPS), size=SIZE, naming="{map}", material=True, **settings)
        rows = [{"label": name, "mb": entry["bytes"] / 2**20} | entry for name, entry in report["maps"].items()]
        print_table(f"Bake at {SIZE} pixels, {report['seconds']:.0f} s", COLUMNS, rows)
        tiles = [Path(folder) / f"tile{number}.png" for number in range(4)]
        render_picture(obj, tiles[0], view=(-20, 12), resolution=(TILE, TILE), samples=48, markers=False)
        for name, tile in (("colour", tiles[1]), ("normal", tiles[2])):
            save(block_means(pixels_of(report["maps"][name]["file"])), tile)
        api.bake(obj, maps="colour", size=CLOSE_SIZE, naming="close", **settings)
        whole = pixels_of(Path(folder) / "close.png")
        save(close_up(obj, whole, solved["dislocations"]), tiles[3])
        beside(tiles, options.folder / "bake.png", labels=LABELS)


def pixels_of(path):
    """(size, size, 3) values of an image file as they are stored, the lowest row first."""
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    values = np.empty(4 * image.size[0] * image.size[1], np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(image.size[1], image.size[0], 4)[:, :, :3]


def block_means(values):
    """An image made smaller to the width of a tile: each pixel is the mean of a block."""
    factor = len(values) // TILE
    return values.reshape(TILE, factor, TILE, factor, 3).mean(axis=(1, 3))


def close_up(obj, values, dislocations):
    """Enlarged pixels around the dislocation that lies farthest inside an island, with its triangle drawn in red."""
    size, half = len(values), TILE // TIMES // 2
    uv = read_uv(obj.data.uv_layers[NEW_MAP])
    corners = [uv[list(obj.data.polygons[d["face"]].loop_indices)] * size for d in dislocations]
    covered = np.zeros((size, size), bool)
    triangles = uv[meshes.read_polygons(obj).triangle_corners].mean(axis=1) * size
    covered[triangles[:, 1].astype(int), triangles[:, 0].astype(int)] = True
    depth = distance_transform_edt(distance_transform_edt(~covered) < 12)
    centres = np.array([corner.mean(axis=0) for corner in corners])
    inside = ((centres > half) & (centres < size - half)).all(axis=1)
    chosen = np.argmax(depth[centres[:, 1].astype(int), centres[:, 0].astype(int)] * inside)
    low = np.rint(centres[chosen] - half).astype(int)
    part = values[low[1] : low[1] + 2 * half, low[0] : low[0] + 2 * half]
    part = part.repeat(TIMES, axis=0).repeat(TIMES, axis=1)
    ends = (corners[chosen] - low) * TIMES
    share = np.linspace(0, 1, 8 * TILE)[:, None]
    for start, end in zip(ends, np.roll(ends, -1, axis=0), strict=True):
        x, y = np.clip(((1 - share) * start + share * end).astype(int), 0, TILE - 2).T
        for aside in (0, 1):
            part[y + aside, x] = part[y, x + aside] = (0.9, 0.1, 0.1)
    return part


def save(values, path):
    """Write (h, w, 3) values as they are to a PNG file."""
    image = bpy.data.images.new(path.stem, values.shape[1], values.shape[0])
    image.colorspace_settings.name = "Non-Color"
    image.pixels.foreach_set(np.dstack([values, np.ones(values.shape[:2])]).astype(np.float32).ravel())
    image.filepath_raw, image.file_format = str(path), "PNG"
    image.save()


if __name__ == "__main__":
    main()
