# SPDX-License-Identifier: GPL-3.0-or-later
"""Sparse factorizations of positive definite matrices, for the smallest level, spectral relaxation and curl."""

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.sparse.linalg import SuperLU, splu

from ..errors import SynchError


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


def has_positive_pivots(lu: SuperLU) -> bool:
    """Check whether a factorization of a Hermitian matrix shows it to be positive definite."""
    if not np.array_equal(lu.perm_r, lu.perm_c):
        return False  # SuperLU exchanged rows: the diagonal pivot was zero
    return bool((lu.U.diagonal().real > 0).all())
