# SPDX-License-Identifier: GPL-3.0-or-later
"""Boundaries and sharp edges as polygonal lines between corners, on which points slide."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from ....fields.constraints.features import line_corners
from ....geometry import TriangleMesh
from ....geometry.polylines import ways_along


@dataclass(frozen=True)
class FeatureLines:
    """Lines of mesh edges between corners.

    Attributes
    ----------
    edges : (k,) indices
    corners : (c,) vertices at which lines end, branch or bend
    lines : (k,) consecutive vertices of each line; a closed line ends with its first vertex
    """

    mesh: TriangleMesh
    edges: np.ndarray
    corners: np.ndarray
    lines: tuple[np.ndarray, ...]

    @classmethod
    def of(cls, mesh: TriangleMesh, edges: np.ndarray) -> "FeatureLines":
        corners = line_corners(mesh, edges)
        return cls(mesh, edges, corners, tuple(_walk_lines(mesh, edges, corners)))

    @cached_property
    def lengths(self) -> tuple[np.ndarray, ...]:
        """For each line, (k,) the distances of its vertices from its start, along the line."""
        return tuple(ways_along(self.mesh.vertices[line]) for line in self.lines)

    @cached_property
    def on_boundary(self) -> np.ndarray:
        """(l,) bool: lines on the boundary."""
        counts = self.mesh.edge_face_counts
        return np.array([counts[self.mesh.edges_between(line[:1], line[1:2])[0]] == 1 for line in self.lines], bool)

    def nearest(self, number: int, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(p,) positions along a line that are nearest to (p, 3) points, and (p,) distances from it."""
        places = self.mesh.vertices[self.lines[number]]
        begin, along = places[:-1], np.diff(places, axis=0)
        offsets = points[:, None] - begin
        squares = np.maximum(np.einsum("sx,sx->s", along, along), np.finfo(float).tiny)
        shares = np.clip(np.einsum("psx,sx->ps", offsets, along) / squares, 0, 1)
        apart = np.linalg.norm(offsets - shares[:, :, None] * along, axis=2)
        best = apart.argmin(axis=1)
        rows = np.arange(len(points))
        lengths = self.lengths[number]
        return lengths[best] + shares[rows, best] * np.diff(lengths)[best], apart[rows, best]

    def at(self, number: int, ways: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(p, 3) points at (p,) positions along a line, their triangles and (p, 3) barycentric weights."""
        line, lengths = self.lines[number], self.lengths[number]
        step = np.clip(np.searchsorted(lengths, ways, side="right") - 1, 0, len(line) - 2)
        shares = (ways - lengths[step]) / np.maximum(np.diff(lengths)[step], np.finfo(float).tiny)
        tails, heads = line[step], line[step + 1]
        half = self._halves[self.mesh.edges_between(tails, heads)]
        triangles = half // 3
        weights = np.zeros((len(ways), 3))
        rows, corner = np.arange(len(ways)), half % 3
        forward = self.mesh.triangles[triangles, corner] == tails
        weights[rows, corner] = np.where(forward, 1 - shares, shares)
        weights[rows, (corner + 1) % 3] = np.where(forward, shares, 1 - shares)
        places = self.mesh.vertices[tails] + shares[:, None] * (self.mesh.vertices[heads] - self.mesh.vertices[tails])
        return places, triangles, weights

    @cached_property
    def _halves(self) -> np.ndarray:
        """(e,) a half-edge of each edge."""
        halves = np.zeros(len(self.mesh.edges), int)
        halves[self.mesh.triangle_edges.ravel()] = np.arange(3 * self.mesh.triangle_count)
        return halves


def _walk_lines(mesh: TriangleMesh, edges: np.ndarray, corners: np.ndarray) -> Iterator[np.ndarray]:
    """Vertices of each line, closed lines without corners last."""
    beside: dict[int, list[int]] = {}
    for i, j in mesh.edges[edges].tolist():
        beside.setdefault(i, []).append(j)
        beside.setdefault(j, []).append(i)
    stops = set(corners.tolist())
    passed: set[tuple[int, int]] = set()
    for first in [*sorted(stops), *sorted(set(beside) - stops)]:
        for second in sorted(beside[first]):
            if (first, second) in passed:
                continue
            line = [first, second]
            while line[-1] not in stops and line[-1] != first:
                line.append(next(v for v in beside[line[-1]] if v != line[-2]))
            passed.update(pairwise(line))
            passed.update(pairwise(line[::-1]))
            yield np.array(line)
