# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces with any number of corners, and the triangles that they are split into."""

from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Self

import numpy as np

from ..graphs import label_rows
from .triangle_mesh import TriangleMesh


@dataclass(frozen=True)
class Polygons:
    """Faces as ranges of corners, and the corners of their triangles.

    Attributes
    ----------
    corner_vertices : (c,) vertex of each corner; the corners of a face follow one another
    starts : (p,) first corner of each face
    sizes : (p,) corners of each face
    triangle_corners : (m, 3) corners of each triangle; the triangles of a face follow one another
    triangle_faces : (m,) face of each triangle
    alike : (c,) corner whose values each corner takes, mostly itself; faces without triangles may duplicate others
    """

    corner_vertices: np.ndarray
    starts: np.ndarray
    sizes: np.ndarray
    triangle_corners: np.ndarray
    triangle_faces: np.ndarray
    alike: np.ndarray | None = None

    @classmethod
    def of_triangles(cls, mesh: TriangleMesh) -> Self:
        """Make each triangle of a mesh a face."""
        count = mesh.triangle_count
        corners = np.arange(3 * count).reshape(-1, 3)
        return cls(mesh.triangles.ravel(), corners[:, 0].copy(), np.full(count, 3), corners, np.arange(count))

    def with_triangles(self, triangles: np.ndarray) -> Self:
        """Replace the vertices of the triangles, (m, 3)."""
        corner_vertices = self.corner_vertices.copy()
        corner_vertices[self.triangle_corners] = triangles
        return replace(self, corner_vertices=corner_vertices)

    @cached_property
    def triangles(self) -> np.ndarray:
        """(m, 3) vertices of the triangles."""
        return self.corner_vertices[self.triangle_corners]

    def __getstate__(self) -> dict[str, object]:
        """Without what is quickly made again: for another process."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @cached_property
    def first_triangles(self) -> np.ndarray:
        """(p,) first triangle of each face."""
        return np.searchsorted(self.triangle_faces, np.arange(len(self.starts)))

    @cached_property
    def corner_faces(self) -> np.ndarray:
        """(c,) face of each corner."""
        return np.repeat(np.arange(len(self.starts)), self.sizes)

    @cached_property
    def drawn(self) -> np.ndarray:
        """(p,) bool: faces that have triangles."""
        return np.bincount(self.triangle_faces, minlength=len(self.starts)) > 0

    @cached_property
    def rim_half_edges(self) -> np.ndarray:
        """(c,) half-edge of a triangle along the edge from each corner to the next one of its face, 3 t + k as in
        :class:`TriangleMesh`, or -1; repaired triangles may run the other way round."""
        following = np.arange(1, len(self.corner_vertices) + 1)
        following[self.starts + self.sizes - 1] = self.starts
        tails, heads = self.triangle_corners.ravel(), np.roll(self.triangle_corners, -1, axis=1).ravel()
        found = np.full(len(following), -1)
        for first, second in ((tails, heads), (heads, tails)):
            halves = np.flatnonzero(following[first] == second)
            found[first[halves]] = halves
        return found

    @cached_property
    def rim_steps(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """The faces with triangles, and the corners of their rims, that are reached by each step from their starts."""
        steps = []
        for step in range(1, self.sizes.max(initial=0)):
            going = np.flatnonzero(self.drawn & (self.sizes > step))
            steps.append((going, self.starts[going] + step))
        return steps

    def at_corners(self, values: np.ndarray) -> np.ndarray:
        """Take (c, ...) values at corners, those of duplicate faces from their originals."""
        return values if self.alike is None else values[self.alike]

    def at_faces(self, values: np.ndarray) -> np.ndarray:
        """Take (p, ...) values of faces, those of duplicates from their originals."""
        return values if self.alike is None else values[self.corner_faces[self.alike[self.starts]]]

    def after_split(self, now: "Polygons", old_corners: np.ndarray) -> "Polygons":
        """Describe the same surface after some faces were split: ``now`` are all faces, (c,) ``old_corners`` the former
        corner of each corner."""
        vertices = self.corner_vertices[old_corners]
        if self.alike is None:
            return replace(now, corner_vertices=vertices)
        now = replace(now, corner_vertices=vertices)
        shown = self.alike[old_corners]
        was_drawn = self.drawn[self.corner_faces[old_corners[now.starts]]]
        both = np.concatenate([self.triangle_corners, shown[now.triangle_corners]])
        labels = label_rows(np.sort(both, axis=1))
        old, new = np.split(labels, [len(self.triangle_corners)])
        # Where a face was split over a duplicate of a part of it, the duplicate has this part's triangle from now on.
        order = np.lexsort((np.where(was_drawn, 0, now.sizes)[now.triangle_faces], new))
        first = order[np.unique(new[order], return_index=True)[1]]
        rows = np.sort(first[np.isin(new[first], old)])
        runs = np.zeros(labels.max(initial=-1) + 1, bool)
        runs[old] = _descends(self.triangle_corners)
        turned = _descends(shown[now.triangle_corners[rows]]) != runs[new[rows]]
        corners = np.where(turned[:, None], now.triangle_corners[rows][:, ::-1], now.triangle_corners[rows])
        now = replace(now, triangle_corners=corners, triangle_faces=now.triangle_faces[rows])
        alike = match_corners(now, find_duplicates(now, now.drawn))
        # Duplicates of a face that was split take the values of its triangles, corner by corner.
        drawn = np.flatnonzero(now.drawn[now.corner_faces])
        known, where = np.unique(shown[drawn], return_index=True)
        left = np.flatnonzero((alike == np.arange(len(alike))) & ~now.drawn[now.corner_faces] & np.isin(shown, known))
        alike[left] = drawn[where[np.searchsorted(known, shown[left])]]
        return replace(now, alike=alike)


def _descends(corners: np.ndarray) -> np.ndarray:
    """Find triangles whose corners run against their numbers, (k,) bool."""
    return (np.roll(corners, -1, axis=1) < corners).sum(axis=1) > 1


def find_duplicates(polygons: Polygons, chosen: np.ndarray) -> np.ndarray:
    """Find for each face the first chosen face with the same vertices, (p,); the face itself without one."""
    first = np.arange(len(polygons.starts))
    for size in np.unique(polygons.sizes):
        faces = np.flatnonzero(polygons.sizes == size)
        corners = np.sort(polygons.corner_vertices[polygons.starts[faces, None] + np.arange(size)], axis=1)
        labels = label_rows(corners)
        leads = np.full(len(faces), len(first))
        np.minimum.at(leads, labels, np.where(chosen[faces], faces, len(first)))
        first[faces] = np.where(leads[labels] < len(first), leads[labels], faces)
    return first


def match_corners(polygons: Polygons, first: np.ndarray) -> np.ndarray:
    """Find for each corner of a face f the corner of the face ``first[f]`` at the same vertex, (c,).

    Both faces have the same vertices; ``first`` is as returned by :func:`find_duplicates`.
    """
    count = polygons.corner_vertices.max(initial=0) + 1
    own = polygons.corner_faces * count + polygons.corner_vertices
    asked = first[polygons.corner_faces] * count + polygons.corner_vertices
    order = np.argsort(own, kind="stable")
    return np.where(asked == own, np.arange(len(own)), order[np.searchsorted(own[order], asked)])
