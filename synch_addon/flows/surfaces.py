# SPDX-License-Identifier: GPL-3.0-or-later
"""Flows on surfaces: a vector attribute of a mesh object, or arrays of a plane, which become a mesh of squares."""

from pathlib import Path

import bpy
import numpy as np

from ...core.errors import SettingError
from ...core.fields.clebsch import edge_integrals
from ...core.geometry import TriangleMesh, mesh_input
from ...core.geometry.check import check_mesh
from ...core.geometry.polygons import Polygons
from ...core.geometry.surface import Surface
from ..blender import attributes, meshes
from .sources import VELOCITY, ArrayFile, objects_of


def surface_flow(source, attribute):
    """The :class:`SurfaceFlow` of a mesh object with faces or of a .npz file with a plane; None for other sources.

    Parameters
    ----------
    source : path, object, or list of objects
    attribute : vector attribute on the vertices of a mesh
    """
    if isinstance(source, str | Path):
        path = Path(source)
        if path.suffix.lower() != ".npz" or not path.is_file():
            return None
        arrays = ArrayFile(path)
        return PlaneFlow(arrays.grid(None), arrays.velocity, path.stem) if arrays.is_plane else None
    objects = objects_of(source)
    surfaces = [obj for obj in objects if obj.type == "MESH" and len(obj.data.polygons)]
    if surfaces and len(objects) > 1:
        raise SettingError(f"{surfaces[0].name} is a surface with a flow of its own: choose it alone")
    return SurfaceFlow(surfaces[0], attribute) if surfaces else None


class SurfaceFlow:
    """The flow that a vector attribute gives on the surface of a mesh object.

    Attributes
    ----------
    name : of the object
    given : MeshInput
    warnings : lines that the user should read
    """

    warnings: tuple[str, ...] = ()

    def __init__(self, obj, attribute):
        reason = meshes.refusal(obj)
        if reason:
            raise SettingError(reason)
        self.name = obj.name
        self.given = meshes.read_mesh(obj)
        self._velocity = attributes.read_vectors(obj, attribute, self.given)

    @property
    def surface(self):
        """The :class:`Surface` of the mesh."""
        return Surface(self.given.mesh)

    def integrals(self, surface):
        """(e,) of the velocity along the surface's edges."""
        return edge_integrals(surface, self._velocity)

    def target(self):
        """The object that results are written to.

        Raises
        ------
        SettingError
            when it is gone or has changed since it was read
        """
        return self.of_object(bpy.data.objects.get(self.name))

    def of_object(self, obj):
        """An object that the mesh is of; errors as :meth:`target`."""
        if obj is None or not meshes.is_unchanged(obj, self.given):
            raise SettingError(f"the mesh {self.name} has changed since its flow was read: run it again")
        return obj


class PlaneFlow(SurfaceFlow):
    """A flow on a grid of two dimensions, as one on a mesh of squares whose object is made when it is written to."""

    def __init__(self, grid, velocity, name):
        self.name = name
        if any(grid.periodic):
            self.warnings = ("a plane is shown open: what leaves it on one side does not come in on the other",)
        self.given = _squares(grid)
        self._velocity = np.pad(velocity, ((0, 0), (0, 1)))

    def target(self):
        """A new object with the squares and the velocity, in no scene yet."""
        data = bpy.data.meshes.new(self.name)
        faces = self.given.polygons.corner_vertices.reshape(-1, 4)
        data.from_pydata(self.given.mesh.vertices.tolist(), [], faces.tolist())
        obj = bpy.data.objects.new(self.name, data)
        attributes.write_attribute(obj, VELOCITY, "POINT", "FLOAT_VECTOR", self._velocity)
        return obj


def _squares(grid):
    """The :class:`MeshInput` of a grid's squares, split as Blender splits them."""
    cuts = np.s_[:-1, :-1], np.s_[1:, :-1], np.s_[1:, 1:], np.s_[:-1, 1:]
    corners = np.column_stack([grid.numbers[cut].ravel() for cut in cuts])
    starts = 4 * np.arange(len(corners))
    triangle_corners = (starts[:, None, None] + [[0, 1, 2], [0, 2, 3]]).reshape(-1, 3)
    polygons = Polygons(
        corners.ravel(), starts, np.full(len(corners), 4), triangle_corners, np.repeat(np.arange(len(corners)), 2)
    )
    # Rounded as the object's vertices are, which tell later whether it has changed.
    places = grid.places.astype(np.float32).astype(float)
    mesh = TriangleMesh(np.pad(places, ((0, 0), (0, 1))), polygons.triangles)
    check_mesh(mesh, polygons.triangle_faces)
    return mesh_input.MeshInput(mesh, polygons, np.eye(3), mesh, np.arange(mesh.vertex_count))
