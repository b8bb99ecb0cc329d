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
    alike : (c,) where faces without triangles look like others: the corner that each corner looks like, mostly itself
    """

    corner_vertices: np.ndarray
    starts: np.ndarray
    sizes: np.ndarray
    triangle_corners: np.ndarray
    triangle_faces: np.ndarray
    alike: np.ndarray | None = None

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

    @cached_property
    def corner_faces(self):
        """(c,) face of each corner."""
        return np.repeat(np.arange(len(self.starts)), self.sizes)

    @cached_property
    def drawn(self):
        """(p,) bool: faces that have triangles."""
        return np.bincount(self.triangle_faces, minlength=len(self.starts)) > 0

    def at_corners(self, values):
        """(c, ...) values at corners, with those of faces that look like others taken from there."""
        return values if self.alike is None else values[self.alike]

    def at_faces(self, values):
        """(p, ...) values of faces, with those of faces that look like others taken from there."""
        return values if self.alike is None else values[self.corner_faces[self.alike[self.starts]]]

    def after_split(self, now, old_corners):
        """The same surface after some of its faces were split.

        Parameters
        ----------
        now : Polygons, all faces as they are
        old_corners : (c,) corner that each corner was
        """
        vertices = self.corner_vertices[old_corners]
        if self.alike is None:
            return replace(now, corner_vertices=vertices)
        now = replace(now, corner_vertices=vertices)
        shown = self.alike[old_corners]
        was_drawn = self.drawn[self.corner_faces[old_corners[now.starts]]]
        both = np.concatenate([self.triangle_corners, shown[now.triangle_corners]])
        labels = np.unique(np.sort(both, axis=1), axis=0, return_inverse=True)[1].reshape(-1)
        old, new = np.split(labels, [len(self.triangle_corners)])
        # Where a face was split over one that doubled a part of it, that one draws this part from now on.
        order = np.lexsort((np.where(was_drawn, 0, now.sizes)[now.triangle_faces], new))
        first = order[np.unique(new[order], return_index=True)[1]]
        rows = np.sort(first[np.isin(new[first], old)])
        runs = np.zeros(labels.max(initial=-1) + 1, bool)
        runs[old] = _descends(self.triangle_corners)
        turned = _descends(shown[now.triangle_corners[rows]]) != runs[new[rows]]
        corners = np.where(turned[:, None], now.triangle_corners[rows][:, ::-1], now.triangle_corners[rows])
        now = replace(now, triangle_corners=corners, triangle_faces=now.triangle_faces[rows])
        alike = alike_corners(now, first_alike(now, now.drawn))
        # What looked like a face that was split looks like its triangles, corner by corner.
        drawn = np.flatnonzero(now.drawn[now.corner_faces])
        known, where = np.unique(shown[drawn], return_index=True)
        left = np.flatnonzero((alike == np.arange(len(alike))) & ~now.drawn[now.corner_faces] & np.isin(shown, known))
        alike[left] = drawn[where[np.searchsorted(known, shown[left])]]
        return replace(now, alike=alike)


def _descends(corners):
    """(k,) bool: triangles whose corners run against their numbers."""
    return (np.roll(corners, -1, axis=1) < corners).sum(axis=1) > 1


def first_alike(polygons, chosen):
    """(p,) the first of the chosen faces with the vertices of each face and no other; itself where there is none."""
    first = np.arange(len(polygons.starts))
    for size in np.unique(polygons.sizes):
        faces = np.flatnonzero(polygons.sizes == size)
        corners = np.sort(polygons.corner_vertices[polygons.starts[faces, None] + np.arange(size)], axis=1)
        labels = np.unique(corners, axis=0, return_inverse=True)[1].reshape(-1)
        leads = np.full(len(faces), len(first))
        np.minimum.at(leads, labels, np.where(chosen[faces], faces, len(first)))
        first[faces] = np.where(leads[labels] < len(first), leads[labels], faces)
    return first


def alike_corners(polygons, first):
    """(c,) the corner of another face, ``first``, that is at the same vertex as each corner of a face."""
    count = polygons.corner_vertices.max(initial=0) + 1
    own = polygons.corner_faces * count + polygons.corner_vertices
    asked = first[polygons.corner_faces] * count + polygons.corner_vertices
    order = np.argsort(own, kind="stable")
    return np.where(asked == own, np.arange(len(own)), order[np.searchsorted(own[order], asked)])
