# SPDX-License-Identifier: GPL-3.0-or-later
"""Distance inside a solid by front propagation (Fu, Kirby and Whitaker 2013, "A Fast Iterative Method for Solving the
Eikonal Equation on Tetrahedral Domains"), as :mod:`.fronts` explains."""

from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from ...geometry.tet_mesh import TetMesh
from ...interpolate_solid import FACE_CORNERS
from .fronts import UNKNOWN, along, chosen_vertices, dot, propagate_distances


def solid_distance(mesh: TetMesh, sources: ArrayLike) -> np.ndarray:
    """(n,) lengths of the shortest ways inside the solid to the nearest of (n,) bool sources, scene units.

    They are 0 on faces between three sources, and nan on pieces without a source and on loose vertices.

    Raises :class:`SettingError` for a set that is empty or of another length.
    """
    is_source = chosen_vertices(mesh, sources, "group of sources")
    return propagate_distances(mesh.tets, mesh.edges, mesh.edge_lengths.mean(), is_source, partial(_arrivals, mesh))


def _arrivals(mesh: TetMesh, distances: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """(k,) distances at corners, rows 4 tet + corner, over the opposite faces; unknown where these are farther away."""
    tets, corners = np.divmod(rows, 4)
    target = mesh.tets[tets, corners]
    face = mesh.tets[tets[:, None], FACE_CORNERS[corners]]
    nearer = distances[face].min(axis=1) < distances[target]
    result = np.full(len(rows), UNKNOWN)
    result[nearer] = _over_faces(
        distances[face[nearer]], mesh.vertices[face[nearer]] - mesh.vertices[target[nearer], None]
    )
    return result


def _over_faces(values: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(k,) distances at the origin over (k, 3, 3) triangles on which they are linear, (k, 3) at the corners."""
    one, two = points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]
    gram = np.array([dot(one, one), dot(one, two), dot(two, two)])
    scale = gram[0] * gram[2] - gram[1] ** 2
    slopes = values[:, 1:].T - values[:, 0]
    # Solutions with the Gram matrix: the projection of the target, and the slope of the distance.
    foot = np.array([-dot(one, points[:, 0]), -dot(two, points[:, 0])])
    shares, steepness = _solve_at(gram, scale, foot), _solve_at(gram, scale, slopes)
    height = np.maximum(dot(points[:, 0], points[:, 0]) - (foot * shares).sum(axis=0), 0)
    slack = 1 - np.minimum((slopes * steepness).sum(axis=0), 2)
    through = shares - np.sqrt(height / np.where(slack > 0, slack, 1)) * steepness
    inside = (slack > 0) & (through >= 0).all(axis=0) & (through.sum(axis=0) <= 1)
    result = values[:, 0] + (slopes * shares).sum(axis=0) + np.sqrt(height * np.maximum(slack, 0))
    rim = np.flatnonzero(~inside)
    sides = [along(points[rim, k - 1], points[rim, k], values[rim, k - 1], values[rim, k]) for k in range(3)]
    result[rim] = np.minimum.reduce(sides)
    return result


def _solve_at(gram: np.ndarray, scale: np.ndarray, right: np.ndarray) -> np.ndarray:
    solution = np.array([gram[2] * right[0] - gram[1] * right[1], gram[0] * right[1] - gram[1] * right[0]])
    solution /= scale
    return solution
