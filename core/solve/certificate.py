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

from .metric import is_positive_definite

# Above this many rows a factorization in double precision is not tried as a proof.
LARGEST_PROOF = 400_000
LANCZOS_STEPS = 40
# Share of the matrix's diagonal by which a factorization in double precision may miss a negative pivot.
ROUNDING = 1e-14


@dataclass(frozen=True)
class Slack:
    """The most negative directions of S relative to A, from a Krylov space.

    ``depth`` is the estimate of the smallest t with S >= -t A, ``error`` the distance to an eigenvalue
    by its residual, ``directions`` (N, k) the directions below zero, most negative first.
    """

    depth: float
    error: float
    directions: np.ndarray


def multipliers(spheres, point, image):
    """(nodes,) lambda_i = Re<Y_i, (L Y)_i> of a lifted field."""
    return spheres.node_products(point, image)[:, 0]


def lower_bound(piece, metric, duals, depth):
    """Value of the dual point that is feasible when S + depth A is positive semidefinite."""
    return float(((duals - depth * metric.shift * piece.mass) / (1 + depth)).sum())


def depth_for_bound(piece, metric, duals, bound):
    """The depth at which :func:`lower_bound` is ``bound``."""
    return float((duals.sum() - bound) / (bound + metric.shift * piece.mass.sum()))


def measure_slack(piece, metric, duals, random, count=2):
    """Most negative directions of S relative to A, by Lanczos on A^-1 (A - S) in the metric A.

    A fixed number of steps with full orthogonalization: the top of that operator's spectrum is dense
    near 1, where the null space of S lies, so that waiting for a converged eigenvector would be
    in vain, while its largest Ritz value is soon good enough to choose t. A proof does not rest on it.
    """
    size = piece.matrix.shape[0]
    steps = min(LANCZOS_STEPS, size - len(piece.unused_rows))
    weight = np.repeat(duals, piece.block) + metric.shift * piece.row_mass
    basis = np.empty((steps, size), piece.matrix.dtype)
    images = np.empty_like(basis)
    vector = random.standard_normal(size).astype(basis.dtype)
    vector[piece.unused_rows] = 0
    for step in range(steps):
        for _ in range(2 if step else 0):  # twice is enough
            image = metric.matrix @ vector
            vector -= (basis[:step].conj() @ image) @ basis[:step]
        length = np.sqrt(np.vdot(vector, metric.matrix @ vector).real)
        if length < 1e-5 and step:
            basis, images = basis[:step], images[:step]
            break
        basis[step] = vector / length
        images[step] = weight * basis[step]
        vector = metric.solve(images[step])
    values, combinations = np.linalg.eigh(basis.conj() @ images.T)
    order = np.argsort(values)[::-1][:count]
    directions = combinations[:, order].T @ basis
    residual = weight * directions[0] - values[order[0]] * (metric.matrix @ directions[0])
    error = np.sqrt(max(np.vdot(residual, metric.solve(residual)).real, 0.0))
    return Slack(float(values[order[0]] - 1), float(error), directions[values[order] > 1].T)


def prove(piece, metric, duals, depth):
    """Whether S + depth A is positive definite, by the inertia of a factorization in double precision.

    What rounding may hide is taken off first: without it, a bound came out above the optimum where energies
    are 1e-12 of the weights.
    """
    if piece.matrix.shape[0] > LARGEST_PROOF:
        return False
    diagonal = depth * metric.shift * piece.row_mass - np.repeat(duals, piece.block)
    diagonal = diagonal - ROUNDING * piece.matrix.diagonal().real
    return is_positive_definite(piece.matrix * (1 + depth) + diags_array(diagonal))
