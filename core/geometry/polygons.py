# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces with any number of corners over the triangles that they are split into."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np


@dataclass(frozen=True)
class Polygons:
    """Faces as runs of corners, and the corners of the triangles that draw them.

    Attributes
    ----------
    corner_vertices : (c,) vertex of each corner; the corners of a face follow one another
    starts : (p,) first corner of each face
    sizes : (p,) corners of each face
    triangle_corners : (m, 3) corners of each triangle; the triangles of a face follow one another
    triangle_faces : (m,) face of each triangle
    """

    corner_vertices: np.ndarray
    starts: np.ndarray
    sizes: np.ndarray
    triangle_corners: np.ndarray
    triangle_faces: np.ndarray

    @classmethod
    def of_triangles(cls, mesh):
        """Each triangle of a mesh as a face of its own."""
        count = mesh.triangle_count
        corners = np.arange(3 * count).reshape(-1, 3)
        return cls(mesh.triangles.ravel(), corners[:, 0].copy(), np.full(count, 3), corners, np.arange(count))

    def with_triangles(self, triangles):
        """The same faces over (m, 3) other vertices."""
        corner_vertices = self.corner_vertices.copy()
        corner_vertices[self.triangle_corners] = triangles
        return replace(self, corner_vertices=corner_vertices)

    @property
    def triangles(self):
        """(m, 3) vertices of the triangles."""
        return self.corner_vertices[self.triangle_corners]

    @cached_property
    def first_triangles(self):
        """(p,) first triangle of each face."""
        return np.searchsorted(self.triangle_faces, np.arange(len(self.starts)))
