# SPDX-License-Identifier: GPL-3.0-or-later
"""Vertices picked with the mouse: those of an object's own mesh, where its modifiers show them."""

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
        place, _, face, _ = self.tree.ray_cast(origin, towards)
        if place is None:
            return None
        corners = self.faces[face]
        return int(corners[np.linalg.norm(self.places[corners] - np.array(place), axis=1).argmin()])
