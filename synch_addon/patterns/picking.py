# SPDX-License-Identifier: GPL-3.0-or-later
"""Vertices and edges picked with the mouse: those of an object's own mesh, where its modifiers show them."""

from dataclasses import dataclass

import bpy
import numpy as np
from mathutils.bvhtree import BVHTree

from ..blender import attributes, meshes
from ..blender.bvh import surface_tree
from ..blender.modifiers import changes_faces, hidden


@dataclass(frozen=True)
class PickedSurface:
    """The faces of an object's own mesh, with (n, 3) places of its vertices in object space."""

    places: np.ndarray
    faces: list
    tree: BVHTree

    @classmethod
    def of(cls, obj):
        """The surface of an object in object mode, bent by its modifiers up to those that change faces."""
        polygons = meshes.read_polygons(obj)
        faces = np.split(polygons.corner_vertices, polygons.starts[1:])
        with hidden([modifier for modifier in obj.modifiers if changes_faces(modifier)]):
            seen = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
            shown = seen if len(seen.data.vertices) == len(obj.data.vertices) else obj
            places = attributes.read_values(shown, "position", "POINT").astype(float)
        return cls(places, faces, surface_tree(places, faces))

    def vertex_at(self, origin, towards):
        """The vertex nearest to where a ray in object space first meets the surface, or None."""
        face, corners = self._hit(origin, towards)
        return None if face is None else int(self.faces[face][np.linalg.norm(corners, axis=1).argmin()])

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

    def _hit(self, origin, towards):
        """The face that a ray first meets, and its corners as seen from that place; None twice where there is none."""
        place, _, face, _ = self.tree.ray_cast(origin, towards)
        return (None, None) if place is None else (face, self.places[self.faces[face]] - np.array(place))
