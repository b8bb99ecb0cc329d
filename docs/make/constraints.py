# SPDX-License-Identifier: GPL-3.0-or-later
"""What rows of the constraint list do on real meshes: a sheet of pictures, and a table of energies.

    python docs/make/constraints.py MESHES --folder docs

MESHES holds spot.obj, fandisk.obj, rocker-arm.obj and inspired_mesh.obj. Needs Blender as a module (bpy).
"""

import tempfile
from pathlib import Path

import bpy
import numpy as np

from synch_fields.bench.command import arguments
from synch_fields.bench.tables import print_table
from synch_fields.core.fields import boundary_line
from synch_fields.core.fields.constraints.lines import group_edges
from synch_fields.docs.make.figures import COLUMNS, row
from synch_fields.docs.make.sheets import beside
from synch_fields.docs.make.solid_pictures import ROSE
from synch_fields.docs.make.tubes import render_with_tubes
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import attributes, files
from synch_fields.synch_addon.blender.groups import read_group
from synch_fields.synch_addon.blender.meshes import read_mesh
from synch_fields.synch_addon.blender.strokes import read_strokes

# Where they are seen from.
SPOT, BEHIND = (205, 12), (150, 18)
# What a row is about: radius of tubes and length of arrows over the longest side, and vertices for each arrow.
RADIUS, ARROW, ARROWS_APART = 0.006, 0.05, 12


def main():
    """Make the sheet and print the table."""
    options = arguments(__doc__, "the meshes", "the sheet goes").parse_args()
    rows, sheets = [], []
    with tempfile.TemporaryDirectory() as folder:
        for number in range(0, len(CASES), 4):
            pictures, chosen = [], CASES[number : number + 4]
            for label, mesh, view, prepare, settings in chosen:
                obj = files.open_object(options.meshes / f"{mesh}.obj")
                prepare(obj)
                report = api.stripes(obj, assign_material=True, surface="faces", **settings)
                rows.append(row(label, report))
                picture = Path(folder) / f"{len(rows)}.png"
                lines = asked_lines(obj, settings)
                look = dict(color=ROSE, radius=RADIUS, resolution=(480, 420), samples=16, view=view)
                pictures.append(render_with_tubes(obj, lines, picture, **look))
            sheets.append(Path(folder) / f"sheet{number}.png")
            beside(pictures, sheets[-1], labels=[case[0] for case in chosen])
        beside(sheets, options.folder / "constraints.png", vertical=True)
    print_table("Constraints", COLUMNS, rows)


def asked_lines(obj, settings):
    """What the constraint or the boundary setting of a case is about, as (n, 3) lines in the object's space."""
    given = read_mesh(obj)
    (row,) = settings.get("constraints", [{"where": "boundary"}])
    if row["where"] == "curve":
        return [points for _, points in read_strokes(obj, row["name"], given)]
    if row["where"] == "attribute":
        vectors = attributes.read_vectors(obj, row["name"], given)
        chosen = np.flatnonzero(vectors.any(axis=1))[::ARROWS_APART]
        halves = ARROW / 2 * max(obj.dimensions) * vectors[chosen] / np.linalg.norm(vectors[chosen], axis=1)[:, None]
        return np.stack([given.mesh.vertices[chosen] - halves, given.mesh.vertices[chosen] + halves], axis=1)
    if row["where"] == "boundary":
        edges = boundary_line(given.mesh).links
    elif row["where"] == "group":
        edges = given.mesh.edges[group_edges(given.mesh, read_group(obj, row["name"]))]
    else:
        edges = attributes.read_marked_edges(obj, row["where"])
    return given.mesh.vertices[edges]


def mark_between(axis, place):
    """Mark as seams the edges between faces on both sides of a plane, in object space."""

    def prepare(obj):
        centres = attributes.read_all(obj.data.polygons, "center", 3, np.float32)
        sides = {}
        for polygon, above in zip(obj.data.polygons, centres[:, axis] > place, strict=True):
            for key in polygon.edge_keys:
                sides.setdefault(key, set()).add(bool(above))
        for edge in obj.data.edges:
            edge.use_seam = len(sides[edge.key]) == 2

    return prepare


def mark_sharp(obj, degrees=35):
    """Mark sharp edges by their angle."""
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.mesh.select_mode(type="EDGE")
    bpy.ops.mesh.edges_select_sharp(sharpness=np.radians(degrees))
    bpy.ops.mesh.mark_sharp()
    bpy.ops.object.mode_set(mode="OBJECT")


def group_ring(axis, low, high):
    """A vertex group "ring" of the vertices between two planes of object space."""

    def prepare(obj):
        along = attributes.read_values(obj, "position", "POINT")[:, axis]
        chosen = np.flatnonzero((along > low) & (along < high))
        obj.vertex_groups.new(name="ring").add(chosen.tolist(), 1.0, "REPLACE")

    return prepare


def add_ring(obj, centre, radius, tilt):
    """A circle of the name "Ring", which cuts through the object."""
    bpy.ops.curve.primitive_bezier_circle_add(radius=radius, location=centre, rotation=tilt)
    bpy.context.object.name = "Ring"
    bpy.context.view_layer.objects.active = obj


def ring_around_spot(obj):
    add_ring(obj, (0.0, -0.1, 0.15), 0.75, (0.0, np.radians(0), 0.0))


def nothing(_obj):
    """As it was read."""


def vectors_around(obj):
    """A vector attribute that goes around the object's vertical axis, on its upper half."""
    places = attributes.read_values(obj, "position", "POINT")
    around = np.cross([0, 1, 0], places)
    around[places[:, 1] < np.median(places[:, 1])] = 0
    obj.data.attributes.new("around", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", around.ravel())


def held(where, what, **more):
    """Settings with one constraint."""
    return {"constraints": [{"where": where, "what": what} | more]}


# Label, mesh, view, how the object is prepared, and settings of the stripes.
CASES = (
    ("seam cut", "spot", SPOT, mark_between(1, 0.1), held("seams", "cut")),
    ("seam, phase constant", "spot", SPOT, mark_between(1, 0.1), held("seams", "constant")),
    ("curve, stripe on it", "spot", SPOT, ring_around_spot, held("curve", "phase", name="Ring")),
    ("curve at 45 degrees", "spot", SPOT, ring_around_spot, held("curve", "angle", name="Ring", degrees=45)),
    ("sharp edges along", "fandisk", BEHIND, mark_sharp, held("sharp", "along")),
    (
        "group across, soft",
        "rocker-arm",
        BEHIND,
        group_ring(0, -0.05, 0.05),
        held("group", "across", name="ring", weight=20),
    ),
    ("boundary, stripe on it", "inspired_mesh", BEHIND, nothing, {"boundary": "phase"}),
    ("attribute along", "spot", SPOT, vectors_around, held("attribute", "along", name="around")),
)


if __name__ == "__main__":
    main()
