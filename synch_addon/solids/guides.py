# SPDX-License-Identifier: GPL-3.0-or-later
"""What layers follow: read from the scene at once, and turned into directions when the solid is there."""

import bpy
import numpy as np

from ...core.errors import MeshError, SettingError, name_elements
from ...core.fields.guidance.solids import (
    axis_directions,
    curve_directions,
    distance_directions,
    harmonic_directions,
    vector_directions,
)
from ...core.geometry import TriangleMesh
from ...core.geometry.check import check_mesh
from ...core.geometry.filling.surface_distance import normals_at
from ...core.geometry.nearest import NearestTriangles, nearest_in_triangles
from ..blender import attributes
from ..blender import groups as blender_groups
from ..blender.strokes import SOURCE_TYPES, polylines
from ..settings.guidance import AXES, BOUNDARY
from .carried import Area

# Points this near to a surface, as a share of what they span, lie on it.
ON_SURFACE = 1e-6


def read_area(obj, surface, name):
    """The :class:`Area` of a vertex group, or of the whole surface by the name "boundary"."""
    if name == BOUNDARY and name not in obj.vertex_groups:
        return Area("the boundary", np.arange(surface.mesh.triangle_count))
    return Area.of_members(surface, blender_groups.read_group(obj, name), f"the vertex group {name!r}")


def read_guide(obj, surface, guide):
    """Read what a :class:`LayerGuide` needs.

    Parameters
    ----------
    obj : bpy.types.Object, in object mode
    surface : Surface of it
    guide : LayerGuide

    Returns
    -------
    callable, :class:`Carried` -> (n, 3) unit vectors at the solid's vertices; it touches no Blender data

    Raises
    ------
    SettingError
        for names that do not exist or do not fit
    """
    return _READERS[guide.kind](obj, surface, *guide.names)


def _axis(obj, surface, name):
    axis = surface.given.stretch[:, AXES.index(name)]
    return lambda carried: axis_directions(carried.solid, axis)


def _harmonic(obj, surface, low, high):
    low, high = read_area(obj, surface, low), read_area(obj, surface, high)
    _refuse_contact(surface, low, high)
    return lambda carried: harmonic_directions(carried.solid, carried.vertices_on(low), carried.vertices_on(high))


def _refuse_contact(surface, low, high):
    triangles = surface.mesh.triangles
    shared = np.intersect1d(triangles[low.triangles], triangles[high.triangles])
    if len(shared):
        raise SettingError(
            f"{low.name} and {high.name} meet at {name_elements('vertex', shared)}: "
            "leave a part of the surface between them, across which the layers follow one another",
            shared,
        )


def _distance(obj, surface, name):
    if name in obj.vertex_groups or name == BOUNDARY:
        area = read_area(obj, surface, name)
        return lambda carried: distance_directions(carried.solid, carried.vertices_on(area))
    other = bpy.data.objects.get(name)
    if other is None or other == obj or other.type != "MESH":
        groups = ", ".join(g.name for g in obj.vertex_groups) or "none yet"
        raise SettingError(
            f"{name!r} is neither a vertex group of {obj.name} nor another mesh object: choose a group ({groups}), "
            f"a mesh, or {BOUNDARY}"
        )
    base = _seen_mesh(other, _into(obj, surface.given))
    return lambda carried: vector_directions(carried.solid, away_from(base, carried.solid.vertices))


def _curve(obj, surface, name, across=False):
    source = bpy.data.objects.get(name)
    if source is None or source == obj or source.type not in SOURCE_TYPES:
        raise SettingError(f"there is no curve object {name!r}: choose a curve or Grease Pencil object of the scene")
    into = _into(obj, surface.given) @ np.array(source.matrix_world)
    curves = [line @ into[:3, :3].T + into[:3, 3] for line in polylines(source)]
    if not curves:
        raise SettingError(f"the object {name!r} holds no curve: draw one, or choose another object")
    return lambda carried: curve_directions(carried.solid, curves, across=across)


def _around(obj, surface, name):
    return _curve(obj, surface, name, across=True)


def _attribute(obj, surface, name):
    vectors = attributes.read_vectors(obj, name, surface.given)
    return lambda carried: vector_directions(carried.solid, carried.on_boundary(vectors))


_READERS = {
    "axis": _axis,
    "harmonic": _harmonic,
    "distance": _distance,
    "curve": _curve,
    "around": _around,
    "attribute": _attribute,
}


def _into(obj, given):
    """(4, 4) from the world to the measured space of an object."""
    stretch = np.eye(4)
    stretch[:3, :3] = given.stretch
    return stretch @ np.linalg.inv(np.array(obj.matrix_world, float))


def _seen_mesh(other, into):
    """The TriangleMesh of another object as it is seen, modifiers included, in the measured space."""
    seen = other.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = seen.to_mesh()
    try:
        mesh.calc_loop_triangles()
        points = attributes.read_all(mesh.vertices, "co", 3, np.float32)
        triangles = attributes.read_all(mesh.loop_triangles, "vertices", 3)
    finally:
        seen.to_mesh_clear()
    if len(triangles) == 0:
        raise SettingError(f"the object {other.name} has no faces: choose a mesh whose surface layers can follow")
    matrix = into @ np.array(other.matrix_world)
    triangles = triangles if np.linalg.det(matrix[:3, :3]) > 0 else triangles[:, ::-1]
    base = TriangleMesh(points.astype(float) @ matrix[:3, :3].T + matrix[:3, 3], triangles)
    try:
        check_mesh(base)
    except MeshError as error:
        raise SettingError(f"the object {other.name} cannot guide layers: {error}") from None
    return base


def away_from(base, points):
    """(k, 3) unit directions in which the distance from a surface grows, counted negative behind its faces.

    Parameters
    ----------
    base : TriangleMesh, open or closed
    points : (k, 3)
    """
    _, found = NearestTriangles(base.vertices, base.triangles).nearest(points)
    corners = base.vertices[base.triangles[found]]
    shares = nearest_in_triangles(points, np.moveaxis(corners, 1, 0))
    offsets = points - np.einsum("pc,pcx->px", shares, corners)
    normals = normals_at(base, found, shares)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    lengths = np.linalg.norm(offsets, axis=1, keepdims=True)
    is_behind = np.einsum("px,px->p", offsets, normals) < 0
    is_on = lengths < ON_SURFACE * np.ptp(points, axis=0).max()
    signed = np.where(is_behind[:, None], -offsets, offsets)
    return np.where(is_on, normals, signed / np.where(is_on, 1, lengths))
