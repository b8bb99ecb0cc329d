# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures made one by one, and put together to a sheet."""

import tempfile
from pathlib import Path

import bpy
import numpy as np

import synch_fields


def make_pictures(parser, pictures):
    """Make each picture, or the one that is asked for, by its function of the options, a folder and its path."""
    parser.add_argument("--only", choices=pictures, help="the name of one picture")
    options = parser.parse_args()
    synch_fields.register()
    for name, make in pictures.items():
        if options.only in (None, name):
            with tempfile.TemporaryDirectory() as folder:
                make(options, Path(folder), options.folder / f"{name}.png")
    synch_fields.unregister()


def pixels_of(path):
    """(height, width, 4) values of an image file, 0 to 1, rows from the top."""
    image = bpy.data.images.load(str(path))
    try:
        values = np.empty(4 * image.size[0] * image.size[1], np.float32)
        image.pixels.foreach_get(values)
        return values.reshape(image.size[1], image.size[0], 4)[::-1].copy()
    finally:
        bpy.data.images.remove(image)


def save_pixels(path, pixels, kind="PNG", quality=90):
    """Write (height, width, 3) values from 0 to 1, rows from the top, as an image file of one of Blender's kinds."""
    height, width, _ = pixels.shape
    image = bpy.data.images.new("Pixels", width, height)
    try:
        image.pixels.foreach_set(np.dstack([pixels[::-1], np.ones((height, width))]).astype(np.float32).ravel())
        image.file_format = kind
        image.save(filepath=str(Path(path).absolute()), quality=quality)
    finally:
        bpy.data.images.remove(image)


def beside(pictures, path, vertical=False):
    """One picture of several of the same size, from left to right or from top to bottom."""
    pixels = [pixels_of(picture)[..., :3] for picture in pictures]
    save_pixels(path, np.concatenate(pixels, axis=0 if vertical else 1))
