# SPDX-License-Identifier: GPL-3.0-or-later
"""Functions on a solid whose changes along the edges are as near as can be to given ones: Poisson's equation."""

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, diags_array
from scipy.sparse.linalg import LinearOperator, cg

from ...algebra.factorization import factorize
from ...algebra.metric import Hierarchy, definite_metric
from ...errors import SettingError, SynchError, name_elements
from ...graphs import components
from .fronts import chosen_vertices

# In solids the time of a factorization grows with the square of the unknowns: from here on, multigrid is faster.
LARGEST_FACTORIZED = 3000
# What makes the Laplacian definite, which is zero on constants, as a share of its scale.
SMALL_SHIFT = 1e-6
PRECISION = 1e-12
MAX_STEPS = 400


def harmonic_function(mesh, low, high):
    """The function without sources that is 0 on one set of vertices and 1 on another.

    Parameters
    ----------
    mesh : TetMesh
    low, high : (n,) bool

    Returns
    -------
    (n,) float in [0, 1]; nan on pieces that neither set touches and on loose vertices

    Raises
    ------
    SettingError
        for sets that are empty or overlap
    """
    low, high = chosen_vertices(mesh, low, "low group"), chosen_vertices(mesh, high, "high group")
    both = np.flatnonzero(low & high)
    if len(both):
        raise SettingError(
            f"{name_elements('vertex', both)} are in both groups of the harmonic function: take them out of one"
        )
    return extend_harmonically(mesh, low | high, high[low | high].astype(float))


def extend_harmonically(mesh, known, values):
    """The harmonic extension of values at some vertices by linear elements, without flow through the boundary.

    Parameters
    ----------
    mesh : TetMesh
    known : (n,) bool
    values : (k,) or (k, d) at the known vertices

    Returns
    -------
    (n,) or (n, d); nan on pieces without a known vertex and on loose vertices
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


def potential(mesh, changes, names=None):
    """The function whose changes along the edges are nearest to given ones by the edges' weights.

    Parameters
    ----------
    mesh : TetMesh
    changes : (e,) from the lower to the higher vertex
    names : (n,) int from 0 up, vertices of the same name have one value; all their own if None

    Returns
    -------
    (n,) float, 0 at the lowest place of each connected piece
    """
    i, j = mesh.edges.T
    flow = mesh.weights * changes
    sources = np.bincount(j, flow, mesh.vertex_count) - np.bincount(i, flow, mesh.vertex_count)
    matrix, masses = _laplacian(mesh, mesh.weights), mesh.vertex_masses
    names = np.arange(mesh.vertex_count) if names is None else names
    count = names.max(initial=-1) + 1
    joined = csr_matrix((np.ones(len(names)), (np.arange(len(names)), names)), shape=(len(names), count))
    matrix = (joined.T @ matrix @ joined).tocsr()
    # A change between two vertices that are one does nothing.
    pieces = np.full(count, -1)
    pieces[names] = components(count, names[mesh.edges])[names]
    free = np.ones(count, bool)
    free[np.unique(pieces, return_index=True)[1]] = False
    result = np.zeros(count)
    result[free] = _solve_at(matrix, joined.T @ masses, np.flatnonzero(free), (joined.T @ sources)[free])
    lowest = np.full(pieces.max(initial=-1) + 1, np.inf)
    np.minimum.at(lowest, pieces, result)
    return (result - lowest[pieces])[names]


def _laplacian(mesh, weights):
    """(n, n) CSR: the energy sum of w_e (u_j - u_i)^2 as a matrix."""
    i, j = mesh.edges.T
    count = mesh.vertex_count
    beside = coo_matrix((weights, (i, j)), shape=(count, count))
    diagonal = np.bincount(i, weights, count) + np.bincount(j, weights, count)
    return (diags_array(diagonal) - beside - beside.T).tocsr()


def _solve_at(matrix, masses, nodes, right):
    """Solution on the given nodes of (k,) or (k, d) right sides, all others being zero."""
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
