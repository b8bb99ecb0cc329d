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


def beside(pictures, path, vertical=False):
    """One picture of several of the same size, from left to right or from top to bottom."""
    loaded = [bpy.data.images.load(str(picture)) for picture in pictures]
    width, height = loaded[0].size
    pixels = [np.array(image.pixels).reshape(height, width, 4) for image in loaded]
    # Rows of pixels go from below upwards.
    whole = np.concatenate(pixels[::-1], axis=0) if vertical else np.concatenate(pixels, axis=1)
    image = bpy.data.images.new("whole", whole.shape[1], whole.shape[0])
    image.pixels = whole.ravel()
    image.filepath_raw, image.file_format = str(path.absolute()), "PNG"
    image.save()
