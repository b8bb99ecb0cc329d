# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of quads: quad meshes, the two sliders, loops that close, the profiles of the node group, and the paper's
Figure 4 again.

    python docs/make/quads.py MESHES --folder docs [--only quad_mesh | sliders | loops | quads]

Figure 4, which paper.py makes: cos x cos y along one cross field, the spectral relaxation on the left and the
semidefinite one on the right. The sliders are shown on a double torus. MESHES holds spot.obj, fertility.obj,
rocker-arm.obj, fandisk.obj and stanford-bunny.obj. Needs Blender as a module (bpy).
"""

import bpy
import numpy as np

from synch_fields.bench.command import arguments
from synch_fields.bench.meshes import write_obj
from synch_fields.bench.surface_shapes import double_torus
from synch_fields.bench.tables import Column, print_table
from synch_fields.core.extract.quads.measure.loops import SHORT
from synch_fields.docs.make.figures import read_directions, row, write_directions
from synch_fields.docs.make.sheets import beside, make_pictures
from synch_fields.docs.make.solid_pictures import plain_material
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import files
from synch_fields.synch_addon.blender.pattern_surface import surface_of
from synch_fields.synch_addon.looks.render import render_picture
from synch_fields.synch_addon.nodes.quads import PROFILES, QUADS_NAME
from synch_fields.synch_addon.nodes.stripes import INK_BLUE, WARM_IVORY
from synch_fields.synch_addon.patterns.loops import loops_of

# Name of a mesh, where it is seen from, and its period's part of the longest side.
WAVES = (("spot", (230, 15), 12), ("fertility", (-20, 10), 18), ("rocker-arm", (30, 20), 16))
MESHES = (("spot", (230, 15), 24), ("fertility", (-20, 10), 24), ("stanford-bunny", (-20, 12), 24))
# Where the double torus of the sliders is seen from, its faces, the sliders' values, and what the table tells.
SLID, SHARES = ((20, 50), 1500), (1.0, 0.5, 0.0)
SLIDER_COLUMNS = (
    Column("branching", "branching", ".0%"),
    Column("disclinations", "disclinations", "d"),
    Column("dislocations", "dislocations", "d"),
    Column("faces", "faces", "d"),
    Column("quads", "quad_share", ".1%"),
    Column("irregular vertices", "irregular_vertices", "d"),
    Column("corners off by", "angle_deviation", ".1f"),
    Column("spacing over asked (98 %)", "spacing", ""),
)
# A mesh whose loops are closed, where it is seen from, and how much may be given up for it.
LOOPED, LOOP_SHARES = ("fandisk", (200, 25)), (0.0, 0.3)
LIGHT_BLUE, MIDDLE_BLUE = (0.45, 0.60, 0.74, 1.0), (0.12, 0.26, 0.50, 1.0)
PATTERNED = ("spot", (230, 15), 12)

WAVE_NODES = ("ShaderNodeGroup", "ShaderNodeMapRange", "ShaderNodeMixRGB", "ShaderNodeGamma")
# The value of cos x cos y with a pure colour, and the power by which colours are mixed as the eye sees them.
CONTRAST, GAMMA = 0.7, 2.2


def main():
    """Make the pictures."""
    make_pictures(arguments(__doc__, "the meshes", "the pictures go"), PICTURES)


def opened(meshes, name):
    """The object of a mesh's file, and the longest side of its box."""
    obj = files.open_object(meshes / f"{name}.obj")
    return obj, max(obj.dimensions)


def figure4(place):
    """The oscillatory fields, one shape below the other."""
    rows, sheets = [], []
    for name, view, count in WAVES:
        pictures = []
        for method in ("spectral", "sdp"):
            obj, size = opened(place.meshes, name)
            if method == "spectral":
                api.directions(obj, symmetry="cross")
                directions = read_directions(obj)
            else:
                write_directions(obj, directions)
            report = api.quads(obj, spacing=size / count, guidance="attribute:synch_direction", method=method)
            rows.append(row(f"{name} {count}: {'SDP' if method == 'sdp' else method}", report))
            obj.data.materials.clear()
            obj.data.materials.append(wave_material())
            picture = place.folder / f"{name} {method}.png"
            pictures.append(render_picture(obj, picture, view=view, resolution=(640, 520), samples=24, markers=False))
        sheets.append(place.folder / f"{name}.png")
        beside(pictures, sheets[-1])
    beside(sheets, place.picture, vertical=True)
    return {"energies": rows}


def wave_material():
    """cos x cos y as a mixture of two colours, half of each on the grid lines."""
    material, tree, surface = plain_material("Wave")
    pattern, ramp, mix, gamma = map(tree.nodes.new, WAVE_NODES)
    pattern.node_tree = bpy.data.node_groups[QUADS_NAME]
    ramp.interpolation_type = "SMOOTHSTEP"
    ramp.inputs["From Min"].default_value, ramp.inputs["From Max"].default_value = -CONTRAST, CONTRAST
    gamma.inputs["Gamma"].default_value = GAMMA
    for name, color in (("Color1", WARM_IVORY), ("Color2", INK_BLUE)):
        mix.inputs[name].default_value = np.power(color, 1 / GAMMA)
    tree.links.new(pattern.outputs["Pattern"], ramp.inputs["Value"])
    tree.links.new(ramp.outputs["Result"], mix.inputs["Fac"])
    tree.links.new(mix.outputs["Color"], gamma.inputs["Color"])
    tree.links.new(gamma.outputs["Color"], surface.inputs["Base Color"])
    return material


def quad_mesh(options, folder, path):
    """Quad meshes with their edges."""
    pictures, labels = [], []
    for name, view, count in MESHES:
        obj, size = opened(options.meshes, name)
        report = api.quad_mesh(obj, spacing=size / count)["quad_mesh"]
        made = bpy.data.objects[report["object"]]
        made.data.materials.clear()
        picture = folder / f"{name}.png"
        pictures.append(render_picture(made, picture, view=view, resolution=(640, 620), edges=True))
        labels.append(f"{report['faces']} faces, {report['quad_share']:.0%} quads")
    beside(pictures, path, labels=labels)


def sliders(_options, folder, path):
    """Quad meshes of as many faces: from left to right fewer branches, from above fewer singularities; and a table."""
    view, count = SLID
    source, sheets, rows = folder / "double-torus.obj", [], []
    write_obj(double_torus(), source)
    for singularities in SHARES:
        pictures = []
        for branching in SHARES:
            obj = files.open_object(source)
            report = api.quad_mesh(obj, faces=count, singularities=singularities, branching=branching)
            made = report["quad_mesh"]
            shown = bpy.data.objects[made["object"]]
            shown.data.materials.clear()
            picture = folder / f"{singularities} {branching}.png"
            pictures.append(render_picture(shown, picture, view=view, resolution=(640, 480), samples=24, edges=True))
            low, *_, high = report["evenness"]["spacing"]
            found = {kind: len(report[kind]) for kind in ("disclinations", "dislocations")}
            shares = {"label": f"{singularities:.0%}", "branching": branching, "spacing": f"{low:.2f}–{high:.2f}"}
            rows.append(made | found | shares)
        sheets.append(folder / f"{singularities}.png")
        beside(pictures, sheets[-1], labels=() if len(sheets) > 1 else [f"branching {share:.0%}" for share in SHARES])
    beside(sheets, path, vertical=True, labels=[f"singularities {share:.0%}" for share in SHARES])
    print_table("Sliders", SLIDER_COLUMNS, rows, first="singularities")


def loops(options, folder, path):
    """Quad meshes whose loops are closed or not: faces in no short loop, in one, and in two."""
    name, view = LOOPED
    pictures, labels = [], []
    for share in LOOP_SHARES:
        obj, _ = opened(options.meshes, name)
        report = api.quad_mesh(obj, faces=SLID[1], loops=share)["quad_mesh"]
        made = bpy.data.objects[report["object"]]
        made.data.materials.clear()
        for number, color in enumerate((WARM_IVORY, LIGHT_BLUE, MIDDLE_BLUE)):
            made.data.materials.append(plain_material(f"In {number}", color)[0])
        made.data.polygons.foreach_set("material_index", short_loops(made))
        picture = folder / f"{share}.png"
        pictures.append(render_picture(made, picture, view=view, resolution=(760, 620), edges=True))
        labels.append(f"loops {share:.0%}: {report['short_loop_share']:.0%} in short loops")
    beside(pictures, path, labels=labels)


def short_loops(obj):
    """(f,) how many of the two loops through each quad are short."""
    found = loops_of(obj)
    short = np.append(found.lengths <= SHORT * np.sqrt(len(found.quads.sizes)), False)
    corners = short[found.corner_loops].astype(int)
    return (np.bincount(found.quads.corner_faces, corners) / 2).astype(np.int32)


def quads(options, folder, path):
    """The profiles of the node group on one pattern."""
    name, view, count = PATTERNED
    obj, size = opened(options.meshes, name)
    api.quads(obj, spacing=size / count, assign_material=True)
    group = next(node for node in surface_of(obj).active_material.node_tree.nodes if node.type == "GROUP")
    pictures = []
    for number, profile in enumerate(PROFILES):
        group.inputs["Profile"].default_value = number
        picture = folder / f"{profile}.png"
        pictures.append(render_picture(obj, picture, view=view, resolution=(560, 620), samples=32, markers=False))
    beside(pictures, path, labels=PROFILES)


PICTURES = {"quad_mesh": quad_mesh, "sliders": sliders, "loops": loops, "quads": quads}


if __name__ == "__main__":
    main()
