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
from scipy.sparse import diags_array
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh

from .metric import is_positive_definite

# Above this many rows a factorization in double precision is not tried as a proof.
LARGEST_PROOF = 400_000


@dataclass(frozen=True)
class Slack:
    """The most negative direction of S relative to A: S >= -depth A, up to ``error``."""

    depth: float
    error: float
    direction: np.ndarray


def multipliers(spheres, point, image):
    """(nodes,) lambda_i = Re<Y_i, (L Y)_i> of a lifted field."""
    return spheres.node_products(point, image)[:, 0]


def lower_bound(piece, metric, duals, depth):
    """Value of the dual point that is feasible when S + depth A is positive semidefinite."""
    return float(((duals - depth * metric.shift * piece.mass) / (1 + depth)).sum())


def measure_slack(piece, metric, duals, tolerance, random):
    """Most negative eigenvalue of S relative to A, by Lanczos on A^-1 (A - S).

    Returns a :class:`Slack`; ``error`` bounds the distance of ``-depth`` to an eigenvalue by the residual.
    """
    size = piece.matrix.shape[0]
    dtype = piece.matrix.dtype
    positive = np.repeat(duals, piece.block) + metric.shift * piece.row_mass
    start = random.standard_normal(size).astype(dtype)
    start[piece.unused_rows] = 0
    inverse = LinearOperator((size, size), matvec=metric.solve, dtype=dtype)
    try:
        values, vectors = eigsh(
            diags_array(positive.astype(dtype)).tocsr(),
            k=1,
            M=metric.matrix,
            Minv=inverse,
            which="LA",
            v0=start,
            tol=tolerance,
            ncv=min(24, size),
            maxiter=20,
        )
    except ArpackNoConvergence as failure:
        values, vectors = failure.eigenvalues, failure.eigenvectors
        if len(values) == 0:
            return Slack(np.inf, np.inf, start)
    vector = vectors[:, -1]
    image = metric.matrix @ vector
    residual = positive * vector - values[-1] * image
    size_squared = np.vdot(vector, image).real
    error = np.sqrt(max(np.vdot(residual, metric.solve(residual)).real, 0) / size_squared)
    return Slack(float(values[-1] - 1), float(error), vector)


def prove(piece, metric, duals, depth):
    """Whether S + depth A is positive definite, by the inertia of a factorization in double precision."""
    if piece.matrix.shape[0] > LARGEST_PROOF:
        return False
    diagonal = depth * metric.shift * piece.row_mass - np.repeat(duals, piece.block)
    return is_positive_definite(piece.matrix * (1 + depth) + diags_array(diagonal))
