# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The six pictures of the README: `python docs/make/front.py MESHES [--folder docs] [--only NAME]`.

Three are rendered by the command line, directions and layers here, all at twice their size; vortices are those of
vortices.py, made smaller.
"""

import shutil
import subprocess
import sys

import synch_fields
from synch_fields.bench.command import arguments
from synch_fields.bench.solids import SPACINGS, shape_of
from synch_fields.core.extract import evenly_traced
from synch_fields.core.fields.guidance.potentials import harmonic_function
from synch_fields.core.fields.guidance.solids import extend_directions, gradient_vectors
from synch_fields.core.fields.layers import solve_layers
from synch_fields.docs.make.sheets import pixels_of, save_pixels
from synch_fields.docs.make.solid_pictures import picture_of_layers
from synch_fields.docs.make.tubes import render_with_tubes
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import attributes, files
from synch_fields.synch_addon.blender.meshes import read_mesh
from synch_fields.synch_addon.blender.schema import DIRECTION
from synch_fields.synch_addon.nodes.canvas import surface_material
from synch_fields.synch_addon.nodes.stripes import INK_BLUE, WARM_IVORY

COMMANDS = {
    "stripes": ["stripes", "stanford-bunny.obj", "--view", "-20", "12"],
    "quads": ["quads", "spot.obj", "--view", "205", "12"],
    "quad_mesh": ["quad_mesh", "spot.obj", "--faces", "3000", "--view", "205", "12"],
}
# Where directions are shown, from where, at most how many streamlines, and their radius over the longest side.
SHOWN, VIEW, STREAMLINES, RADIUS = "fertility.obj", (-20, 10), 400, 0.004
# Width and height of the pictures, and of those that are made smaller.
SIZE, LARGE = (600, 450), (1200, 900)


def halved(path):
    """Make a picture smaller, to this script's size."""
    values = pixels_of(path)[..., :3]
    height, width, _ = values.shape
    rows, columns = height // SIZE[1], width // SIZE[0]
    save_pixels(path, values.reshape(SIZE[1], rows, SIZE[0], columns, 3).mean(axis=(1, 3)))


def directions(meshes, picture):
    """Render the streamlines of a smooth line field as tubes."""
    obj = files.open_object(meshes / SHOWN)
    obj.data.shade_smooth()
    api.directions(obj)
    given = read_mesh(obj)
    vectors = attributes.read_vectors(obj, DIRECTION.name, given)
    lines = evenly_traced(given.mesh, vectors, 2, STREAMLINES).segments(given.mesh)
    material, surface, _ = surface_material("Surface")
    surface.inputs["Base Color"].default_value = WARM_IVORY
    obj.data.materials.append(material)
    look = dict(color=INK_BLUE, radius=RADIUS, resolution=LARGE, samples=24, view=VIEW)
    render_with_tubes(obj, lines, picture, **look)


def layers(meshes, picture):
    """Render layers in the stuffed bunny, cut open."""
    shape = shape_of("bunny", meshes)
    growth = extend_directions(
        shape.mesh, gradient_vectors(shape.mesh, harmonic_function(shape.mesh, shape.low, shape.high))
    )
    pattern = solve_layers(shape.mesh, growth, SPACINGS["bunny"] * shape.size, shape.groups)
    picture_of_layers("bunny", pattern, True, picture, curves=False, resolution=LARGE)


def main():
    parser = arguments(__doc__, "the meshes", "the pictures go")
    parser.add_argument("--only", choices=[*COMMANDS, *DRAWN, "vortices"], help="the name of one picture")
    options = parser.parse_args()
    made = options.folder / "makes"
    made.mkdir(parents=True, exist_ok=True)
    for name, (command, mesh, *flags) in COMMANDS.items():
        if options.only in (None, name):
            picture = made / f"{name}.png"
            given = [command, str(options.meshes / mesh), *flags, "--render", str(picture), "--quiet"]
            subprocess.run([sys.executable, "-m", "synch_fields", *given], check=True)
            halved(picture)
    synch_fields.register()
    for name, draw in DRAWN.items():
        if options.only in (None, name):
            draw(options.meshes, made / f"{name}.png")
            halved(made / f"{name}.png")
    synch_fields.unregister()
    if options.only in (None, "vortices"):
        shutil.copy(options.folder / "vortices.png", made)
        halved(made / "vortices.png")


# The pictures that are rendered here.
DRAWN = {"directions": directions, "layers": layers}

if __name__ == "__main__":
    main()
