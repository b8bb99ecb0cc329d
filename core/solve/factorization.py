# SPDX-License-Identifier: GPL-3.0-or-later
"""Sparse factorizations of positive definite matrices: for the smallest level, spectral relaxation and proofs."""

import numpy as np
from scipy.sparse.linalg import splu

from ..errors import SynchError


def factorize(matrix, single=True):
    """Sparse factorization of a positive definite matrix without row exchanges.

    Single precision (for preconditioning) takes half the memory and time of double.
    """
    precision = {True: (np.complex64, np.float32), False: (np.complex128, np.float64)}[single]
    dtype = precision[0] if np.iscomplexobj(matrix.data) else precision[1]
    try:
        return splu(
            matrix.astype(dtype).tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
    except MemoryError as error:
        raise SynchError(
            f"no memory for a factorization of {matrix.shape[0]} unknowns: solve a coarser mesh, or its parts"
        ) from error


def is_positive_definite(matrix):
    """Whether a Hermitian sparse matrix is positive definite, by the signs of its pivots.

    The pivots of a factorization without exchanges are those of L D L^H, and their signs are the
    inertia (Sylvester). Computed in double precision.
    """
    try:
        lu = factorize(matrix, single=False)
    except RuntimeError:  # an exactly singular pivot
        return False
    if not np.array_equal(lu.perm_r, lu.perm_c):
        return False  # SuperLU exchanged rows: the diagonal pivot was zero
    pivots = lu.U.diagonal()
    return bool((pivots.real > 0).all())
