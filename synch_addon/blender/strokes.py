# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves of other objects, read as strokes on the surface."""

from contextlib import contextmanager

import bpy
import numpy as np
from mathutils.bvhtree import BVHTree

from ...core.errors import SettingError
from ...core.geometry.polylines import check_length, polyline_length, resample_polyline, values_along
from .attributes import read_all
from .modifiers import is_of_filaments
from .objects import world_of

SOURCE_TYPES = {"CURVE", "GREASEPENCIL", "MESH"}
# The offsets from a curve to the surface are averaged over this number of mesh edges to both sides.
_SMOOTHED = 1.5
# What the course of a spline depends on besides its points.
_OF_SPLINES = ("use_cyclic_u", "use_endpoint_u", "use_bezier_u", "order_u", "resolution_u")
# Places of a shape key's points; only those of Bézier splines have handles.
_OF_KEYS = ("co", "handle_left", "handle_right")


def read_strokes(obj, name, given):
    """Curves of another object, projected to the surface: pairs of (p,) triangles and (p, 3) points.

    Every polyline is sampled at half the mesh's shorter edges. What lies nearest to a curve off the surface jumps from
    face to face: the ways there are averaged along it, over some edges. Works with curves, Grease Pencil and meshes of
    edges, as they are seen, modifiers included; of a curve with thickness or fill the splines alone count. Raises
    SettingError when there is no such object, or it holds no curve, or one that is far too long for the mesh.
    """
    source = bpy.data.objects.get(name)
    if source is None or source == obj:
        raise SettingError(f"there is no curve object {name!r}: choose a curve or Grease Pencil object of the scene")
    if source.type not in SOURCE_TYPES:
        raise SettingError(f"the object {name!r} is a {source.type.lower()}: choose a curve or Grease Pencil object")
    mesh = given.mesh
    step = 0.5 * np.quantile(mesh.edge_lengths, 0.1)
    tree = BVHTree.FromPolygons(mesh.vertices.tolist(), mesh.triangles.tolist(), all_triangles=True)
    into = given.stretch @ np.array(world_of(obj).inverted())[:3]
    matrix = np.array(source.matrix_world)
    lines = [np.column_stack([line, np.ones(len(line))]) @ matrix.T @ into.T for line in polylines(source)]
    check_length(f"the object {name!r}", sum(polyline_length(points) for points in lines), step)
    reach = _SMOOTHED * np.median(mesh.edge_lengths)
    strokes = [_project_polyline(tree, resample_polyline(points, step), reach) for points in lines]
    if not strokes:
        raise SettingError(f"the object {name!r} holds no curve: draw one, or choose another object")
    return strokes


def _project_polyline(tree, points, reach):
    """(p,) faces and (p, 3) places on the surface for the points of a polyline."""
    faces, places = _nearest(tree, points)
    reach = min(reach, polyline_length(points) / 4)
    ways = np.linspace(-reach, reach, 9)
    for _ in range(2):
        around = values_along(points, places - points, ways)
        faces, places = _nearest(tree, points + np.average(around, axis=0, weights=1.1 * reach - np.abs(ways)))
    return faces, places


def _nearest(tree, points):
    places, _, faces, _ = zip(*map(tree.find_nearest, points), strict=True)
    return np.array(faces), np.array(places)


def polylines(source):
    """(p, 3) points of every curve of an object, in its own space."""
    evaluated = source.evaluated_get(bpy.context.evaluated_depsgraph_get())
    if source.type == "GREASEPENCIL":
        lines = [line for layer in evaluated.data.layers for line in _strokes_at_frame(layer)]
    elif _is_of_splines(source):
        with _middle_line(source) as thin:
            lines = _chains(thin)
    else:
        lines = _chains(evaluated)
    return [line for line in lines if len(line) > 1 and np.ptp(line, axis=0).any()]


def shape_of(source):
    """Arrays that change if :func:`polylines` of an object do. Nothing is written, so that panels may ask as they
    are drawn."""
    if not _is_of_splines(source):
        return polylines(source)
    shape = list(_shape_of_keys(source.data.shape_keys))
    for spline in source.data.splines:
        shape.append(np.array([getattr(spline, name) for name in _OF_SPLINES]))
        shape += [read_all(spline.bezier_points, name, 3, np.float32) for name in ("co", "handle_left", "handle_right")]
        shape.append(read_all(spline.points, "co", 4, np.float32))
    return shape


def _shape_of_keys(keys):
    """Arrays that determine how shape keys, which may be None, shape a curve."""
    if keys is None:
        return
    blocks = keys.key_blocks
    yield np.array([keys.use_relative, keys.eval_time])
    for block in blocks:
        yield np.array([block.value, block.mute, blocks.find(block.relative_key.name), block.frame])
        yield np.frombuffer(block.interpolation.encode(), np.uint8)
        yield np.array([getattr(point, name) for point in block.data for name in _OF_KEYS if hasattr(point, name)])


def _is_of_splines(source):
    """Whether an object is a curve of which only the splines count, without thickness and modifiers."""
    return source.type == "CURVE" and (_is_thick(source.data) or any(map(is_of_filaments, source.modifiers)))


def _strokes_at_frame(layer):
    """Strokes of a Grease Pencil layer at the present frame."""
    frame = layer.current_frame()
    for stroke in frame.drawing.strokes if frame is not None else ():
        points = [layer.matrix_local @ point.position for point in stroke.points]
        yield np.array(points + points[:1] if stroke.cyclic else points)


def _is_thick(curve):
    filled = curve.dimensions == "2D" and curve.fill_mode != "NONE"
    return filled or curve.extrude or curve.bevel_depth or curve.bevel_mode == "OBJECT"


@contextmanager
def _middle_line(source):
    """A temporary object with a curve's splines, without thickness and modifiers."""
    data = source.data.copy()
    data.dimensions, data.bevel_mode, data.bevel_depth, data.extrude = "3D", "ROUND", 0, 0
    thin = bpy.data.objects.new(source.name, data)
    try:
        yield thin
    finally:
        bpy.data.objects.remove(thin)
        bpy.data.curves.remove(data)


def _chains(seen):
    """Polylines along the edges of the mesh that an object shows."""
    mesh = seen.to_mesh()
    if mesh is None:  # of a curve without splines
        return []
    try:
        points = read_all(mesh.vertices, "co", 3, np.float32)
        pairs = read_all(mesh.edges, "vertices", 2)
    finally:
        seen.to_mesh_clear()
    beside = {}
    for i, j in pairs.tolist():
        beside.setdefault(i, []).append(j)
        beside.setdefault(j, []).append(i)
    chains, passed = [], set()
    for start in sorted(beside, key=lambda v: len(beside[v]) == 2):  # ends and junctions first, then loops
        for following in beside[start]:
            chain = [start]
            while following is not None and (chain[-1], following) not in passed:
                passed |= {(chain[-1], following), (following, chain[-1])}
                chain.append(following)
                on = [v for v in beside[following] if (following, v) not in passed]
                following = on[0] if len(beside[following]) == 2 and on else None
            if len(chain) > 1:
                chains.append(points[chain])
    return chains
