# SPDX-License-Identifier: GPL-3.0-or-later
"""Streamlines of a direction field, traced from triangle to triangle, all lines at once.

Inside a triangle the symmetry-th power of the field is interpolated linearly between its corners, which does not depend
on the representatives; the line follows the root that turns it least. Each triangle is crossed straight, in the
direction at the middle of the crossing (midpoint rule); the direction is carried across an edge by unfolding the two
triangles. Points and directions are complex numbers in the frame of their triangle, whose real axis is its first edge.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...geometry import TriangleMesh
from ...unit_vectors import unit_vectors

# A line that would leave by the edge where it entered runs along that edge instead, at this slope.
SLOPE = 1e-3
# A line ends after this many triangles per mean edge length: it circles around a vertex.
STEPS_PER_EDGE = 12
# Lines end at a triangle whose area is less than this share of its longest edge squared.
FLAT = 1e-10
# Line, step, triangle and weights as in Streamlines.
_Step = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Streamlines:
    """Straight pieces of lines, one in each triangle that a line crosses, in their order along the lines.

    Attributes
    ----------
    line : (s,) number of the line that a piece belongs to, ascending
    step : (s,) pieces between it and the seed: 0, 1, 2 ... ahead of the seed, -1, -2 ... behind it
    triangle : (s,) triangle that it crosses
    weights : (s, 2, 3) barycentric coordinates of its two ends there
    """

    line: np.ndarray
    step: np.ndarray
    triangle: np.ndarray
    weights: np.ndarray

    def segments(self, mesh: TriangleMesh) -> np.ndarray:
        """(s, 2, 3) ends of the pieces in space."""
        return np.einsum("sek,skx->sex", self.weights, mesh.vertices[mesh.triangles[self.triangle]])

    def __getitem__(self, pieces: np.ndarray) -> "Streamlines":
        """Some of the pieces, by index or mask."""
        return Streamlines(self.line[pieces], self.step[pieces], self.triangle[pieces], self.weights[pieces])


def trace(
    mesh: TriangleMesh, vectors: np.ndarray, symmetry: int, triangles: np.ndarray, weights: np.ndarray, length: float
) -> Streamlines:
    """Follow the field from seeds both ways, half of ``length`` each or until a boundary.

    A cross field has two lines through each seed: numbers k to 2 k - 1 are the second ones.

    Parameters
    ----------
    mesh : checked
    vectors : (n, 3) one tangent representative at each vertex, of any length
    symmetry : 1, 2 or 4
    triangles, weights : (k,) triangles of the seeds and (k, 3) barycentric coordinates there
    length : in scene units
    """
    charts = _Charts(mesh, vectors, symmetry)
    points = (weights * charts.corners[triangles]).sum(axis=1)
    first = charts.directions(triangles, points, np.ones(len(points), complex), 1)
    most_steps = int(STEPS_PER_EDGE * (length / mesh.edge_lengths.mean() + 1))
    pieces: list[_Step] = []
    for branch in range(2 if symmetry == 4 else 1):
        line = np.arange(len(points)) + branch * len(points)
        for sense in (1, -1):
            heading = sense * 1j**branch * first
            half = _follow(charts, line, triangles, points, heading, sense, length / 2, most_steps)
            pieces += half if sense > 0 else map(_reverse_lines, half)
    traced = Streamlines(*(np.concatenate(parts) for parts in zip(*pieces, strict=True)))
    return traced[np.lexsort((traced.step, traced.line))]


def _reverse_lines(piece: _Step) -> _Step:
    line, step, triangle, weights = piece
    return line, -1 - step, triangle, weights[:, ::-1]


def _follow(
    charts: "_Charts",
    line: np.ndarray,
    triangle: np.ndarray,
    point: np.ndarray,
    direction: np.ndarray,
    sense: int,
    length: float,
    most_steps: int,
) -> Iterator[_Step]:
    """Yield one step at a time of all lines that have not ended."""
    left = np.full(len(line), float(length))
    entry = np.full(len(line), -1)
    for step in range(most_steps):
        heading = charts.bounded(triangle, entry, charts.directions(triangle, point, direction, sense))
        middle = point + heading * charts.exits(triangle, entry, point, heading)[1] / 2
        heading = charts.bounded(triangle, entry, charts.directions(triangle, middle, heading, sense))
        leaving, distance = charts.exits(triangle, entry, point, heading)
        moved = np.minimum(distance, left)
        end = point + heading * moved
        ends = [charts.weights(triangle, p) for p in (point, end)]
        yield line, np.full(len(line), step), triangle, np.stack(ends, axis=1)
        left = left - moved
        twin = charts.mesh.twins[3 * triangle + leaving]
        going = (left > 0) & (twin >= 0) & charts.usable[twin // 3]
        if not going.any():
            return
        line, left, twin = line[going], left[going], twin[going]
        point, direction = charts.across(triangle[going], leaving[going], twin, end[going], heading[going])
        triangle, entry = np.divmod(twin, 3)


class _Charts:
    """The triangles laid flat, each in its own frame, with the field's power at their corners.

    Attributes
    ----------
    corners : (m, 3) complex
    powers : (m, 3) complex, of unit modulus or zero
    usable : (m,) bool, False for degenerate triangles
    """

    def __init__(self, mesh: TriangleMesh, vectors: np.ndarray, symmetry: int) -> None:
        self.mesh, self.symmetry = mesh, symmetry
        normals = mesh.face_normals
        a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
        x = unit_vectors(b - a)
        y = np.cross(normals, x)
        self.corners = np.column_stack([np.zeros(len(a)), _complex(b - a, x, y), _complex(c - a, x, y)])
        turned = [_turn_vectors(vectors[at], mesh.vertex_normals[at], normals) for at in mesh.triangles.T]
        self.powers = np.column_stack([_units(_complex(corner, x, y)) ** symmetry for corner in turned])
        self.usable = mesh.areas > FLAT * (np.abs(self.edges) ** 2).max(axis=1)

    @cached_property
    def edges(self) -> np.ndarray:
        """(m, 3) complex, from corner k to corner k + 1."""
        return np.roll(self.corners, -1, axis=1) - self.corners

    def weights(self, triangle: np.ndarray, point: np.ndarray) -> np.ndarray:
        """(k, 3) barycentric coordinates."""
        heights = np.maximum(self._heights(triangle, point), 0)
        return np.roll(heights, -1, axis=1) / heights.sum(axis=1, keepdims=True)

    def directions(self, triangle: np.ndarray, point: np.ndarray, heading: np.ndarray, sense: int) -> np.ndarray:
        """The field's root nearest to a heading; for a vector field its direction times ``sense``."""
        power = (self.weights(triangle, point) * self.powers[triangle]).sum(axis=1)
        turn = np.angle(power * (sense * np.conj(heading)) ** self.symmetry) / self.symmetry
        return heading * np.exp(1j * turn)

    def bounded(self, triangle: np.ndarray, entry: np.ndarray, heading: np.ndarray) -> np.ndarray:
        """The heading, changed where it would leave by the edge of entry (-1 in a seed's triangle)."""
        along = _units(self.edges[triangle, entry])
        slope = np.imag(np.conj(along) * heading)
        outward = (entry >= 0) & (slope < SLOPE)
        forward = np.where(np.real(np.conj(along) * heading) < 0, -1, 1)
        return np.where(outward, _units(along * (forward + 1j * SLOPE)), heading)

    def exits(
        self, triangle: np.ndarray, entry: np.ndarray, point: np.ndarray, heading: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Edge by which a straight line leaves its triangle, and the distance to it."""
        rates = -np.imag(np.conj(self.edges[triangle]) * heading[:, None])
        heights = np.maximum(self._heights(triangle, point), 0)
        ahead = (rates > 0) & (np.arange(3) != entry[:, None])
        distances = np.divide(heights, rates, out=np.full(heights.shape, np.inf), where=ahead)
        leaving = distances.argmin(axis=1)
        return leaving, distances[np.arange(len(leaving)), leaving]

    def across(
        self, triangle: np.ndarray, leaving: np.ndarray, twin: np.ndarray, point: np.ndarray, heading: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """A point on an edge and a heading, in the frame of the triangle on the other side."""
        here = self.edges[triangle, leaving]
        share = np.real(np.conj(here) * (point - self.corners[triangle, leaving])) / np.abs(here) ** 2
        other, k = np.divmod(twin, 3)
        there = -self.edges[other, k]
        start = self.corners[other, (k + 1) % 3]
        return start + np.clip(share, 0, 1) * there, heading * _units(there) / _units(here)

    def _heights(self, triangle: np.ndarray, point: np.ndarray) -> np.ndarray:
        """(k, 3) twice the area of the triangle of each edge and the point."""
        return np.imag(np.conj(self.edges[triangle]) * (point[:, None] - self.corners[triangle]))


def _complex(vectors: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.einsum("ij,ij->i", vectors, x) + 1j * np.einsum("ij,ij->i", vectors, y)


def _units(numbers: np.ndarray) -> np.ndarray:
    sizes = np.abs(numbers)
    return np.divide(numbers, sizes, out=np.zeros_like(numbers), where=sizes > 0)


def _turn_vectors(vectors: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Vectors orthogonal to the unit normals ``start``, rotated with them to ``end`` along the shortest arc."""
    both = start + end
    shares = np.einsum("ij,ij->i", vectors, end) / np.maximum(1 + np.einsum("ij,ij->i", start, end), 1e-6)
    return vectors - shares[:, None] * both
