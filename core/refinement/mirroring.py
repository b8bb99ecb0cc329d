# SPDX-License-Identifier: GPL-3.0-or-later
"""Symmetric divisions: triangles are cut at the mirror planes, divided on one side and reflected."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from ..geometry.mirror import mirrored_corners
from ..geometry.polygons import Polygons
from ..geometry.triangle_mesh import TriangleMesh
from ..graphs import find, pair_keys
from .division import TRIANGLE_EDGES, Division, Faces, join_faces

# Vertices are moved onto a plane that is nearer than this share of their shortest edge.
NEAR_PLANE = 0.2


@dataclass(frozen=True)
class Reflection:
    """Mirror images of a mesh's (n,) vertices and (e,) edges, -1 for none, and (c,) corners, in axis 0, 1 or 2."""

    axis: int
    vertices: np.ndarray
    corners: np.ndarray
    edges: np.ndarray

    @classmethod
    def of(cls, mesh: TriangleMesh, polygons: Polygons, edges: np.ndarray, axis: int) -> Self:
        """Match a mesh, its polygons and (e, 2) edges with their mirror images; errors as :func:`mirrored_corners`."""
        vertices, corners = mirrored_corners(mesh, polygons, axis)
        images = find(pair_keys(edges, len(vertices)), pair_keys(vertices[edges], len(vertices)))
        return cls(axis, vertices, corners, images)

    @classmethod
    def of_half(cls, mesh: TriangleMesh, corner_count: int, edge_count: int, axis: int) -> Self:
        """A reflection of the positive side, whose vertices near the plane are moved onto it.

        Vertices off the plane have no image yet. The image of a corner or an edge keeps its number.
        """
        shortest = np.full(mesh.vertex_count, np.inf)
        np.minimum.at(shortest, mesh.edges, mesh.edge_lengths[:, None])
        is_on = np.abs(mesh.vertices[:, axis]) <= NEAR_PLANE * shortest
        vertices = np.where(is_on, np.arange(mesh.vertex_count), -1)
        return cls(axis, vertices, np.arange(corner_count), np.arange(edge_count))


def snap_to_planes(division: Division, reflections: Sequence[Reflection]) -> Division:
    """Move given vertices that mirror themselves exactly onto their planes, so that points between are on them too."""
    vertices = division.vertices.copy()
    for reflection in reflections:
        own = reflection.vertices == np.arange(len(reflection.vertices))
        vertices[: len(own), reflection.axis][own] = 0
    return replace(division, vertices=vertices)


def cut_at_plane(division: Division, reflection: Reflection) -> Division:
    """Cut the triangles at the plane of a reflection, so that each is on one side."""
    heights = division.vertices[:, reflection.axis]
    signs = np.sign(heights[division.triangles])
    across = (signs.min(axis=1) < 0) & (signs.max(axis=1) > 0)
    signs = signs[across]
    # Begin with the corner on the plane, or with the single one on its side.
    begins = (signs == 0).any(axis=1)
    alone = signs == -np.sign(signs.sum(axis=1))[:, None]
    faces = division.faces[across].turned(np.where(begins[:, None], signs == 0, alone).argmax(axis=1))
    vertices, faces = _add_cuts(division.vertices, heights, faces, reflection.axis)
    # Points 3 to 5 are the cuts of the edges from corners 0, 1 and 2.
    parts = [division.faces[~across]]
    for rows, split in ((begins, ((0, 1, 4), (0, 4, 2))), (~begins, ((0, 3, 5), (3, 1, 2), (3, 2, 5)))):
        parts += [faces.cut(rows, points, TRIANGLE_EDGES) for points in split]
    return join_faces(parts, 3).division(vertices)


def _add_cuts(vertices: np.ndarray, heights: np.ndarray, faces: Faces, axis: int) -> tuple[np.ndarray, Faces]:
    """Add vertices where edges of triangles cross the plane; the triangles get these cuts as points 3 to 5, or -1."""
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


def add_reflection(division: Division, parents: np.ndarray, reflection: Reflection) -> tuple[Division, np.ndarray]:
    """Join a division on the positive side with its mirror image; triangles in the plane are their own image.

    ``parents`` are the (t, 3) corners that weights refer to, which are also returned for the result.
    """
    heights = division.vertices[:, reflection.axis]
    count, given = len(division.vertices), len(reflection.vertices)
    image = np.where(heights == 0, np.arange(count), -1)
    image[:given] = reflection.vertices
    moved = np.flatnonzero(image < 0)
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
