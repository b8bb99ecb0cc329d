# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The moving picture of the README: two knobs are turned, stripes follow, and a quad mesh is made of them.

    python docs/make/moving.py MESHES --folder docs

Every frame is a result of the program: the settings change as a user changes them with Live on. MESHES holds spot.obj.
Needs Blender as a module (bpy).
"""

import tempfile
from dataclasses import replace
from math import pi, sin
from pathlib import Path

import bpy
import numpy as np

import synch_fields
from synch_fields.bench.command import arguments
from synch_fields.core.solve.following import Follower
from synch_fields.docs.make import knobs, webp
from synch_fields.docs.make.gallery import opened
from synch_fields.docs.make.sheets import pixels_of, save_pixels
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender.transaction import only_for_now
from synch_fields.synch_addon.jobs import job
from synch_fields.synch_addon.looks.render import picture_scene, render_scene, stand_in
from synch_fields.synch_addon.patterns import memory
from synch_fields.synch_addon.patterns.live import LiveJob
from synch_fields.synch_addon.patterns.reading import settings_for
from synch_fields.synch_addon.settings.fields import Settings

SHAPE, VIEW = "spot", (215, 12)
# Pixels of what is rendered, of which columns are cut off at the left: the knobs stand at the right.
WIDTH, HEIGHT, CUT = 780, 400, 140
SAMPLES, QUALITY = 16, 82
# Stripes along the longest side at both ends of the first knob's way; degrees by which the second one turns them.
STRIPES, TURN = (8.0, 22.0), 90.0
FACES = 1500
# Frames in which the knobs are turned, one picture fades into the next, and the mesh turns to and fro, by degrees.
TURNED, FADED, SWUNG, SWING = 24, 5, 24, 42.0
# Milliseconds of a frame, and of those that the eye should rest on.
SHORT, LONG = 75, 900
KNOBS, BUTTON = {"Spacing": (565, 88), "Direction": (565, 208)}, (565, 322)


def main():
    """Run from the command line."""
    options = arguments(__doc__, f"{SHAPE}.obj", "the picture goes").parse_args()
    synch_fields.register()
    try:
        with tempfile.TemporaryDirectory() as folder, only_for_now():
            scenes = Film(opened(options.meshes, SHAPE, 1), Path(folder))
            frames = scenes.frames()
            path = options.folder / "moving.webp"
            path.write_bytes(webp.animated(*scenes.encoded(frames)))
            print(f"{path}: {len(frames)} frames, {path.stat().st_size / 1e6:.2f} MB")
    finally:
        synch_fields.unregister()


class Film:
    """Renders what an object shows, from one place.

    Parameters
    ----------
    obj : bpy.types.Object
    folder : Path for files on the way
    """

    def __init__(self, obj, folder):
        self.obj, self.folder, self._size = obj, folder, max(obj.dimensions)
        self._followers = Follower(), Follower()
        self._settings = Settings(spacing=self._size / STRIPES[0], guidance="curvature-min")
        api.run("stripes", obj, self._settings)
        self._scene, self._shown = picture_scene(
            obj, resolution=(WIDTH, HEIGHT), markers=False, edges=False, view=VIEW
        )

    def frames(self):
        """Pictures, (height, width, 3), and the milliseconds for which each is shown."""
        turned = [self._turned(*shares) for shares in _shares()]
        mesh = self._mesh()
        swung = [(self._swung(mesh, _share(n, SWUNG)), (1.0, 1.0, 1.0), SHORT) for n in range(SWUNG)]
        turned[0], turned[TURNED], turned[-1] = (
            (*frame[:2], LONG) for frame in (turned[0], turned[TURNED], turned[-1])
        )
        swung[0] = (*swung[0][:2], LONG)
        whole = [*turned, *_faded(turned[-1], swung[0]), *swung, *_faded(swung[0], turned[0])]
        return [(_with_knobs(picture, values), shown) for picture, values, shown in whole]

    def encoded(self, frames):
        """Still files of frames, the size of all, and the milliseconds of each."""
        path, stills = self.folder / "still.webp", []
        for picture, _ in frames:
            save_pixels(path, picture, "WEBP", QUALITY)
            stills.append(path.read_bytes())
        return stills, (WIDTH - CUT, HEIGHT), [shown for _, shown in frames]

    def _turned(self, first, second):
        """The frame after the knobs went to shares of their ways."""
        stripes = STRIPES[0] * (STRIPES[1] / STRIPES[0]) ** first
        settings = replace(self._settings, spacing=self._size / stripes, angle=np.radians(TURN * second))
        asked = settings_for("stripes", self.obj, settings)
        shown = memory.state(self.obj)
        if asked != shown.report.settings:
            job.run(LiveJob(self.obj, asked, shown, self._followers, instead=True))
        return self._rendered(), (first, second, 0.0), SHORT

    def _mesh(self):
        """The quad mesh in place of the object; returns what stands for it in the scene."""
        name = api.quad_mesh(self.obj, faces=FACES)["quad_mesh"]["object"]
        bpy.data.objects[name].data.materials.clear()
        self._shown.hide_render = True
        return stand_in(bpy.data.objects[name], self._scene, edges=True)

    def _swung(self, mesh, share):
        mesh.rotation_euler.z = -np.radians(SWING) * sin(2 * pi * share)
        return self._rendered()

    def _rendered(self):
        path = self.folder / "frame.png"
        render_scene(self._scene, path, (WIDTH, HEIGHT), SAMPLES)
        return pixels_of(path)[:, CUT:, :3]


def _shares():
    """Where both knobs are in each frame: one is turned after the other."""
    ways = [_share(n, TURNED) for n in range(TURNED + 1)]
    return [(_eased(way), 0.0) for way in ways] + [(1.0, _eased(way)) for way in ways[1:]]


def _share(number, count):
    return number / count


def _eased(share):
    return share * share * (3 - 2 * share)


def _faded(first, last):
    """Frames between two."""
    for number in range(1, FADED + 1):
        share = number / (FADED + 1)
        values = tuple(a + share * (b - a) for a, b in zip(first[1], last[1], strict=True))
        yield (1 - share) * first[0] + share * last[0], values, SHORT


def _with_knobs(picture, values):
    picture = picture.copy()
    for (name, place), value in zip(KNOBS.items(), values, strict=False):
        knobs.knob(picture, place, name, value)
    knobs.button(picture, BUTTON, "Quad Mesh", values[-1])
    return picture


if __name__ == "__main__":
    main()
