# SPDX-License-Identifier: GPL-3.0-or-later
"""The one door by which arrays become Blender's meshes and curves.

Blender trusts what scripts give it: a face with a vertex twice, a number of a vertex that does not exist or a
coordinate that is not finite ends its process, at once or later. All of these are refused here, before Blender sees
anything of them; where they come up the fault is ours.
"""

import bpy
import numpy as np

from ...core.errors import SynchError

_NO_POINTS = np.empty((0, 3))
_NO_CORNERS = np.empty(0, int)


def new_mesh(name, points=_NO_POINTS, corners=_NO_CORNERS, sizes=None, smooth=False):
    """A new mesh datablock; arguments and errors as of :func:`fill_mesh`."""
    checked = _check_arrays(name, points, corners, sizes)
    data = bpy.data.meshes.new(name)
    _fill(data, *checked, smooth)
    return data


def fill_mesh(data, points, corners, sizes=None, smooth=False):
    """Put vertices and faces into a mesh datablock in place of what it has; its materials stay.

    Raises SynchError before anything is changed: where a face has fewer than three corners or a vertex twice, where a
    vertex does not exist, and where a place is not finite.

    Parameters
    ----------
    points : (n, 3) places of the vertices
    corners : (f, k) vertices of faces that all have k corners; or (c,) of all faces, one after the other
    sizes : (f,) number of corners of each face, None where ``corners`` implies it
    smooth : whether faces are shaded smooth
    """
    checked = _check_arrays(data.name, points, corners, sizes)
    data.clear_geometry()
    _fill(data, *checked, smooth)


def add_spline(data, points, kind="POLY", is_closed=False):
    """Add a spline through (n, 3) points to a curve datablock, and return it; knots of Bezier splines are smooth.

    Raises SynchError before anything is changed, where there are no points or one is not finite.
    """
    points = _finite(data.name, points)
    if len(points) == 0:
        raise _fault(data.name, "a curve without points")
    spline = data.splines.new(kind)
    spline.use_cyclic_u = bool(is_closed)
    if kind == "BEZIER":
        spline.bezier_points.add(len(points) - 1)
        spline.bezier_points.foreach_set("co", points.ravel())
        for point in spline.bezier_points:
            point.handle_left_type = point.handle_right_type = "AUTO"
        return spline
    spline.points.add(len(points) - 1)
    spline.points.foreach_set("co", np.column_stack([points, np.ones(len(points), np.float32)]).ravel())
    return spline


def _fill(data, points, corners, sizes, smooth):
    """Fill an empty mesh: (n, 3) points, the corners' vertices face by face, and (f,) numbers of corners."""
    data.vertices.add(len(points))
    data.loops.add(len(corners))
    data.polygons.add(len(sizes))
    data.vertices.foreach_set("co", points.ravel())
    data.loops.foreach_set("vertex_index", corners)
    data.polygons.foreach_set("loop_start", (np.cumsum(sizes) - sizes).astype(np.int32))
    data.update(calc_edges=True)
    if smooth:
        data.shade_smooth()
    else:
        data.shade_flat()


def _check_arrays(name, points, corners, sizes):
    """(n, 3) float32 places, (c,) int32 corners and (f,) sizes that Blender can take."""
    points, corners = _finite(name, points), np.asarray(corners)
    if sizes is None:
        sizes = np.full(len(corners), corners.shape[1] if corners.ndim == 2 else 0)
    sizes, corners = np.asarray(sizes, int), corners.ravel()
    if sizes.sum() != len(corners):
        raise _fault(name, f"faces of {sizes.sum()} corners with the vertices of {len(corners)}")
    if len(corners) and (corners.min() < 0 or corners.max() >= len(points)):
        wrong = corners[(corners < 0) | (corners >= len(points))][0]
        raise _fault(name, f"a face at vertex {wrong} of {len(points)}")
    starts = np.cumsum(sizes) - sizes
    for size in np.unique(sizes):
        of_size = np.flatnonzero(sizes == size)
        rows = np.sort(corners[starts[of_size, None] + np.arange(size)], axis=1)
        different = min(size, 1) + np.count_nonzero(np.diff(rows, axis=1), axis=1)
        wrong = np.flatnonzero(different < max(size, 3))
        if len(wrong):
            raise _fault(
                name, f"face {of_size[wrong[0]]} with {different[wrong[0]]} different vertices at {size} corners"
            )
    return points, corners.astype(np.int32), sizes


def _finite(name, points):
    """(n, 3) places as Blender's single-precision numbers."""
    with np.errstate(over="ignore"):
        points = np.ascontiguousarray(points, np.float32).reshape(-1, 3)
    wrong = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(wrong):
        raise _fault(name, f"point {wrong[0]} of {len(points)} at a place that is not finite")
    return points


def _fault(name, what):
    return SynchError(f"an internal fault made {what} for {name}: nothing was written, please report it with the file")
