# SPDX-License-Identifier: GPL-3.0-or-later
"""Divisions that are their own mirror image: triangles are cut at the mirror planes, and what is on one side is divided
and reflected."""

from dataclasses import dataclass, replace

import numpy as np

from ..geometry.mirror import mirrored_corners
from .division import Division

# New vertices nearer to a plane than this share of the size lie on it.
_ON_PLANE = 1e-12


@dataclass(frozen=True)
class Reflection:
    """What mirrors a mesh's elements in one of its axes.

    Attributes
    ----------
    axis : 0, 1 or 2
    vertices : (n,) the vertex that mirrors each one
    corners : (c,) the corner that mirrors each one
    edges : (e,) the edge that mirrors each one, -1 for none
    """

    axis: int
    vertices: np.ndarray
    corners: np.ndarray
    edges: np.ndarray

    @classmethod
    def of(cls, mesh, polygons, edges, axis):
        """The reflection of a TriangleMesh and its Polygons, with (e, 2) vertices of edges; errors as
        :func:`mirrored_corners`."""
        vertices, corners = mirrored_corners(mesh, polygons, axis)
        keys = _keys(edges, len(vertices))
        order = np.argsort(keys)
        asked = _keys(vertices[edges], len(vertices))
        found = order[np.minimum(np.searchsorted(keys[order], asked), len(order) - 1)] if len(order) else order
        return cls(axis, vertices, corners, np.where(keys[found] == asked, found, -1))


def _keys(edges, count):
    low, high = np.sort(edges, axis=1).T
    return low * count + high


def on_planes(division, reflections):
    """The :class:`Division` with the given vertices that mirror themselves exactly on their planes: what lies between
    them is then on the plane, too."""
    vertices = division.vertices.copy()
    for reflection in reflections:
        own = reflection.vertices == np.arange(len(reflection.vertices))
        vertices[: len(own), reflection.axis][own] = 0
    return replace(division, vertices=vertices)


def cut_at_plane(division, reflection):
    """The :class:`Division` whose triangles are each on one side of the plane of a :class:`Reflection`."""
    heights = _heights(division, reflection)
    sides = np.sign(heights[division.triangles])
    across = (sides.min(axis=1) < 0) & (sides.max(axis=1) > 0)
    kept, crossing = division[~across], division[across]
    signs = sides[across]
    # First the corner on the plane, or the one that is alone on its side.
    on_plane = signs == 0
    alone = signs == -np.sign(signs.sum(axis=1))[:, None]
    turns = (np.where(on_plane.any(axis=1, keepdims=True), on_plane, alone).argmax(axis=1)[:, None] + np.arange(3)) % 3
    corners, labels = (np.take_along_axis(values, turns, 1) for values in (crossing.triangles, crossing.sides))
    weights = np.take_along_axis(crossing.weights, turns[:, :, None], 1)
    vertices, points, weights = _with_cuts(division.vertices, heights, corners, weights, reflection.axis)
    parts = [kept]
    labels = np.column_stack([labels, np.full(len(labels), -1)])
    begins = on_plane.any(axis=1)
    # Points 0 to 2 are the corners, 3 to 5 the cuts of the edges from 0 to 1, 1 to 2 and 2 to 0; sides by their edges.
    for rows, split in (
        (begins, (((0, 1, 4), (0, 1, 3)), ((0, 4, 2), (3, 1, 2)))),
        (~begins, (((0, 3, 5), (0, 3, 2)), ((3, 1, 2), (0, 1, 3)), ((3, 2, 5), (3, 2, 3)))),
    ):
        for triangle, edges in split:
            parts.append(
                Division(
                    vertices,
                    points[rows][:, triangle],
                    crossing.source[rows],
                    weights[rows][:, triangle],
                    labels[rows][:, edges],
                )
            )
    fields = ("triangles", "source", "weights", "sides")
    joined = {name: np.concatenate([getattr(part, name) for part in parts]) for name in fields}
    return Division(vertices, **joined)


def _heights(division, reflection):
    """(v,) coordinates along the axis, 0 on the plane."""
    heights = division.vertices[:, reflection.axis].copy()
    new = heights[len(reflection.vertices) :]
    new[np.abs(new) <= _ON_PLANE * np.nanmax(np.abs(division.vertices), initial=0)] = 0
    return heights


def _with_cuts(vertices, heights, corners, weights, axis):
    """The vertices with those where edges of triangles cross the plane, (k, 6) numbers of corners and cuts, -1 for
    none, and (k, 6, 3) their weights."""
    following = np.roll(corners, -1, axis=1)
    crosses = heights[corners] * heights[following] < 0
    ends = np.sort(np.stack([corners, following], axis=2)[crosses], axis=1)
    unique, numbers = np.unique(ends, axis=0, return_inverse=True)
    low, high = heights[unique].T
    shares = (low / (low - high))[:, None]
    cuts = (1 - shares) * vertices[unique[:, 0]] + shares * vertices[unique[:, 1]]
    cuts[:, axis] = 0
    points = np.column_stack([corners, np.full_like(corners, -1)])
    points[:, 3:][crosses] = len(vertices) + numbers.reshape(-1)
    begin, end = heights[corners], heights[following]
    share = np.divide(begin, begin - end, out=np.zeros_like(begin), where=crosses)[:, :, None]
    between = (1 - share) * weights + share * np.roll(weights, -1, axis=1)
    return np.concatenate([vertices, cuts]), points, np.concatenate([weights, between], axis=1)


def on_positive_side(division, reflection):
    """(t,) bool: triangles of a cut division on the plane's positive side, or in the plane."""
    return (_heights(division, reflection)[division.triangles] >= 0).all(axis=1)


def with_reflection(division, parents, reflection):
    """A division on the positive side together with its mirror image, and the corners that weights are for; triangles
    in the plane are their own image.

    Parameters
    ----------
    division : Division
    parents : (t, 3) corners of the faces
    reflection : Reflection
    """
    heights = _heights(division, reflection)
    count, given = len(division.vertices), len(reflection.vertices)
    image = np.arange(count)
    image[:given] = reflection.vertices
    moved = given + np.flatnonzero(heights[given:] != 0)
    image[moved] = count + np.arange(len(moved))
    mirrored = division.vertices[moved].copy()
    mirrored[:, reflection.axis] *= -1
    rows = (heights[division.triangles] != 0).any(axis=1)
    labels = division.sides[rows, ::-1]
    labels = np.where(labels < 0, -1, reflection.edges[labels]) if len(reflection.edges) else labels
    both = replace(
        division,
        vertices=np.concatenate([division.vertices, mirrored]),
        triangles=np.concatenate([division.triangles, image[division.triangles[rows]][:, [0, 2, 1]]]),
        source=np.concatenate([division.source, division.source[rows]]),
        weights=np.concatenate([division.weights, division.weights[rows][:, [0, 2, 1]]]),
        sides=np.concatenate([division.sides, labels]),
    )
    return both, np.concatenate([parents, reflection.corners[parents[rows]]])
