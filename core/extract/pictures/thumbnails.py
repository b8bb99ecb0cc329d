# SPDX-License-Identifier: GPL-3.0-or-later
"""Small pictures of a surface and of the patterns on it.

The visible triangle at each point of a picture is determined once; patterns are evaluated only there.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ...geometry.polygons import Polygons
from ...graphs import ragged_arange
from ...interpolate import EdgePhases, evaluate, face_phases

# Points across a pixel, part of the picture that the surface fills, and depth at which dots are still drawn, as part of
# the picture.
_FINE, _FILLED, _BEHIND = 2, 0.96, 0.03
# Diameter of dots, as part of the picture; brightness of surfaces seen edge-on.
_DOT, _DARK = 0.045, 0.45


@dataclass(frozen=True)
class Seen:
    """The visible part of a surface.

    Attributes
    ----------
    size : of the square picture, in points
    points : (k,) int numbers of the points that show the surface, row by row from below
    triangles : (k,) int visible triangle
    weights : (k, 3) barycentric coordinates there
    light : (k,) from 0 to 1
    places : (n, 3) vertices: to the right and upwards in points, and towards the viewer
    corners : (m, 3) int vertices of the surface's triangles
    """

    size: int
    points: np.ndarray
    triangles: np.ndarray
    weights: np.ndarray
    light: np.ndarray
    places: np.ndarray
    corners: np.ndarray

    @classmethod
    def of(cls, vertices: np.ndarray, triangles: np.ndarray, pixels: int, view: np.ndarray) -> "Seen":
        """The visible part of (m, 3) triangles of (n, 3) vertices in a picture of a width in pixels.

        ``view`` is a (3, 3) map, from which the right, the upwards and the distance towards the viewer come.
        """
        size = _FINE * pixels
        places = vertices @ view.T
        low, high = (end(places[np.unique(triangles)], axis=0) for end in (np.min, np.max))
        extent = max((high - low)[:2].max(), np.finfo(float).tiny)
        places = (places - (low + high) / 2) * _FILLED * size / extent
        places[:, :2] += size / 2
        corners = places[triangles]
        which, points = _covered_points(corners[..., :2], size)
        weights = _weights(corners[which, :, :2], np.column_stack([points % size, points // size]) + 0.5)
        depths = np.einsum("ki,ki->k", weights, corners[which, :, 2])
        order = np.lexsort((depths, points))
        nearest = order[np.flatnonzero(np.diff(points[order], append=-1))]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        facing = np.abs(normals[:, 2]) / np.maximum(np.linalg.norm(normals, axis=1), np.finfo(float).tiny)
        which = which[nearest]
        light = _DARK + (1 - _DARK) * facing[which]
        return cls(size, points[nearest], which, weights[nearest], light, places, triangles)

    @cached_property
    def _depths(self) -> np.ndarray:
        """(size * size,) coordinate of the visible surface towards the viewer; -inf for the background."""
        depths = np.full(self.size * self.size, -np.inf)
        at = self.places[self.corners[self.triangles], 2]
        depths[self.points] = np.einsum("ki,ki->k", self.weights, at)
        return depths

    def ink(self, edge_phases: EdgePhases) -> np.ndarray:
        """(k,) amount of ink, 0 to 1, that the pattern's lines leave at the points."""
        shown, own = np.unique(self.triangles, return_inverse=True)
        count = len(shown)
        corners = np.arange(3 * count).reshape(-1, 3)
        starts = corners[:, 0].copy()
        faces = Polygons(self.corners[shown].ravel(), starts, np.full(count, 3), corners, np.arange(count))
        phases = [evaluate(phase, faces, own, self.weights) for phase in face_phases(edge_phases, faces)]
        if len(phases) == 1:
            return (np.cos(phases[0]) + 1) / 2
        return np.max([np.cos(phase) ** 8 for phase in phases], axis=0)

    def picture(
        self, ink: ArrayLike, paper: ArrayLike, inked: np.ndarray, dots: Iterable[tuple[ArrayLike, Sequence[float]]]
    ) -> np.ndarray:
        """(pixels, pixels, 4) float32 red, green, blue, alpha of the smoothed picture, rows from below.

        The points have (k,) shares ``inked`` of the ink's (3,) colour on that of the paper. Dots are pairs of (d,)
        triangles, whose middles get one where they are visible, and its (3,) colour.
        """
        image = np.zeros((self.size * self.size, 4), np.float32)
        color = np.asarray(paper) + inked[:, None] * (np.asarray(ink) - np.asarray(paper))
        image[self.points, :3], image[self.points, 3] = self.light[:, None] * color, 1
        for triangles, dot in dots:
            image[self._dot_points(triangles)] = *dot, 1
        fine = image.reshape(self.size // _FINE, _FINE, self.size // _FINE, _FINE, 4).astype(np.float64)
        covered = fine[..., 3:].sum(axis=(1, 3))
        color = fine[..., :3].sum(axis=(1, 3)) / np.maximum(covered, 1)
        return np.concatenate([color, covered / _FINE**2], axis=2).astype(np.float32)

    def _dot_points(self, triangles: ArrayLike) -> np.ndarray:
        """Numbers of the points in dots at the middles of triangles that are not hidden."""
        middles = self.places[self.corners[np.asarray(triangles, int)]].mean(axis=1)
        column, row = np.clip(middles[:, :2].astype(int), 0, self.size - 1).T
        middles = middles[middles[:, 2] >= self._depths[row * self.size + column] - _BEHIND * self.size]
        reach = int(np.ceil(_DOT * self.size / 2))
        steps = np.stack(np.meshgrid(*2 * [np.arange(-reach, reach + 1)]), axis=-1).reshape(-1, 2)
        steps = steps[np.linalg.norm(steps, axis=1) <= _DOT * self.size / 2]
        column, row = np.clip(middles[:, None, :2].astype(int) + steps, 0, self.size - 1).reshape(-1, 2).T
        return row * self.size + column


def _covered_points(corners: np.ndarray, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Rasterize triangles by scan lines: (k,) triangles and (k,) numbers of the points that they cover.

    ``corners`` are (m, 3, 2) in points, whose middles have half-integer coordinates; ``size`` is the picture's width.
    """
    low, high = corners[..., 1].min(axis=1), corners[..., 1].max(axis=1)
    first = np.clip(np.ceil(low - 0.5), 0, size).astype(int)
    last = np.clip(np.floor(high - 0.5), -1, size - 1).astype(int)
    which, row = ragged_arange(np.maximum(last - first + 1, 0))
    row += first[which]
    height = row + 0.5  # each (triangle, row) from here on: where the row enters and leaves the triangle
    begin, end = np.full(len(row), np.inf), np.full(len(row), -np.inf)
    for start, stop in ((0, 1), (1, 2), (2, 0)):
        (x, y), (to_x, to_y) = corners[which, start].T, corners[which, stop].T
        rise = np.where(to_y == y, 1, to_y - y)
        share = np.where(to_y == y, -1, (height - y) / rise)
        crossed = (share >= 0) & (share <= 1)
        at = x + share * (to_x - x)
        begin, end = np.where(crossed, np.minimum(begin, at), begin), np.where(crossed, np.maximum(end, at), end)
    first = np.clip(np.ceil(begin - 0.5), 0, size).astype(int)
    last = np.clip(np.floor(end - 0.5), -1, size - 1).astype(int)
    line, column = ragged_arange(np.maximum(last - first + 1, 0))
    return which[line], row[line] * size + column + first[line]


def _weights(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(k, 3) barycentric weights of (k, 2) points in (k, 3, 2) triangles; thirds in degenerate triangles."""
    across, along, offset = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], points - corners[:, 0]
    area = across[:, 0] * along[:, 1] - across[:, 1] * along[:, 0]
    parts = [offset[:, 0] * along[:, 1] - offset[:, 1] * along[:, 0]]
    parts.append(across[:, 0] * offset[:, 1] - across[:, 1] * offset[:, 0])
    second, third = (np.divide(part, area, out=np.full(len(area), 1 / 3), where=area != 0) for part in parts)
    return np.column_stack([1 - second - third, second, third])
