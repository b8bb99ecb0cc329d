# SPDX-License-Identifier: GPL-3.0-or-later
"""Division of triangles at the midpoints of long edges, until no edge is longer than a limit."""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from itertools import combinations

import numpy as np

from ..graphs import ragged_arange

# Points 0 to 2 are the corners of a triangle, 3 to 5 the midpoints of its edges from corner k to corner k + 1; the
# first edge is the longest of those that are divided. The keys are whether the second and third edge are divided, and
# whether the shorter diagonal of the remaining quadrilateral begins at the first midpoint.
_SPLITS = {
    (False, False, True): ((0, 3, 2), (3, 1, 2)),
    (True, False, True): ((3, 1, 4), (0, 3, 2), (3, 4, 2)),
    (True, False, False): ((3, 1, 4), (0, 3, 4), (0, 4, 2)),
    (False, True, True): ((0, 3, 5), (3, 1, 2), (3, 2, 5)),
    (False, True, False): ((0, 3, 5), (3, 1, 5), (1, 2, 5)),
    (True, True, True): ((0, 3, 5), (3, 1, 4), (3, 4, 2), (3, 2, 5)),
    (True, True, False): ((0, 3, 5), (3, 1, 4), (3, 4, 5), (4, 2, 5)),
}
# Needles are triangles with two edges that are more than this many times too long, and a short third one. Divided as
# above they become 3^k triangles for edges in 2^k parts; so their tips are cut off instead, which leaves a strip.
_NEEDLE = 8.0
_TIPS = {(True, False): ((3, 1, 4), (0, 3, 4, 2)), (False, True): ((0, 3, 5), (3, 1, 2, 5))}
# Strips are quadrilaterals whose first and third edge may be long; points 4 and 5 are the midpoints of these. They stay
# strips until both are short. The keys are whether the first and third edge are long, and then whether the diagonal
# from corner 0 is the shorter.
_STRIPS = {
    (True, True): ((0, 4, 5, 3), (4, 1, 2, 5)),
    (True, False): ((0, 4, 3), (4, 1, 2), (4, 2, 3)),
    (False, True): ((0, 1, 5), (1, 2, 5), (0, 5, 3)),
}
_DIAGONALS = {True: ((0, 1, 2), (0, 2, 3)), False: ((0, 1, 3), (1, 2, 3))}


def _edges_of(lines: Sequence[Sequence[int]]) -> np.ndarray:
    """Tabulate the edge that a pair of points lies on, (p, p), from the points of each edge; -1 for none."""
    count = max(map(max, lines)) + 1
    table = np.full((count, count), -1)
    for edge, points in enumerate(lines):
        for one, other in combinations(points, 2):
            table[one, other] = table[other, one] = edge
    return table


TRIANGLE_EDGES = _edges_of(((0, 3, 1), (1, 4, 2), (2, 5, 0)))
_STRIP_EDGES = _edges_of(((0, 4, 1), (1, 2), (2, 5, 3), (3, 0)))


@dataclass(frozen=True)
class Division:
    """Triangles, and the triangles that they were divided from.

    Attributes
    ----------
    vertices : (v, 3) the given ones first
    triangles : (t, 3)
    source : (t,) triangle that each is a part of, ascending
    weights : (t, 3, 3) of the source's corners at each corner; they add up to one
    sides : (t, 3) label of the source's edge that the edge from corner k to corner k + 1 lies on, -1 inside
    """

    vertices: np.ndarray
    triangles: np.ndarray
    source: np.ndarray
    weights: np.ndarray
    sides: np.ndarray

    def __getitem__(self, rows: np.ndarray) -> "Division":
        return self.faces[rows].division(self.vertices)

    @property
    def faces(self) -> "Faces":
        """The triangles as :class:`Faces`."""
        return Faces(self.triangles, self.source, self.weights, self.sides)


@dataclass(frozen=True)
class Faces:
    """Triangles or strips: (k, 3 or 4) corners, and the rest as in :class:`Division`."""

    corners: np.ndarray
    source: np.ndarray
    weights: np.ndarray
    sides: np.ndarray

    def __getitem__(self, rows: np.ndarray) -> "Faces":
        return Faces(self.corners[rows], self.source[rows], self.weights[rows], self.sides[rows])

    def __len__(self) -> int:
        return len(self.corners)

    def turned(self, first: np.ndarray) -> "Faces":
        """Rotate the corners of each face so that corner ``first``, (k,), is the first."""
        count = self.corners.shape[1]
        turns = (first[:, None] + np.arange(count)) % count
        corners, sides = (np.take_along_axis(values, turns, 1) for values in (self.corners, self.sides))
        return Faces(corners, self.source, np.take_along_axis(self.weights, turns[:, :, None], 1), sides)

    def division(self, vertices: np.ndarray) -> Division:
        """Build a :class:`Division` with (v, 3) vertices."""
        return Division(vertices, self.corners, self.source, self.weights, self.sides)

    def with_middles(self, middles: np.ndarray, edges: Sequence[int]) -> "Faces":
        """Append the midpoints of some edges as corners."""
        halves = (self.weights[:, edges] + np.roll(self.weights, -1, axis=1)[:, edges]) / 2
        return self.with_points(middles, halves)

    def with_points(self, points: np.ndarray, weights: np.ndarray) -> "Faces":
        """Append points with weights as corners."""
        corners, weights = np.hstack([self.corners, points]), np.hstack([self.weights, weights])
        return Faces(corners, self.source, weights, np.column_stack([self.sides, np.full(len(self), -1)]))

    def cut(self, rows: np.ndarray, points: Sequence[int], edges: np.ndarray) -> "Faces":
        """Build faces from some points of the faces ``rows``, with the edges of :func:`_edges_of`."""
        sides = edges[points, np.roll(points, -1)]
        return Faces(
            self.corners[rows][:, points], self.source[rows], self.weights[rows][:, points], self.sides[rows][:, sides]
        )


def whole_division(vertices: np.ndarray, triangles: np.ndarray, sides: np.ndarray) -> Division:
    """Build the :class:`Division` of whole triangles; ``sides`` label edges from corner k to corner k + 1, (m, 3)."""
    weights = np.broadcast_to(np.eye(3), (len(triangles), 3, 3))
    return Division(vertices, triangles, np.arange(len(triangles)), weights, sides)


def split_at(whole: Division, halves: np.ndarray, places: np.ndarray, shares: np.ndarray) -> Division:
    """Split triangles at points on their edges, each of which becomes a vertex of its own, in fans.

    Parameters
    ----------
    halves : (s,) ascending, 3 t + k for a point on the edge from corner k of triangle t to the next
    places : (s, 3) of the points
    shares : (s,) of the edge's length, from corner k to the point, ascending on each edge
    """
    count = 3 * len(whole.triangles)
    faces = replace(whole.faces, sides=np.arange(count).reshape(-1, 3))
    points, first = np.bincount(halves, minlength=count), np.searchsorted(halves, np.arange(count))
    for k in range(3):
        split = (faces.sides >= 0) & (faces.sides % 3 == k) & (points[faces.sides] > 0)
        rows = split.any(axis=1)
        turned = faces[rows].turned(split[rows].argmax(axis=1))
        owner, step = ragged_arange(points[turned.sides[:, 0]] + 1)
        fan, own = turned[owner], first[turned.sides[owner, 0]] + step
        begins, ends = step > 0, step < points[fan.sides[:, 0]]
        corners, weights, sides = fan.corners.copy(), fan.weights.copy(), fan.sides.copy()
        for corner, moved, at in ((0, begins, own - 1), (1, ends, own)):
            share = shares[at[moved], None]
            corners[moved, corner] = len(whole.vertices) + at[moved]
            weights[moved, corner] = (1 - share) * fan.weights[moved, 0] + share * fan.weights[moved, 1]
        sides[ends, 1], sides[begins, 2] = -1, -1
        faces = join_faces([faces[~rows], Faces(corners, fan.source, weights, sides)], 3)
    labels = np.where(faces.sides < 0, -1, whole.sides.ravel()[faces.sides])
    order = np.argsort(faces.source, kind="stable")
    return replace(faces, sides=labels)[order].division(np.concatenate([whole.vertices, places]))


def divide(whole: Division, longest: float, most: int) -> Division | None:
    """Divide triangles until all edges are at most ``longest``; None if there would be more than ``most`` triangles.

    An edge is halved as often as needed, in the same way in all its triangles. Old vertices do not move.
    """
    vertices, now = whole.vertices, whole.faces
    strips = join_faces([], 4)
    done, count = [], 0
    while True:
        lengths, strip_lengths = (_edge_lengths(vertices, faces) for faces in (now, strips))
        # An edge has the same length in all of its faces, which are therefore divided in the same step.
        long, sides_long = lengths > longest, strip_lengths[:, ::2] > longest
        settled = ~long.any(axis=1)
        done.append(now[settled])
        count += int(settled.sum())
        if settled.all() and len(strips) == 0:
            break
        left = _bound_count(vertices, now[~settled], lengths[~settled], longest)
        if count + left + 2 * _parts(strip_lengths[:, ::2].max(axis=1), longest).sum() > most:
            return None
        vertices, now, strips = _halve_edges(vertices, now[~settled], lengths[~settled], strips, sides_long, longest)
    faces = join_faces(done, 3)
    return faces[np.argsort(faces.source, kind="stable")].division(vertices)


def join_faces(parts: Sequence[Faces], corners: int) -> Faces:
    """Concatenate faces with the same number of corners."""
    none = np.empty((0, corners), int)
    parts = [Faces(none, np.empty(0, int), np.empty((0, corners, 3)), none), *parts]
    return Faces(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(Faces)))


def _edge_lengths(vertices: np.ndarray, faces: Faces) -> np.ndarray:
    corners = vertices[faces.corners]
    return np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)


def _parts(lengths: np.ndarray, longest: float) -> np.ndarray:
    """Count the parts that edges are divided into."""
    return 2.0 ** np.ceil(np.maximum(np.log2(lengths) - np.log2(longest), 0))


def _bound_count(vertices: np.ndarray, faces: Faces, lengths: np.ndarray, longest: float) -> float:
    """Compute a lower bound of the number of triangles after division: each part of a longest edge has one, and none is
    larger than an equilateral one."""
    a, b, c = np.moveaxis(vertices[faces.corners], 1, 0)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    return np.maximum(_parts(lengths.max(axis=1), longest), areas / (np.sqrt(3) / 4 * longest**2)).sum()


def _halve_edges(
    vertices: np.ndarray, faces: Faces, lengths: np.ndarray, strips: Faces, sides_long: np.ndarray, longest: float
) -> tuple[np.ndarray, Faces, Faces]:
    """Halve the long edges of triangles and strips."""
    long = lengths > longest
    first = np.argmax(np.where(long, lengths, -1), axis=1)
    faces = faces.turned(first)
    turns = (first[:, None] + np.arange(3)) % 3
    lengths, long = (np.take_along_axis(values, turns, 1) for values in (lengths, long))
    vertices, middles, strip_middles = _add_midpoints(vertices, (faces, [0, 1, 2], long), (strips, [0, 2], sides_long))
    faces, strips = faces.with_middles(middles, [0, 1, 2]), strips.with_middles(strip_middles, [0, 2])
    is_needle = (long.sum(axis=1) == 2) & (np.where(long, lengths, np.inf).min(axis=1) > _NEEDLE * longest)
    kinds = np.column_stack([long[:, 1:], _first_diagonal_is_shorter(vertices, faces.corners, long)])
    triangles, new_strips = [], []
    for kind, split in _SPLITS.items():
        rows = np.flatnonzero((kinds == kind).all(axis=1) & ~is_needle)
        triangles += [faces.cut(rows, points, TRIANGLE_EDGES) for points in split]
    for ends, (tip, rest) in _TIPS.items():
        rows = np.flatnonzero((long[:, 1:] == ends).all(axis=1) & is_needle)
        triangles.append(faces.cut(rows, tip, TRIANGLE_EDGES))
        new_strips.append(faces.cut(rows, rest, TRIANGLE_EDGES))
    for ends, pieces in _STRIPS.items():
        rows = np.flatnonzero((sides_long == ends).all(axis=1))
        parts = [strips.cut(rows, points, _STRIP_EDGES) for points in pieces]
        (new_strips if ends == (True, True) else triangles).extend(parts)
    settled = ~sides_long.any(axis=1)
    diagonal = _first_is_shorter(vertices, strips.corners[:, [0, 2]], strips.corners[:, [1, 3]])
    for is_first, halves in _DIAGONALS.items():
        rows = np.flatnonzero(settled & (diagonal == is_first))
        triangles += [strips.cut(rows, points, _STRIP_EDGES) for points in halves]
    return vertices, join_faces(triangles, 3), join_faces(new_strips, 4)


def _add_midpoints(vertices: np.ndarray, *parts: tuple[Faces, list[int], np.ndarray]) -> tuple[np.ndarray, ...]:
    """Add the midpoints of long edges to the vertices; also returns the midpoint of each edge of each part, or -1.

    A part consists of faces, the numbers of some of their edges, and whether each of these is long.
    """
    of_parts = [
        np.stack([faces.corners[:, edges], np.roll(faces.corners, -1, axis=1)[:, edges]], axis=2)[long]
        for faces, edges, long in parts
    ]
    ends = np.sort(np.concatenate(of_parts), axis=1)
    _, first, numbers = np.unique(ends[:, 0] * len(vertices) + ends[:, 1], return_index=True, return_inverse=True)
    numbers = len(vertices) + numbers.reshape(-1)
    found = []
    for _, _, long in parts:
        middles = np.full(long.shape, -1)
        middles[long], numbers = numbers[: long.sum()], numbers[long.sum() :]
        found.append(middles)
    return np.concatenate([vertices, vertices[ends[first]].mean(axis=1)]), *found


def _first_diagonal_is_shorter(vertices: np.ndarray, points: np.ndarray, long: np.ndarray) -> np.ndarray:
    """Tell whether the first diagonal is shorter in the quadrilateral left after cutting off a corner, (k,) bool."""
    ends = np.where(long[:, 1], points[:, 4], points[:, 1]), np.where(long[:, 2], points[:, 5], points[:, 0])
    return _first_is_shorter(vertices, points[:, [3, 2]], np.column_stack(ends)) | ~long[:, 1:].any(axis=1)


def _first_is_shorter(vertices: np.ndarray, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Tell whether the first of two lines between (k, 2) vertices is not longer than the other, (k,) bool."""
    lengths = [((vertices[ends[:, 0]] - vertices[ends[:, 1]]) ** 2).sum(axis=1) for ends in (one, other)]
    return lengths[0] <= lengths[1]
