# SPDX-License-Identifier: GPL-3.0-or-later
"""The metric A = L + shift M in which descent and certificate measure, and sparse factorizations."""

import numpy as np
from scipy.sparse import diags_array
from scipy.sparse.linalg import splu

from ..errors import SynchError

# Share of the stiffness below which a shift drowns in single precision.
SMALLEST_SHIFT = 1e-6


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


class Factorization:
    """Solves with a positive definite sparse matrix for all columns at once, in single precision."""

    def __init__(self, matrix):
        self._lu = factorize(matrix)
        self._dtype = np.complex64 if np.iscomplexobj(matrix.data) else np.float32

    def solve(self, columns):
        """(N, k) or (N,) right-hand sides; the result has their dtype."""
        return self._lu.solve(np.asfortranarray(columns, dtype=self._dtype)).astype(columns.dtype, order="C")


class Metric(Factorization):
    """A = L + shift M with its inverse.

    The shift makes the matrix definite; at a small share of the mean energy per mass it hardly
    changes the metric.
    """

    def __init__(self, piece, shift):
        shift = max(shift, SMALLEST_SHIFT * piece.stiffness)
        self.shift = shift
        self.matrix = (piece.matrix + diags_array(shift * piece.row_mass)).tocsr()
        super().__init__(self.matrix)


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
