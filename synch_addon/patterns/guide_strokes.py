# SPDX-License-Identifier: GPL-3.0-or-later
"""Guide strokes: splines of curve objects that belong to a mesh object, one for each wish and strength.

Each of these curves is a row of the object's constraint list. They lie in a collection, in the object's space, and are
curves like any other: what is changed of them by hand counts as it is.
"""

import math
from itertools import pairwise
from typing import NamedTuple

import bpy
import numpy as np
from mathutils.geometry import interpolate_bezier

from ..blender.changes import changes
from ..blender.new_geometry import add_spline
from ..blender.transaction import keep, leave, whole_or_nothing

# What a curve object of strokes has as a custom property.
STROKES = "synch_strokes"
# Names of curve objects, behind that of the mesh object, by what they ask for.
_NAMES = {"ALONG": "Along", "ACROSS": "Across", "PHASE": "Stripes"}
# Points from one of a Bézier spline to the next.
_RESOLUTION = 12


class Stroke(NamedTuple):
    """One stroke of an object.

    Attributes
    ----------
    curve : name of the curve object
    number : of its spline
    wish : "ALONG", "ACROSS" or "PHASE"
    points : (p, 3) along it, in the mesh object's space
    """

    curve: str
    number: int
    wish: str
    points: np.ndarray

    @property
    def key(self):
        """The key of a stroke among those of its object."""
        return self.curve, self.number


def strokes_of(obj):
    """The strokes of a mesh object, as list of :class:`Stroke`."""
    return [stroke for row in _rows(obj) for stroke in _strokes(row)]


def state_of(obj):
    """A value that stays equal until Blender reports a change of an object's strokes."""
    return tuple((row.what, changes.state(row.curve), _to_owner(row.curve).freeze()) for row in _rows(obj))


def _strokes(row):
    matrix = np.array(_to_owner(row.curve))
    for number, spline in enumerate(row.curve.data.splines):
        points = _points(spline)
        if len(points) > 1:
            yield Stroke(row.curve.name, number, row.what, points @ matrix[:3, :3].T + matrix[:3, 3])


def _points(spline):
    """(p, 3) along a spline."""
    if spline.type != "BEZIER":
        return np.array([point.co[:3] for point in spline.points])
    knots = list(spline.bezier_points)
    line = [np.array(knot.co)[None] for knot in knots[:1]]
    for start, end in pairwise(knots):
        piece = interpolate_bezier(start.co, start.handle_right, end.handle_left, end.co, _RESOLUTION + 1)
        line.append(np.array(piece)[1:])
    return np.concatenate(line)


def _rows(obj):
    return [row for row in obj.synch.constraints if row.where == "CURVE" and _is_of_strokes(row.curve, obj)]


def _is_of_strokes(curve, obj):
    return curve is not None and curve.type == "CURVE" and curve.parent == obj and STROKES in curve


def _to_owner(curve):
    """The transform from a curve object's space to that of its parent."""
    return curve.matrix_parent_inverse @ curve.matrix_basis


def add(obj, lines, wish, weight):
    """Add strokes to a mesh object: lines of (k, 3) knots in its space, with the wish "ALONG", "ACROSS" or "PHASE" and
    a weight, None for strokes that are held exactly."""
    with whole_or_nothing():
        row = next((row for row in _rows(obj) if row.what == wish and _has_weight(row, weight)), None)
        curve = _new_curve(obj, wish) if row is None else row.curve
        keep(curve.data)
        _add_lines(curve, lines)
        if row is None:
            _add_row(obj, curve, wish, weight)


def replace(obj, lines):
    """Give strokes of a mesh object other points.

    ``lines``: dict of (k, 3) knots in the object's space, by the strokes' keys.
    """
    with whole_or_nothing():
        for curve, numbers in _by_curve(lines):
            keep(curve.data)
            _add_lines(curve, [lines[curve.name, number] for number in numbers])
            _remove_splines(curve, numbers)


def remove(obj, keys):
    """Remove strokes from a mesh object, by their keys; a curve object without strokes goes, and its row with it."""
    with whole_or_nothing():
        emptied = []
        for curve, numbers in _by_curve(keys):
            if len(numbers) == len(curve.data.splines):
                emptied.append(curve)
            else:
                keep(curve.data)
                _remove_splines(curve, numbers)
        _remove_curves(obj, emptied)


def _by_curve(keys):
    """Group strokes by their curve objects: pairs of an object and the numbers of its splines, in descending order."""
    numbers = {}
    for name, number in sorted(keys, reverse=True):
        numbers.setdefault(name, []).append(number)
    return [(bpy.data.objects[name], found) for name, found in numbers.items()]


def _remove_splines(curve, numbers):
    for number in numbers:
        curve.data.splines.remove(curve.data.splines[number])
    _strokes_changed(curve)


def _remove_curves(obj, curves):
    """Remove curve objects with their rows, and their collection if nothing else is in it."""
    rows = obj.synch.constraints
    for number in reversed([number for number, row in enumerate(rows) if row.curve in curves]):
        rows.remove(number)
    of_strokes = {group for curve in curves for group in curve.users_collection if group.get(STROKES)}
    emptied = [group for group in of_strokes if set(group.all_objects) <= set(curves) and not group.children]
    leave([*curves, *(curve.data for curve in curves), *emptied])


def _has_weight(row, weight):
    if weight is None or not row.soft:
        return weight is None and not row.soft
    return math.isclose(row.weight, weight, rel_tol=1e-6)


def _new_curve(obj, wish):
    """A curve object for strokes, which goes where the mesh object goes."""
    data = bpy.data.curves.new(f"{obj.name} {_NAMES[wish]}", "CURVE")
    data.dimensions, data.resolution_u = "3D", _RESOLUTION
    curve = bpy.data.objects.new(data.name, data)
    curve.parent, curve[STROKES] = obj, True
    _collection(obj).objects.link(curve)
    return curve


def _collection(obj):
    """The collection of an object's strokes."""
    for row in _rows(obj):
        for collection in row.curve.users_collection:
            if collection.get(STROKES):
                return collection
    made = bpy.data.collections.new(f"{obj.name} Strokes")
    made[STROKES] = True
    parents = [collection for collection in obj.users_collection if collection.is_editable]
    (parents or [bpy.context.scene.collection])[0].children.link(made)
    return made


def _add_row(obj, curve, wish, weight):
    row = obj.synch.constraints.add()
    row.where, row.what, row.curve = "CURVE", wish, curve
    row.soft = weight is not None
    if weight is not None:
        row.weight = weight


def _add_lines(curve, lines):
    """Add a spline through knots in the owner's space for each line."""
    inverse = np.array(_to_owner(curve).inverted())
    for line in lines:
        add_spline(curve.data, line @ inverse[:3, :3].T + inverse[:3, 3], "BEZIER")
    _strokes_changed(curve)


def _strokes_changed(curve):
    """Blender sends no message about splines that scripts add or remove."""
    curve.data.update_tag()
