# SPDX-License-Identifier: GPL-3.0-or-later
"""Spectral relaxation: the smallest eigenvector of (L, M), normalized (Eqs. 19, 20)."""

import numpy as np
from scipy.sparse import diags_array
from scipy.sparse.linalg import LinearOperator, eigsh

from .factorization import factorize
from .metric import SMALLEST_SHIFT


def smallest_eigenpair(piece, seed):
    """Smallest generalized eigenvalue of (L, M) and its (N,) eigenvector, by shift-inverted Lanczos.

    ``piece.mass.sum() * eigenvalue`` is the spectral lower bound of Eq. (23).
    """
    size = piece.matrix.shape[0]
    mass = diags_array(piece.row_mass).tocsr()
    if size < 16:
        return _dense_eigenpair(piece)
    shift = SMALLEST_SHIFT * piece.stiffness
    lu = factorize(piece.matrix + shift * mass, single=False)
    dtype = piece.matrix.dtype
    inverse = LinearOperator((size, size), matvec=lambda x: lu.solve(x.astype(dtype)), dtype=dtype)
    start = np.random.default_rng(seed).standard_normal(size).astype(dtype)
    start[piece.unused_rows] = 0
    values, vectors = eigsh(piece.matrix, k=1, M=mass, sigma=-shift, OPinv=inverse, v0=start, tol=1e-9)
    return max(float(values[0]), 0.0), vectors[:, 0]


def _dense_eigenpair(piece):
    root = np.sqrt(piece.row_mass)
    values, vectors = np.linalg.eigh(piece.matrix.toarray() / root[:, None] / root)
    return max(float(values[0]), 0.0), vectors[:, 0] / root
