# SPDX-License-Identifier: GPL-3.0-or-later
"""Guides of directions, read from an object."""

from functools import partial

import bpy
import numpy as np

from ...core.errors import SettingError
from ...core.fields.guidance.guides import axis_guide, curvature_guide, distance_guide, gradient_guide, vectors_guide
from ...core.settings.guidance import AXES, BOUNDARY
from ...core.settings.surface import SYMMETRY_ORDERS
from ...core.tasks.surface_source import PendingGuide
from ..blender import attributes
from ..blender import groups as blender_groups
from ..blender.field_files import read_guide
from ..blender.strokes import read_strokes


def read_guides(obj, given, symmetry, sources):
    """Read what sources need of the object, as a PendingGuide each, for fields of the symmetry "vector", "line" or
    "cross".

    Raises SettingError for names that do not exist, files that do not fit, and lines or crosses as guides of another
    symmetry.
    """
    return tuple(
        PendingGuide(source.label, _pending(obj, given, symmetry, source), source.share, source.is_of_curvature)
        for source in sources
    )


def _pending(obj, given, symmetry, source):
    """Read what a guide names, and return the function without arguments that computes its directions."""
    mesh, kind, name = given.mesh, source.kind, source.name
    if source.is_of_curvature:
        _refuse_unequal(source, 2, symmetry)
        return partial(curvature_guide, mesh, largest=kind == "curvature-max")
    if kind in ("gradient", "contour"):
        return partial(gradient_guide, mesh, attributes.read_numbers(obj, name, given), contour=kind == "contour")
    if kind in ("distance", "offset"):
        return partial(distance_guide, mesh, _read_origin(obj, name, given), contour=kind == "offset")
    if kind == "axis":
        return partial(axis_guide, mesh, given.stretch[:, AXES.index(name)])
    if kind in ("uv-u", "uv-v"):
        coordinates = attributes.read_uv_map(obj, name)[given.polygons.triangle_corners]
        return partial(gradient_guide, mesh, coordinates[..., "uv".index(kind[-1])])
    if kind == "attribute":
        return partial(vectors_guide, mesh, attributes.read_vectors(obj, name, given))
    file_symmetry, compute = read_guide(given, name)
    _refuse_unequal(source, file_symmetry, symmetry)
    return compute


def _refuse_unequal(source, own, symmetry):
    """Refuse a guide with ``own`` equivalent directions at a point for a field of whose directions fewer are
    equivalent."""
    if SYMMETRY_ORDERS[symmetry] % own:
        fitting = [name for name, number in SYMMETRY_ORDERS.items() if number % own == 0]
        remedy = f"set the symmetry to {' or '.join(fitting)}" if fitting else "leave it out"
        raise SettingError(
            f"{source.label} gives {own} directions at a point, which cannot guide a {symmetry} field: {remedy}"
        )


def _read_origin(obj, name, given):
    """(n,) bool: the vertices from which distances are measured."""
    if name in obj.vertex_groups:
        return blender_groups.read_group(obj, name)[given.source]
    if name == BOUNDARY:
        edges = given.boundary_edges
        if len(edges) == 0:
            raise SettingError(
                f"the mesh {obj.data.name} has no boundary: measure from a vertex group or a curve object"
            )
        on_boundary = np.zeros(given.uncut.vertex_count, bool)
        on_boundary[given.uncut.edges[edges]] = True
        return given.of_uncut(on_boundary)
    if name not in bpy.data.objects:
        groups = ", ".join(g.name for g in obj.vertex_groups) or "none yet"
        raise SettingError(
            f"{name!r} is neither a vertex group nor an object: choose a vertex group ({groups}), "
            "a curve object, or boundary"
        )
    passed = np.zeros(given.mesh.vertex_count, bool)
    for faces, _ in read_strokes(obj, name, given):
        passed[given.mesh.triangles[faces]] = True
    return passed
