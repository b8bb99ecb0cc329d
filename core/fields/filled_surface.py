# SPDX-License-Identifier: GPL-3.0-or-later
"""From the vertices of a surface to the solid that fills it: groups by their faces, values by interpolation."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from ..errors import SettingError
from ..geometry.filling.closed_surface import Area, ClosedSurface
from ..geometry.nearest import NearestTriangles, nearest_in_triangles
from ..geometry.tet_mesh import TetMesh
from .guidance.potentials import extend_harmonically
from .layers import LayerGroup

# Vertices of the solid this near to a group's faces lie on them, as a share of the surface's size; filling places them
# within a tenth of it.
ON_FACES = 1e-6
# The same as a share of the largest coordinate: Blender rounds the surface of a given solid.
ROUNDED = 4 * float(np.finfo(np.float32).eps)


@dataclass(frozen=True)
class FilledSurface:
    """A closed surface and the solid in it."""

    surface: ClosedSurface
    solid: TetMesh

    def faces_on(self, area: Area) -> np.ndarray:
        """(f, 3) triangles of the solid's boundary that lie on an area, without those that cut across its rim.

        Raises :class:`SettingError` where there is none.
        """
        triangles = self.solid.boundary_triangles
        triangles = triangles[self._lies_on(area)[triangles].all(axis=1)]
        # Between vertices of the area there may be other faces.
        under = self.surface.distance.nearest(self.solid.vertices[triangles].mean(axis=1))
        triangles = triangles[np.isin(under, area.triangles)]
        if len(triangles) == 0:
            raise SettingError(
                f"{area.name} is smaller than the solid's triangles: reduce the size, or mark a larger area"
            )
        return triangles

    def covered_share(self, area: Area, triangles: np.ndarray) -> float:
        """Share of an area that (f, 3) triangles of the solid cover."""
        a, b, c = np.moveaxis(self.solid.vertices[triangles], 1, 0)
        covered = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
        return float(covered / self.surface.mesh.areas[area.triangles].sum())

    def group_on(self, area: Area, phase: float | None) -> LayerGroup:
        """The group of the triangles and other vertices on an area; its phase, radians, is None where it is free."""
        triangles = self.faces_on(area)
        return LayerGroup(np.union1d(np.flatnonzero(self._lies_on(area)), triangles), triangles, phase, area.name)

    def vertices_on(self, area: Area) -> np.ndarray:
        """(n,) bool, the solid's vertices on an area, or those nearest to its triangles where there are none."""
        chosen = self._lies_on(area)
        if not chosen.any():
            boundary = np.flatnonzero(self.solid.boundary_vertices)
            centres = self.surface.mesh.vertices[self.surface.mesh.triangles[area.triangles]].mean(axis=1)
            chosen[boundary[cKDTree(self.solid.vertices[boundary]).query(centres)[1]]] = True
        return chosen

    def _lies_on(self, area: Area) -> np.ndarray:
        """(n,) bool, vertices of the solid's boundary that lie on an area."""
        mesh, boundary = self.surface.mesh, np.flatnonzero(self.solid.boundary_vertices)
        marked, points = mesh.triangles[area.triangles], self.solid.vertices[boundary]
        places, _ = NearestTriangles(mesh.vertices, marked).nearest(points)
        apart = np.linalg.norm(points - places, axis=1)
        result = np.zeros(self.solid.vertex_count, bool)
        allowed = max(ON_FACES * self.surface.reach, ROUNDED * np.abs(mesh.vertices).max())
        result[boundary[apart <= allowed]] = True
        return result

    def on_boundary(self, values: np.ndarray) -> np.ndarray:
        """(n, ...) values at the solid's boundary vertices from those at the surface's vertices; 0 inside."""
        triangles, weights = self._places
        corners = values[self.surface.mesh.triangles[triangles]]
        result = np.zeros((self.solid.vertex_count, *values.shape[1:]))
        result[self.solid.boundary_vertices] = np.einsum("pk,pk...->p...", weights, corners)
        return result

    def inside(self, values: np.ndarray) -> np.ndarray:
        """(n,) values in the whole solid, extended smoothly from the surface's and clipped to their extremes."""
        known = self.solid.boundary_vertices
        spread = extend_harmonically(self.solid, known, self.on_boundary(values)[known])
        return np.clip(np.nan_to_num(spread, nan=values.mean()), values.min(), values.max())

    @cached_property
    def _places(self) -> tuple[np.ndarray, np.ndarray]:
        """(b,) triangles of the surface nearest to the boundary's vertices, and (b, 3) weights of their corners."""
        mesh, points = self.surface.mesh, self.solid.vertices[self.solid.boundary_vertices]
        triangles = self.surface.distance.nearest(points)
        return triangles, nearest_in_triangles(points, np.moveaxis(mesh.vertices[mesh.triangles[triangles]], 1, 0))
