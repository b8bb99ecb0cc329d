# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The six pictures of the README: `python docs/make/front.py MESHES [--folder docs]`.

Four are rendered by the command line and halved; layers and vortices are cut out of the pictures of their pages.
"""

import argparse
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np

COMMANDS = {
    "stripes": ["stripes", "stanford-bunny.obj", "--view", "-20", "12"],
    "directions": ["directions", "spot.obj", "--symmetry", "cross", "--view", "205", "12"],
    "quads": ["quads", "spot.obj", "--view", "205", "12"],
    "quad_mesh": ["quad_mesh", "spot.obj", "--faces", "1500", "--view", "205", "12"],
}
# Pictures that are cut out, and the pixels from left and from the bottom.
CUT = {"layers": ("printing.png", (560, 0, 1120, 420)), "vortices": ("vortices.png", (0, 0, 960, 720))}
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
    for name, (whole, (left, bottom, right, top)) in CUT.items():
        save(pixels(options.folder / whole)[bottom:top, left:right], made / f"{name}.png")


if __name__ == "__main__":
    main()
