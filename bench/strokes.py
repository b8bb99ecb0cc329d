# SPDX-License-Identifier: GPL-3.0-or-later
"""A stripe on a curve: how far its middle is from the curve, and how wavy the stripes beside it are.

    python bench/strokes.py

The sample Vase at several fineness and spacings, with a Bezier circle of radius 1.05 at z = -0.6 that a stripe is to
lie on, and without. Prints a table. Needs Blender as a module (bpy).

What is measured are the middles of stripes as they are drawn, in spacings, at the 95th percentile: *off the curve* from
points of the curve on the surface to the nearest middle; *wavy* how far to the side middles are of cubics through them
over two spacings of their length, between half a spacing and two and a half from the curve: all of them, and those
farther than one and a half spacings from any defect, where stripes end and others make room.
"""

import bpy
import numpy as np
from scipy.signal import savgol_filter
from scipy.spatial import cKDTree

import synch_fields
from synch_fields.bench.command import arguments
from synch_fields.bench.tables import Column, print_table
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import meshes
from synch_fields.synch_addon.blender.strokes import read_strokes
from synch_fields.synch_addon.looks.samples import add_sample
from synch_fields.synch_addon.patterns.picking import PickedSurface

DETAILS, SPACINGS = (3, 4), (0.1, 0.15, 0.25)
# In spacings: from point to point of what is measured, the length of cubics, from where to where neighbours are, and
# how far from defects.
STEP, LENGTH, NEAR, AWAY = 0.01, 2, (0.5, 2.5), 1.5
COLUMNS = (
    Column("spacing", "spacing", ".2f"),
    Column("off the curve", "off", ".2%"),
    Column("wavy beside it, all", "held_all", ".2%"),
    Column("without the curve", "free_all", ".2%"),
    Column("away from defects", "held", ".2%"),
    Column("without the curve", "free", ".2%"),
)


def main():
    """Print the table."""
    arguments(__doc__).parse_args()
    synch_fields.register()
    try:
        rows = [measured(detail, spacing) for detail in DETAILS for spacing in SPACINGS]
        print_table("A stripe on a circle", COLUMNS, rows, "vertices")
    finally:
        synch_fields.unregister()


def measured(detail, spacing):
    """A row of the table."""
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.curve.primitive_bezier_circle_add(radius=1.05, location=(0, 0, -0.6))
    source = bpy.context.active_object
    source.data.resolution_u = 64
    obj = add_sample("VASE", detail)
    obj.synch.boundary = "FREE"
    curve = on_surface(obj, source)
    wish = {"where": "curve", "what": "phase", "name": source.name}
    row = {"label": f"{len(obj.data.vertices):,}", "spacing": spacing}
    for name, wishes in (("held", [wish]), ("free", [])):
        report = api.stripes(obj, spacing=spacing, constraints=wishes)
        lines = middles(obj, spacing)
        defects = [defect["position"] for kind in ("disclinations", "dislocations") for defect in report[kind]]
        row[f"{name}_all"], row[name] = waviness(obj, lines, curve, np.array(defects), spacing)
        if wishes:
            row["off"] = np.quantile(cKDTree(np.concatenate(lines)).query(curve)[0], 0.95) / spacing
    return row


def on_surface(obj, source):
    """(k, 3) points of a curve on the surface of an object that lies where the scene begins."""
    given = meshes.read_mesh(obj)
    ((_, points),) = read_strokes(obj, source.name, given)
    return resampled(np.concatenate([points, points[:1]]), np.ptp(points, axis=0).max() / 300)


def middles(obj, spacing):
    """[(k, 3)] of the middles of all stripes, a point at each step."""
    lines = bpy.data.objects[api.isolines(obj, radius=0, distance=0, smoothing=0)["object"]]
    found = []
    for spline in lines.data.splines:
        points = np.array([lines.matrix_world @ point.co.to_3d() for point in spline.points])
        if spline.use_cyclic_u:
            points = np.concatenate([points, points[:1]])
        found.append(resampled(points, STEP * spacing))
    bpy.data.objects.remove(lines)
    bpy.context.view_layer.objects.active = obj
    return found


def resampled(points, step):
    """(k, 3) points at equal steps of arc length along a polyline."""
    way = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    asked = np.linspace(0, way[-1], max(int(way[-1] / step), 1) + 1)
    return np.column_stack([np.interp(asked, way, points[:, axis]) for axis in range(3)])


def waviness(obj, lines, curve, defects, spacing):
    """How far to the side lines beside a curve are of cubics through them, in spacings, at the 95th percentile: all of
    them, and those away from defects."""
    beside, ends, surface = cKDTree(curve), cKDTree(defects), PickedSurface.of(obj).tree
    window, off, is_away = int(LENGTH / STEP) + 1, [], []
    for points in lines:
        apart = beside.query(points)[0] / spacing
        near = (apart > NEAR[0]) & (apart < NEAR[1])
        if len(points) > window and near.any():
            residual = (points - savgol_filter(points, window, 3, axis=0))[near]
            normals = np.array([surface.find_nearest(point)[1] for point in points[near]])
            residual -= np.einsum("ij,ij->i", residual, normals)[:, None] * normals
            off.append(np.linalg.norm(residual, axis=1) / spacing)
            is_away.append(ends.query(points[near])[0] > AWAY * spacing)
    off, is_away = np.concatenate(off), np.concatenate(is_away)
    return np.quantile(off, 0.95), np.quantile(off[is_away], 0.95)


if __name__ == "__main__":
    main()
