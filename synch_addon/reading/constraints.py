# SPDX-License-Identifier: GPL-3.0-or-later
"""The constraint list of an object: edges that are cut, and rows along lines of its mesh."""

from dataclasses import replace

import numpy as np

from ...core.errors import SettingError
from ...core.fields import Row, boundary_line, line_of_edges
from ...core.fields.constraints.lines import (
    group_edges,
    line_of_group,
    line_of_points,
    line_of_strokes,
    line_of_vectors,
)
from ...core.geometry.cut import cut_open, edges_after_cut
from ..blender import attributes, groups
from ..blender.strokes import read_strokes


def cut_mesh(obj, given, constraints):
    """The :class:`MeshInput` cut open along the edges of the rows that ask for a cut."""
    cutting = [c for c in constraints if c.what == "cut"]
    if not cutting:
        return given
    edges = np.unique(np.concatenate([_edges(obj, given, c) for c in cutting]))
    mesh, source = cut_open(given.mesh, edges)
    polygons = given.polygons.with_triangles(mesh.triangles)
    # The seam of a one-sided surface stays linked where it is not cut.
    linked = given.linked[~np.isin(given.mesh.triangle_edges.ravel()[given.linked], edges).any(axis=1)]
    return replace(given, mesh=mesh, polygons=polygons, source=given.source[source], linked=linked)


def rows_of(obj, given, constraints):
    """The core's rows for all constraints but cuts, on the mesh as it may have been cut."""
    return tuple(_row(obj, given, c) for c in constraints if c.what != "cut")


def _row(obj, given, constraint):
    value = np.radians(constraint.degrees)
    if constraint.where == "attribute":
        line, phases = _line_of_attribute(obj, given, constraint)
        value = value if phases is None else value + phases
    else:
        line = _line(obj, given, constraint)
    return Row(line, constraint.what, value, constraint.weight, constraint.label)


def _line(obj, given, constraint):
    """The line of a constraint: its nodes and edges on the cut mesh."""
    if constraint.where == "curve":
        return line_of_strokes(given.mesh, read_strokes(obj, constraint.name, given))
    group = groups.read_group(obj, constraint.name) if constraint.name else None
    if constraint.where == "boundary":
        try:
            members = None if group is None else group[_source_of_uncut(given)]
            line = boundary_line(given.uncut, members, given.boundary_edges)
        except SettingError as error:
            raise SettingError(f"{constraint.label}: {error}, or remove the row") from None
        edges = given.uncut.edges_between(*line.links.T)
    elif constraint.where == "group":
        return line_of_group(given.mesh, group[given.source])
    else:
        edges = _edges(obj, given, constraint)
    return line_of_edges(given.mesh, edges_after_cut(given.uncut, given.mesh, edges))


def _edges(obj, given, constraint):
    """Indices of edges of the uncut mesh."""
    if constraint.where != "group":
        edges = given.edges_of(attributes.read_marked_edges(obj, constraint.where))
        remedy = {"seams": "Mark Seam", "sharp": "Mark Sharp", "creases": "Edge Crease"}[constraint.where]
        remedy = f"mark edges with {remedy} first"
    else:
        members = groups.read_group(obj, constraint.name)
        edges = group_edges(given.uncut, members[_source_of_uncut(given)])
        remedy = f"add both ends of at least one to {constraint.name!r}"
    if len(edges) == 0:
        raise SettingError(f"{constraint.label} holds no edge: {remedy}, or remove the row")
    return edges


def _source_of_uncut(given):
    """(n,) vertex of the object for each vertex of the uncut surface."""
    return given.source[: given.uncut.vertex_count]


def _line_of_attribute(obj, given, constraint):
    """A field of directions, or of phases, as unlinked points, and the phases."""
    phases = None
    if constraint.what == "phase":
        numbers = attributes.read_numbers(obj, constraint.name, given, outside=np.nan)
        line = line_of_points(given.mesh, np.flatnonzero(np.isfinite(numbers)))
        phases = numbers[line.nodes]
    else:
        line = line_of_vectors(given.mesh, attributes.read_vectors(obj, constraint.name, given))
    if len(line.vertices) == 0:
        kind = "tangential vector" if phases is None else "number"
        raise SettingError(f"{constraint.label} holds nowhere: give one vertex at least a {kind}, or remove the row")
    return line, phases
