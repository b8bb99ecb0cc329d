# SPDX-License-Identifier: GPL-3.0-or-later
"""The metric A = L + shift M in which descent and certificate measure, inverted by covariant multigrid.

Smoothed aggregation (Vanek, Mandel and Brezina 1996) with a local near null space: inside an aggregate the phase of
the root, carried along the transports. So every level is again a connection Laplacian with one block per node, and the
number of conjugate gradient steps does not grow with the mesh.

PyAMG has no transports but global candidates, and a few fields cannot agree with a connection everywhere. With one or
three candidates, random columns smoothed by Jacobi steps, conjugate gradients took 3 to 20 times as many steps as here,
more on finer meshes, and the setup 2 to 3 times as long (figures in bench/README.md).
"""

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import get_lapack_funcs
from scipy.sparse import csr_matrix, diags_array
from scipy.sparse.linalg import SuperLU

from .blocks import block_diagonal
from .coarsening import aggregates, hubs, truncated
from .columns import PAIR
from .factorization import factorize, has_positive_pivots
from .products import Matrix, SharedRows
from .reductions import HERE, Reductions

# Share of the stiffness below which a shift is lost in single precision.
SMALLEST_SHIFT = 1e-6
# Nodes of the smallest level, which is factorized, and the ratio of sizes that stops coarsening.
SMALLEST_LEVEL = 200
STAGNATION = 0.7
# Rows up to which the inverse of the smallest level is dense.
LARGEST_DENSE = 512
# A level with more than this share of the finer one's rows has small aggregates, as on long thin triangles. There
# smoothed prolongations would fill the coarser levels: on a CAD part ten times, at the same energies of first fields.
SMALL_AGGREGATES = 0.2
# Damped Jacobi smoothing: the share of the spectrum, below the largest eigenvalue, that it damps evenly; 0.15 is as
# good for the relaxation, 0.5 takes 6 % more products (measured as in :mod:`core.solve.methods.staircase`). One step
# before and after is faster than Chebyshev polynomials of degree 2 or 3, which save few steps.
SMOOTHED_PART = 0.3
# Diagonals are raised to this many times the largest that rounding has made negative.
ROUNDING_MARGIN = 10.0
POWER_STEPS = 10
# No eigenvalue of a connection Laplacian over its diagonal is larger.
LARGEST = 2.0
SAFETY = 1.1
# Factor on the Jacobi step that is added to the coarser levels' part, against that of a cycle: at half of it the
# relaxation takes 21 % more products, at twice 64 %.
ADDED_STEP = 1.5


@dataclass(frozen=True)
class Level:
    """One level of a hierarchy: single precision matrix, (N,) mass of each row, prolongation from the next.

    ``ground`` is the node whose block may be singular; ``largest`` bounds the spectrum of D^-1 matrix; ``tentative`` is
    the prolongation before smoothing, with one unit block per node. Both prolongations are None on the smallest level.
    """

    matrix: csr_matrix
    row_mass: np.ndarray
    ground: int | None
    largest: float
    prolongation: csr_matrix | None
    tentative: csr_matrix | None


class Hierarchy:
    """Covariant smoothed aggregation of a connection Laplacian.

    Parameters
    ----------
    matrix : (N, N), Hermitian, positive semidefinite
    row_mass : (N,) positive
    block : rows per node
    ground : node whose block may be singular
    tentatives : tentative prolongations of a hierarchy on the same graph, to begin with; only without a ground
    is_rough : the first prolongation is not smoothed, which takes half the time; the metric of the finest level is poor
    """

    def __init__(
        self,
        matrix: csr_matrix,
        row_mass: np.ndarray,
        block: int,
        ground: int | None = None,
        tentatives: Sequence[csr_matrix] = (),
        is_rough: bool = False,
    ) -> None:
        random = np.random.default_rng(0)
        matrix = matrix.astype(np.complex64 if np.iscomplexobj(matrix.data) else np.float32)
        row_mass = row_mass.astype(np.float32)
        self.levels: list[Level] = []
        while True:
            inverse_diagonal, is_smoothed = 1 / matrix.diagonal().real, bool(self.levels) or not is_rough
            largest = largest_eigenvalue(matrix, inverse_diagonal, random) if is_smoothed else LARGEST
            prolongation = tentative = coarse_ground = None
            if len(self.levels) < len(tentatives):
                tentative = tentatives[len(self.levels)]
            elif matrix.shape[0] > SMALLEST_LEVEL * block:
                tentative, coarse_ground = aggregates(matrix, block, ground, random)
                if tentative.shape[1] > STAGNATION * matrix.shape[0]:
                    tentative = None
            if tentative is not None and not is_smoothed:
                prolongation = tentative
            elif tentative is not None:
                smoother = diags_array(smoothing_weights(matrix, 4 / 3 / largest * inverse_diagonal))
                prolongation = (tentative - smoother @ (matrix @ tentative)).tocsr()
                if tentative.shape[1] > SMALL_AGGREGATES * matrix.shape[0]:
                    prolongation = truncated(prolongation, tentative, block)
            self.levels.append(Level(matrix, row_mass, ground, largest, prolongation, tentative))
            if prolongation is None:
                return
            matrix = with_positive_diagonal((prolongation.conj().T.tocsr() @ (matrix @ prolongation)).tocsr())
            row_mass = coarse_mass(tentative, row_mass)
            ground = coarse_ground

    def lowered(self, diagonal: np.ndarray, depth: int = 0) -> "Hierarchy | None":
        """Subtract (N,) numbers or (n, d, d) blocks from the diagonal of a level's matrix, with the same aggregates.

        Returns None if the diagonal of a level shows that the result has negative eigenvalues.
        """
        random = np.random.default_rng(0)
        result = copy(self)
        result.levels = []
        change = block_diagonal(diagonal.astype(np.float32)).tocsr()
        for level in self.levels[depth:]:
            matrix = (level.matrix - change).tocsr()
            if not (matrix.diagonal().real > 0).all():
                return None
            largest = largest_eigenvalue(matrix, 1 / matrix.diagonal().real, random)
            result.levels.append(replace(level, matrix=matrix, largest=largest))
            if level.prolongation is not None:
                change = (level.prolongation.conj().T.tocsr() @ (change @ level.prolongation)).tocsr()
        return result

    def rows(self, depth: int) -> SharedRows:
        """Prepare the matrix of a level for products."""
        return SharedRows(self.levels[depth].matrix)

    def restricted(self, fields: np.ndarray, depth: int) -> np.ndarray:
        """Restrict fields of the next finer level to a depth, as weighted sums."""
        way = self.levels[depth - 1].prolongation
        assert way is not None  # only the smallest level has none
        return way.conj().T @ fields

    @staticmethod
    def step(level: Level, scale: np.ndarray, coarse_scale: np.ndarray) -> "Step":
        """Build the :class:`Step` on a level from the (N,) scales of its rows and of the next level's."""
        prolongation = scale_matrix(level.prolongation, 1 / scale, coarse_scale)
        return Step(
            SharedRows(unit_diagonal(level.matrix, scale)),
            damping(level.largest),
            SharedRows(prolongation),
            SharedRows(prolongation.conj().T.tocsr()),
        )

    @staticmethod
    def factorized(level: Level, scale: np.ndarray) -> "Inverse | None":
        """Factorize the smallest level with (N,) scales of its rows; None if it is not positive definite."""
        inverse = Inverse(unit_diagonal(level.matrix, scale))
        return inverse if inverse.is_definite else None

    @property
    def complexity(self) -> float:
        """Stored entries of all levels over those of the first."""
        return sum(level.matrix.nnz for level in self.levels) / self.levels[0].matrix.nnz


def smoothing_weights(matrix: csr_matrix, weights: np.ndarray) -> np.ndarray:
    """Set the (N,) weights of the prolongation's Jacobi step to 0 at hubs, which would join all aggregates around."""
    return np.where(hubs(matrix), 0, weights).astype(np.float32)


def with_positive_diagonal(matrix: csr_matrix) -> csr_matrix:
    """Raise the diagonal of a semidefinite matrix where rounding may outweigh it, if rounding has made any negative."""
    diagonal = matrix.diagonal().real
    least = -ROUNDING_MARGIN * diagonal.min()
    return (matrix + diags_array(np.maximum(least - diagonal, 0))).tocsr() if least > 0 else matrix


def coarse_mass(tentative: csr_matrix, row_mass: np.ndarray) -> np.ndarray:
    """Compute the masses of coarse rows; the squares of a unit block's column sum to 1."""
    squares = csr_matrix((np.abs(tentative.data) ** 2, tentative.indices, tentative.indptr), shape=tentative.shape)
    return squares.T @ row_mass


def largest_eigenvalue(
    matrix: csr_matrix, inverse_diagonal: np.ndarray, random: np.random.Generator, reductions: Reductions = HERE
) -> float:
    """Estimate an upper bound of the spectrum of D^-1 matrix by the power method."""
    vector = random.standard_normal(len(inverse_diagonal)).astype(matrix.dtype)
    size = 1.0
    for _ in range(POWER_STEPS):
        vector /= reductions.norm(vector)
        vector = inverse_diagonal * (matrix @ vector)
        size = float(reductions.norm(vector))
    return max(SAFETY * size, 1.0)


def definite_factors(matrix: csr_matrix) -> SuperLU | None:
    """Factorize a Hermitian matrix; None if it is not positive definite to its precision."""
    try:
        factors = factorize(matrix)
    except RuntimeError:  # an exactly singular pivot
        return None
    return factors if has_positive_pivots(factors) else None


def dense_inverse(matrix: csr_matrix) -> np.ndarray | None:
    """Invert a Hermitian matrix; None where the matrix or, after rounding, the inverse is not positive definite."""
    dense = matrix.toarray(order="F")
    potrf, potri = get_lapack_funcs(("potrf", "potri"), (dense,))
    factor, failed = potrf(dense, lower=True, overwrite_a=True)
    if failed:
        return None
    lower, _ = potri(factor, lower=True, overwrite_c=True)
    lower = np.tril(lower)
    inverse = lower + np.tril(lower, -1).conj().T
    return None if potrf(inverse, lower=True)[1] else np.ascontiguousarray(inverse)


class Inverse:
    """The inverse of a matrix, applied pair by pair: BLAS rounds a column by how many are beside it.

    A small one is dense: that takes a third of the time of factors, and half the time of triangular solves.
    ``is_definite``: whether the matrix is positive definite to its precision.
    """

    def __init__(self, matrix: csr_matrix) -> None:
        self._dense = dense_inverse(matrix) if matrix.shape[0] <= LARGEST_DENSE else None
        self._factors = definite_factors(matrix) if self._dense is None else None
        self.is_definite = self._dense is not None or self._factors is not None

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Apply the inverse to (N, k) columns."""
        count = right.shape[1]
        if self._dense is None:
            assert self._factors is not None  # the matrix is definite
            turned = np.asfortranarray(right)
            return np.hstack([self._factors.solve(turned[:, k : k + PAIR]) for k in range(0, count, PAIR)])
        result, whole = np.empty_like(right), count - count % PAIR
        pairs, solved = (columns[:, :whole].reshape(len(right), -1, PAIR).swapaxes(0, 1) for columns in (right, result))
        np.matmul(self._dense, pairs, out=solved)
        if whole < count:
            result[:, whole:] = self._dense @ right[:, whole:]
        return result


def definite_metric(hierarchy: Hierarchy, shift: float, depth: int = 0) -> "Metric":
    """Build the metric of a shift, or of the first of 10, 100 ... times the shift that is definite after rounding."""
    metric = Metric(hierarchy, shift, depth)
    return metric if metric.is_definite else definite_metric(hierarchy, 10 * shift, depth)


@dataclass(frozen=True)
class Step:
    """The operators of a cycle on a level above the smallest, scaled to unit diagonal so that smoothing is simple.

    ``damping`` is the length of a Jacobi step; ``prolongation`` is from the next smaller level, ``restriction`` to it.
    """

    matrix: Matrix
    damping: np.float32
    prolongation: Matrix
    restriction: Matrix


def damping(largest: float) -> np.float32:
    """Compute the length of a Jacobi step from the largest eigenvalue."""
    return np.float32(2 / (largest * (1 + SMOOTHED_PART)))


class Metric:
    """A = L + shift M with an approximate inverse: one V-cycle on all columns at once, in single precision.

    The shift makes the matrix definite; a small share of the mean energy per mass hardly changes the metric.
    ``is_definite``: whether the smallest level, to the precision of its factorization, is positive definite.

    Parameters
    ----------
    hierarchy : of L
    shift : positive
    depth : the hierarchy's level that is L
    """

    def __init__(self, hierarchy: Hierarchy, shift: float, depth: int = 0) -> None:
        self.shift = shift
        levels = hierarchy.levels[depth:]
        scales = [1 / np.sqrt(lv.matrix.diagonal().real + np.float32(shift) * lv.row_mass) for lv in levels]
        self._scale = scales[0][:, None]
        self._steps = [hierarchy.step(*of_level) for of_level in zip(levels[:-1], scales[:-1], scales[1:], strict=True)]
        self._smallest = hierarchy.factorized(levels[-1], scales[-1])
        self.is_definite = self._smallest is not None
        self.dtype = levels[-1].matrix.dtype

    def solve(self, columns: np.ndarray) -> np.ndarray:
        """Apply A^-1 approximately to (N, k) or (N,) columns: a fixed Hermitian operator, positive if A is.

        Keeps dtypes. Columns may have several numbers per row, as those of :class:`.products.SharedRows`.
        """
        return self._applied(self._cycle, columns)

    def precondition(self, columns: np.ndarray) -> np.ndarray:
        """Apply A^-1 roughly, without products on the finest level: add its smoothing and the coarser levels' part.

        The result is up to 2.5 times too long where both contribute. A descent, which learns the curvature and can
        halve a step, takes a few more steps with it, each of less than half the cost.
        """
        return self._applied(self._sum, columns)

    def _applied(self, operator: Callable[[np.ndarray], np.ndarray], columns: np.ndarray) -> np.ndarray:
        """Apply an operator for the scaled matrix to columns of the given one, in the metric's dtype."""
        vectors = columns.reshape(len(self._scale), -1)
        result = self._scaled_rows(operator(self._scaled_rows(vectors.astype(self.dtype, order="C"))))
        return result.reshape(columns.shape).astype(columns.dtype, copy=False)

    def _scaled_rows(self, columns: np.ndarray) -> np.ndarray:
        reals = columns.view(columns.real.dtype)
        reals *= self._scale
        return columns

    def _cycle(self, right: np.ndarray, depth: int = 0) -> np.ndarray:
        """Solve approximately at a depth by a V-cycle: damped Jacobi steps before and after the coarse correction."""
        if depth == len(self._steps):
            assert self._smallest is not None  # the metric is definite
            return self._smallest.solve(right).astype(self.dtype, order="C", copy=False)
        step = self._steps[depth]
        guess = step.damping * right
        guess += step.prolongation @ self._cycle(step.restriction @ _residual(step.matrix, guess, right), depth + 1)
        change = _residual(step.matrix, guess, right)
        change *= step.damping
        guess += change
        return guess

    def _sum(self, right: np.ndarray) -> np.ndarray:
        """Add smoothing on the finest level and the V-cycle of the next one, which do not depend on each other."""
        if not self._steps:
            return self._cycle(right)
        step = self._steps[0]
        result = ADDED_STEP * step.damping * right
        result += step.prolongation @ self._cycle(step.restriction @ right, 1)
        return result


def _residual(matrix: Matrix, guess: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Compute right - matrix guess in one new array, as memory bandwidth limits cycles on large grids."""
    image = matrix @ guess
    return np.subtract(right, image, out=image)


def unit_diagonal(matrix: csr_matrix, scale: np.ndarray) -> csr_matrix:
    """Compute diag(scale) matrix diag(scale), with the diagonal set to the exact ones that rounding misses."""
    result = scale_matrix(matrix, scale, scale)
    result.setdiag(1)
    return result


def scale_matrix(matrix: csr_matrix, row_scale: np.ndarray, column_scale: np.ndarray) -> csr_matrix:
    """Compute diag(row_scale) matrix diag(column_scale)."""
    rows = np.repeat(row_scale.astype(np.float32), np.diff(matrix.indptr))
    result = copy(matrix)  # a constructor would check the indices again
    result.data = matrix.data * (rows * column_scale.astype(np.float32)[matrix.indices])
    return result
