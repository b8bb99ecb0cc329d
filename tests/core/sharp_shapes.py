# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes with boundaries and sharp edges, and how far a quad mesh is from these."""

from itertools import pairwise

import numpy as np
from scipy.spatial import Delaunay

from synch_fields.core.extract.quads.finishing import finish_quads
from synch_fields.core.extract.quads.trace.quad_mesh import quad_mesh
from synch_fields.core.fields import DirectionWishes, direction_field, quad_pattern
from synch_fields.core.fields.constraints.features import feature_edges, feature_row
from synch_fields.core.geometry import TriangleMesh

from .meshes import grid_quads, split_quads

ANGLE = np.radians(40)


def welded(patches):
    """One mesh of (points, triangles), whose equal points become one vertex."""
    points, triangles, count = [], [], 0
    for places, faces in patches:
        points.append(places)
        triangles.append(np.asarray(faces) + count)
        count += len(places)
    vertices, number = np.unique(np.round(np.concatenate(points), 9), axis=0, return_inverse=True)
    return TriangleMesh(vertices, number.ravel()[np.concatenate(triangles)])


def plate(cells=30, radius=0.22):
    """A square of side 1 with a round hole in its middle."""
    random = np.random.default_rng(0)
    x, y = np.meshgrid(*[np.arange(cells + 1) / cells - 0.5] * 2)
    points = np.column_stack([x.ravel(), y.ravel()])
    inner = (np.abs(points) < 0.5 - 1e-9).all(axis=1)
    points[inner] += 0.2 / cells * random.uniform(-1, 1, (inner.sum(), 2))
    points = points[np.linalg.norm(points, axis=1) > radius + 0.5 / cells]
    count = int(2 * np.pi * radius * cells)
    around = 2 * np.pi / count * np.arange(count)
    points = np.vstack([points, radius * np.column_stack([np.cos(around), np.sin(around)])])
    triangles = Delaunay(points).simplices
    middles = points[triangles].mean(axis=1)
    triangles = triangles[np.linalg.norm(middles, axis=1) > radius * np.cos(np.pi / count) - 1e-9]
    return TriangleMesh(np.column_stack([points, np.zeros(len(points))]), triangles)


def flat_cells(cells, fine):
    """Unit squares of the plane, as one mesh."""
    grid = split_quads(grid_quads(fine, fine))
    i, j = np.mgrid[: fine + 1, : fine + 1]
    square = np.column_stack([i.ravel(), j.ravel(), 0 * i.ravel()]) / fine
    return welded([(square + [x, y, 0], grid) for x, y in cells])


def wedge(degrees, fine=32):
    """A triangle with two sides of length 1 that meet at an angle."""
    rows, columns = np.nonzero(np.tri(fine + 1, dtype=bool))
    turns = np.radians(degrees) * np.divide(columns, rows, out=np.zeros(len(rows)), where=rows > 0)
    # Straight between the sides, not along a circle.
    lengths = rows / fine * np.cos(np.radians(degrees) / 2) / np.cos(turns - np.radians(degrees) / 2)
    points = lengths[:, None] * np.column_stack([np.cos(turns), np.sin(turns)])
    return TriangleMesh(np.column_stack([points, 0 * turns]), Delaunay(points).simplices)


def polygon(sides, fine=12):
    """A regular polygon of radius 1 in the plane."""
    angles = 2 * np.pi / sides * np.arange(sides + 1)
    corners = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    return welded([_fine_triangle(np.zeros(3), a, b, fine) for a, b in pairwise(corners)])


def chamfered_cube(cells=16, cut=0.12):
    """A cube of side 1 whose edges are cut off, and its corners to triangles."""
    inner = 0.5 - cut
    across = max(2, round(cells * cut * np.sqrt(2) / (2 * inner)))
    patches = []
    for axis in range(3):
        for side in (-0.5, 0.5):
            corners = np.full((4, 3), side)
            corners[:, (axis + 1) % 3] = np.array([-inner, inner, inner, -inner])
            corners[:, (axis + 2) % 3] = np.array([-inner, -inner, inner, inner])
            patches.append(_patch(corners, cells, cells))
        for signs in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            corners = np.empty((4, 3))
            corners[:, axis] = np.array([-inner, inner, inner, -inner])
            corners[:, (axis + 1) % 3] = signs[0] * np.array([0.5, 0.5, inner, inner])
            corners[:, (axis + 2) % 3] = signs[1] * np.array([inner, inner, 0.5, 0.5])
            patches.append(_patch(corners, cells, across))
    for signs in np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T:
        patches.append(_fine_triangle(*(signs * (np.full((3, 3), inner) + cut * np.eye(3))), across))
    return _outwards(welded(patches))


def _patch(corners, columns, rows):
    u, v = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1), indexing="ij")
    u, v = u.ravel()[:, None], v.ravel()[:, None]
    a, b, c, d = corners
    return (1 - u) * (1 - v) * a + u * (1 - v) * b + u * v * c + (1 - u) * v * d, split_quads(grid_quads(columns, rows))


def _fine_triangle(a, b, c, count):
    places = [(i, j) for i in range(count + 1) for j in range(count + 1 - i)]
    number = {place: k for k, place in enumerate(places)}
    points = np.array([a + (b - a) * i / count + (c - a) * j / count for i, j in places])
    up = [(number[i, j], number[i + 1, j], number[i, j + 1]) for i, j in places if i + j < count]
    down = [(number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]) for i, j in places if i + j < count - 1]
    return points, up + down


def _outwards(mesh):
    """A convex mesh around the origin with its faces looking away from there."""
    inwards = np.einsum("fx,fx->f", mesh.face_normals, mesh.vertices[mesh.triangles].mean(axis=1)) < 0
    triangles = mesh.triangles.copy()
    triangles[inwards] = triangles[inwards][:, ::-1]
    return TriangleMesh(mesh.vertices, triangles)


def kept_quads(mesh, spacing, rounds=10):
    """The quad mesh that keeps features and has quads alone, and the indices of the mesh's edges that are features."""
    edges = feature_edges(mesh, ANGLE, spacing / 2)
    rows = (feature_row(mesh, edges),)
    field = direction_field(mesh, 4, DirectionWishes(rows=rows))
    pattern = quad_pattern(mesh, field, spacing, rows, branching=0.0)
    return finish_quads(quad_mesh(pattern.edge_phases), mesh, rows, rounds, only_quads=True), edges


def distances_from_edges(quads, points):
    """(p,) how far points are from the nearest edge of a quad mesh."""
    begin, end = np.moveaxis(quads.vertices[quads.edges[0]], 1, 0)
    along, nearest = end - begin, np.full(len(points), np.inf)
    for start, step in zip(begin, along, strict=True):
        share = np.clip((points - start) @ step / max(step @ step, np.finfo(float).tiny), 0, 1)
        nearest = np.minimum(nearest, np.linalg.norm(points - start - share[:, None] * step, axis=1))
    return nearest


def samples(mesh, edges, count=5):
    """Points on edges."""
    shares = ((np.arange(count) + 0.5) / count)[:, None, None]
    a, b = np.moveaxis(mesh.vertices[mesh.edges[edges]], 1, 0)
    return (a + shares * (b - a)).reshape(-1, 3)


def plate_with_holes(holes, size=8.0, side=0.3, thickness=0.3, step=0.3):
    """A closed square plate with square holes of a side at all pairs of coordinates, in cells of at most a step."""
    marks = sorted({0.0, size} | {hole + way * side / 2 for hole in holes for way in (-1, 1)})
    parts = [np.linspace(a, b, int(np.ceil((b - a) / step - 1e-9)) + 1)[:-1] for a, b in pairwise(marks)]
    lines = np.append(np.concatenate(parts), size)
    in_hole = (np.abs((lines[:-1] + lines[1:]) / 2 - np.reshape(holes, (-1, 1))) < side / 2).any(axis=0)
    solid = np.pad(~(in_hole[:, None] & in_hole), 1)
    count = len(lines)
    places = np.stack(np.meshgrid(lines, lines, [0, thickness], indexing="ij"), axis=-1).reshape(-1, 3)
    quads = []
    for i, j in np.argwhere(solid[1:-1, 1:-1]).tolist():
        corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
        low = [2 * (count * a + b) for a, b in corners]
        quads += [[vertex + 1 for vertex in low], low[::-1]]
        for k, (a, b) in enumerate([(0, -1), (1, 0), (0, 1), (-1, 0)]):
            if not solid[1 + i + a, 1 + j + b]:
                first, second = low[k], low[(k + 1) % 4]
                quads.append([first, second, second + 1, first + 1])
    used, corners = np.unique(quads, return_inverse=True)
    corners = corners.reshape(-1, 4)
    return TriangleMesh(places[used], np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]]))
