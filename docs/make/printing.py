# SPDX-License-Identifier: GPL-3.0-or-later
"""Tool paths as beads, while they are printed: a curved shell, a bent bar, a ring, a cup, the bunny, the rocker-arm.

    python docs/make/printing.py MESHES [--folder docs]

Each bead is as wide and as high as the program of the printer has it, in the colour of its height: dark blue where it
is half as high as the layers are apart, sand where it is as high, red where it is half as high again. MESHES holds
bunny.mesh and rocker-arm.obj. Needs Blender as a module (bpy).
"""

import bpy
import numpy as np

from synch_fields.bench.command import arguments
from synch_fields.bench.printing import bunny, placed, upright
from synch_fields.bench.solid_shapes import bent_bar, cup, curved_shell, ring
from synch_fields.core.printing.machine import Machine
from synch_fields.core.tasks.layer_outputs import PathSettings
from synch_fields.docs.make.sheets import beside, make_pictures
from synch_fields.docs.make.solid_pictures import material_of_values
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender.new_geometry import new_mesh
from synch_fields.synch_addon.looks.render import render_picture
from synch_fields.synch_addon.solids import memory
from synch_fields.synch_addon.solids.beads import bead_faces, bead_rings

TILE, SAMPLES = (560, 500), 12
# Points around a bead.
AROUND = 24
# Heights in spacings, and their colours.
HEIGHTS = (0.5, 1.5)
COLORS = [
    (0.0, (0.01, 0.04, 0.2, 1)),
    (0.25, (0.02, 0.16, 0.34, 1)),
    (0.45, (0.16, 0.36, 0.36, 1)),
    (0.5, (0.55, 0.4, 0.2, 1)),
    (0.55, (0.6, 0.27, 0.09, 1)),
    (0.75, (0.5, 0.07, 0.03, 1)),
    (1.0, (0.25, 0.01, 0.03, 1)),
]


def main():
    """Make the picture."""
    make_pictures(arguments(__doc__, "bunny.mesh and rocker-arm.obj", "the picture goes"), {"printing": printing})


def printing(options, folder, path):
    """The six solids, three side by side."""
    shapes = {
        "shell": (curved_shell(), "ac", 26, 0.8, (-28, 34)),
        "bar": (bent_bar(), "ac", 26, 0.86, (-38, 24)),
        "ring": (wavy_ring(), "ac", 26, 0.8, (-28, 34)),
        "cup": (cup(), "xyz", 40, 0.72, (-28, 34)),
        "bunny": (bunny(options.meshes), "xyz", 44, 0.8, (-28, 20)),
        "rocker-arm": (upright(options.meshes, "rocker-arm"), "xyz", 44, 0.75, (-32, 42)),
    }
    tiles = []
    for label, (shape, axes, layers, share, view) in shapes.items():
        vertices, _, _, guidance, groups = shape
        obj = placed(label, shape)
        spacing = float(np.ptp(vertices, axis=0).max()) / layers
        api.layers(obj, guidance=guidance, groups=groups, spacing=spacing)
        plan = memory.recall_layers(obj).paths(PathSettings(machine=Machine(axes=axes, largest_tilt=80))).solve()
        tiles.append(folder / f"{label}.png")
        beads = beads_object(plan, share, spacing)
        render_picture(beads, tiles[-1], resolution=TILE, samples=SAMPLES, markers=False, view=view)
    rows = [folder / "upper.png", folder / "lower.png"]
    for row, three in zip(rows, (tiles[:3], tiles[3:]), strict=True):
        beside(three, row)
    beside(rows, path, vertical=True)


def wavy_ring():
    """The ring of :mod:`bench.solid_shapes`, from its flat bottom to its wavy top."""
    shape = ring(48, 12, 8)
    surface, used = shape.mesh.boundary_surface
    groups = {"Low": shape.low[used], "High": shape.high[used]}
    faces = surface.triangles.tolist()
    return surface.vertices, faces, groups, "harmonic:Low:High", "Low=layer:0.5,High=layer:0.5"


def beads_object(plan, share, spacing):
    """The first beads of a plan, a share of their length, as one mesh object whose values are their heights.

    Its faces are small and flat: in narrow turns beads overlap themselves, where smooth shades would be black.
    """
    lines = plan.lines
    lengths = np.cumsum(lines.lengths)
    shown = lengths <= share * lengths[-1]
    rows = shown[lines.numbers]
    rings = bead_rings(plan, np.minimum(plan.heights, HEIGHTS[1] * spacing), AROUND)[rows]
    mesh = new_mesh("Beads", rings.reshape(-1, 3), bead_faces(lines.chosen(shown), AROUND))
    values = np.repeat(plan.heights[rows] / spacing, AROUND)
    mesh.attributes.new("value", "FLOAT", "POINT").data.foreach_set("value", values.astype(np.float32))
    mesh.materials.append(material_of_values("Beads", COLORS, HEIGHTS))
    obj = bpy.data.objects.new("Beads", mesh)
    bpy.context.scene.collection.objects.link(obj)
    return obj


if __name__ == "__main__":
    main()
