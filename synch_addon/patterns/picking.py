# SPDX-License-Identifier: GPL-3.0-or-later
"""Vertices, edges and places of the mesh that carries an object's pattern, picked with the mouse where modifiers show
them."""

from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree
from mathutils.interpolate import poly_3d_calc

from ...core.geometry.polygons import Polygons
from ..blender import meshes
from ..blender.bvh import surface_tree
from ..blender.modifiers import changes_faces, hidden
from ..blender.pattern_surface import surface_modifier, surface_of


@dataclass(frozen=True)
class PickedSurface:
    """The faces of the mesh that carries an object's pattern.

    Attributes
    ----------
    places : (n, 3) of its vertices in object space, as modifiers bend it
    own : (n, 3) of them on the mesh itself
    tree : over the faces as they are bent
    """

    places: np.ndarray
    own: np.ndarray
    polygons: Polygons
    tree: BVHTree

    @classmethod
    def of(cls, obj):
        """The surface of an object in object mode, bent by its modifiers up to those that change its faces."""
        surface, bound = surface_of(obj), surface_modifier(obj)
        polygons, own = meshes.read_polygons(surface), meshes.measured_places(surface)
        later = list(obj.modifiers)[0 if bound is None else obj.modifiers.find(bound.name) + 1 :]
        with hidden([modifier for modifier in later if changes_faces(modifier)]):
            depsgraph = bpy.context.evaluated_depsgraph_get()
            seen = obj.evaluated_get(depsgraph)
            if len(seen.data.vertices) == len(own) and len(seen.data.polygons) == len(polygons.starts):
                return cls(meshes.measured_places(seen), own, polygons, BVHTree.FromObject(obj, depsgraph))
        return cls(own, own, polygons, surface_tree(own, np.split(polygons.corner_vertices, polygons.starts[1:])))

    def vertex_at(self, origin, towards):
        """The vertex nearest to where a ray in object space first meets the surface, or None."""
        face, corners = self._hit(origin, towards)
        return None if face is None else int(self._corners(face)[np.linalg.norm(corners, axis=1).argmin()])

    def face_at(self, origin, towards):
        """The face that a ray in object space first meets, or None."""
        return self.tree.ray_cast(origin, towards)[2]

    def place_at(self, origin, towards):
        """Where a ray in object space first meets the surface: (3,) there and (3,) on the mesh itself, or None."""
        place, _, face, _ = self.tree.ray_cast(origin, towards)
        if place is None:
            return None
        corners = self._corners(face)
        weights = poly_3d_calc([Vector(corner) for corner in self.places[corners]], place)
        return np.array(place), np.array(weights) @ self.own[corners]

    def side_at(self, origin, towards):
        """The face that a ray in object space first meets and the number of its side nearest to there, or None; the
        first side leads from the first corner to the second."""
        face, corners = self._hit(origin, towards)
        if face is None:
            return None
        sides = np.roll(corners, -1, axis=0) - corners
        squares = np.maximum(np.einsum("ij,ij->i", sides, sides), np.finfo(float).tiny)
        along = np.clip(-np.einsum("ij,ij->i", corners, sides) / squares, 0, 1)
        return face, int(np.linalg.norm(corners + along[:, None] * sides, axis=1).argmin())

    def nearest(self, points):
        """(k, 3) places on the mesh itself that are nearest to (k, 3) points in object space."""
        tree = surface_tree(self.own, self.polygons.triangles)
        return np.array([tree.find_nearest(point)[0] for point in points])

    def _hit(self, origin, towards):
        """The first face that a ray meets, and its corners relative to the place; (None, None) if it meets none."""
        place, _, face, _ = self.tree.ray_cast(origin, towards)
        return (None, None) if place is None else (face, self.places[self._corners(face)] - np.array(place))

    def _corners(self, face):
        """(k,) vertices of a face."""
        start = self.polygons.starts[face]
        return self.polygons.corner_vertices[start : start + self.polygons.sizes[face]]
