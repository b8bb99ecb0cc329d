# SPDX-License-Identifier: GPL-3.0-or-later
"""Vectors given in a solid, such as principal stresses, in another solid that fills the same space."""

from typing import Protocol

import numpy as np
from scipy.spatial import cKDTree

from ...geometry.tet_mesh import TetMesh
from ...graphs import components
from ...trees import along_trees
from ...unit_vectors import unit_vectors

# Tetrahedra around a point, by their centres, among which the one that contains it best is chosen; points at once.
_NEAR, _BATCH = 24, 20_000


class SolidVectors(Protocol):
    """What guides need of a :class:`core.files.solid_vectors.SolidVectors`, which describes it."""

    @property
    def mesh(self) -> TetMesh: ...
    @property
    def values(self) -> np.ndarray: ...
    @property
    def at_vertices(self) -> bool: ...


def vectors_at(mesh: TetMesh, values: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(k, ...) values at points from (n, ...) values at vertices, linear in each tetrahedron; outside of the solid,
    those at its nearest side."""
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
        inside = np.maximum(weights[rows, best], 0)
        inside /= inside.sum(axis=1, keepdims=True)
        found[part] = np.einsum("ki,ki...->k...", inside, values[mesh.tets[tets[rows, best]]])
    return found


def line_matrices(vectors: np.ndarray) -> np.ndarray:
    """(k, 3, 3) matrices v v^T / |v| of vectors, whose means are those of lines."""
    return vectors[:, :, None] * unit_vectors(vectors)[:, None]


def principal_vectors(matrices: np.ndarray) -> np.ndarray:
    """(k, 3) eigenvectors of the largest eigenvalues of symmetric matrices, as long as these; of either sign."""
    values, vectors = np.linalg.eigh(matrices)
    return vectors[:, :, 2] * values[:, 2:]


def orient_vectors(mesh: TetMesh, lines: np.ndarray) -> np.ndarray:
    """(n, 3) vectors of either sign, oriented along shortest paths from one vertex in each piece; zero where neighbours
    still disagree, around lines that come back to themselves reversed."""
    i, j = mesh.edges.T
    agree = np.where(np.einsum("ex,ex->e", lines[i], lines[j]) < 0, -1.0, 1.0)
    roots = np.unique(components(mesh.vertex_count, mesh.edges), return_index=True)[1]
    signs = along_trees(mesh.vertex_count, i, j, agree.astype(complex), roots).real
    turned: np.ndarray = np.where(signs < 0, -1.0, 1.0)[:, None] * lines
    odd = np.einsum("ex,ex->e", turned[i], turned[j]) < 0
    turned[mesh.edges[odd]] = 0
    return turned
