# SPDX-License-Identifier: GPL-3.0-or-later
"""A short mark for the direction at a vertex: an arrow, a line or a cross."""

import numpy as np

# Shares of the mean distance between two marks.
LENGTH, LIFT = 0.7, 0.08
# Marks keep this share of the vertices' mean distance, so that dense parts of a mesh do not fill up.
CELL = 0.6
# Barbs of an arrow, as shares of its length along and across it.
BARB = (0.3, 0.15)


def direction_glyphs(mesh, vectors, symmetry, limit):
    """(k, 2, 3) segments that show the directions at no more than ``limit`` vertices, evenly spread.

    A line is drawn around its vertex, a little above the surface; a cross is two lines, a vector an arrow.

    Parameters
    ----------
    mesh : TriangleMesh
    vectors : (n, 3) one tangent representative at each vertex; no mark where it is zero
    symmetry : 1, 2 or 4
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
    segments = [_segments(centres - along / 2, centres + along / 2)]
    if symmetry == 4:
        segments.append(_segments(centres - across / 2, centres + across / 2))
    if symmetry == 1:
        tips = centres + along / 2
        back, aside = BARB
        segments += [_segments(tips, tips - back * along + sign * aside * across) for sign in (1, -1)]
    return np.concatenate(segments)


def thin_points(points, size, limit):
    """Indices of at most ``limit`` of (n, 3) points: one in each cell of a cubic grid, of a size or larger."""
    while True:
        chosen = _one_in_each_cell(points / size)
        if len(chosen) <= limit:
            return chosen
        size *= max(np.sqrt(len(chosen) / limit), 1.01)


def _one_in_each_cell(points):
    """Indices of the point next to the centre of each unit cell that holds any."""
    cells = np.floor(points)
    order = np.argsort(np.linalg.norm(points - cells - 0.5, axis=1), kind="stable")
    cells = (cells - cells.min(axis=0)).astype(np.int64)[order]
    _, rows, columns = cells.max(axis=0) + 1
    first = np.unique((cells[:, 0] * rows + cells[:, 1]) * columns + cells[:, 2], return_index=True)[1]
    return np.sort(order[first])


def _segments(starts, ends):
    return np.stack([starts, ends], axis=1)
