# SPDX-License-Identifier: GPL-3.0-or-later
"""Guides of layers, read from the scene: functions of the filled surface, called once the solid exists."""

from dataclasses import replace
from functools import partial

import bpy
import numpy as np

from ...core.errors import MeshError, SettingError, name_elements
from ...core.fields.guidance import filled
from ...core.files.obj_files import centre_of_far
from ...core.files.solid_vectors import read_vectors
from ...core.geometry import TriangleMesh
from ...core.geometry.check import check_mesh
from ...core.geometry.tet_mesh import TetMesh
from ...core.settings.guidance import AXES, BOUNDARY
from ...core.validation import check_path
from ..blender import attributes
from ..blender.strokes import SOURCE_TYPES, polylines
from .surface import LOOKS, read_area


def read_guide(obj, given, guide):
    """Read what a :class:`LayerGuide` needs of an object in object mode, whose MeshInput is given.

    Returns a function that can be pickled, :class:`FilledSurface` -> (n, 3) unit vectors at the solid's vertices.
    Raises SettingError for names that do not exist or do not fit.
    """
    return _READERS[guide.kind](obj, given, *guide.names)


def _axis(obj, given, name):
    return partial(filled.along_axis, given.stretch[:, AXES.index(name)])


def _harmonic(obj, given, low, high):
    low, high = read_area(obj, given, low), read_area(obj, given, high)
    triangles = given.mesh.triangles
    shared = np.intersect1d(triangles[low.triangles], triangles[high.triangles])
    if len(shared):
        raise SettingError(
            f"{low.name} and {high.name} meet at {name_elements('vertex', shared)}: "
            "leave a part of the surface between them, across which the layers follow one another",
            shared,
        )
    return partial(filled.between_areas, low, high)


def _distance(obj, given, name):
    if name in obj.vertex_groups or name in (BOUNDARY, *LOOKS):
        return partial(filled.away_from_area, read_area(obj, given, name))
    other = bpy.data.objects.get(name)
    if other is None or other == obj or other.type != "MESH":
        groups = ", ".join(g.name for g in obj.vertex_groups) or "none yet"
        raise SettingError(
            f"{name!r} is neither a vertex group of {obj.name} nor another mesh object: choose a group ({groups}), "
            f"a mesh, or {BOUNDARY}"
        )
    return partial(filled.away_from_surface, _seen_mesh(other, _into(obj, given)))


def _curves(obj, given, name):
    source = bpy.data.objects.get(name)
    if source is None or source == obj or source.type not in SOURCE_TYPES:
        raise SettingError(f"there is no curve object {name!r}: choose a curve or Grease Pencil object of the scene")
    into = _into(obj, given) @ np.array(source.matrix_world)
    curves = [line @ into[:3, :3].T + into[:3, 3] for line in polylines(source)]
    if not curves:
        raise SettingError(f"the object {name!r} holds no curve: draw one, or choose another object")
    return curves


def _curve(obj, given, name):
    return partial(filled.along_curves, _curves(obj, given, name))


def _around(obj, given, name):
    return partial(filled.around_curves, _curves(obj, given, name))


def _attribute(obj, given, name):
    return partial(filled.of_vectors, attributes.read_vectors(obj, name, given))


def _file(obj, given, path, name=""):
    return partial(filled.of_given_vectors, _vectors_of_file(obj, given, path, name), given.stretch)


def _lines(obj, given, path, name=""):
    return partial(filled.of_given_lines, _vectors_of_file(obj, given, path, name), given.stretch)


def _vectors_of_file(obj, given, path, name):
    """The :class:`SolidVectors` of a file in the object's space: files that are far from the origin are read about
    their centre, at which their object is then."""
    found = read_vectors(bpy.path.abspath(check_path(path)), name)
    if centre_of_far(found.mesh.vertices) is None or centre_of_far(given.mesh.vertices) is not None:
        return found
    vertices = found.mesh.vertices - np.array(obj.matrix_world, float)[:3, 3]
    return replace(found, mesh=TetMesh(vertices, found.mesh.tets))


_READERS = {
    "axis": _axis,
    "harmonic": _harmonic,
    "distance": _distance,
    "curve": _curve,
    "around": _around,
    "attribute": _attribute,
    "file": _file,
    "lines": _lines,
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
