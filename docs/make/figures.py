# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's Figures 6 and 8 again: stripes on a plane domain and on the bunny, side by side.

Figure 6: a line field on a planar domain, and stripes along it by the spectral relaxation, by the semidefinite one,
and by the semidefinite one with a stripe on the boundary. Figure 8: stripes along the principal curvature of
stanford-bunny.obj, spectral and semidefinite. Needs Blender as a module (bpy).
"""

import bpy
import numpy as np
from scipy.spatial import Delaunay

from synch_fields.bench.tables import Column
from synch_fields.docs.make.sheets import beside
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import attributes, files
from synch_fields.synch_addon.looks.render import render_picture

SPACING = 0.075
EDGE = 0.02
COLUMNS = (
    Column("nodes", "nodes", "d"),
    Column("spectral bound", "spectral_bound", ".1f"),
    Column("lower bound", "lower_bound", ".1f"),
    Column("SDP", "sdp_value", ".1f"),
    Column("certificate", "certificate", ""),
    Column("energy", "energy", ".1f"),
    Column("dislocations", "dislocation count", "d"),
    Column("s", "seconds", ".1f"),
)


def figure6(place):
    """The line field and three patterns along it."""
    bpy.ops.wm.read_homefile(use_empty=True)
    obj = add_domain()
    field = api.directions(obj, boundary="along")
    view = dict(view=(0, 90), resolution=(560, 440), markers=False)
    runs = (("spectral", dict(method="spectral")), ("SDP", {}), ("SDP, stripe on the boundary", dict(boundary="phase")))
    pictures = [render_picture(add_glyphs(obj), place.folder / "field.png", **view)]
    rows = [row("planar: line field along the boundary", field)]
    for name, settings in runs:
        report = api.stripes(
            obj, guidance="attribute:synch_direction", spacing=SPACING, assign_material=True, **settings
        )
        rows.append(row(f"planar: {name}", report))
        pictures.append(render_picture(obj, place.folder / f"{name}.png", **view))
    beside(pictures, place.picture)
    return {"energies": rows}


def figure8(place):
    """Two patterns along one line field."""
    rows, pictures = [], []
    for name, method in (("spectral", "spectral"), ("SDP", "sdp")):
        obj = files.open_object(place.meshes / "stanford-bunny.obj")
        if method == "spectral":
            field = api.directions(obj, guidance="curvature-min")
            rows.append(row("bunny: line of least curvature", field))
            directions = read_directions(obj)
        else:
            write_directions(obj, directions)
        report = api.stripes(obj, guidance="attribute:synch_direction", method=method, assign_material=True)
        rows.append(row(f"bunny: {name}", report))
        picture = place.folder / f"{name}.png"
        pictures.append(render_picture(obj, picture, view=(-20, 12), resolution=(900, 800), samples=16, markers=False))
    beside(pictures, place.picture)
    return {"energies": rows}


def row(label, report):
    """A row of the table from a report."""
    counts = {"dislocation count": len(report["dislocations"]), "seconds": report["times"]["total"], "label": label}
    return {key: value for key, value in report.items() if value is not None} | counts


def add_domain():
    """A blob with a hole in the plane, of even triangles, as the active object."""
    turn = np.linspace(0, 2 * np.pi, 20_000)
    rim = closed_curve((1 + 0.22 * np.cos(2 * turn + 0.5) + 0.14 * np.cos(3 * turn + 1.2)) * np.exp(1j * turn))
    hole = closed_curve(0.32 + 0.08j + 0.22 * np.exp(1j * turn))
    x, y = np.meshgrid(np.arange(-1.5, 1.5, EDGE), np.arange(-1.5, 1.5, EDGE * np.sqrt(0.75)))
    x[::2] += EDGE / 2
    inside = np.column_stack([x.ravel(), y.ravel()])
    inside = inside[contains(rim, inside) & ~contains(hole, inside)]
    walls = np.concatenate([rim, hole])
    far = np.linalg.norm(inside[:, None] - walls, axis=2).min(axis=1) > 0.65 * EDGE
    points = np.concatenate([walls, inside[far]])
    triangles = Delaunay(points).simplices
    centres = points[triangles].mean(axis=1)
    triangles = triangles[contains(rim, centres) & ~contains(hole, centres)]
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    upside = np.linalg.det(np.stack([b - a, c - a], axis=1)) < 0
    triangles[upside] = triangles[upside, ::-1]
    return add_mesh("Domain", np.column_stack([points, np.zeros(len(points))]), triangles)


def closed_curve(numbers):
    """Points on a closed curve of complex numbers, EDGE apart."""
    points = np.column_stack([numbers.real, numbers.imag])
    along = np.append(0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    places = np.linspace(0, along[-1], round(along[-1] / EDGE), endpoint=False)
    return np.column_stack([np.interp(places, along, column) for column in points.T])


def contains(polygon, points):
    """Whether a closed polygon winds around each point."""
    start, end = polygon, np.roll(polygon, -1, axis=0)
    crossed = np.zeros(len(points), bool)
    for (x0, y0), (x1, y1) in zip(start, end, strict=True):
        if y0 != y1:
            spans = (points[:, 1] < max(y0, y1)) & (points[:, 1] >= min(y0, y1))
            crossed ^= spans & (points[:, 0] < x0 + (points[:, 1] - y0) * (x1 - x0) / (y1 - y0))
    return crossed


def add_glyphs(obj, length=0.055, width=0.011):
    """The domain with a bar for the direction at some of its vertices."""
    points, directions = (attributes.read_values(obj, name, "POINT") for name in ("position", "synch_direction"))
    cells = np.unique(np.floor(points[:, :2] / (1.25 * length)), axis=0, return_index=True)[1]
    along = directions[cells] * length / 2
    across = np.cross([0, 0, 1], directions[cells]) * width / 2
    corners = [points[cells] + s * along + t * across for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    bars = np.stack(corners, axis=1).reshape(-1, 3) + [0, 0, 0.004]
    copy = add_mesh("Line field", bars, np.arange(len(bars)).reshape(-1, 4))
    dark = bpy.data.materials.new("Dark")
    if dark.node_tree is None:
        dark.use_nodes = True
    dark.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.02, 0.03, 0.06, 1)
    copy.data.materials.append(dark)
    return copy


def add_mesh(name, points, faces):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points.tolist(), [], faces.tolist())
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    return obj


def read_directions(obj):
    values = np.empty(3 * len(obj.data.vertices), np.float32)
    obj.data.attributes["synch_direction"].data.foreach_get("vector", values)
    return values


def write_directions(obj, values):
    obj.data.attributes.new("synch_direction", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", values)
