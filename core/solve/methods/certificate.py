# SPDX-License-Identifier: GPL-3.0-or-later
"""Lower bounds on the optimum, from the dual of the semidefinite relaxation (Eqs. 22, 23).

With lambda_i = Re<Y_i, (L Y)_i>, of frames symmetric blocks, the slack is S = L - diag(lambda). If S + t A is positive
semidefinite for A = L + shift M, then (lambda - t shift m) / (1 + t) is feasible for the dual, since

    L - diag(lambda - t shift m) / (1 + t) = (S + t A) / (1 + t),

and its sum bounds the optimum of (22), hence of (18), from below. Measuring the slack in A rather than
in M makes the loss relative: it is about t times the energy, where a localized negative direction
of S would cost the M-bound the whole domain's mass.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh

from ...algebra.blocks import block_diagonal, on_rows, times, traces, with_diagonal
from ...algebra.metric import Metric
from ...algebra.multifrontal import Elimination, rounding_error
from ...algebra.products import Matrix
from ...algebra.reductions import Reductions
from ...memory import room
from ...monitor import Monitor
from ...piece import Piece
from .memory_estimate import elimination_bytes
from .stage import Workspace

# A factorization in double precision is tried as a proof up to these numbers of rows, and of multiplications for each
# entry of L: these take as long as the relaxation, and surfaces need some 1,000.
LARGEST_PROOF, LONGEST_ELIMINATION = 1_000_000, 25_000
# Allowance for rounding errors at first, in units of the diagonal's last digit, for each rounding of one term; how many
# allowances are tried, and how much larger than the error the second one is. Errors were 7 to 15 such units.
ROUNDINGS, ALLOWANCES, LARGER_ALLOWANCE = 16, 2, 1.1
# Rows up to which the search space for negative directions is kept in double precision.
DOUBLE_BASIS = 50_000
# Directions in that space at least and at most, and the error at which one counts as converged.
FEWEST_STEPS, MOST_STEPS = 20, 60
CONVERGED = 1e-6
# Share of the lifted field's square below which a principal column is negligible.
NEGLIGIBLE = 1e-6
# Largest overlap of a new vector with the others after it was made orthogonal to them: far from a singular space.
LARGEST_OVERLAP = 1e-2


@dataclass(frozen=True)
class Slack:
    """The most negative directions of S relative to A, from a search space.

    ``depth`` is the estimate of the smallest t with S >= -t A, ``error`` the distance to an eigenvalue
    by its residual, ``directions`` (N, k) the directions below zero, most negative first.
    """

    depth: float
    error: float
    directions: np.ndarray


def lower_bound(piece: Piece, shift: float, duals: np.ndarray, depth: float) -> float:
    """Value of the dual point that is feasible when S + depth A is positive semidefinite (Eqs. 22, 23)."""
    share = 1 / (1 + depth)
    return float(piece.reductions.sum((share * traces(duals) - (1 - share) * shift * piece.width * piece.mass).sum()))


def depth_for_bound(piece: Piece, shift: float, duals: np.ndarray, bound: float) -> float:
    """The depth at which :func:`lower_bound` is ``bound``."""
    return float((piece.reductions.sum(traces(duals).sum()) - bound) / (bound + shift * piece.total_mass))


def measure_slack(
    workspace: Workspace,
    shift: float,
    metric: Metric,
    point: np.ndarray,
    duals: np.ndarray,
    random: np.random.Generator,
    monitor: Monitor,
    enough: float = -np.inf,
    count: int = 2,
) -> Slack:
    """Most negative directions of S relative to A, by a generalized Davidson method.

    With W = A - S, a diagonal, these are the largest eigenvalues of W x = mu A x, mu = 1 + depth. Near the optimum S Y
    vanishes, so that the columns of Y have mu = 1 already; the search is orthogonal to them. The search space grows by
    the preconditioned residual of its best direction; with an exact inverse it is the Krylov space of Lanczos. The
    steps are few, since the spectrum is dense near mu = 1 and eigenvectors converge slowly. A negative direction may be
    missed: this is an estimate, on which no proof depends.

    Parameters
    ----------
    shift : of A
    metric : the preconditioner, best one near S
    point : (N, r) lifted field Y
    duals : (nodes,) lambda, or (nodes, d, d) of frames
    enough : depth plus error below which the search may end early
    count : directions to return at most
    """
    piece = workspace.piece
    size = piece.matrix.shape[0]
    matrix = workspace.matrix if size <= DOUBLE_BASIS else workspace.stages[0].matrix
    free = size - len(piece.unused_rows)
    steps = min(MOST_STEPS, free)
    masses = shift * piece.row_mass
    weight = with_diagonal(on_rows(duals, piece.block), masses)
    space = _Space(matrix, masses, weight, point.shape[1] + steps, piece.reductions)
    squares, rotation = eigh(piece.reductions.sum(point.conj().T @ point))
    for column in (point @ rotation[:, squares > NEGLIGIBLE * squares[-1]]).T:
        space.add(column)
    known = space.filled
    vector = random.standard_normal(len(point)).astype(matrix.dtype)
    vector[piece.unused_rows] = 0
    vector = metric.solve(times(space.weight, vector))
    for step in range(1, steps + 1):
        monitor.check()
        if not space.add(vector):
            break
        (value,), (direction,) = space.best(known, 1)
        residual = space.residual(value, direction)
        vector = metric.solve(residual)
        error = space.length(residual, vector)
        if error < CONVERGED or (step >= FEWEST_STEPS and max(value - 1, 0) + error <= enough):
            break
    if space.filled == known < free:  # rounding kept every vector out: nothing is known about the rest
        return Slack(0.0, np.inf, np.zeros((len(point), 0), matrix.dtype))
    (largest,), best = space.best(0, 1)
    values, directions = space.best(known, count)
    measure = workspace.stages[0].metric(shift)
    reach = []
    for value, direction in zip([largest, *values[:1]], [*best, *directions[:1]], strict=True):
        residual = space.residual(value, direction)
        reach.append(value + space.length(residual, measure.solve(residual)))
    return Slack(float(largest - 1), float(max(reach) - largest), directions[values > 1].T)


class _Space:
    """At most ``capacity`` vectors, orthogonal in A up to the precision of L, with W and A restricted to them.

    ``matrix`` is L, ``masses`` the (N,) diagonal of A - L, ``weight`` W, (N,) or in blocks.
    """

    def __init__(
        self, matrix: Matrix, masses: np.ndarray, weight: np.ndarray, capacity: int, reductions: Reductions
    ) -> None:
        real = np.finfo(matrix.dtype).dtype
        self._matrix, self._masses, self.weight = matrix, masses.astype(real), weight.astype(real)
        self._vectors = np.empty((capacity, len(masses)), matrix.dtype)
        self._weighted, self._measured = np.zeros((2, capacity, capacity), matrix.dtype)
        self._reductions, self.filled = reductions, 0

    def _apply(self, vector: np.ndarray) -> np.ndarray:
        return self._matrix @ vector + self._masses * vector

    def add(self, vector: np.ndarray) -> bool:
        """Add the part of a vector orthogonal to the others; False where it is lost in rounding."""
        vectors = self._vectors[: self.filled]
        vector = vector.astype(self._vectors.dtype)
        vector -= self._inner(vectors, self._apply(vector)) @ vectors
        image = self._apply(vector)
        square = self._reductions.sum(np.vdot(vector, image).real)
        if not square > 0:
            return False
        image /= np.sqrt(square)
        overlaps = self._inner(vectors, image)
        if np.linalg.norm(overlaps) > LARGEST_OVERLAP:
            return False
        added = self._vectors[self.filled] = vector / np.sqrt(square)
        self.filled += 1
        for seen, other in ((self._weighted, times(self.weight, added)), (self._measured, image)):
            seen[: self.filled, self.filled - 1] = self._inner(self._vectors[: self.filled], other)
            seen[self.filled - 1, : self.filled] = seen[: self.filled, self.filled - 1].conj()
        return True

    def best(self, start: int, count: int) -> tuple[np.ndarray, np.ndarray]:
        """The ``count`` largest mu in the space of the vectors from number ``start`` on, and directions in rows."""
        part = slice(start, self.filled)
        values, combinations = eigh(self._weighted[part, part], self._measured[part, part])
        return values[::-1][:count], combinations[:, ::-1][:, :count].T @ self._vectors[part]

    def residual(self, value: float, direction: np.ndarray) -> np.ndarray:
        """(W - mu A) times a direction."""
        return times(self.weight, direction) - self._masses.dtype.type(value) * self._apply(direction)

    def length(self, residual: np.ndarray, solved: np.ndarray) -> float:
        """Length of a residual in the inverse metric that solved it; infinite where that is not positive."""
        square = float(self._reductions.sum(np.vdot(residual, solved).real))
        return float(np.sqrt(square)) if square >= 0 else np.inf

    def _inner(self, vectors: np.ndarray, other: np.ndarray) -> np.ndarray:
        """(k,) inner products of (k, N) vectors with another one, without copying them."""
        return self._reductions.sum((vectors @ other.conj()).conj())


@dataclass(frozen=True)
class ProofPlan:
    """How a bound is proved: the order of elimination, and the bytes of memory that it takes."""

    elimination: Elimination
    bytes: int


def plan_proof(piece: Piece, long_proofs: bool = False) -> ProofPlan | None:
    """The :class:`ProofPlan` of a piece; None where a proof by factorization is not affordable in memory or, unless
    ``long_proofs`` is set, in time."""
    matrix, usable = piece.matrix, max(room().usable, 0)
    if not piece.reductions.is_whole or (matrix.shape[0] > LARGEST_PROOF and not long_proofs):
        return None
    most = np.inf if long_proofs else LONGEST_ELIMINATION * matrix.nnz
    elimination = Elimination.of(matrix, piece.block, most, np.sqrt(usable / matrix.dtype.itemsize))
    if elimination is None:
        return None
    size = elimination_bytes(piece, elimination.entries)
    return ProofPlan(elimination, size) if size <= usable else None


def prove(piece: Piece, shift: float, duals: np.ndarray, depth: float, plan: ProofPlan) -> bool:
    """Whether S + depth A is positive definite, by a factorization in double precision.

    An allowance for the rounding error is subtracted from the diagonal first. Where the row sums of the error's bound
    are at most as large, it hides nothing (Gershgorin). An inner product of complex numbers is one of real numbers of
    twice the length for each part: its error is sqrt(2) times as large.
    """
    multipliers = on_rows(duals, piece.block)
    added = with_diagonal(-multipliers, depth * shift * piece.row_mass)
    # At least the diagonal of the matrix that is factorized.
    own = multipliers if multipliers.ndim == 1 else np.einsum("nii->ni", multipliers).ravel()
    diagonal = (1 + depth) * piece.matrix.diagonal().real + depth * shift * piece.row_mass + np.maximum(-own.real, 0)
    unit = np.finfo(float).eps * (np.sqrt(2) if piece.is_complex else 1.0)
    allowed = ROUNDINGS * plan.elimination.chains.max() * diagonal
    for _ in range(ALLOWANCES):
        lowered = with_diagonal(added, -unit * (np.diff(piece.matrix.indptr) * diagonal + allowed))
        try:
            errors = rounding_error(piece.matrix * (1 + depth) + block_diagonal(lowered), plan.elimination)
        except MemoryError:
            return False
        if errors is None or (errors <= allowed).all():
            return errors is not None
        allowed = np.maximum(allowed, LARGER_ALLOWANCE * errors)
    return False
