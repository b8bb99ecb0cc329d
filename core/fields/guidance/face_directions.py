# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions in faces as complex numbers, and their maps to and from the vertices' tangent planes.

In a face, angles count counterclockwise from its first half-edge. A corner's share of the rescaled tangent plane of its
vertex is that corner opened or closed about its bisector: a direction keeps its angle to the bisector. This is exact
where the surface is flat, and needs no projection where it is not.
"""

import numpy as np

from ...geometry.triangle_mesh import TriangleMesh
from ...unit_vectors import unit_vectors


def face_frames(mesh: TriangleMesh) -> tuple[np.ndarray, np.ndarray]:
    """Two (m, 3) arrays: the direction of angle 0 in each face, and a quarter turn counterclockwise."""
    a, b = mesh.vertices[mesh.triangles[:, 0]], mesh.vertices[mesh.triangles[:, 1]]
    x = unit_vectors(b - a)
    return x, np.cross(mesh.face_normals, x)


def face_gradients(edges: np.ndarray, corner_values: np.ndarray) -> np.ndarray:
    """(m,) complex, area times the gradient of the linear functions with (m, 3) corner values.

    The product stays finite in a triangle without area. ``edges`` are :attr:`TriangleMesh.plane_half_edges`.
    """
    second, third = (corner_values[:, 1:] - corner_values[:, :1]).T
    return 0.5j * (second * edges[:, 2] + third * edges[:, 0])


def sum_at_vertices(mesh: TriangleMesh, face_values: np.ndarray, symmetry: int) -> np.ndarray:
    """(n,) complex, the sum over each vertex's faces of (m,) complex powers, in the vertex's tangent plane."""
    totals = np.zeros(mesh.vertex_count, complex)
    np.add.at(totals, mesh.triangles, np.exp(1j * symmetry * corner_turns(mesh)) * face_values[:, None])
    return totals


def average_in_faces(mesh: TriangleMesh, vertex_values: np.ndarray, symmetry: int) -> np.ndarray:
    """(m,) complex, the mean over each face's corners of (n,) complex powers, in the face's plane."""
    return (np.exp(-1j * symmetry * corner_turns(mesh)) * vertex_values[mesh.triangles]).mean(axis=1)


def corner_turns(mesh: TriangleMesh) -> np.ndarray:
    """(m, 3) difference of a direction's angle in the tangent plane of each corner's vertex and in the face."""
    ends = mesh.edge_directions[mesh.triangle_edges]
    at_vertex = np.where(mesh.triangle_edge_signs > 0, ends[..., 0], ends[..., 1])
    return at_vertex - mesh.half_edge_angles + 0.5 * (mesh.scaled_angles - mesh.corner_angles)
