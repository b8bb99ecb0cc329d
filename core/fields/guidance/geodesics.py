# SPDX-License-Identifier: GPL-3.0-or-later
"""Geodesic distance by the heat method (Crane, Weischedel, Wardetzky 2013, "Geodesics in Heat")."""

import numpy as np
from scipy.sparse import coo_matrix, diags_array

from ...algebra.factorization import factorize
from ...errors import SettingError
from ...geometry.intrinsic_delaunay import intrinsic_delaunay, side_angles
from .face_directions import face_gradients, half_edges

# The heat's reach, by the mean edge length: as long where edges are coarser than this share of a piece's
# extent, and longer than an edge by the root of their ratio where they are finer.
COARSE = 1 / 20


def geodesic_distance(mesh, sources):
    """Length of the shortest way on the surface to the nearest source.

    Heat spreads from the sources for a time t, its gradients are normalized, and the distance is the function that
    vanishes on the sources and whose gradient is nearest to them (Algorithm 1), on the intrinsic Delaunay
    triangulation. On a boundary the heat is the mean of no flow across it and zero on it. The mean error is
    less than half an edge on planes and spheres; near corners of the boundary it is a few edges.

    The time is t = h max(h, d / 20), with h the mean edge length of a connected piece and d the diagonal of its
    bounding box. The paper's t = h^2 does not let the distance converge: heat that falls by e along every edge
    follows the edges, however fine the mesh.

    Parameters
    ----------
    mesh : TriangleMesh
    sources : (n,) bool, vertices at distance 0

    Returns
    -------
    (n,) float, scene units; nan on pieces without a source and on loose vertices

    Raises
    ------
    SettingError
        for a set that is empty or of another length
    """
    sources = np.array(sources, bool)
    if sources.shape != (mesh.vertex_count,):
        raise SettingError(
            f"the sources have the shape {sources.shape} and the mesh has {mesh.vertex_count} vertices: "
            "give one truth value to each vertex"
        )
    sources[mesh.loose_vertices] = False
    if not sources.any():
        raise SettingError("no vertex with a face is among the sources: add at least one to the group")
    reached = np.isin(mesh.pieces, mesh.pieces[sources])
    triangles, lengths = intrinsic_delaunay(mesh)
    angles = side_angles(lengths)
    weights = np.roll(0.5 / np.tan(angles), 1, axis=1)
    tails, heads = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    stiffness = _stiffness(mesh.vertex_count, tails, heads, weights.ravel())
    heat = _spread_heat(mesh, stiffness, sources, reached)

    edges = half_edges(lengths, angles)
    gradients = face_gradients(edges, heat[triangles])
    sizes = np.abs(gradients)
    away = np.divide(-gradients, sizes, out=np.zeros_like(gradients), where=sizes > 0)
    rises = (weights * (away.conj()[:, None] * edges).real).ravel()
    divergence = np.bincount(heads, rises, mesh.vertex_count) - np.bincount(tails, rises, mesh.vertex_count)

    distances = np.where(reached, 0.0, np.nan)
    free = reached & ~sources
    distances[free] = np.maximum(_solve(stiffness, divergence, free), 0)
    return distances


def _stiffness(count, tails, heads, weights):
    """Laplacian matrix of weighted half-edges."""
    rows = np.concatenate([tails, heads, tails, heads])
    columns = np.concatenate([heads, tails, tails, heads])
    return coo_matrix((np.concatenate([-weights, -weights, weights, weights]), (rows, columns)), (count, count)).tocsr()


def _spread_heat(mesh, stiffness, sources, reached):
    """(n,) heat after one implicit step, zero where not reached."""
    matrix = (stiffness + diags_array(mesh.vertex_masses / _time_steps(mesh))).tocsr()
    heat = np.zeros(mesh.vertex_count)
    heat[reached] = _solve(matrix, sources.astype(float), reached)
    rim = mesh.boundary_vertices & ~sources
    if rim[reached].any():
        inner = reached & ~rim
        cooled = np.zeros(mesh.vertex_count)
        cooled[inner] = _solve(matrix, sources.astype(float), inner)
        heat = 0.5 * (heat + cooled)
    return heat


def _time_steps(mesh):
    """(n,) in squared scene units, the same all over a piece; 1 on loose vertices."""
    pieces = mesh.pieces
    piece_of_edge = pieces[mesh.edges[:, 0]]
    count = pieces.max() + 1
    edges = np.bincount(piece_of_edge, minlength=count)
    means = np.bincount(piece_of_edge, mesh.edge_lengths, count) / np.maximum(edges, 1)
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, pieces, mesh.vertices)
    np.maximum.at(high, pieces, mesh.vertices)
    steps = means * np.maximum(means, COARSE * np.linalg.norm(high - low, axis=1))
    return np.where(edges > 0, steps, 1.0)[pieces]


def _solve(matrix, values, chosen):
    """Solution on the chosen nodes of a positive definite system in which all others are zero."""
    nodes = np.flatnonzero(chosen)
    if len(nodes) == 0:
        return np.empty(0)
    return factorize(matrix[nodes][:, nodes], single=False).solve(values[nodes])
