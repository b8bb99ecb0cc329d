# SPDX-License-Identifier: GPL-3.0-or-later
"""Vectors that are given in a solid, such as principal stresses, in another solid that fills the same space."""

import numpy as np
from scipy.spatial import cKDTree

from ...geometry.tet_mesh import TetMesh
from ...graphs import components
from ...trees import along_trees

# Tetrahedra around a point, by their middles, among which the one that holds it best is taken; points at once.
_NEAR, _BATCH = 24, 20_000


def vectors_at(mesh, values, points):
    """(k, ...) values at points, linear in each tetrahedron; outside of the solid, those at its nearest side.

    Parameters
    ----------
    mesh : TetMesh
    values : (n, ...) at its vertices
    points : (k, 3)
    """
    tree = cKDTree(mesh.vertices[mesh.tets].mean(axis=1))
    near = min(_NEAR, mesh.tet_count)
    found = np.empty((len(points), *values.shape[1:]))
    for part in np.array_split(np.arange(len(points)), len(points) // _BATCH + 1):
        tets = tree.query(points[part], near)[1].reshape(len(part), near)
        offsets = points[part][:, None] - mesh.vertices[mesh.tets[tets, 0]]
        others = np.einsum("knix,knx->kni", mesh.hat_gradients[tets, 1:], offsets)
        weights = np.concatenate([1 - others.sum(axis=2, keepdims=True), others], axis=2)
        best = weights.min(axis=2).argmax(axis=1)
        rows = np.arange(len(part))
        held = np.maximum(weights[rows, best], 0)
        held /= held.sum(axis=1, keepdims=True)
        found[part] = np.einsum("ki,ki...->k...", held, values[mesh.tets[tets[rows, best]]])
    return found


def at_vertices(given):
    """(n, ...) values of :class:`core.files.solid_vectors.SolidVectors` at the solid's vertices."""
    return given.values if given.at_vertices else given.mesh.at_vertices(given.values)


def without_sign(vectors):
    """(k, 3, 3) matrices v v^T / |v| of vectors, whose means are those of lines."""
    lengths = np.linalg.norm(vectors, axis=1)
    return vectors[:, :, None] * (vectors / np.where(lengths > 0, lengths, 1)[:, None])[:, None]


def principal(matrices):
    """(k, 3) vectors of symmetric matrices along which these are largest, as long as that; of either sign."""
    values, vectors = np.linalg.eigh(matrices)
    return vectors[:, :, 2] * values[:, 2:]


def orient_vectors(mesh: TetMesh, lines):
    """(n, 3) vectors of either sign, turned to agree with their neighbours along the shortest ways from one in each
    piece; zero where they do not, around lines that come back to themselves turned over."""
    i, j = mesh.edges.T
    agree = np.where(np.einsum("ex,ex->e", lines[i], lines[j]) < 0, -1.0, 1.0)
    roots = np.unique(components(mesh.vertex_count, mesh.edges), return_index=True)[1]
    signs = along_trees(mesh.vertex_count, i, j, agree.astype(complex), roots).real
    turned = np.where(signs < 0, -1.0, 1.0)[:, None] * lines
    odd = np.einsum("ex,ex->e", turned[i], turned[j]) < 0
    turned[mesh.edges[odd]] = 0
    return turned
