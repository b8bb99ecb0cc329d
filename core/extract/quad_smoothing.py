# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad meshes smoothed on the surface that they were traced on."""

from dataclasses import replace

import numpy as np

from ..errors import SettingError
from ..geometry.nearest import NearestTriangles

# Shares of the way to the middle of its neighbours that a vertex moves at once, forth and back: uneven places are
# smoothed, and little shrinks (after Taubin 1995).
_STEPS = 0.5, -0.4
# A vertex nearer than this to a mirror plane, as a share of the object's size, lies on it.
_ON_PLANE = 1e-5
# Cosine of the angle between the normals of neighbours beyond which both stay where they are: rims keep their shape.
_SHARP = 0.5
# A vertex of the quad mesh nearer to an edge than this, as a barycentric coordinate, lies on it.
_ON_EDGE = 1e-3


def smoothed(quads, mesh, rows, planes, rounds):
    """Vertices moved towards the middle of their neighbours and back onto the surface.

    Those on the boundary, on lines that were asked for, on mirror planes and at sharp edges stay there.

    Parameters
    ----------
    quads : QuadMesh
    mesh : TriangleMesh that it was traced on
    rows : Rows of the constraint list; those of phases hold the vertices on their lines
    planes : (3,) normals of mirror planes through the origin, of any length
    rounds : how often

    Raises
    ------
    SettingError
        for a pattern without any face, one whose faces would meet themselves, and one that loses a handle
    """
    if len(quads.sizes) == 0:
        raise SettingError("no grid lines cross on the mesh: reduce the spacing")
    if not quads.is_simple:
        raise SettingError("the quads are too large for the mesh, some would meet themselves: reduce the spacing")
    if not mesh.boundary_vertices.any() and quads.euler_characteristic > mesh.euler_characteristic:
        raise SettingError("the quads are too large for the mesh, a handle of it would be lost: reduce the spacing")
    edges, counts = quads.edges
    free = ~_on_lines(quads, mesh, rows)
    free[edges[counts == 1]] = False
    for normal in planes:
        heights = quads.vertices @ normal
        free &= np.abs(heights) > _ON_PLANE * np.ptp(quads.vertices, axis=0).max() * np.linalg.norm(normal)
    normals = mesh.face_normals[quads.triangles]
    free[edges[np.einsum("ij,ij->i", normals[edges[:, 0]], normals[edges[:, 1]]) < _SHARP]] = False
    surface = NearestTriangles(mesh.vertices, mesh.triangles)
    degrees = np.bincount(edges.ravel(), minlength=len(quads.vertices))[:, None]
    for _ in range(rounds):
        for step in _STEPS:
            sums = np.zeros_like(quads.vertices)
            np.add.at(sums, edges[:, 0], quads.vertices[edges[:, 1]])
            np.add.at(sums, edges[:, 1], quads.vertices[edges[:, 0]])
            moved = quads.vertices + step * (sums / degrees - quads.vertices)
            quads = _moved(quads, mesh, free, *surface.nearest(moved[free]))
    return quads


def _on_lines(quads, mesh, rows):
    """(n,) bool: vertices on edges or at vertices of rows that ask for a grid line."""
    held = np.zeros(mesh.vertex_count, bool)
    for row in rows:
        if row.is_of_phases:
            held[row.line.nodes] = True
    return (held[mesh.triangles[quads.triangles]] | (quads.weights < _ON_EDGE)).all(axis=1)


def _moved(quads, mesh, which, places, triangles):
    """The quad mesh with some vertices at other places of the surface."""
    weights = barycentric(mesh, triangles, places)
    result = replace(quads, **{n: getattr(quads, n).copy() for n in ("vertices", "triangles", "weights")})
    result.vertices[which], result.triangles[which], result.weights[which] = places, triangles, weights
    return result


def barycentric(mesh, triangles, places):
    """(k, 3) barycentric coordinates of places in the planes of triangles, negative beyond a side."""
    corners = mesh.vertices[mesh.triangles[triangles]]
    normals = mesh.face_normals[triangles]
    weights = np.stack([_double_areas(places, corners[:, k - 2], corners[:, k - 1], normals) for k in range(3)], axis=1)
    sums = weights.sum(axis=1, keepdims=True)
    return np.divide(weights, sums, out=np.full_like(weights, 1 / 3), where=sums > 0)


def _double_areas(a, b, c, normals):
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), normals)
