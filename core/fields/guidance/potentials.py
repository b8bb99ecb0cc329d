# SPDX-License-Identifier: GPL-3.0-or-later
"""Functions on a solid whose changes along the edges are nearest to given ones: Poisson's equation."""

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import coo_matrix, csr_matrix, diags_array
from scipy.sparse.linalg import LinearOperator, cg

from ...algebra.factorization import factorize
from ...algebra.metric import Hierarchy, definite_metric
from ...errors import SettingError, SynchError, name_elements
from ...geometry.tet_mesh import TetMesh
from ...graphs import components
from .fronts import chosen_vertices

# In solids the time of a factorization grows with the square of the unknowns: beyond this many, multigrid is faster.
LARGEST_FACTORIZED = 3000
# Makes the Laplacian, which is zero on constants, definite, as a share of its scale.
SMALL_SHIFT = 1e-6
PRECISION = 1e-12
MAX_STEPS = 400


def harmonic_function(mesh: TetMesh, low: ArrayLike, high: ArrayLike) -> np.ndarray:
    """(n,) the harmonic function that is 0 on one set of vertices and 1 on another, (n,) bool each.

    It is nan on pieces that neither set touches and on loose vertices.

    Raises :class:`SettingError` for sets that are empty or overlap.
    """
    low, high = chosen_vertices(mesh, low, "low group"), chosen_vertices(mesh, high, "high group")
    both = np.flatnonzero(low & high)
    if len(both):
        raise SettingError(
            f"{name_elements('vertex', both)} are in both groups of the harmonic function: take them out of one"
        )
    return extend_harmonically(mesh, low | high, high[low | high].astype(float))


def extend_harmonically(mesh: TetMesh, known: np.ndarray, values: np.ndarray) -> np.ndarray:
    """(n,) or (n, d) harmonic extension by linear elements, without flow through the boundary.

    The values, (k,) or (k, d), are given at (n,) bool known vertices; the result is nan on pieces without a known
    vertex and on loose vertices.
    """
    known = known.copy()
    known[mesh.loose_vertices] = False
    reached = np.isin(mesh.pieces, mesh.pieces[known])
    result = np.full((mesh.vertex_count, *np.shape(values)[1:]), np.nan)
    result[known] = values
    free = np.flatnonzero(reached & ~known)
    matrix = _laplacian(mesh, mesh.cotangent_weights)
    known = np.flatnonzero(known)
    right = -(matrix[free][:, known] @ result[known])
    result[free] = _solve_at(matrix, mesh.vertex_masses, free, right)
    return result


def potential(mesh: TetMesh, changes: np.ndarray, names: np.ndarray | None = None) -> np.ndarray:
    """(n,) the function whose changes along the edges are nearest to (e,) given ones, weighted; its least value is 0 on
    each connected piece.

    Vertices with the same of (n,) names, int from 0, have the same value.
    """
    i, j = mesh.edges.T
    flow = mesh.weights * changes
    sources = np.bincount(j, flow, mesh.vertex_count) - np.bincount(i, flow, mesh.vertex_count)
    matrix, masses = _laplacian(mesh, mesh.weights), mesh.vertex_masses
    names = np.arange(mesh.vertex_count) if names is None else names
    count = int(names.max(initial=-1)) + 1
    joined = csr_matrix((np.ones(len(names)), (np.arange(len(names)), names)), shape=(len(names), count))
    matrix = (joined.T @ matrix @ joined).tocsr()
    # A change between two vertices of the same name has no effect.
    pieces = np.full(count, -1)
    pieces[names] = components(count, names[mesh.edges])[names]
    free = np.ones(count, bool)
    free[np.unique(pieces, return_index=True)[1]] = False
    result = np.zeros(count)
    result[free] = _solve_at(matrix, joined.T @ masses, np.flatnonzero(free), (joined.T @ sources)[free])
    lowest = np.full(pieces.max(initial=-1) + 1, np.inf)
    np.minimum.at(lowest, pieces, result)
    result -= lowest[pieces]
    return result[names]


def _laplacian(mesh: TetMesh, weights: np.ndarray) -> csr_matrix:
    """(n, n) matrix of the energy sum of w_e (u_j - u_i)^2."""
    i, j = mesh.edges.T
    count = mesh.vertex_count
    beside = coo_matrix((weights, (i, j)), shape=(count, count))
    diagonal = np.bincount(i, weights, count) + np.bincount(j, weights, count)
    return (diags_array(diagonal) - beside - beside.T).tocsr()


def _solve_at(matrix: csr_matrix, masses: np.ndarray, nodes: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solution at (k,) nodes for (k,) or (k, d) right sides, zero at all others."""
    if len(nodes) == 0:
        return right
    matrix = matrix[nodes][:, nodes].tocsr()
    if len(nodes) <= LARGEST_FACTORIZED:
        return factorize(matrix, single=False).solve(right)
    scale, mass = matrix.diagonal().mean(), masses[nodes]
    metric = definite_metric(Hierarchy(matrix / scale, mass / mass.mean(), 1), SMALL_SHIFT)
    preconditioner = LinearOperator(matrix.shape, matvec=metric.solve)
    columns = right.reshape(len(right), -1) / scale
    result = np.zeros_like(columns)
    for column, solution in zip(columns.T, result.T, strict=True):
        solution[:], failed = cg(matrix / scale, column, rtol=PRECISION, maxiter=MAX_STEPS, M=preconditioner)
        if failed:
            raise SynchError(
                f"Poisson's equation on the solid's {len(nodes)} vertices did not converge: "
                "remove its flattest tetrahedra, or make it anew at another resolution"
            )
    return result.reshape(right.shape)
