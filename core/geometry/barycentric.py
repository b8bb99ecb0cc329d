# SPDX-License-Identifier: GPL-3.0-or-later
"""Barycentric coordinates in the planes of triangles."""

import numpy as np

from ..unit_vectors import cross
from .triangle_mesh import TriangleMesh


def barycentric(mesh: TriangleMesh, triangles: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Compute (k, 3) barycentric coordinates of (k, 3) places in the planes of triangles, negative beyond a side."""
    corners = mesh.vertices[mesh.triangles[triangles]]
    normals = mesh.face_normals[triangles]
    weights = np.stack([_double_areas(places, corners[:, k - 2], corners[:, k - 1], normals) for k in range(3)], axis=1)
    sums = weights.sum(axis=1, keepdims=True)
    return np.divide(weights, sums, out=np.full_like(weights, 1 / 3), where=sums > 0)


def _double_areas(a: np.ndarray, b: np.ndarray, c: np.ndarray, normals: np.ndarray) -> np.ndarray:
    return np.einsum("ij,ij->i", cross(b - a, c - a), normals)
