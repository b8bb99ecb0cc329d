# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's Figure 2 again: dislocations of stripes in a plane, of layers in a block, and in one tetrahedron."""

import bpy
import numpy as np

from synch_fields.bench.solid_shapes import wedge
from synch_fields.bench.tables import Column
from synch_fields.core.extract.layers.defect_curves import defect_curves
from synch_fields.core.fields.layers import LayerPattern, SolidTargetOneForm, solve_layers
from synch_fields.core.geometry.tet_mesh import TetMesh
from synch_fields.docs.make.figures import add_mesh
from synch_fields.docs.make.sheets import beside
from synch_fields.docs.make.solid_pictures import RESOLUTION, SAMPLES, picture_of_layers
from synch_fields.synch_addon import api
from synch_fields.synch_addon.looks.render import render_picture

# Distance between layers of the block, whose thickness is 1 on average; and of the stripes.
SPACING = 0.2
# The plane: half its length, its heights at both ends, and vertices along and across.
HALF, HEIGHTS, VERTICES = 1.25, (0.6, 1.4), (121, 61)
# Phase across the tetrahedron, beside the one turn around the line through it.
STEEPNESS = 14.0
COLUMNS = (
    Column("nodes", "nodes", "d"),
    Column("energy", "energy", ".2f"),
    Column("bound", "bound", ".2f"),
    Column("certificate", "certificate", ""),
    Column("dislocations", "found", "d"),
)


def figure2(place):
    """Stripes flush with the upper and the lower side of a trapezoid, layers with those of a wedge, one tetrahedron."""
    bpy.ops.wm.read_homefile(use_empty=True)
    obj = trapezoid()
    sides = [{"where": "group", "what": "phase", "name": name} for name in ("Bottom", "Top")]
    report = api.stripes(obj, guidance="axis:X", spacing=SPACING, constraints=sides, assign_material=True)
    flat = render_picture(
        obj, place.folder / "plane.png", view=(0, 90), resolution=RESOLUTION, samples=SAMPLES, markers=True
    )
    shape = wedge()
    upwards = np.tile([0.0, 0.0, 1.0], (shape.mesh.vertex_count, 1))
    pattern = solve_layers(shape.mesh, upwards, SPACING, shape.groups)
    solid = picture_of_layers("wedge", pattern, True, place.folder / "wedge.png")
    one = picture_of_layers("tetrahedron", tetrahedron(), True, place.folder / "tetrahedron.png")
    beside([flat, solid, one], place.picture)
    plane = {"label": "stripes in the plane", "found": len(report["dislocations"]), "bound": report["lower_bound"]}
    plane |= {name: report[name] for name in ("nodes", "energy", "certificate")}
    solution = pattern.solution
    block = {"label": "layers in the block", "nodes": shape.mesh.vertex_count, "energy": solution.energy}
    block |= {"bound": solution.lower_bound, "certificate": solution.certificate.value}
    block["found"] = len(defect_curves(shape.mesh, pattern.face_numbers))
    return {"dislocations": [plane, block]}


def trapezoid():
    """The plane of the wedge as an object, with vertex groups on its lower and its upper side."""
    x, share = np.meshgrid(
        *(np.linspace(low, high, n) for (low, high), n in zip(((-HALF, HALF), (-0.5, 0.5)), VERTICES, strict=True)),
        indexing="ij",
    )
    points = np.column_stack([x.ravel(), (share * np.interp(x, (-HALF, HALF), HEIGHTS)).ravel(), np.zeros(x.size)])
    number = np.arange(x.size).reshape(VERTICES)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    # Triangles whose diagonals change their way from one to the next favour no direction.
    is_even = (np.indices(a.shape).sum(axis=0) % 2 == 0)[..., None]
    ways = (((a, b, c), (a, c, d)), ((a, b, d), (b, c, d)))
    faces = [np.where(is_even, np.stack(one, -1), np.stack(other, -1)) for one, other in zip(*ways, strict=True)]
    obj = add_mesh("Plane", points, np.concatenate([face.reshape(-1, 3) for face in faces]))
    for name, row in (("Bottom", number[:, 0]), ("Top", number[:, -1])):
        obj.vertex_groups.new(name=name).add(row.tolist(), 1.0, "REPLACE")
    return obj


def tetrahedron():
    """Layers in one tetrahedron: they grow upwards, and by a turn around a line through two of its faces."""
    corners = np.array([(1, 1, 1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1)], float)
    mesh = TetMesh(corners, np.array([[0, 1, 2, 3]]))
    x, _, z = (corners - [0.05, 0, -0.1]).T
    around = np.arctan2(z, x)
    i, j = mesh.edges.T
    turns = around[j] - around[i]
    asked = STEEPNESS * (z[j] - z[i]) + turns - 2 * np.pi * np.rint(turns / (2 * np.pi))
    growth = SolidTargetOneForm(mesh, np.zeros_like(corners), asked)
    return LayerPattern(mesh, None, growth.edge_phases(np.exp(1j * (STEEPNESS * z + around))))
