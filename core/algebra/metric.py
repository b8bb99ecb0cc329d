# SPDX-License-Identifier: GPL-3.0-or-later
"""The metric A = L + shift M in which descent and certificate measure, inverted by covariant multigrid.

Smoothed aggregation (Vanek, Mandel and Brezina 1996) whose near null space is local: inside an aggregate the
phase of the root, carried along the transports. So every level is a connection Laplacian with one
block a node again, and the number of conjugate gradient steps does not grow with the mesh.

PyAMG knows no transports: it is given global candidates, and no few fields agree with a connection everywhere. With one
or three of them, random columns smoothed by Jacobi steps, conjugate gradients took 3 to 20 times the steps that they
take here, the more the finer the mesh, and the setup 2 to 3 times as long (figures in bench/README.md).
"""

from copy import copy
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_matrix, diags_array

from .blocks import block_diagonal
from .coarsening import aggregates, hubs
from .factorization import factorize, has_positive_pivots
from .products import SharedRows
from .reductions import HERE

# Share of the stiffness below which a shift drowns in single precision.
SMALLEST_SHIFT = 1e-6
# Nodes of the smallest level, which is factorized, and the ratio of sizes that stops coarsening.
SMALLEST_LEVEL = 200
STAGNATION = 0.7
# Damped Jacobi smoothing: the part of the spectrum that it damps evenly, below the largest eigenvalue; 0.15 does as
# well for the relaxation, 0.5 takes 6 % more products (measured as in :mod:`core.solve.methods.staircase`). One step
# before and after is faster in all than Chebyshev polynomials of degree 2 or 3, which save few steps.
SMOOTHED_PART = 0.3
POWER_STEPS = 10
SAFETY = 1.1
# How much longer than in a cycle the Jacobi step is that is added to the coarser levels' part: at half of it the
# relaxation takes 21 % more products, at twice of it 64 %.
ADDED_STEP = 1.5


@dataclass(frozen=True)
class Level:
    """One level of a hierarchy: single precision matrix, (N,) mass of each row, prolongation from the next.

    ``ground`` is the node whose block may be singular, or None; ``largest`` bounds the spectrum of D^-1 matrix;
    ``tentative`` is the prolongation before it is smoothed, one unit block a node. Both are None on the smallest level.
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
    matrix : (N, N) CSR, Hermitian, positive semidefinite
    row_mass : (N,) positive
    block : rows per node
    ground : node whose block may be singular, or None
    tentatives : tentative prolongations to begin with, optional: those of a hierarchy on the same graph; without a
        ground only
    """

    def __init__(self, matrix, row_mass, block, ground=None, tentatives=()):
        random = np.random.default_rng(0)
        matrix = matrix.astype(np.complex64 if np.iscomplexobj(matrix.data) else np.float32)
        row_mass = row_mass.astype(np.float32)
        self.levels: list[Level] = []
        while True:
            inverse_diagonal = 1 / matrix.diagonal().real
            largest = largest_eigenvalue(matrix, inverse_diagonal, random)
            prolongation = tentative = coarse_ground = None
            if len(self.levels) < len(tentatives):
                tentative = tentatives[len(self.levels)]
            elif matrix.shape[0] > SMALLEST_LEVEL * block:
                tentative, coarse_ground = aggregates(matrix, block, ground, random)
                if tentative.shape[1] > STAGNATION * matrix.shape[0]:
                    tentative = None
            if tentative is not None:
                smoother = diags_array(smoothing_weights(matrix, 4 / 3 / largest * inverse_diagonal))
                prolongation = (tentative - smoother @ (matrix @ tentative)).tocsr()
            self.levels.append(Level(matrix, row_mass, ground, largest, prolongation, tentative))
            if prolongation is None:
                return
            matrix = (prolongation.conj().T.tocsr() @ (matrix @ prolongation)).tocsr()
            row_mass = coarse_mass(tentative, row_mass)
            ground = coarse_ground

    def lowered(self, diagonal, depth=0):
        """The hierarchy of a level's matrix less (N,) numbers on its diagonal or (n, d, d) blocks.

        The aggregates are the same. None where the diagonal of a level shows that this has negative eigenvalues.
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

    def rows(self, depth):
        """The matrix of a level, for products."""
        return SharedRows(self.levels[depth].matrix)

    def restricted(self, fields, depth):
        """Fields of the level before a depth on that level: weighted sums."""
        return self.levels[depth - 1].prolongation.conj().T @ fields

    @staticmethod
    def step(level, scale, coarse_scale):
        """The :class:`Step` on a level, from the (N,) scales of its rows and of those of the next."""
        prolongation = scale_matrix(level.prolongation, 1 / scale, coarse_scale)
        return Step(
            SharedRows(unit_diagonal(level.matrix, scale)),
            damping(level),
            SharedRows(prolongation),
            SharedRows(prolongation.conj().T.tocsr()),
        )

    @staticmethod
    def factorized(level, scale):
        """The smallest level with (N,) scales of its rows, to be solved; None where it is not positive definite."""
        return definite_factors(unit_diagonal(level.matrix, scale))

    @property
    def complexity(self):
        """Stored entries of all levels over those of the first."""
        return sum(level.matrix.nnz for level in self.levels) / self.levels[0].matrix.nnz


def smoothing_weights(matrix, weights):
    """(N,) weights of the prolongation's Jacobi step: none at hubs, which would join all aggregates beside them."""
    return np.where(hubs(matrix), 0, weights).astype(np.float32)


def coarse_mass(tentative, row_mass):
    """Mass of each coarse row: the squares of a unit block's column add up to one."""
    squares = csr_matrix((np.abs(tentative.data) ** 2, tentative.indices, tentative.indptr), shape=tentative.shape)
    return squares.T @ row_mass


def largest_eigenvalue(matrix, inverse_diagonal, random, held=HERE):
    """Upper estimate of the spectrum of D^-1 matrix, by the power method."""
    vector = random.standard_normal(len(inverse_diagonal)).astype(matrix.dtype)
    size = 1.0
    for _ in range(POWER_STEPS):
        vector /= held.norm(vector)
        vector = inverse_diagonal * (matrix @ vector)
        size = float(held.norm(vector))
    return max(SAFETY * size, 1.0)


def definite_factors(matrix):
    """The factorization of a Hermitian matrix; None where it is not positive definite to its precision."""
    try:
        factors = factorize(matrix)
    except RuntimeError:  # an exactly singular pivot
        return None
    return factors if has_positive_pivots(factors) else None


def definite_metric(hierarchy, shift, depth=0):
    """The metric of a shift, or of the first of ten, a hundred ... times that which rounding leaves definite."""
    metric = Metric(hierarchy, shift, depth)
    return metric if metric.is_definite else definite_metric(hierarchy, 10 * shift, depth)


@dataclass(frozen=True)
class Step:
    """What a cycle needs on a level above the smallest, scaled to unit diagonal: smoothing then has none to divide by.

    ``damping`` is the length of a Jacobi step; ``prolongation`` comes from the next smaller level, and ``restriction``
    leads to it.
    """

    matrix: SharedRows
    damping: np.float32
    prolongation: SharedRows
    restriction: SharedRows


def damping(level):
    """Length of a Jacobi step on a level."""
    return np.float32(2 / (level.largest * (1 + SMOOTHED_PART)))


class Metric:
    """A = L + shift M with an approximate inverse: one V-cycle on all columns at once, in single precision.

    The shift makes the matrix definite; at a small share of the mean energy per mass it hardly
    changes the metric.

    Parameters
    ----------
    hierarchy : Hierarchy of L
    shift : positive
    depth : the hierarchy's level that is L

    Attributes
    ----------
    shift : as given
    is_definite : whether the smallest level, to the precision of its factorization, is positive definite
    """

    def __init__(self, hierarchy, shift, depth=0):
        self.shift = shift
        levels = hierarchy.levels[depth:]
        scales = [1 / np.sqrt(lv.matrix.diagonal().real + np.float32(shift) * lv.row_mass) for lv in levels]
        self._scale = scales[0][:, None]
        self._steps = [hierarchy.step(*of_level) for of_level in zip(levels[:-1], scales[:-1], scales[1:], strict=True)]
        self._smallest = hierarchy.factorized(levels[-1], scales[-1])
        self.is_definite = self._smallest is not None
        self.dtype = levels[-1].matrix.dtype

    def solve(self, columns):
        """Approximate A^-1 on (N, k) or (N,) columns; a fixed Hermitian operator, positive if A is; keeps dtypes.

        Columns may hold several numbers for each row, as those of :class:`.products.SharedRows`.
        """
        return self._applied(self._cycle, columns)

    def precondition(self, columns):
        """The same without products on the finest level: what its smoothing and the coarser levels give is added up.

        It is too long by up to 2.5 where they meet. A descent, which remembers the curvature that it met and may halve
        a step, takes some more steps with it, of less than half the cost.
        """
        return self._applied(self._sum, columns)

    def _applied(self, operator, columns):
        vectors = columns.reshape(len(self._scale), -1)
        result = self._scaled_rows(operator(self._scaled_rows(vectors.astype(self.dtype, order="C"))))
        return result.reshape(columns.shape).astype(columns.dtype, copy=False)

    def _scaled_rows(self, columns):
        reals = columns.view(columns.real.dtype)
        reals *= self._scale
        return columns

    def _cycle(self, right, depth=0):
        if depth == len(self._steps):
            return self._smallest.solve(np.asfortranarray(right)).astype(self.dtype, order="C")
        step = self._steps[depth]
        guess = step.damping * right
        guess += step.prolongation @ self._cycle(step.restriction @ _residual(step.matrix, guess, right), depth + 1)
        change = _residual(step.matrix, guess, right)
        change *= step.damping
        guess += change
        return guess

    def _sum(self, right):
        if not self._steps:
            return self._cycle(right)
        step = self._steps[0]
        result = ADDED_STEP * step.damping * right
        result += step.prolongation @ self._cycle(step.restriction @ right, 1)
        return result


def _residual(matrix, guess, right):
    """right - matrix guess, in one new array: on large grids memory's speed is what a cycle costs."""
    image = matrix @ guess
    return np.subtract(right, image, out=image)


def unit_diagonal(matrix, scale):
    """diag(scale) matrix diag(scale) with ones on the diagonal, which are there but for rounding."""
    result = scale_matrix(matrix, scale, scale)
    result.setdiag(1)
    return result


def scale_matrix(matrix, row_scale, column_scale):
    """diag(row_scale) matrix diag(column_scale)."""
    rows = np.repeat(row_scale.astype(np.float32), np.diff(matrix.indptr))
    result = copy(matrix)  # a constructor would look through the indices again
    result.data = matrix.data * (rows * column_scale.astype(np.float32)[matrix.indices])
    return result
