# SPDX-License-Identifier: GPL-3.0-or-later
"""Sparse factorizations of positive definite matrices, for the smallest level, spectral relaxation and proofs."""

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import breadth_first_order, connected_components, reverse_cuthill_mckee
from scipy.sparse.linalg import SuperLU, splu

from ..errors import SynchError
from ..graphs import fronts
from .coarsening import hubs


def factorize(matrix: csr_matrix, single: bool = True) -> SuperLU:
    """Factorize a positive definite sparse matrix without row exchanges.

    Single precision (for preconditioning) takes half the memory and time of double. Panels of one column are a
    tenth to a third faster here than SuperLU's default. A SynchError reports a lack of memory.
    """
    precision = {True: (np.complex64, np.float32), False: (np.complex128, np.float64)}[single]
    dtype = precision[0] if np.iscomplexobj(matrix.data) else precision[1]
    try:
        return splu(
            matrix.astype(dtype).tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            panel_size=1,
            options={"SymmetricMode": True},
        )
    except MemoryError as error:
        raise SynchError(
            f"no memory for a factorization of {matrix.shape[0]} unknowns: solve a coarser mesh, or its parts"
        ) from error


def solve_definite(matrix: csr_matrix, right: np.ndarray) -> np.ndarray:
    """Solve a system with a positive definite sparse matrix, (n, n), and (n,) right sides, in double precision."""
    order = near_order(matrix)
    result = np.empty_like(right)
    result[order] = factorize(matrix[order][:, order], single=False).solve(right[order])
    return result


def near_order(matrix: csr_matrix) -> np.ndarray:
    """Order the rows of a symmetric matrix so that neighbours are near one another, (n,) indices.

    SuperLU finds its own order from this one much faster than from the order of vertices or faces in some files.
    """
    return reverse_cuthill_mckee(matrix, symmetric_mode=True)


def front_width(matrix: csr_matrix) -> int:
    """Compute the largest front of a breadth-first sweep, with the cube of which the cost of a factorization grows.

    About 2 sqrt(n) on surfaces and n^(2/3) in solids. Hubs, which are eliminated last, are part of every front.
    """
    kept = np.flatnonzero(~hubs(matrix))
    pattern = csr_matrix((np.ones(matrix.nnz, np.int8), matrix.indices, matrix.indptr), shape=matrix.shape)
    if len(kept) < matrix.shape[0]:
        pattern = pattern[kept][:, kept]
    labels = connected_components(pattern, directed=False)[1]
    seen, firsts = np.unique(labels, return_index=True)
    sizes = np.bincount(labels)
    widest = 1
    for label in seen[np.argsort(-sizes)]:
        if sizes[label] <= widest:
            break
        widest = max(widest, _widest_front(pattern, firsts[label]))
    return widest + matrix.shape[0] - len(kept)


def _widest_front(pattern: csr_matrix, node: int) -> int:
    """Compute the largest front of a sweep through the node's component, from a node far from it."""
    far = breadth_first_order(pattern, node)[0][-1]
    return int(np.diff(fronts(pattern, far)[1]).max())


def is_positive_definite(matrix: csr_matrix) -> bool:
    """Check in double precision whether a Hermitian sparse matrix is positive definite, by the signs of its pivots.

    The pivots of a factorization without exchanges are those of L D L^H, and their signs give the inertia (Sylvester).
    """
    try:
        lu = factorize(matrix, single=False)
    except RuntimeError:  # an exactly singular pivot
        return False
    return has_positive_pivots(lu)


def has_positive_pivots(lu: SuperLU) -> bool:
    """Check whether a factorization of a Hermitian matrix shows it to be positive definite."""
    if not np.array_equal(lu.perm_r, lu.perm_c):
        return False  # SuperLU exchanged rows: the diagonal pivot was zero
    return bool((lu.U.diagonal().real > 0).all())
