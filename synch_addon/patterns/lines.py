# SPDX-License-Identifier: GPL-3.0-or-later
"""Isolines of a pattern as a curve object: tubes, wires or ribbons that lie on the surface."""

from collections import Counter
from dataclasses import asdict, replace

import bpy
import numpy as np
from mathutils import Matrix

from ...core.errors import SettingError
from ...core.extract.lines.isolines import End
from ...core.extract.lines.isolines import isolines as traced_lines
from ...core.files.json_text import Json
from ...core.geometry.barycentric import barycentric
from ..blender.new_geometry import add_spline
from ..jobs.report import count_text, versions

# As traced, lines pass vertices of the mesh that lie on them several times: points closer than this are one, in
# spacings.
_SAME = 1e-4
# Share of the way to the middle of its neighbours that a point moves at once.
_STEP = 0.5
# Below this sum of its components in X and Y, a tangent is vertical to Blender's Z-up frames.
_VERTICAL = 1e-4


def write(obj, request, pattern, settings) -> Json:
    """Make the curve object of a pattern's lines beside a mesh object; returns the report.

    It has the place and turn of the mesh object, and the scale is in its points, so that tubes are round and lengths
    those of the scene. Line k of the report's order is spline k.
    """
    spacing = request.spacing
    lines = traced_lines(pattern.edge_phases, settings.width)
    if len(lines.sizes) == 0:
        raise SettingError(f"no line of the pattern lies on {obj.name}: reduce the spacing and solve again")
    length = float(lines.lengths.sum())
    distance = settings.distance * spacing
    shown = lines.resampled(distance) if distance else lines.without_repeats(_SAME * spacing)
    shown = smooth_lines(shown, settings.smoothing)
    data = bpy.data.curves.new(f"{obj.data.name} Lines", "CURVE")
    data.dimensions, data.resolution_u = "3D", 4
    # Frames that depend on each point alone can be turned to the surface exactly, but are not smooth between points.
    data.twist_mode = "Z_UP" if settings.spline == "poly" else "MINIMUM"
    data.bevel_depth = settings.radius * spacing
    data.use_fill_caps = True
    add_splines(data, shown, settings.spline)
    made = bpy.data.objects.new(f"{obj.name} Lines", data)
    for collection in obj.users_collection:
        collection.objects.link(made)
    made.matrix_world = obj.matrix_world @ Matrix(np.linalg.inv(request.given.stretch)).to_4x4()
    return _report(made, shown, length, settings)


def smooth_lines(lines, times):
    """Lines whose points have moved to the middle of their neighbours, but for the ends, and back onto the surface.

    It takes out what comes from the mesh's edges, above all the bends with which lines reach the centres of triangles
    with a dislocation.
    """
    if times == 0:
        return lines
    mesh, following, previous = lines.mesh, lines.next, lines.previous
    places = np.arange(len(following))
    free = (following != places) & (previous != places)
    points, normals = lines.points, lines.normals
    for _ in range(times):
        # Along the surface only: from inside a convex one, the nearest points jump from face to face.
        step = _STEP * (0.5 * (points[following] + points[previous]) - points)
        step -= np.einsum("ij,ij->i", step, normals)[:, None] * normals
        points[free] += step[free]
    places, triangles = mesh.finder.nearest(points[free])
    moved = replace(lines, triangles=lines.triangles.copy(), weights=lines.weights.copy())
    moved.triangles[free], moved.weights[free] = triangles, barycentric(mesh, triangles, places)
    return moved


def add_splines(data, lines, kind):
    """Add a spline of a kind to a curve for each line, poly splines with the tilt of the surface."""
    points, tilts = lines.points, tilts_of(lines).astype(np.float32)
    for start, size, closed in zip(lines.starts, lines.sizes, lines.closed, strict=True):
        run = slice(start, start + size)
        spline = add_spline(data, points[run], kind.upper(), closed)
        if kind == "poly":
            spline.points.foreach_set("tilt", tilts[run])
        elif kind == "nurbs":
            spline.order_u = min(4, size)
            spline.use_endpoint_u = not closed


def tilts_of(lines):
    """(n,) radians that turn the Z-up frame of a polygonal curve so that its normal is the surface's."""
    tangents = _tangents(lines)
    x, y, _ = tangents.T
    level = np.column_stack([y, -x, np.zeros(len(x))])
    level[np.abs(x) + np.abs(y) < _VERTICAL] = [1, 0, 0]
    level /= np.linalg.norm(level, axis=1, keepdims=True)
    across = np.cross(tangents, level)
    normals = lines.normals
    return np.arctan2(np.einsum("ij,ij->i", normals, across), np.einsum("ij,ij->i", normals, level))


def _tangents(lines):
    """(n, 3) unit tangents as Blender has them: halfway between the directions to the points on both sides."""
    leaving = _normalized(lines.points[lines.next] - lines.points)
    arriving = np.zeros_like(leaving)
    arriving[lines.next] = leaving
    last = (lines.starts + lines.sizes - 1)[~lines.closed]
    arriving[lines.starts[~lines.closed]] = 0
    arriving[last] = leaving[last - 1]
    leaving[last] = 0
    return _normalized(arriving + leaving)


def _normalized(vectors):
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.divide(vectors, lengths, out=np.tile([0.0, 0.0, 1.0], (len(vectors), 1)), where=lengths > 0)


def _report(made, lines, length, settings):
    counts = Counter(End(kind) for kind in lines.ends[~lines.closed].ravel().tolist())
    return {
        "status": "made",
        "command": "isolines",
        "object": made.name,
        "lines": len(lines.sizes),
        "closed": int(lines.closed.sum()),
        "ends": {end.name.lower(): counts[end] for end in End if end != End.CLOSED},
        "length": length,
        "points": len(lines.triangles),
        "settings": asdict(settings),
        "versions": versions(),
    }


def summary_line(report):
    """Summarize a report in one line."""
    at = {"boundary": "on the boundary", "dislocation": "at dislocations", "disclination": "at disclinations"}
    ends = [f"{count} {at[end]}" for end, count in report["ends"].items() if count]
    lines = f"{report['object']}: {count_text(report['lines'], 'line')}, {report['length']:.4g} long in all"
    return f"{lines}, {report['closed']} closed" + (f"; ends: {', '.join(ends)}" if ends else "")
