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
from ....graphs import ragged_arange

# Pairs of points and steps of lines whose distances are computed at once, about.
PAIRS = 1_000_000


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
    def lengths(self) -> np.ndarray:
        """(l,) length of each line."""
        return np.array([ways[-1] for ways in self._ways], float)

    @cached_property
    def closed(self) -> np.ndarray:
        """(l,) bool: closed lines without a corner."""
        ends = np.reshape([line[[0, -1]] for line in self.lines], (-1, 2))
        return (ends[:, 0] == ends[:, 1]) & ~np.isin(ends[:, 0], self.corners)

    @cached_property
    def on_boundary(self) -> np.ndarray:
        """(l,) bool: lines on the boundary."""
        counts = self.mesh.edge_face_counts
        return np.array([counts[self.mesh.edges_between(line[:1], line[1:2])[0]] == 1 for line in self.lines], bool)

    @cached_property
    def _ways(self) -> tuple[np.ndarray, ...]:
        """For each line, (k,) the distances of its vertices from its start, along the line."""
        return tuple(ways_along(self.mesh.vertices[line]) for line in self.lines)

    @cached_property
    def _starts(self) -> np.ndarray:
        """(l + 1,) the first of the steps of each line, in the order of the lines, and the number of all."""
        return np.cumsum([0, *(len(line) - 1 for line in self.lines)])

    @cached_property
    def _steps(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """(s, 2) vertices of the steps of all lines, (s, 3) vectors along them, and (s,) their starts and lengths."""
        ends = np.concatenate([np.column_stack([line[:-1], line[1:]]) for line in self.lines])
        begins = np.concatenate([ways[:-1] for ways in self._ways])
        lengths = np.concatenate([np.diff(ways) for ways in self._ways])
        return ends, np.diff(self.mesh.vertices[ends], axis=1)[:, 0], begins, lengths

    def nearest(self, numbers: int | np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(p,) positions along a line, or (p,) lines, that are nearest to (p, 3) points, and (p,) distances from it."""
        numbers = np.broadcast_to(numbers, len(points))
        pairs = np.cumsum(np.diff(self._starts)[numbers])
        if len(pairs) == 0 or pairs[-1] <= PAIRS:
            return self._nearest(numbers, points)
        parts = np.split(np.arange(len(points)), np.flatnonzero(np.diff(pairs // PAIRS)) + 1)
        ways, apart = zip(*(self._nearest(numbers[part], points[part]) for part in parts), strict=True)
        return np.concatenate(ways), np.concatenate(apart)

    def _nearest(self, numbers: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """:meth:`nearest` for (p,) lines, by projecting the points to all segments of their lines."""
        ends, along, begins, lengths = self._steps
        firsts, counts = self._starts[numbers], np.diff(self._starts)[numbers]
        rows, places = ragged_arange(counts)
        steps = firsts[rows] + places
        offsets, along = points[rows] - self.mesh.vertices[ends[steps, 0]], along[steps]
        squares = np.maximum(np.einsum("sx,sx->s", along, along), np.finfo(float).tiny)
        shares = np.clip(np.einsum("sx,sx->s", offsets, along) / squares, 0, 1)
        apart = np.linalg.norm(offsets - shares[:, None] * along, axis=1)
        least = np.minimum.reduceat(apart, np.cumsum(counts) - counts) if len(rows) else apart
        best = np.flatnonzero(apart == least[rows])
        best = best[np.append(True, rows[best[1:]] != rows[best[:-1]])[: len(best)]]
        return begins[steps[best]] + shares[best] * lengths[steps[best]], least

    def at(self, numbers: int | np.ndarray, ways: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(p, 3) points at (p,) positions along a line, or (p,) lines, their triangles and (p, 3) weights in these."""
        numbers = np.broadcast_to(numbers, len(ways))
        ends, along, begins, lengths = self._steps
        # One after the other, with gaps between them, all lines have ascending positions.
        offsets = 2 * (np.cumsum(self.lengths) - self.lengths)
        of_steps = np.repeat(np.arange(len(self.lines)), np.diff(self._starts))
        step = np.searchsorted(offsets[of_steps] + begins, offsets[numbers] + ways, side="right") - 1
        step = np.clip(step, self._starts[numbers], self._starts[numbers + 1] - 1)
        shares = np.clip((ways - begins[step]) / np.maximum(lengths[step], np.finfo(float).tiny), 0, 1)
        tails, heads = ends[step].T
        half = self._halves[self.mesh.edges_between(tails, heads)]
        triangles = half // 3
        weights = np.zeros((len(ways), 3))
        rows, corner = np.arange(len(ways)), half % 3
        forward = self.mesh.triangles[triangles, corner] == tails
        weights[rows, corner] = np.where(forward, 1 - shares, shares)
        weights[rows, (corner + 1) % 3] = np.where(forward, shares, 1 - shares)
        return self.mesh.vertices[tails] + shares[:, None] * along[step], triangles, weights

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
