# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's method: a staircase of Riemannian trust regions on products of spheres (Algorithm 1), by pymanopt.

A lifted field of r columns is one unit vector of 2 r real coordinates per node, which pymanopt knows
as the oblique manifold. In favour of the method the staircase starts at rank 2, products with L at the
current point are kept, and the negative direction comes from a factorization.
"""

from dataclasses import dataclass
from time import perf_counter

import numpy as np
import pymanopt
from pymanopt.manifolds import Oblique
from pymanopt.optimizers import TrustRegions
from scipy.sparse import diags_array
from scipy.sparse.linalg import eigsh

from synch_fields.bench.peers import Inverse, lowest_mode, normalize

FIRST_RANK, LAST_RANK = 2, 12
SMALLEST_GRADIENT = 1e-6
# The staircase ends where the most negative direction could lower the value by no larger share.
TARGET_GAP = 1e-3
# A column whose singular value is below this share of the largest is empty.
EMPTY = 1e-4
# Shift of the preconditioner as a share of the smallest eigenvalue of (L, M).
SHIFT = 0.1


@dataclass(frozen=True)
class PaperRun:
    """What the staircase reached.

    Attributes
    ----------
    value : of the relaxation (24)
    energy : of the field that SVD rounding gives
    rank : columns at the end
    seconds : until the staircase ended, or until the time was up
    capped : whether the time was up before
    history : list of (seconds, value) whenever the value fell
    """

    value: float
    energy: float
    rank: int
    seconds: float
    capped: bool
    history: list

    def seconds_to(self, value):
        """Seconds until the relaxation was at most ``value``; None if that never happened."""
        return next((seconds for seconds, reached in self.history if reached <= value), None)


class _TimeIsUp(Exception):
    pass


class _Relaxation:
    """Half of Re<Y, L Y> with its derivatives in pymanopt's layout, one column of coordinates per node."""

    def __init__(self, piece, seconds):
        self._piece, self._start, self._end = piece, perf_counter(), perf_counter() + seconds
        self._point, self._image = None, None
        self.best, self.history = None, []

    @property
    def seconds(self):
        return perf_counter() - self._start

    def rows(self, point):
        """(N, r) rows from (coordinates, nodes)."""
        rows = np.ascontiguousarray(point.T)
        return rows.view(complex) if self._piece.is_complex else rows.reshape(self._piece.matrix.shape[0], -1)

    def coordinates(self, rows):
        """The other way."""
        rows = np.ascontiguousarray(rows, dtype=self._piece.matrix.dtype)
        return np.ascontiguousarray(rows.view(float).reshape(self._piece.node_count, -1).T)

    def multiply(self, point):
        if perf_counter() > self._end:
            raise _TimeIsUp
        return self.coordinates(self._piece.matrix @ self.rows(point))

    def cost(self, point):
        value = float(np.vdot(point, self.gradient(point)))
        if not self.history or value < self.history[-1][1]:
            self.best = point
            self.history.append((self.seconds, value))
        return value / 2

    def gradient(self, point):
        if self._point is not point:
            self._point, self._image = point, self.multiply(point)
        return self._image

    def hessian(self, point, vector):
        return self.multiply(vector)


def staircase(piece, seed, seconds, preconditioned=False):
    """Climb from a random point until nothing is left to gain or so many ``seconds`` are over; returns a PaperRun."""
    relaxation = _Relaxation(piece, seconds)
    coordinates = piece.block * FIRST_RANK * (2 if piece.is_complex else 1)
    point = _unit(np.random.default_rng(seed).standard_normal((coordinates, piece.node_count)))
    inverse = _preconditioner(piece) if preconditioned else None
    capped = False
    try:
        for rank in range(FIRST_RANK, LAST_RANK + 1):
            point = _trust_regions(relaxation, point, inverse)
            singular = np.linalg.svd(relaxation.rows(point), compute_uv=False)
            if singular[-1] < EMPTY * singular[0] or rank == LAST_RANK:
                break
            depth, direction = _negative_direction(piece, relaxation, point)
            if depth * piece.mass.sum() <= TARGET_GAP * relaxation.history[-1][1]:
                break
            point = _climb(relaxation, point, direction)
    except _TimeIsUp:
        capped = True
    taken = relaxation.seconds
    rows = relaxation.rows(relaxation.best)
    energy = float(piece.energy(_round_by_svd(piece, rows))[0])
    return PaperRun(relaxation.history[-1][1], energy, rows.shape[1], taken, capped, relaxation.history)


def _unit(point):
    return point / np.linalg.norm(point, axis=0)


def _trust_regions(relaxation, point, inverse):
    manifold = Oblique(*point.shape)
    on_manifold = pymanopt.function.numpy(manifold)

    def precondition(at, vector):
        return manifold.projection(at, relaxation.coordinates(inverse(relaxation.rows(vector))))

    problem = pymanopt.Problem(
        manifold,
        on_manifold(lambda at: relaxation.cost(at)),
        euclidean_gradient=on_manifold(lambda at: relaxation.gradient(at)),
        euclidean_hessian=on_manifold(lambda at, vector: relaxation.hessian(at, vector)),
        preconditioner=None if inverse is None else precondition,
    )
    optimizer = TrustRegions(
        min_gradient_norm=SMALLEST_GRADIENT,
        max_time=np.inf,
        max_iterations=10**6,
        max_cost_evaluations=10**6,
        verbosity=0,
    )
    return optimizer.run(problem, initial_point=point).point


def _preconditioner(piece):
    """The inverse of L + shift M."""
    rate, _ = lowest_mode(piece)
    return Inverse(piece.matrix + diags_array(SHIFT * rate * piece.row_mass))


def _negative_direction(piece, relaxation, point):
    """How far the slack S = L - diag(lambda) is from positive, by mass, and the (N, 1) direction."""
    multipliers = np.einsum("cn,cn->n", point, relaxation.gradient(point))
    slack = piece.matrix - diags_array(np.repeat(multipliers, piece.block))
    below = -multipliers.sum() / piece.mass.sum()
    values, vectors = eigsh(slack, k=1, M=diags_array(piece.row_mass).tocsc(), sigma=below, which="LM", tol=1e-3)
    return -values[0], vectors / np.abs(vectors).max()


def _climb(relaxation, point, direction):
    """The direction as a new column, as long as that lowers the value most."""
    trials = (
        _unit(relaxation.coordinates(np.hstack([relaxation.rows(point), length * direction])))
        for length in 2.0 ** -np.arange(12)
    )
    return min(trials, key=relaxation.cost)


def _round_by_svd(piece, rows):
    """(N, 1) normalized dominant singular column (Section 4.5)."""
    _, directions = np.linalg.eigh(rows.conj().T @ rows)
    return normalize(piece, rows @ directions[:, -1:])
