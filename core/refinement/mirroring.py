# SPDX-License-Identifier: GPL-3.0-or-later
"""Divisions that are their own mirror image: triangles are cut at the mirror planes, and what is on one side is divided
and reflected."""

from dataclasses import dataclass, replace

import numpy as np

from ..geometry.mirror import mirrored_corners
from .division import TRIANGLE_EDGES, joined_faces


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
    heights = division.vertices[:, reflection.axis]
    signs = np.sign(heights[division.triangles])
    across = (signs.min(axis=1) < 0) & (signs.max(axis=1) > 0)
    signs = signs[across]
    # First the corner on the plane, or the one that is alone on its side.
    begins = (signs == 0).any(axis=1)
    alone = signs == -np.sign(signs.sum(axis=1))[:, None]
    faces = division.faces[across].turned(np.where(begins[:, None], signs == 0, alone).argmax(axis=1))
    vertices, faces = _with_cuts(division.vertices, heights, faces, reflection.axis)
    # Points 3 to 5 are the cuts of the edges from corners 0, 1 and 2.
    parts = [division.faces[~across]]
    for rows, split in ((begins, ((0, 1, 4), (0, 4, 2))), (~begins, ((0, 3, 5), (3, 1, 2), (3, 2, 5)))):
        parts += [faces.cut(rows, points, TRIANGLE_EDGES) for points in split]
    return joined_faces(parts, 3).division(vertices)


def _with_cuts(vertices, heights, faces, axis):
    """The vertices with those where edges of triangles cross the plane, and the triangles with these cuts as points 3
    to 5, -1 where there is none."""
    corners, following = faces.corners, np.roll(faces.corners, -1, axis=1)
    begin, end = heights[corners], heights[following]
    crosses = begin * end < 0
    ends, numbers = np.unique(
        np.sort(np.stack([corners, following], axis=2)[crosses], axis=1), axis=0, return_inverse=True
    )
    low, high = heights[ends].T
    shares = (low / (low - high))[:, None]
    cuts = (1 - shares) * vertices[ends[:, 0]] + shares * vertices[ends[:, 1]]
    cuts[:, axis] = 0
    points = np.full_like(corners, -1)
    points[crosses] = len(vertices) + numbers.reshape(-1)
    share = np.divide(begin, begin - end, out=np.zeros_like(begin), where=crosses)[:, :, None]
    between = (1 - share) * faces.weights + share * np.roll(faces.weights, -1, axis=1)
    return np.concatenate([vertices, cuts]), faces.with_points(points, between)


def on_positive_side(division, reflection):
    """(t,) bool: triangles of a cut division on the plane's positive side, or in the plane."""
    return (division.vertices[division.triangles, reflection.axis] >= 0).all(axis=1)


def with_reflection(division, parents, reflection):
    """A division on the positive side together with its mirror image, and the corners that weights are for; triangles
    in the plane are their own image.

    Parameters
    ----------
    division : Division
    parents : (t, 3) corners of the faces
    reflection : Reflection
    """
    heights = division.vertices[:, reflection.axis]
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
