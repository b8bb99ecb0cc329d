# SPDX-License-Identifier: GPL-3.0-or-later
"""Triangles divided at the middles of their long edges, until no edge is longer than a limit."""

from dataclasses import dataclass

import numpy as np

# Corners of a triangle, then the middles of its edges from corner k to corner k + 1; the first edge is the longest that
# is divided. Which edges are divided, and whether the shorter diagonal of the quadrilateral that is left begins at the
# first middle, says how the triangle is split.
_SPLITS = {
    (False, False, True): ((0, 3, 2), (3, 1, 2)),
    (True, False, True): ((3, 1, 4), (0, 3, 2), (3, 4, 2)),
    (True, False, False): ((3, 1, 4), (0, 3, 4), (0, 4, 2)),
    (False, True, True): ((0, 3, 5), (3, 1, 2), (3, 2, 5)),
    (False, True, False): ((0, 3, 5), (3, 1, 5), (1, 2, 5)),
    (True, True, True): ((0, 3, 5), (3, 1, 4), (3, 4, 2), (3, 2, 5)),
    (True, True, False): ((0, 3, 5), (3, 1, 4), (3, 4, 5), (4, 2, 5)),
}
# The edge of the triangle that a pair of these points lies on; 3 for none.
_EDGE_OF = np.full((6, 6), 3)
for _edge, _points in enumerate(((0, 3, 1), (1, 4, 2), (2, 5, 0))):
    for _one, _other in ((0, 1), (1, 2), (0, 2)):
        _EDGE_OF[_points[_one], _points[_other]] = _EDGE_OF[_points[_other], _points[_one]] = _edge


@dataclass(frozen=True)
class Division:
    """Triangles inside the triangles that they were divided from.

    Attributes
    ----------
    vertices : (v, 3) the given ones first
    triangles : (t, 3)
    source : (t,) the triangle that each was part of, ascending
    weights : (t, 3, 3) of the source's corners at each corner; they add up to one
    sides : (t, 3) label of the source's edge that the edge from corner k to corner k + 1 lies on, -1 inside
    """

    vertices: np.ndarray
    triangles: np.ndarray
    source: np.ndarray
    weights: np.ndarray
    sides: np.ndarray

    def __getitem__(self, rows):
        return Division(self.vertices, self.triangles[rows], self.source[rows], self.weights[rows], self.sides[rows])


def undivided(vertices, triangles, sides):
    """The :class:`Division` of triangles that are whole.

    Parameters
    ----------
    vertices : (n, 3)
    triangles : (m, 3)
    sides : (m, 3) label of the edge from corner k to corner k + 1
    """
    weights = np.broadcast_to(np.eye(3), (len(triangles), 3, 3))
    return Division(vertices, triangles, np.arange(len(triangles)), weights, sides)


def divided(now, longest, most):
    """The :class:`Division` whose edges are all at most ``longest``; None where it has more than ``most`` triangles.

    An edge is halved as often as it takes, alike in all triangles at it. The places of old vertices stay.

    Parameters
    ----------
    now : Division
    longest : float
    most : int
    """
    done, count = [], 0
    while True:
        lengths = _edge_lengths(now)
        # An edge has the same length in all of its triangles: those are divided in the same step.
        long = lengths > longest
        settled = ~long.any(axis=1)
        done.append(now[settled])
        count += int(settled.sum())
        if settled.all():
            break
        if count + _fewest_triangles(now[~settled], lengths[~settled], longest) > most:
            return None
        now = _halved(now[~settled], lengths[~settled], long[~settled])
    fields = ("triangles", "source", "weights", "sides")
    parts = {name: np.concatenate([getattr(part, name) for part in done]) for name in fields}
    order = np.argsort(parts["source"], kind="stable")
    return Division(now.vertices, *(parts[name][order] for name in fields))


def _edge_lengths(division):
    corners = division.vertices[division.triangles]
    return np.linalg.norm(corners[:, [1, 2, 0]] - corners, axis=2)


def _fewest_triangles(division, lengths, longest):
    """A lower bound on the number of triangles that these become: each part of a longest edge has one of its own, and
    none is larger than an even one."""
    a, b, c = np.moveaxis(division.vertices[division.triangles], 1, 0)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    parts = 2.0 ** np.ceil(np.log2(lengths.max(axis=1)) - np.log2(longest))
    return np.maximum(parts, areas / (np.sqrt(3) / 4 * longest**2)).sum()


def _halved(division, lengths, long):
    """The triangles with their long edges halved."""
    turns = (np.argmax(np.where(long, lengths, -1), axis=1)[:, None] + np.arange(3)) % 3
    corners, sides, long = (
        np.take_along_axis(values, turns, 1) for values in (division.triangles, division.sides, long)
    )
    weights = np.take_along_axis(division.weights, turns[:, :, None], 1)
    vertices, middles = _middles(division.vertices, corners, long)
    points = np.concatenate([corners, middles], axis=1)
    weights = np.concatenate([weights, (weights + weights[:, [1, 2, 0]]) / 2], axis=1)
    sides = np.column_stack([sides, np.full(len(sides), -1)])
    kinds = np.column_stack([long[:, 1:], _first_diagonal_is_shorter(vertices, points, long)])
    parts = []
    for kind, split in _SPLITS.items():
        rows = np.flatnonzero((kinds == kind).all(axis=1))
        for triangle in split:
            edges = _EDGE_OF[triangle, np.roll(triangle, -1)]
            parts.append(
                (points[rows][:, triangle], division.source[rows], weights[rows][:, triangle], sides[rows][:, edges])
            )
    return Division(vertices, *(np.concatenate(values) for values in zip(*parts, strict=True)))


def _middles(vertices, corners, long):
    """The vertices with those in the middle of long edges added, and (k, 3) the vertex in the middle of each edge, -1
    where there is none."""
    ends = np.stack([corners, corners[:, [1, 2, 0]]], axis=2)[long]
    ends.sort(axis=1)
    _, first, numbers = np.unique(ends[:, 0] * len(vertices) + ends[:, 1], return_index=True, return_inverse=True)
    middles = np.full(corners.shape, -1)
    middles[long] = len(vertices) + numbers.reshape(-1)
    return np.concatenate([vertices, vertices[ends[first]].mean(axis=1)]), middles


def _first_diagonal_is_shorter(vertices, points, long):
    """(k,) bool: of the quadrilateral that is left when a corner beside the first middle is cut off."""
    ends = np.where(long[:, 1], points[:, 4], points[:, 1]), np.where(long[:, 2], points[:, 5], points[:, 0])
    lengths = [((vertices[a] - vertices[b]) ** 2).sum(axis=1) for a, b in ((points[:, 3], points[:, 2]), ends)]
    return (lengths[0] <= lengths[1]) | ~long[:, 1:].any(axis=1)
