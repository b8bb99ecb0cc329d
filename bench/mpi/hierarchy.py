# SPDX-License-Identifier: GPL-3.0-or-later
"""The hierarchy of :mod:`core.algebra.metric` distributed over processes.

Aggregates stay within a process; PETSc multiplies the coarser matrices. Every process solves the smallest level.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import SuperLU

from synch_fields.bench.mpi.rows import SpreadReductions, SpreadRows, local_block, petsc_matrix
from synch_fields.core.algebra.coarsening import aggregates
from synch_fields.core.algebra.metric import (
    SMALLEST_LEVEL,
    STAGNATION,
    Step,
    coarse_mass,
    damping,
    definite_factors,
    largest_eigenvalue,
    smoothing_weights,
)


@dataclass(frozen=True)
class SpreadLevel:
    """As :class:`core.algebra.metric.Level`, without a ground.

    ``whole`` and ``way`` are the matrix and the prolongation in PETSc, in double precision.
    """

    matrix: SpreadRows
    row_mass: np.ndarray
    largest: float
    prolongation: SpreadRows | None
    whole: PETSc.Mat
    way: PETSc.Mat | None


class SpreadHierarchy:
    """Covariant smoothed aggregation of a connection Laplacian with one complex row per node."""

    def __init__(self, levels: list[SpreadLevel], reductions: SpreadReductions) -> None:
        self.levels, self._reductions = levels, reductions

    @classmethod
    def of(cls, whole: PETSc.Mat, row_mass: np.ndarray, reductions: SpreadReductions) -> Self:
        """Build the hierarchy of a Hermitian PETSc matrix and the (N,) mass of its rows."""
        random, row_mass = np.random.default_rng(0), row_mass.astype(np.float32)
        levels: list[SpreadLevel] = []
        while True:
            matrix, largest = _single_precision(whole, random, reductions)
            tentative = _tentative(whole, random, reductions)
            way = None if tentative is None else _smooth_prolongation(tentative, whole, matrix, largest)
            prolongation = None if way is None else SpreadRows.of(way, np.complex64)
            levels.append(SpreadLevel(matrix, row_mass, largest, prolongation, whole, way))
            if tentative is None:
                return cls(levels, reductions)
            whole, row_mass = _galerkin_product(whole, way), coarse_mass(tentative, row_mass)

    def lowered(self, diagonal: np.ndarray, depth: int = 0) -> "SpreadHierarchy | None":
        """Subtract (N,) numbers from the diagonal of a level's matrix; None if a level's diagonal is not positive."""
        random, levels = np.random.default_rng(0), []
        change = _diagonal_matrix(self.levels[depth].whole, diagonal)
        for level in self.levels[depth:]:
            whole = level.whole.copy()
            whole.axpy(-1, change, structure=PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)
            if self._reductions.max(-whole.getDiagonal().array.real.min(initial=np.inf)) >= 0:
                return None
            matrix, largest = _single_precision(whole, random, self._reductions)
            levels.append(SpreadLevel(matrix, level.row_mass, largest, level.prolongation, whole, level.way))
            if level.way is not None:
                change = _galerkin_product(change, level.way)
        return SpreadHierarchy(levels, self._reductions)

    def rows(self, depth: int) -> SpreadRows:
        """Take the matrix of a level, for products."""
        return self.levels[depth].matrix

    def restricted(self, fields: np.ndarray, depth: int) -> np.ndarray:
        """Restrict fields of the next finer level to a depth, as weighted sums."""
        return _restriction(self.levels[depth - 1]) @ fields

    @staticmethod
    def step(level: SpreadLevel, scale: np.ndarray, coarse_scale: np.ndarray) -> Step:
        """Build the step on a level from the (N,) scales of its rows and of the next level's."""
        assert level.prolongation is not None  # only the smallest level has none
        return Step(
            level.matrix.unit_diagonal(scale),
            damping(level.largest),
            level.prolongation.scaled(1 / scale, coarse_scale),
            _restriction(level).scaled(coarse_scale, 1 / scale),
        )

    def factorized(self, level: SpreadLevel, scale: np.ndarray) -> "_Gathered | None":
        """Factorize the smallest level with (N,) scales of its rows; None if it is not positive definite."""
        factors = definite_factors(level.matrix.unit_diagonal(scale).gathered(self._reductions.comm))
        return None if factors is None else _Gathered(factors, self._reductions.comm, len(scale))


class _Gathered:
    """A factorization in every process, for columns whose rows are distributed."""

    def __init__(self, factors: SuperLU, comm: MPI.Comm, count: int) -> None:
        self._factors, self._comm = factors, comm
        counts = comm.allgather(count)
        first = sum(counts[: comm.rank])
        self._own = slice(first, first + count)

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Solve for the rows held here."""
        whole = np.concatenate(self._comm.allgather(np.ascontiguousarray(right)))
        return self._factors.solve(np.asfortranarray(whole))[self._own]


def _single_precision(
    whole: PETSc.Mat, random: np.random.Generator, reductions: SpreadReductions
) -> tuple[SpreadRows, float]:
    """Take the rows of a PETSc matrix in single precision, and bound the spectrum of D^-1 matrix."""
    matrix = SpreadRows.of(whole, np.complex64)
    return matrix, largest_eigenvalue(matrix, 1 / matrix.diagonal().real, random, reductions)


def _tentative(whole: PETSc.Mat, random: np.random.Generator, reductions: SpreadReductions) -> csr_matrix | None:
    """Aggregate the rows held here, (N, coarse); None for a matrix that is small or hardly gets smaller."""
    size = whole.getSize()[0]
    if size <= SMALLEST_LEVEL:
        return None
    tentative, _ = aggregates(local_block(whole, np.complex64), 1, None, random)
    return None if reductions.sum(tentative.shape[1]) > STAGNATION * size else tentative


def _smooth_prolongation(tentative: csr_matrix, whole: PETSc.Mat, matrix: SpreadRows, largest: float) -> PETSc.Mat:
    """Compute the prolongation T - D^-1 A T, with the weights of a Jacobi step."""
    weights = smoothing_weights(matrix.matrix, 4 / 3 / largest / matrix.diagonal().real)
    plain = petsc_matrix(tentative.astype(complex), whole.comm.tompi4py())
    result = whole.matMult(plain)
    numbers = whole.createVecLeft()
    numbers.array[:] = -weights
    result.diagonalScale(numbers)
    result.axpy(1, plain, structure=PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)
    return result


def _galerkin_product(whole: PETSc.Mat, way: PETSc.Mat) -> PETSc.Mat:
    """Compute P^H A P."""
    return _adjoint(way).matMult(whole.matMult(way))


def _restriction(level: SpreadLevel) -> SpreadRows:
    return SpreadRows.of(_adjoint(level.way), np.complex64)


def _adjoint(way: PETSc.Mat) -> PETSc.Mat:
    return PETSc.Mat.hermitianTranspose(way, PETSc.Mat())


def _diagonal_matrix(like: PETSc.Mat, numbers: np.ndarray) -> PETSc.Mat:
    """Build a diagonal matrix distributed as another matrix."""
    result = PETSc.Mat().createAIJ(like.getSizes(), nnz=(1, 0), comm=like.comm)
    vector = like.createVecLeft()
    vector.array[:] = numbers
    result.setDiagonal(vector)
    result.assemble()
    return result
