# SPDX-License-Identifier: GPL-3.0-or-later
"""The same surface with more triangles: every triangle divided evenly in its own plane, and spheres."""

from itertools import combinations

import numpy as np

from synch_fields.core.geometry import TriangleMesh


def subdivided(mesh, parts):
    """Every edge in ``parts`` equal parts and every triangle in ``parts`` squared; nothing is smoothed.

    Two parts are 4:1 midpoint subdivision, four parts are two rounds of it.
    """
    # Points of one triangle by their weights (i, j, k) / parts; those on an edge belong to both its triangles.
    grid = np.array([(parts - j - k, j, k) for j in range(parts + 1) for k in range(parts + 1 - j)])
    names = _point_names(mesh, grid, parts)
    places = np.einsum("pc,tcx->tpx", grid / parts, mesh.vertices[mesh.triangles])
    _, first, points = np.unique(names.ravel(), return_index=True, return_inverse=True)
    points = points.reshape(names.shape)
    small = points[:, _small_triangles(parts)]
    return TriangleMesh(places.reshape(-1, 3)[first], small.reshape(-1, 3))


def _point_names(mesh, grid, parts):
    """(m, p) one number for each point: corners, then points on edges, then those inside."""
    names = np.empty((mesh.triangle_count, len(grid)), np.int64)
    edges_from = mesh.vertex_count
    inside_from = edges_from + len(mesh.edges) * parts
    for column, weights in enumerate(grid):
        filled = np.flatnonzero(weights)
        if len(filled) == 1:
            names[:, column] = mesh.triangles[:, filled[0]]
        elif len(filled) == 2:
            # Half-edge k runs from corner k; the last one back to corner 0.
            corner = filled[0] if filled[1] == filled[0] + 1 else filled[1]
            passed = parts - weights[corner]
            passed = np.where(mesh.triangle_edge_signs[:, corner] > 0, passed, parts - passed)
            names[:, column] = edges_from + mesh.triangle_edges[:, corner] * parts + passed
        else:
            names[:, column] = inside_from + np.arange(mesh.triangle_count) * len(grid) + column
    return names


def _small_triangles(parts):
    """(parts squared, 3) columns of the grid, wound like the triangle."""
    starts = np.concatenate([[0], np.cumsum(np.arange(parts + 1, 0, -1))])
    small = []
    for j in range(parts):
        for k in range(parts - j):
            here, above = starts[j] + k, starts[j + 1] + k
            small.append((here, above, here + 1))
            if k + 1 < parts - j:
                small.append((above, above + 1, here + 1))
    return np.array(small)


def sphere(parts):
    """A sphere of unit area with 10 parts² + 2 vertices, from the icosahedron."""
    golden = (1 + np.sqrt(5)) / 2
    corners = np.array([(0, a, b * golden) for a in (-1, 1) for b in (-1, 1)])
    corners = np.concatenate([np.roll(corners, shift, axis=1) for shift in range(3)])
    distances = np.linalg.norm(corners[:, None] - corners, axis=2)
    near = np.isclose(distances, 2)
    triangles = [(a, b, c) for a, b, c in combinations(range(12), 3) if near[a, b] and near[b, c] and near[a, c]]
    outward = [np.linalg.det(corners[list(triangle)]) > 0 for triangle in triangles]
    triangles = [t if out else t[::-1] for t, out in zip(triangles, outward, strict=True)]
    mesh = subdivided(TriangleMesh(corners, np.array(triangles)), parts)
    directions = mesh.vertices / np.linalg.norm(mesh.vertices, axis=1)[:, None]
    return TriangleMesh(directions / np.sqrt(4 * np.pi), mesh.triangles)
