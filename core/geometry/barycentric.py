# SPDX-License-Identifier: GPL-3.0-or-later
"""Barycentric coordinates in the planes of triangles."""

import numpy as np

from ..unit_vectors import cross
from .triangle_mesh import TriangleMesh


def barycentric(mesh: TriangleMesh, triangles: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Compute (k, 3) barycentric coordinates of (k, 3) places in the planes of triangles, negative beyond a side."""
    corners = mesh.vertices[mesh.triangles[triangles]]
    normals = mesh.face_normals[triangles]
    # Twice the signed areas of the triangles of the place and two corners.
    sides = [cross(corners[:, k - 2] - places, corners[:, k - 1] - places) for k in range(3)]
    weights = np.stack([np.einsum("ij,ij->i", side, normals) for side in sides], axis=1)
    sums = weights.sum(axis=1, keepdims=True)
    return np.divide(weights, sums, out=np.full_like(weights, 1 / 3), where=sums > 0)
