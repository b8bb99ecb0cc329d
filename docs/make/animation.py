# SPDX-License-Identifier: GPL-3.0-or-later
"""Four frames of an animation side by side: stripes on the bending tentacle of bench/animation.py.

    python docs/make/animation.py --folder docs

Needs Blender as a module (bpy).
"""

import tempfile
from pathlib import Path

import bpy

import synch_fields
from synch_fields.bench.animation import FRAMES, SPACING, tentacle
from synch_fields.bench.command import arguments
from synch_fields.docs.make.sheets import beside
from synch_fields.synch_addon import api
from synch_fields.synch_addon.looks.render import render_picture

SHOWN = (1, 7, 13, 19)
TILE = (460, 560)


def main():
    """Run from the command line."""
    options = arguments(__doc__, folder="the picture goes").parse_args()
    synch_fields.register()
    try:
        bpy.ops.wm.read_homefile(use_empty=True)
        obj = tentacle()
        api.animate(obj, frames=(1, FRAMES), spacing=SPACING)
        render(obj, options.folder / "animation.png")
    finally:
        synch_fields.unregister()


def render(obj, path):
    """Four frames side by side."""
    with tempfile.TemporaryDirectory() as folder:
        tiles = []
        for frame in SHOWN:
            bpy.context.scene.frame_set(frame)
            tiles.append(Path(folder) / f"{frame}.png")
            render_picture(obj, tiles[-1], view=(-12, 10), resolution=TILE, samples=48, markers=False)
        beside(tiles, path)


if __name__ == "__main__":
    main()
