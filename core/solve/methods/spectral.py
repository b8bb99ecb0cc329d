# SPDX-License-Identifier: GPL-3.0-or-later
"""Spectral relaxation: the smallest eigenvector of (L, M), normalized (Eqs. 19, 20)."""

import numpy as np
from scipy.sparse import diags_array
from scipy.sparse.linalg import LinearOperator, eigsh, lobpcg

from ...algebra.factorization import factorize
from ...algebra.metric import SMALLEST_SHIFT, Hierarchy, definite_metric
from ...algebra.multifrontal import Elimination
from ...piece import Piece
from .certificate import LARGEST_PROOF

# Vectors in a block of LOBPCG, steps at most, and the residual at convergence, at a mean diagonal and a mean mass of 1:
# it is small because phases count even where the vector is tiny.
BLOCK = 4
MAX_STEPS = 600
RESIDUAL = 1e-11
# Multiplications for each entry of the matrix up to which it is factorized by columns: surfaces need some 1,000, solids
# of 2,000 nodes 5,000.
LONGEST_FACTORIZATION = 5_000


def smallest_eigenpair(piece: Piece, seed: int) -> tuple[float, np.ndarray]:
    """Smallest generalized eigenvalue of (L, M) and its eigenvector, by shift-inverted Lanczos.

    Where a factorization takes too much, as in most solids, LOBPCG is used with the multigrid cycle as preconditioner.
    For frames of ``width`` columns it is the mean of as many eigenvalues, with their (N * width,) eigenvectors.
    ``piece.total_mass * eigenvalue`` is the spectral lower bound of Eq. (23).
    """
    values, vectors = _smallest_eigenpairs(piece, seed)
    order = np.argsort(values, kind="stable")[: piece.width]
    return max(float(values[order].mean()), 0.0), np.take(vectors, order, axis=1).ravel()


def _smallest_eigenpairs(piece: Piece, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """(c,) eigenvalues and (N, c) eigenvectors, among them the smallest."""
    size = piece.matrix.shape[0]
    mass = diags_array(piece.row_mass).tocsr()
    if size < 16:
        return _dense_eigenpair(piece)
    if not is_narrow(piece):
        return _by_multigrid(piece, seed)
    shift = SMALLEST_SHIFT * piece.stiffness
    lu = factorize(piece.matrix + shift * mass, single=False)
    dtype = piece.matrix.dtype
    inverse = LinearOperator((size, size), matvec=lambda x: lu.solve(x.astype(dtype)), dtype=dtype)
    start = np.random.default_rng(seed).standard_normal(size).astype(dtype)
    start[piece.unused_rows] = 0
    values, vectors = eigsh(piece.matrix, k=piece.width, M=mass, sigma=-shift, OPinv=inverse, v0=start, tol=1e-9)
    return values, vectors


def is_narrow(piece: Piece) -> bool:
    """Whether a factorization by columns, which is also applied many times, takes little time."""
    most = LONGEST_FACTORIZATION * piece.matrix.nnz
    is_short = piece.reductions.is_whole and piece.matrix.shape[0] <= LARGEST_PROOF
    return is_short and Elimination.of(piece.matrix, piece.block, most) is not None


def _dense_eigenpair(piece: Piece) -> tuple[np.ndarray, np.ndarray]:
    root = np.sqrt(piece.row_mass)
    values, vectors = np.linalg.eigh(piece.matrix.toarray() / root[:, None] / root)
    return values, vectors / root[:, None]


def _by_multigrid(piece: Piece, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """The smallest eigenpairs by LOBPCG with a multigrid preconditioner."""
    scaled, weight = piece.scaled()
    size, dtype = scaled.matrix.shape[0], scaled.matrix.dtype
    metric = definite_metric(Hierarchy(scaled.matrix, scaled.row_mass, scaled.block, scaled.ground), SMALLEST_SHIFT)
    inverse = LinearOperator((size, size), matvec=metric.solve, matmat=metric.solve, dtype=dtype)
    start = np.random.default_rng(seed).standard_normal((size, max(BLOCK, piece.width + 1))).astype(dtype)
    start[piece.unused_rows] = 0
    mass = diags_array(scaled.row_mass).tocsr()
    values, vectors = lobpcg(scaled.matrix, start, B=mass, M=inverse, tol=RESIDUAL, maxiter=MAX_STEPS, largest=False)
    return values * weight / piece.mass.mean(), vectors
