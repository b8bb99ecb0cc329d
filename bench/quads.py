# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad patterns by three methods with the bound on all of them, and their quad meshes beside Blender's QuadriFlow.

    python bench/quads.py MESHES [--only NAME ...]

Patterns: along the cross field of each MESHES/*.obj, at periods of the longest side over 15 and over 30. Every
violated inequality of Eq. (23) is printed below the table. Quad meshes: at a period of the longest side over 25, but at
least four median edges, and QuadriFlow's mesh of as many faces; the same functions measure both. Needs Blender as a
module (bpy).
"""

import sys
from itertools import pairwise

import bpy
import numpy as np

from synch_fields.bench.command import arguments
from synch_fields.bench.measure import timed
from synch_fields.bench.meshes import read_obj
from synch_fields.bench.tables import Column, print_table
from synch_fields.core.errors import MeshError
from synch_fields.core.extract.quad_mesh import QuadMesh
from synch_fields.core.extract.quad_quality import quality
from synch_fields.core.fields import direction_field, quad_pattern
from synch_fields.core.fields.growth import Growth
from synch_fields.core.solve import Options
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import attributes, files, meshes
from synch_fields.synch_addon.blender.bvh import surface_tree
from synch_fields.synch_addon.blender.quiet import quiet_stdout

# Periods along the longest side.
PERIODS = (15, 30)
# The meshes' periods: along the longest side at most, and median edges in one at least.
MESH_PERIODS, EDGES_PER_PERIOD = 25, 4
FIELD_FILE = "cheburashka-cf.rawfield"
# Names of meshes, and of field files for them.
COMPARED = (
    *((name, None) for name in "spot stanford-bunny fertility fandisk rocker-arm botijo cheburashka".split()),
    ("cheburashka", FIELD_FILE),
)
METHODS = ("spectral", "diffusion", "sdp")

PATTERN_COLUMNS = (
    Column("nodes", "nodes", "d"),
    Column("coarse", "coarse", ".0%"),
    Column("lower bound", "lower_bound", ".1f"),
    Column("SDP", "sdp_value", ".1f"),
    Column("SDP gap", "sdp_gap", ".1e"),
    Column("proof", "certificate", ""),
    Column("polished", "sdp", ".1f"),
    Column("MBO falling", "diffusion", ".1f"),
    Column("spectral", "spectral", ".1f"),
    Column("disclinations", "disclinations", "d"),
    Column("dislocations SDP", "sdp dislocations", "d"),
    Column("dislocations MBO", "diffusion dislocations", "d"),
    Column("dislocations spectral", "spectral dislocations", "d"),
    Column("s field", "field seconds", ".1f"),
    Column("s SDP", "sdp seconds", ".1f"),
    Column("s MBO", "diffusion seconds", ".1f"),
    Column("s spectral", "spectral seconds", ".1f"),
)
MESH_COLUMNS = (
    Column("faces", "faces", "d"),
    Column("quads", "quad_share", ".1%"),
    Column("irregular", "irregular_vertices", "d"),
    Column("mean angle off", "angle_deviation", ".1f"),
    Column("worst", "worst_angle", ".0f"),
    Column("edge spread", "length_spread", ".3f"),
    Column("Hausdorff / side", "distance", ".2%"),
    Column("χ", "euler_characteristic", "d"),
    Column("χ given", "given_characteristic", "d"),
    Column("closed", "closed", ""),
    Column("manifold", "manifold", ""),
    Column("s", "seconds", ".1f"),
)


def main():
    """Print both tables; returns the number of violated inequalities."""
    parser = arguments(__doc__, "the meshes")
    parser.add_argument("--only", nargs="+", default=(), help="names of meshes, all by default")
    options = parser.parse_args()
    rows, refused = [], []
    for path in sorted(options.meshes.glob("*.obj")):
        if not options.only or path.stem in options.only:
            try:
                rows += patterns(path)
            except MeshError as error:
                refused.append(f"{path.stem} is refused: {error}")
    print_table("Quad patterns", PATTERN_COLUMNS, rows)
    violations = [line for row in rows for line in violated(row)]
    print("\n" + "\n".join(refused + (violations or ["All inequalities hold."])))
    chosen = [(name, field) for name, field in COMPARED if not options.only or name in options.only]
    with quiet_stdout():
        rows = [row for name, field in chosen for row in quad_meshes(options.meshes, name, field)]
    print_table("Quad meshes", MESH_COLUMNS, rows)
    return len(violations)


def patterns(path):
    """Rows of the first table for one mesh."""
    mesh = read_obj(path)
    field, field_seconds = timed(direction_field, mesh, 4)
    for count in PERIODS:
        spacing = longest_side(mesh) / count
        row = {
            "label": f"{path.stem} {count}",
            "nodes": 2 * (mesh.vertex_count - len(mesh.loose_vertices)),
            "coarse": Growth.of(mesh, field, spacing).coarse_share,
            "disclinations": len(field.disclinations),
            "field seconds": field_seconds,
        }
        for method in METHODS:
            pattern, seconds = timed(quad_pattern, mesh, field, spacing, (), (), Options(method=method))
            row |= {
                method: pattern.solution.energy,
                f"{method} dislocations": len(pattern.dislocations),
                f"{method} seconds": seconds,
            }
        for name in ("lower_bound", "sdp_value", "sdp_gap", "certificate"):
            row[name] = getattr(pattern.solution, name)
        print(row["label"], "is solved", file=sys.stderr, flush=True)
        yield row


def violated(row):
    """Lines for the inequalities of Eq. (23) that a row does not hold, and for a method better than ours."""
    pairs = (*pairwise(("lower_bound", "sdp_value", "sdp", "spectral")), ("sdp", "diffusion"))
    return [
        f"violated: {row['label']}: {smaller} {row[smaller]:.6g} > {larger} {row[larger]:.6g}"
        for smaller, larger in pairs
        if row[smaller] > row[larger] * (1 + 1e-9)
    ]


def longest_side(mesh):
    return np.ptp(mesh.vertices[np.unique(mesh.triangles)], axis=0).max()


def quad_meshes(folder, name, field):
    """Two rows of the second table: our quad mesh of one mesh, and QuadriFlow's."""
    obj = opened(folder / f"{name}.obj")
    given = meshes.read_mesh(obj).mesh
    spacing = max(longest_side(given) / MESH_PERIODS, EDGES_PER_PERIOD * np.median(given.edge_lengths))
    label, settings = name, {}
    if field:
        api.import_field(obj, folder / field)
        label, settings = f"{name}, field file", {"guidance": "attribute:synch_direction"}
    report, seconds = timed(lambda: api.quad_mesh(obj, spacing=float(spacing), **settings))
    rows = [measured(f"{label}: quad mesh", bpy.data.objects[report["quad_mesh"]["object"]], given, seconds)]
    if not field:
        copy = opened(folder / f"{name}.obj")
        rows.append(quadriflow(f"{label}: QuadriFlow", copy, given, rows[0]["faces"]))
    print(name, "is meshed", file=sys.stderr, flush=True)
    return rows


def opened(path):
    obj = files.opened(path)
    obj.select_set(True)
    return obj


def quadriflow(label, obj, given, faces):
    """The row of an object that becomes QuadriFlow's mesh, or a row without figures where it fails."""
    try:
        done, seconds = timed(lambda: bpy.ops.object.quadriflow_remesh(target_faces=faces, seed=0))
    except RuntimeError as error:
        return {"label": f"{label} fails: {str(error).strip()}"}
    if done != {"FINISHED"}:
        return {"label": f"{label} fails"}
    return measured(label, obj, given, seconds)


def measured(label, obj, given, seconds):
    """The row of an object's own mesh."""
    quads = as_quads(obj)
    row = quality(quads) | {
        "label": label,
        "distance": distance(quads, given) / longest_side(given),
        "given_characteristic": given.euler_characteristic,
        "seconds": seconds,
        "manifold": "yes",
    }
    row["closed"] = "yes" if row["closed"] else "no"
    try:
        meshes.read_mesh(obj)
    except MeshError as error:
        row["manifold"] = str(error).split(":")[0]
    return row


def as_quads(obj):
    """The :class:`QuadMesh` of an object's faces; nothing is known of the surface below."""
    polygons = meshes.read_polygons(obj)
    places = attributes.read_values(obj, "position", "POINT")
    return QuadMesh(places.astype(float), None, None, polygons.corner_vertices, polygons.sizes)


def distance(quads, given):
    """Hausdorff distance of a quad mesh and the given one, at the vertices of both and the middles of the quads."""
    corners = np.split(quads.corner_vertices, quads.starts[1:])
    middles = np.array([quads.vertices[corner].mean(axis=0) for corner in corners])
    ours = np.concatenate([quads.vertices, middles])
    theirs = given.vertices[np.unique(given.triangles)]
    there, back = surface_tree(given.vertices, given.triangles), surface_tree(quads.vertices, corners)
    return max(
        tree.find_nearest(point)[3] for tree, points in ((there, ours), (back, theirs)) for point in points.tolist()
    )


if __name__ == "__main__":
    sys.exit(min(main(), 1))
