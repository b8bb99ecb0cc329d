# SPDX-License-Identifier: GPL-3.0-or-later
"""Lower bounds on the optimum, from the dual of the semidefinite relaxation (Eqs. 22, 23).

With lambda_i = Re<Y_i, (L Y)_i> the slack is S = L - diag(lambda). If S + t A is positive
semidefinite for A = L + shift M, then (lambda - t shift m) / (1 + t) is feasible for the dual, since

    L - diag(lambda - t shift m) / (1 + t) = (S + t A) / (1 + t),

and its sum bounds the optimum of (22), hence of (18), from below. Measuring the slack in A rather than
in M makes the loss relative: it is about t times the energy, where a localized negative direction
of S would cost the M-bound the whole domain's mass.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import LinAlgError, eigh
from scipy.sparse import diags_array

from ..errors import SynchError
from .factorization import front_width, is_positive_definite

# A factorization in double precision is tried as a proof up to this many rows, and rows of a front, of complex numbers
# (True) or of real ones: some ten seconds.
LARGEST_PROOF, WIDEST_PROOF = 400_000, {True: 1_000, False: 1_600}
# In solids, whose fronts have more nodes than this many roots of all nodes (on surfaces up to 3.8 were seen), no order
# of elimination is much better than a sweep: a proof takes as long as about rows * width^2 / (25 nnz) products of L
# with all columns (measured, within a factor of 2, from 6k to 30k rows), against some 400 for the relaxation. It is
# tried up to a thousand.
SURFACE_FRONT, LONGEST_SWEEP = 4.0, 25_000
# Rounding of a row in a factorization, in units of the diagonal's last digit: so many for each row of a front.
ROUNDINGS = 4
# Rows up to which the space that is searched for negative directions is kept in double precision.
DOUBLE_BASIS = 50_000
# Size of that space, and the error at which a direction is as good as exact.
SEARCH_STEPS = 40
CONVERGED = 1e-6


@dataclass(frozen=True)
class Slack:
    """The most negative directions of S relative to A, from a search space.

    ``depth`` is the estimate of the smallest t with S >= -t A, ``error`` the distance to an eigenvalue
    by its residual, ``directions`` (N, k) the directions below zero, most negative first.
    """

    depth: float
    error: float
    directions: np.ndarray


def lower_bound(piece, metric, duals, depth):
    """Value of the dual point that is feasible when S + depth A is positive semidefinite."""
    return float(((duals - depth * metric.shift * piece.mass) / (1 + depth)).sum())


def depth_for_bound(piece, metric, duals, bound):
    """The depth at which :func:`lower_bound` is ``bound``."""
    return float((duals.sum() - bound) / (bound + metric.shift * piece.mass.sum()))


def measure_slack(workspace, metric, duals, random, monitor, enough=-np.inf, count=2):
    """Most negative directions of S relative to A, by a generalized Davidson method.

    With W = A - S, a diagonal, these are the largest eigenvalues of W x = mu A x, mu = 1 + depth. The space
    grows by the preconditioned residual of the best direction; with an exact inverse it is the Krylov space
    of Lanczos. A fixed number of steps: the spectrum is dense near mu = 1, where the null space of S
    lies, so that waiting for a converged eigenvector would be in vain. A proof does not rest on it.

    Parameters
    ----------
    workspace : Workspace
    metric : Metric of the piece
    duals : (nodes,) lambda
    random : numpy Generator
    monitor : Monitor
    enough : depth plus error below which the search may end after half its steps
    count : directions to return at most
    """
    piece = workspace.piece
    size = piece.matrix.shape[0]
    matrix = workspace.matrix if size <= DOUBLE_BASIS else workspace.stages[0].matrix
    real = np.finfo(matrix.dtype).dtype
    steps = min(SEARCH_STEPS, size - len(piece.unused_rows))
    shift = (metric.shift * piece.row_mass).astype(real)
    weight = np.repeat(duals, piece.block).astype(real) + shift
    basis = np.empty((steps, size), matrix.dtype)
    weighted, measured = np.zeros((2, steps, steps), matrix.dtype)
    vector = random.standard_normal(size).astype(matrix.dtype)
    vector[piece.unused_rows] = 0
    vector = metric.solve(weight * vector)
    for step in range(steps):
        monitor.check()
        vector -= _inner(basis[:step], matrix @ vector + shift * vector) @ basis[:step]
        image = matrix @ vector + shift * vector
        length = np.sqrt(np.vdot(vector, image).real)
        if not length > 0:
            break
        basis[step] = vector / length
        filled = step + 1
        for products, other in ((weighted, weight * basis[step]), (measured, image / length)):
            products[:filled, step] = _inner(basis[:filled], other)
            products[step, :filled] = products[:filled, step].conj()
        try:
            values, combinations = eigh(weighted[:filled, :filled], measured[:filled, :filled])
        except LinAlgError:  # in single precision the new direction may lie among the others
            break
        best = combinations[:, -1] @ basis[:filled]
        residual = weight * best - values[-1].astype(real) * (matrix @ best + shift * best)
        vector = metric.solve(residual)
        error = np.sqrt(max(np.vdot(residual, vector).real, 0.0))
        if error < CONVERGED or (2 * filled >= steps and max(values[-1] - 1, 0) + error <= enough):
            break
    order = np.argsort(values)[::-1][:count]
    directions = combinations[:, order].T @ basis[: len(values)]
    return Slack(float(values[-1] - 1), float(error), directions[values[order] > 1].T)


def _inner(vectors, other):
    """(k,) inner products of (k, N) vectors with another one, without a conjugated copy of them."""
    return (vectors @ other.conj()).conj()


def provable_width(piece):
    """Rows of the widest front if a proof by factorization is affordable, otherwise None."""
    if piece.matrix.shape[0] > LARGEST_PROOF:
        return None
    rows, width = piece.matrix.shape[0], front_width(piece.matrix)
    is_solid = width / piece.block > SURFACE_FRONT * np.sqrt(piece.node_count)
    if is_solid and rows * width**2 > LONGEST_SWEEP * piece.matrix.nnz:
        return None
    return width if width <= WIDEST_PROOF[piece.is_complex] else None


def prove(piece, metric, duals, depth, width):
    """Whether S + depth A is positive definite, by the inertia of a factorization in double precision.

    What rounding may hide is taken off the diagonal first: it grows with the entries that were summed for a row of
    L, and with the length of a factor's column, at most the ``width`` of the fronts.
    """
    diagonal = depth * metric.shift * piece.row_mass - np.repeat(duals, piece.block)
    hidden = np.finfo(float).eps * (np.diff(piece.matrix.indptr) + ROUNDINGS * width)
    diagonal = diagonal - hidden * piece.matrix.diagonal().real
    try:
        return is_positive_definite(piece.matrix * (1 + depth) + diags_array(diagonal))
    except SynchError:  # no memory for it
        return False
