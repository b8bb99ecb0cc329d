# SPDX-License-Identifier: GPL-3.0-or-later
"""Five solids from a mesh to G-code, by one command each: layers, what their beads cover, heights, tilt, collisions.

    python bench/printing.py MESHES [--covered]

A curved shell and a bent bar, which this program makes, MESHES/bunny.mesh on its base, fandisk and rocker-arm. Each is
100 mm long and printed in layers of 5 mm with beads as wide: the first two along their normals on a table that turns
around X and Z, the others upright. With --covered, what beads of three widths cover of layers along Z in each of nine
solids of MESHES instead, in tetrahedra of half the distance of layers. Needs Blender as a module (bpy).
"""

import json
import tempfile
from pathlib import Path
from time import process_time

import bpy
import numpy as np

from synch_fields.bench.command import arguments
from synch_fields.bench.meshes import read_obj
from synch_fields.bench.solid_shapes import bent_bar, curved_shell, solid_bunny
from synch_fields.bench.tables import Column, print_table
from synch_fields.core.printing.beads import contour_beads
from synch_fields.synch_addon import api
from synch_fields.synch_addon.command.main import main as run
from synch_fields.synch_addon.solids import memory

# Layers in the longest side, which is 100 mm.
LAYERS = 20
# Smallest and largest height of a second bent bar's layers, millimetres.
LIMITS = (3.0, 8.0)
# All closed meshes, and the widths of beads that cover their layers, in spacings.
CLOSED = ("bumpy-cube", "botijo", "cheburashka", "deckel_input", "fandisk", "fertility", "rocker-arm", "spot")
STEPS = (0.5, 1.0, 2.0)
COVERED = (
    Column("layers", "layers", "d"),
    *(Column(f"covered at {step:g}", f"covered {step:g}", ".2%") for step in STEPS),
    *(Column(f"least of a layer at {step:g}", f"least {step:g}", ".1%") for step in STEPS),
)
COLUMNS = (
    Column("layers", "layers", "d"),
    Column("paths", "paths", "d"),
    Column("covered", "covered", ".2%"),
    Column("least of a layer", "least", ".1%"),
    Column("heights 1 %, mm", "low", ".2f"),
    Column("50 %", "middle", ".2f"),
    Column("99 %", "high", ".2f"),
    Column("tilt 99 %", "tilt", ".0f"),
    Column("on air", "air", ".1%"),
    Column("collisions", "met", ".1%"),
    Column("G-code, lines", "lines", "d"),
    Column("s CPU", "seconds", ".0f"),
)


def bunny(meshes):
    """The boundary of the bunny's tetrahedra, on its base."""
    surface, _ = solid_bunny(meshes).mesh.boundary_surface
    return surface.vertices, surface.triangles.tolist(), {}, "axis:Z", ""


def upright(meshes, name):
    """A mesh whose Y is up."""
    mesh = read_obj(meshes / f"{name}.obj")
    turned = mesh.vertices[:, [0, 2, 1]] * [1, -1, 1]
    return turned, mesh.triangles.tolist(), {}, "axis:Z", ""


def placed(label, shape):
    """The object of a shape, in an empty file."""
    vertices, faces, groups, _, _ = shape
    bpy.ops.wm.read_homefile(use_empty=True)
    data = bpy.data.meshes.new(label)
    data.from_pydata((np.asarray(vertices) - vertices.min(axis=0)).tolist(), [], faces)
    obj = bpy.data.objects.new(label, data)
    bpy.context.scene.collection.objects.link(obj)
    for name, chosen in groups.items():
        obj.vertex_groups.new(name=name).add(np.flatnonzero(chosen).tolist(), 1.0, "REPLACE")
    return obj


def printed(label, shape, axes, folder, heights=None):
    """The row of a shape that goes through the command line, with limits of its heights or without, millimetres."""
    vertices, _, _, guidance, asked = shape
    placed(label, shape)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "solid.blend"))
    longest = float(np.ptp(vertices, axis=0).max())
    scale = 100 / longest
    machine = f'axes = "{axes}"\nscale = {scale!r}\nnozzle_radius = 1\nnozzle_angle = 20\nnozzle_length = 40\n'
    if heights is not None:
        machine += f"smallest_height = {heights[0]}\nlargest_height = {heights[1]}\n"
    (folder / "printer.toml").write_text(machine + "largest_tilt = 80\n")
    report, program, start = folder / "report.json", folder / f"{label.replace(' ', '_')}.gcode", process_time()
    command = ["layers", folder / "solid.blend", "--guidance", guidance, "--groups", asked, "--export-gcode", program]
    command += ["--spacing", longest / LAYERS, "--machine", folder / "printer.toml", "--report", report, "--quiet"]
    if run([str(word) for word in command]):
        raise SystemExit(f"{label}: the command failed")
    told = json.loads(report.read_text())
    paths = told["print"]
    return {
        "label": label,
        "layers": told["layers"],
        "paths": paths["paths"],
        "covered": paths["covered"],
        "least": paths["least_covered"]["share"],
        "low": scale * paths["heights"]["low"],
        "middle": scale * paths["heights"]["median"],
        "high": scale * paths["heights"]["high"],
        "tilt": paths["tilts"]["high"],
        "air": paths["overhangs"]["share"],
        "met": paths["collisions"]["share"],
        "lines": len(program.read_text().splitlines()),
        "seconds": process_time() - start,
    }


def covered(label, shape):
    """The row of what beads of several widths cover of layers of a shape along Z."""
    vertices, _, _, guidance, _ = shape
    obj, spacing = placed(label, shape), float(np.ptp(vertices, axis=0).max()) / LAYERS
    api.layers(obj, guidance=guidance, spacing=spacing, size=spacing / 2)
    surfaces = memory.recall_layers(obj).surfaces
    row = {"label": label, "layers": surfaces.count}
    for step in STEPS:
        beads = contour_beads(surfaces, step * spacing)
        # Layers that are smaller than what a bead is wide have none.
        large = surfaces.areas > (step * spacing) ** 2
        row |= {f"covered {step:g}": beads.covered_share, f"least {step:g}": float(beads.covered[large].min())}
    return row


def main():
    """Print the table."""
    parser = arguments(__doc__, "bunny.mesh and closed .obj meshes")
    parser.add_argument("--covered", action="store_true", help="what beads cover, of more solids")
    options = parser.parse_args()
    meshes = options.meshes
    if options.covered:
        shapes = {"bunny": bunny(meshes)} | {name: upright(meshes, name) for name in CLOSED}
        print_table("Covered", COVERED, [covered(label, shape) for label, shape in shapes.items()])
        return
    shapes = {
        "curved shell": (curved_shell(), "ac"),
        "bent bar": (bent_bar(), "ac"),
        "bent bar, {:g} to {:g} mm".format(*LIMITS): (bent_bar(), "ac", LIMITS),
        "bunny": (bunny(meshes), "xyz"),
        "fandisk": (upright(meshes, "fandisk"), "xyz"),
        "rocker-arm": (upright(meshes, "rocker-arm"), "xyz"),
    }
    with tempfile.TemporaryDirectory() as folder:
        rows = [printed(label, shape, axes, Path(folder), *limits) for label, (shape, axes, *limits) in shapes.items()]
    print_table("From a mesh to G-code", COLUMNS, rows)


if __name__ == "__main__":
    main()
