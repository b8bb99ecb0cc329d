# SPDX-License-Identifier: GPL-3.0-or-later
"""Five solids from a mesh to G-code, by one command each: layers, what their beads cover, heights, tilt, collisions.

    python bench/printing.py MESHES [--covered | --simulated]

A curved shell and a bent bar, which this program makes, MESHES/bunny.mesh on its base, fandisk and rocker-arm. Each is
100 mm long and printed in layers of 5 mm with beads as wide: the first two along their normals on a table that turns
around X and Z, the others upright. With --covered, what beads of three widths cover of layers along Z in each of nine
solids of MESHES instead, in tetrahedra of half the distance of layers. With --simulated, what a printer that reads
the programs alone makes of them (bench/gcode_simulator.py). Needs Blender as a module (bpy).
"""

import json
import tempfile
from pathlib import Path
from time import process_time

import bpy
import numpy as np

from synch_fields.bench.command import arguments
from synch_fields.bench.gcode_simulator import (
    deviations,
    filled_share,
    read_moves,
    sampled,
    travels_through,
    turn_speed,
)
from synch_fields.bench.meshes import read_obj
from synch_fields.bench.solid_shapes import solid_bunny
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

# Places in the solid that are looked at, and what samples of moves are apart, in beads' widths.
PLACES, APART = 5000, 0.1
SIMULATED = (
    Column("layers", "layers", "d"),
    Column("volume", "volume", ".2%"),
    Column("filled", "filled", ".2%"),
    Column("tip off its way at most, mm", "off", ".4f"),
    Column("table, degrees a second", "speed", ".0f"),
    Column("travels through beads", "through", ".2%"),
    Column("tool off the normal, degrees", "tool", ".1f"),
    Column("s CPU", "seconds", ".0f"),
)


def box(counts):
    """Vertices of the surface of a unit cube cut into cells, and its quads."""
    numbers, quads = {}, []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, counts[axis]):
            for i, j in np.ndindex(counts[u], counts[v]):
                corners = []
                for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                    place = [0, 0, 0]
                    place[axis], place[u], place[v] = side, a, b
                    corners.append(numbers.setdefault(tuple(place), len(numbers)))
                quads.append(corners if side else corners[::-1])
    return np.array(list(numbers)) / counts, quads


def curved_shell():
    """A dome, a quarter as thick as its inner radius: layers from its inner side outwards."""
    places, quads = box((24, 24, 3))
    across = np.tan(1.4 * (places[:, :2] - 0.5))
    rays = np.column_stack([across, np.ones(len(places))])
    rays *= ((1 + 0.25 * places[:, 2]) / np.linalg.norm(rays, axis=1))[:, None]
    return rays, quads, {"Inner": places[:, 2] == 0}, "distance:Inner", "Inner=layer:0.5"


def bent_bar():
    """A bar that stands on one end and bends by 75 degrees: layers from end to end."""
    places, quads = box((24, 6, 6))
    turn, radius = np.radians(75) * places[:, 0], 1 + 0.6 * places[:, 2]
    bent = np.column_stack([-radius * np.cos(turn), 0.6 * places[:, 1], radius * np.sin(turn)])
    groups = {"Low": places[:, 0] == 0, "High": places[:, 0] == 1}
    return bent, quads, groups, "harmonic:Low:High", "Low=layer:0.5,High=layer:0.5"


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


def printed(label, shape, axes, folder, heights=None, more=()):
    """The row of a shape that goes through the command line, with limits of its heights or without, millimetres, and
    with more flags."""
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
    command += more
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
        "scale": scale,
        "program": program,
        "object": told["object"],
        "tool": paths["program"]["tool_off"],
        "lines": len(program.read_text().splitlines()),
        "seconds": process_time() - start,
    }


def simulated(label, shape, axes, folder, heights=None):
    """The row of a shape whose program is run by the simulator; heights as for :func:`printed`."""
    made = printed(label, shape, axes, folder, heights, ["--export-paths", folder / "paths.csv"])
    scale, diameter, pivot_z = made["scale"], 1.75, 0.0
    moves = read_moves(made["program"].read_text())
    rows = np.genfromtxt(folder / "paths.csv", delimiter=",", names=True)
    layering = memory.recall_layers(bpy.data.objects[made["object"]])
    solid, matrix = layering.solid, layering.matrix
    world = solid.vertices @ matrix[:3, :3].T + matrix[:3, 3]
    low, high = world.min(axis=0), world.max(axis=0)
    lowest = np.append((low + high)[:2] / 2, low[2])
    normals = np.column_stack([rows["nx"], rows["ny"], rows["nz"]])
    tips = np.column_stack([rows["x"], rows["y"], rows["z"]]) + rows["above"][:, None] * normals
    tips = scale * (tips - lowest)
    ways = [tips[rows["path"] == path] for path in np.unique(rows["path"])]
    beads = moves.printing & (moves.kinds != "Skirt/Brim")
    width = float(np.nanmedian(moves.widths[beads]))
    samples = sampled(moves, beads, pivot_z, APART * width)
    travels = sampled(moves, moves.extruded == 0, pivot_z, APART * width)
    random = np.random.default_rng(0)
    tets = random.choice(solid.tet_count, PLACES, p=solid.volumes / solid.volumes.sum())
    places = np.einsum("nk,nkx->nx", random.dirichlet(np.ones(4), PLACES), world[solid.tets[tets]])
    volume = moves.extruded[beads].sum() * np.pi * diameter**2 / 4
    return {
        "label": label,
        "layers": made["layers"],
        "volume": volume / (scale**3 * solid.volumes.sum()),
        "filled": filled_share(samples, moves, scale * (places - lowest), 0.02 * width),
        "off": float(deviations(samples, [way for way in ways if len(way) > 1], APART * width).max()),
        "speed": turn_speed(moves) if axes != "xyz" else 0.0,
        "through": travels_through(samples, travels, moves, 0.1 * width),
        "tool": made["tool"],
        "seconds": made["seconds"],
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
    parser.add_argument("--simulated", action="store_true", help="what a simulated printer makes of the programs")
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
    if options.simulated:
        with tempfile.TemporaryDirectory() as folder:
            rows = [
                simulated(label, shape, axes, Path(folder), *more) for label, (shape, axes, *more) in shapes.items()
            ]
        print_table("Programs as a simulated printer runs them", SIMULATED, rows)
        return
    with tempfile.TemporaryDirectory() as folder:
        rows = [printed(label, shape, axes, Path(folder), *limits) for label, (shape, axes, *limits) in shapes.items()]
    print_table("From a mesh to G-code", COLUMNS, rows)


if __name__ == "__main__":
    main()
