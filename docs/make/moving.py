# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The moving picture of the README: two knobs are turned, stripes follow, and a quad mesh is made of the shape.

    python docs/make/moving.py MESHES --folder docs

Stripes are solved at some positions of each knob. Between two of them cos θ is mixed, pixel by pixel, so that stripes
flow from one pattern into the next. MESHES holds spot.obj. Needs Blender as a module (bpy).
"""

import tempfile
from dataclasses import replace
from math import pi, sin
from pathlib import Path

import bpy
import numpy as np

import synch_fields
from synch_fields.bench.command import arguments
from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.docs.make import knobs, webp
from synch_fields.docs.make.gallery import opened
from synch_fields.docs.make.sheets import pixels_of, save_pixels
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender.transaction import only_for_now
from synch_fields.synch_addon.looks.render import picture_scene, render_scene, stand_in
from synch_fields.synch_addon.nodes.canvas import surface_material
from synch_fields.synch_addon.nodes.stripes import STRIPES_NAME
from synch_fields.synch_addon.patterns import memory

SHAPE, VIEW = "spot", (215, 12)
# Pixels of what is rendered, of which columns are cut off at the left: the knobs stand at the right.
WIDTH, HEIGHT, CUT = 780, 400, 140
SAMPLES, QUALITY = 16, 82
WAVE_NODES = ("ShaderNodeGroup", "ShaderNodeMath", "ShaderNodeCombineColor")
# Stripes along the longest side at both ends of the first knob's way; degrees by which the second one turns them.
STRIPES, TURN = (20.0, 8.0), 90.0
FACES = 3000
# Solved positions of a knob, and frames from one to the next.
POSITIONS, BETWEEN = 9, 3
# Variations of a solve of which one is shown.
VARIATIONS = 6
# Frames in which one picture fades into the next, and in which the mesh turns to and fro, by degrees.
FADED, SWUNG, SWING = 4, 20, 42.0
# Milliseconds of a frame, and of those that the eye should rest on.
SHORT, LONG = 75, 900
KNOBS, BUTTON = {"Spacing": (565, 84), "Direction": (565, 212)}, (565, 330)


def main():
    """Run from the command line."""
    options = arguments(__doc__, f"{SHAPE}.obj", "the picture goes").parse_args()
    synch_fields.register()
    try:
        with tempfile.TemporaryDirectory() as folder, only_for_now():
            frames = Film(opened(options.meshes, SHAPE, 1), Path(folder)).frames()
            path = options.folder / "moving.webp"
            path.write_bytes(encoded(frames, Path(folder) / "still.webp"))
            print(f"{path}: {len(frames)} frames, {path.stat().st_size / 1e6:.2f} MB")
    finally:
        synch_fields.unregister()


def encoded(frames, path):
    """The bytes of the film, whose stills go through a file."""
    stills = []
    for picture, _ in frames:
        save_pixels(path, picture, "WEBP", QUALITY)
        stills.append(path.read_bytes())
    return webp.animated(stills, (WIDTH - CUT, HEIGHT), [milliseconds for _, milliseconds in frames])


class Film:
    """Renders what an object shows, from one place.

    Parameters
    ----------
    obj : bpy.types.Object
    folder : Path for files on the way
    """

    def __init__(self, obj, folder):
        self.obj, self.folder, self._size = obj, folder, max(obj.dimensions)
        self._settings = SurfaceSettings(guidance="curvature-min")
        self._phases = np.ones(1)
        self._solve(0.0, 0.0)
        self._lit, self._shown = picture_scene(obj, resolution=(WIDTH, HEIGHT), markers=False, edges=False, view=VIEW)
        self._flat = flat_scene(obj, self._lit.camera)
        nodes = obj.active_material.node_tree.nodes
        self._width = next(node for node in nodes if node.type == "GROUP").inputs["Width"]
        self._plain, self._inked = self._with_width(0.0), self._with_width(1.0)

    def frames(self):
        """Pictures, (height, width, 3), and the milliseconds for which each is shown."""
        striped = self._striped()
        mesh = self._mesh()
        swung = [(self._swung(mesh, n / SWUNG), (1.0, 1.0, 1.0), SHORT) for n in range(SWUNG)]
        for part, place in ((striped, 0), (striped, len(striped) // 2), (striped, -1), (swung, 0)):
            part[place] = (*part[place][:2], LONG)
        whole = [*striped, *_faded(striped[-1], swung[0]), *swung, *_faded(swung[0], striped[0])]
        return [(_with_knobs(picture, values), milliseconds) for picture, values, milliseconds in whole]

    def _striped(self):
        """Frames in which one knob is turned after the other: pictures, values of the knobs, milliseconds."""
        ways = np.linspace(0, 1, POSITIONS)
        places = [(way, 0.0) for way in ways] + [(1.0, way) for way in ways[1:]]
        waves = [self._waves(*place) for place in places]
        steps = np.arange(BETWEEN * (len(places) - 1) + 1) / BETWEEN
        return [(self._inked_where(_between(waves, step)), (*_between(places, step), 0.0), SHORT) for step in steps]

    def _waves(self, first, second):
        """cos θ in each pixel after the knobs went to shares of their ways, and -1 beside the object."""
        self._solve(first, second)
        red, green, _ = np.moveaxis(self._rendered(self._flat, "waves.exr"), -1, 0)
        return np.where(green > 0.05, 2 * red / np.maximum(green, 0.05) - 1, -1)

    def _solve(self, first, second):
        """Solve stripes, and show the variation that changes least."""
        stripes = STRIPES[0] * (STRIPES[1] / STRIPES[0]) ** first
        settings = replace(self._settings, spacing=self._size / stripes, angle=np.radians(TURN * second))
        api.run("stripes", self.obj, settings)
        others = memory.state(self.obj).pattern.solution.variations[:VARIATIONS]
        changes = [np.abs(phases.real - self._phases.real).mean() for phases in others]
        api.vary(self.obj, int(np.argmin(changes)))
        self._phases = others[np.argmin(changes)]

    def _inked_where(self, waves):
        """Stripes where waves are above 0, with edges of a pixel."""
        slope = np.hypot(*np.gradient(waves))
        cover = np.clip(0.5 + waves / (slope + 1e-3), 0, 1)[..., None]
        return self._plain + cover * (self._inked - self._plain)

    def _with_width(self, width):
        self._width.default_value = width
        return self._rendered(self._lit, "frame.png")

    def _mesh(self):
        """Make the quad mesh, and put it in place of the object; returns what stands for it in the scene."""
        name = api.quad_mesh(self.obj, faces=FACES)["quad_mesh"]["object"]
        bpy.data.objects[name].data.materials.clear()
        self._shown.hide_render = True
        return stand_in(bpy.data.objects[name], self._lit, edges=True)

    def _swung(self, mesh, share):
        mesh.rotation_euler.z = -np.radians(SWING) * sin(2 * pi * share)
        return self._rendered(self._lit, "frame.png")

    def _rendered(self, scene, name):
        path = self.folder / name
        render_scene(scene, path, (WIDTH, HEIGHT), SAMPLES)
        return pixels_of(path)[:, CUT:, :3]


def flat_scene(obj, camera):
    """A dark scene with an object that shines in 0.5 + 0.5 cos θ of red and 1 of green, seen by a camera."""
    scene = bpy.data.scenes.new("Waves")
    scene.collection.objects.link(camera)
    scene.camera = camera
    slot = stand_in(obj, scene, edges=False).material_slots[0]
    slot.link = "OBJECT"
    slot.material, surface, _ = surface_material("Waves")
    tree = slot.material.node_tree
    pattern, half, color = map(tree.nodes.new, WAVE_NODES)
    pattern.node_tree = bpy.data.node_groups[STRIPES_NAME]
    half.operation, half.inputs[1].default_value, half.inputs[2].default_value = "MULTIPLY_ADD", 0.5, 0.5
    color.inputs["Green"].default_value = 1.0
    surface.inputs["Base Color"].default_value = (0.0, 0.0, 0.0, 1.0)
    surface.inputs["Specular IOR Level"].default_value = 0.0
    surface.inputs["Emission Strength"].default_value = 1.0
    tree.links.new(pattern.outputs["Cosine"], half.inputs[0])
    tree.links.new(half.outputs[0], color.inputs["Red"])
    tree.links.new(color.outputs["Color"], surface.inputs["Emission Color"])
    return scene


def _between(values, step):
    """The value at a step that need not be whole."""
    number = min(int(step), len(values) - 2)
    share = step - number
    return (1 - share) * np.asarray(values[number]) + share * np.asarray(values[number + 1])


def _faded(first, last):
    """Frames between two."""
    for number in range(1, FADED + 1):
        picture, values = (_between((a, b), number / (FADED + 1)) for a, b in zip(first[:2], last[:2], strict=True))
        yield picture, values, SHORT


def _with_knobs(picture, values):
    picture = np.array(picture)
    for (name, place), value in zip(KNOBS.items(), values[:2], strict=True):
        knobs.knob(picture, place, name, value)
    knobs.button(picture, BUTTON, "Quad Mesh", values[2] >= 0.5)
    return picture


if __name__ == "__main__":
    main()
