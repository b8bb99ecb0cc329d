# SPDX-License-Identifier: GPL-3.0-or-later
"""Marks for directions at vertices: arrows, lines and crosses."""

import numpy as np

from ...geometry import TriangleMesh

# Length of a mark and its height above the surface, as shares of the mean distance between marks.
LENGTH, LIFT = 0.7, 0.08
# Width of the grid cells with one mark each, as a share of the mean distance between vertices.
CELL = 0.6
# Barbs of an arrow, as shares of its length along and across it.
BARB = (0.3, 0.15)


def direction_glyphs(mesh: TriangleMesh, vectors: np.ndarray, symmetry: int, limit: int) -> np.ndarray:
    """(k, 2, 3) segments that show the directions at no more than ``limit`` vertices, evenly spread.

    A line field is drawn by lines a little above the surface, a cross field by two lines each, a vector field by
    arrows. ``vectors`` holds one (n, 3) tangent representative at each vertex, zero for no mark; ``symmetry`` is 1, 2
    or 4.
    """
    used = np.flatnonzero(np.linalg.norm(vectors, axis=1) > 0)
    if len(used) == 0:
        return np.empty((0, 2, 3))
    area = mesh.areas.sum()
    chosen = used[thin_points(mesh.vertices[used], CELL * np.sqrt(area / len(used)), limit)]
    distance = np.sqrt(area / len(chosen))
    normals = mesh.vertex_normals[chosen]
    centres = mesh.vertices[chosen] + LIFT * distance * normals
    along = vectors[chosen] / np.linalg.norm(vectors[chosen], axis=1, keepdims=True) * (LENGTH * distance)
    across = np.cross(normals, along)
    segments = [(centres - along / 2, centres + along / 2)]
    if symmetry == 4:
        segments.append((centres - across / 2, centres + across / 2))
    if symmetry == 1:
        tips = centres + along / 2
        back, aside = BARB
        segments += [(tips, tips - back * along + sign * aside * across) for sign in (1, -1)]
    return np.concatenate([np.stack(ends, axis=1) for ends in segments])


def thin_points(points: np.ndarray, size: float, limit: int) -> np.ndarray:
    """Indices of at most ``limit`` of (n, 3) points: one in each cell of a cubic grid, at least ``size`` wide."""
    while True:
        chosen = _one_in_each_cell(points / size)
        if len(chosen) <= limit:
            return chosen
        size *= max(np.sqrt(len(chosen) / limit), 1.01)


def _one_in_each_cell(points: np.ndarray) -> np.ndarray:
    """Index of the point nearest to the centre of each unit cell that is not empty."""
    cells = np.floor(points)
    order = np.argsort(np.linalg.norm(points - cells - 0.5, axis=1), kind="stable")
    cells = (cells - cells.min(axis=0)).astype(np.int64)[order]
    _, rows, columns = cells.max(axis=0) + 1
    first = np.unique((cells[:, 0] * rows + cells[:, 1]) * columns + cells[:, 2], return_index=True)[1]
    return np.sort(order[first])
