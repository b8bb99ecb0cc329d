# SPDX-License-Identifier: GPL-3.0-or-later
"""The hierarchy of :mod:`core.algebra.metric` on many processes.

Aggregates stay within a process and carry phases along its transports; PETSc multiplies the coarser matrices. The
smallest level is solved by every process.
"""

from dataclasses import dataclass

import numpy as np
from petsc4py import PETSc

from ..algebra.coarsening import aggregates
from ..algebra.metric import (
    SMALLEST_LEVEL,
    STAGNATION,
    Step,
    coarse_mass,
    damping,
    definite_factors,
    largest_eigenvalue,
    smoothing_weights,
)
from .rows import SpreadRows, local_block, petsc_matrix


@dataclass(frozen=True)
class SpreadLevel:
    """As :class:`core.algebra.metric.Level`, without a ground.

    ``whole`` and ``way`` are the matrix and the prolongation as PETSc has them, in double precision.
    """

    matrix: SpreadRows
    row_mass: np.ndarray
    largest: float
    prolongation: SpreadRows | None
    whole: PETSc.Mat
    way: PETSc.Mat | None


class SpreadHierarchy:
    """Covariant smoothed aggregation of a connection Laplacian with one complex row a node.

    Parameters
    ----------
    levels : list of SpreadLevel
    held : HeldByAll
    """

    def __init__(self, levels, held):
        self.levels, self._held = levels, held

    @classmethod
    def of(cls, whole, row_mass, held):
        """That of a Hermitian PETSc matrix, and of the (N,) mass of its rows."""
        random, row_mass = np.random.default_rng(0), row_mass.astype(np.float32)
        levels: list[SpreadLevel] = []
        while True:
            matrix, largest = _single_precision(whole, random, held)
            tentative = _tentative(whole, random, held)
            way = None if tentative is None else _smooth_prolongation(tentative, whole, matrix, largest)
            prolongation = None if way is None else SpreadRows.of(way, np.complex64)
            levels.append(SpreadLevel(matrix, row_mass, largest, prolongation, whole, way))
            if tentative is None:
                return cls(levels, held)
            whole, row_mass = _galerkin_product(whole, way), coarse_mass(tentative, row_mass)

    def lowered(self, diagonal, depth=0):
        """The hierarchy of a level's matrix less (N,) numbers on its diagonal; None where a level's is not positive."""
        random, levels = np.random.default_rng(0), []
        change = _diagonal_matrix(self.levels[depth].whole, diagonal)
        for level in self.levels[depth:]:
            whole = level.whole.copy()
            whole.axpy(-1, change, structure=PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)
            if self._held.max(-whole.getDiagonal().array.real.min(initial=np.inf)) >= 0:
                return None
            matrix, largest = _single_precision(whole, random, self._held)
            levels.append(SpreadLevel(matrix, level.row_mass, largest, level.prolongation, whole, level.way))
            if level.way is not None:
                change = _galerkin_product(change, level.way)
        return SpreadHierarchy(levels, self._held)

    def rows(self, depth):
        """The matrix of a level, for products."""
        return self.levels[depth].matrix

    def restricted(self, fields, depth):
        """Fields of the level before a depth on that level: weighted sums."""
        return _restriction(self.levels[depth - 1]) @ fields

    @staticmethod
    def step(level, scale, coarse_scale):
        """The :class:`core.algebra.metric.Step` on a level, from the (N,) scales of its rows and of the next one's."""
        return Step(
            level.matrix.unit_diagonal(scale),
            damping(level),
            level.prolongation.scaled(1 / scale, coarse_scale),
            _restriction(level).scaled(coarse_scale, 1 / scale),
        )

    def factorized(self, level, scale):
        """The smallest level with (N,) scales of its rows, to be solved; None where it is not positive definite."""
        factors = definite_factors(level.matrix.unit_diagonal(scale).gathered(self._held.comm))
        return None if factors is None else _Gathered(factors, self._held.comm, len(scale))


class _Gathered:
    """A factorization that every process has, for columns of which each holds some rows."""

    def __init__(self, factors, comm, count):
        self._factors, self._comm = factors, comm
        counts = comm.allgather(count)
        first = sum(counts[: comm.rank])
        self._own = slice(first, first + count)

    def solve(self, right):
        """The rows held here of the solution."""
        whole = np.concatenate(self._comm.allgather(np.ascontiguousarray(right)))
        return self._factors.solve(np.asfortranarray(whole))[self._own]


def _single_precision(whole, random, held):
    """The rows of a PETSc matrix in single precision, and a bound of the spectrum over its diagonal."""
    matrix = SpreadRows.of(whole, np.complex64)
    return matrix, largest_eigenvalue(matrix, 1 / matrix.diagonal().real, random, held)


def _tentative(whole, random, held):
    """(N, coarse) CSR with aggregates of the rows held here; None where a matrix is small or hardly gets smaller."""
    size = whole.getSize()[0]
    if size <= SMALLEST_LEVEL:
        return None
    tentative, _ = aggregates(local_block(whole, np.complex64), 1, None, random)
    return None if held.sum(tentative.shape[1]) > STAGNATION * size else tentative


def _smooth_prolongation(tentative, whole, matrix, largest):
    """The prolongation as a PETSc matrix: T - D^-1 A T with the weights of a Jacobi step."""
    weights = smoothing_weights(matrix.matrix, 4 / 3 / largest / matrix.diagonal().real)
    plain = petsc_matrix(tentative.astype(complex), whole.comm.tompi4py())
    result = whole.matMult(plain)
    numbers = whole.createVecLeft()
    numbers.array[:] = -weights
    result.diagonalScale(numbers)
    result.axpy(1, plain, structure=PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)
    return result


def _galerkin_product(whole, way):
    """P^H A P."""
    return _adjoint(way).matMult(whole.matMult(way))


def _restriction(level):
    return SpreadRows.of(_adjoint(level.way), np.complex64)


def _adjoint(way):
    return PETSc.Mat.hermitianTranspose(way, PETSc.Mat())


def _diagonal_matrix(like, numbers):
    """Numbers on the diagonal, spread as another matrix."""
    result = PETSc.Mat().createAIJ(like.getSizes(), nnz=(1, 0), comm=like.comm)
    vector = like.createVecLeft()
    vector.array[:] = numbers
    result.setDiagonal(vector)
    result.assemble()
    return result
