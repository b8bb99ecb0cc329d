# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that cannot carry a field as they are, made from good ones: vertices and faces as lists of vertices."""

from itertools import product

import numpy as np
from scipy.spatial import cKDTree

from ..core.meshes import grid_quads, icosphere, torus_points, voxel_quads


def faces_of(polygons):
    """The faces as lists of vertices."""
    return [polygons.corner_vertices[s : s + k].tolist() for s, k in zip(polygons.starts, polygons.sizes, strict=True)]


def fans(count, angles=None):
    """Half disks of ``count`` cells along a common edge on the x axis, at these angles around it (degrees)."""
    angles = np.radians((0, 120, 240) if angles is None else angles)
    x = np.linspace(0, 1, count + 1)
    points, faces = [np.column_stack([x, 0 * x, 0 * x])], []
    for k, angle in enumerate(angles):
        rim = (k + 1) * (count + 1)
        points.append(np.column_stack([x, np.cos(angle) + 0 * x, np.sin(angle) + 0 * x]))
        faces += [[c, c + 1, rim + c + 1, rim + c] for c in range(count)]
    return np.vstack(points), faces


def hourglass(subdivisions=2):
    """Two spheres with one vertex in common, and that vertex."""
    ball = icosphere(subdivisions)
    top = np.argmax(ball.vertices[:, 2])
    numbers = np.arange(ball.vertex_count) + ball.vertex_count
    numbers[top] = top
    other = ball.vertices * [1, 1, -1] + [0, 0, 2 * ball.vertices[top, 2]]
    return (
        np.vstack([ball.vertices, other]),
        np.vstack([ball.triangles, numbers[ball.triangles][:, ::-1]]).tolist(),
        top,
    )


def doubled_and_turned(faces, doubled=(), turned=()):
    """Faces with some of them once more at the end, rolled and turned over, and others turned over."""
    faces = [face[::-1] if k in set(turned) else face for k, face in enumerate(faces)]
    return faces + [faces[k][1:][::-1] + faces[k][:1] for k in doubled]


def turned_about(polygons, some, doubled=()):
    """Faces for :func:`polygon_mesh` with the same diagonals: some of them run the other way round, and some come up
    once more, so turned."""
    firsts = polygons.triangle_corners[polygons.first_triangles, 0] - polygons.starts
    faces = list(zip(faces_of(polygons), firsts.tolist(), strict=True))
    turned = [(face[:1] + face[:0:-1], -first % len(face)) for face, first in faces]
    return [turned[k] if some[k] else face for k, face in enumerate(faces)] + [turned[k] for k in doubled]


def moebius_strip(count=12, across=1, radius=2.0):
    """A band of quads with a half twist."""
    turn = np.arange(count) * 2 * np.pi / count
    side = np.linspace(-0.5, 0.5, across + 1)
    a, s = np.meshgrid(turn, side, indexing="ij")
    reach = radius + s * np.cos(a / 2)
    points = np.stack([reach * np.cos(a), reach * np.sin(a), s * np.sin(a / 2)], axis=-1).reshape(-1, 3)
    number = np.arange(count * (across + 1)).reshape(count, across + 1)
    ahead = np.vstack([number[1:], number[:1, ::-1]])
    quads = np.stack([number[:, :-1], ahead[:, :-1], ahead[:, 1:], number[:, 1:]], axis=-1)
    return points, quads.reshape(-1, 4).tolist()


def klein_bottle(around=24, across=12):
    """A Klein bottle of quads that passes through itself."""
    u, v = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.arange(across) * 2 * np.pi / across, indexing="ij")
    reach = 2 + np.cos(u / 2) * np.sin(v) - np.sin(u / 2) * np.sin(2 * v)
    height = np.sin(u / 2) * np.sin(v) + np.cos(u / 2) * np.sin(2 * v)
    points = np.stack([reach * np.cos(u), reach * np.sin(u), height], axis=-1).reshape(-1, 3)
    number = np.arange(around * across).reshape(around, across)
    ahead = np.vstack([number[1:], number[:1, -np.arange(across) % across]])
    beside = lambda rows: np.roll(rows, -1, axis=1)  # noqa: E731
    return points, np.stack([number, ahead, beside(ahead), beside(number)], axis=-1).reshape(-1, 4).tolist()


def projective_plane(subdivisions=3):
    """A projective plane that passes through itself: each place of a sphere, and the one opposite to it."""
    ball = icosphere(subdivisions)
    opposite = cKDTree(ball.vertices).query(-ball.vertices)[1]
    first, names = np.unique(np.minimum(np.arange(ball.vertex_count), opposite), return_inverse=True)
    x, y, z = ball.vertices[first].T
    points = np.column_stack([x * y + 0.15 * x * x, y * z + 0.15 * (y * y - z * z), z * x + 0.075 * z * z])
    triangles = names[ball.triangles]
    once = np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)[1]
    return points, triangles[once].tolist()


def torus_on_a_sheet(around=24, across=12):
    """A torus of quads, and a flat ring around it that begins on its outer circle."""
    points, faces = torus_points(1.0, 0.4, around, across), grid_quads(around, across, True, True).tolist()
    outer = np.arange(around) * across
    for scale in (1.2, 1.4):
        rim = len(points) + np.arange(around)
        points = np.vstack([points, points[np.arange(around) * across] * scale])
        faces += np.stack([outer, rim, np.roll(rim, -1), np.roll(outer, -1)], axis=1).tolist()
        outer = rim
    return points, faces


def boxes(places):
    """Unit cubes at places of a lattice, which share the vertices that they have in common."""
    corners, faces = {}, []
    for place in places:
        points, quads = voxel_quads([place])
        numbers = [corners.setdefault(tuple(p), len(corners)) for p in points.tolist()]
        faces += [[numbers[v] for v in quad] for quad in quads.tolist()]
    return np.array(list(corners), float), faces


def checkerboard(size):
    """Cubes of a lattice that touch in edges and vertices only."""
    return boxes([place for place in product(range(size), repeat=3) if sum(place) % 2 == 0])
