# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures made one by one, and put together to a sheet."""

import tempfile
from functools import cache
from pathlib import Path

import bpy
import numpy as np

import synch_fields

# The colours of letters and of the paper below them; the letters' size in pixels.
NAVY, PAPER = np.array([(24, 43, 92), (247, 245, 240)]) / 255
LETTERS = 30


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


def beside(pictures, path, vertical=False, labels=()):
    """One picture of several of the same size, from left to right or from top to bottom.

    Labels, one for each picture, are written above the pictures, upwards on their left where they are from top to
    bottom.
    """
    pixels = [pixels_of(picture)[..., :3] for picture in pictures]
    turns = 1 if vertical else 0
    if labels:
        pairs = zip(pixels, labels, strict=True)
        pixels = [np.rot90(labelled(np.rot90(picture, -turns), label), turns) for picture, label in pairs]
    save_pixels(path, np.concatenate(pixels, axis=0 if vertical else 1))


def labelled(picture, text):
    """A picture below a band with a text."""
    band = np.full((2 * LETTERS, *picture.shape[1:]), PAPER)
    write(band, (picture.shape[1] / 2, LETTERS), text, size=LETTERS)
    return np.concatenate([band, picture])


def write(picture, place, text, color=NAVY, size=15):
    """Write a text of letters of a size in pixels around a place, x and y from the top left, into a picture."""
    cover = _cover_of(text, size)
    height, width = cover.shape
    left, top = round(place[0] - width / 2), round(place[1] - height / 2)
    paint(picture[top : top + height, left : left + width], color, cover)


@cache
def _cover_of(text, size):
    """What a text covers of a box around it, (height, width), 0 to 1; capitals without a tail are in the middle."""
    import blf  # on the path once bpy is loaded
    import imbuf

    font = 0
    blf.size(font, size)
    blf.color(font, 1, 1, 1, 1)
    width, height, capital = round(blf.dimensions(font, text)[0]) + 4, 2 * size, blf.dimensions(font, "H")[1]
    canvas = imbuf.new((width, height))
    with blf.bind_imbuf(font, canvas):
        blf.position(font, 2, (height - capital) / 2, 0)
        blf.draw_buffer(font, text)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "text.png"
        imbuf.write(canvas, filepath=str(path))
        return pixels_of(path)[..., 3]


def paint(picture, color, cover):
    """Mix a colour into a picture by (height, width) shares."""
    picture += cover[..., None] * (color - picture)
