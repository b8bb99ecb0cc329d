# SPDX-License-Identifier: GPL-3.0-or-later
"""Sparse matrices whose rows are distributed over processes, and sums over all of them.

PETSc assembles, distributes and multiplies the matrices. SciPy multiplies them by many columns at once, after PETSc has
fetched the rows of the columns that other processes hold.
"""

import math
from copy import copy
from functools import cache
from typing import Any, Self

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc
from scipy.sparse import csr_matrix

from synch_fields.core.algebra.metric import scale_matrix
from synch_fields.core.algebra.reductions import Numbers, Reductions


class SpreadReductions(Reductions):
    """Sums over all processes of a communicator, which MPI gives to all of them alike to the last bit."""

    is_whole = False

    def __init__(self, comm: MPI.Comm) -> None:
        self.comm = comm

    def sum(self, numbers: Numbers) -> Numbers:
        return self._reduced(numbers, MPI.SUM)

    def max(self, numbers: Numbers) -> Numbers:
        return self._reduced(numbers, MPI.MAX)

    def norm(self, vector: np.ndarray) -> float:
        return np.sqrt(self.sum(float(np.linalg.norm(vector)) ** 2))

    def _reduced(self, numbers: Any, operation: MPI.Op) -> Any:
        own = np.asarray(numbers, order="C")
        result = np.empty_like(own)
        self.comm.Allreduce(own, result, operation)
        return result[()]


class Fetching:
    """Rows of columns that other processes hold, fetched for each product.

    Parameters
    ----------
    ranges : (processes + 1,) first row of each process, and the number of rows
    wanted : (k,) rows of other processes, ascending
    """

    def __init__(self, ranges: np.ndarray, wanted: np.ndarray, comm: MPI.Comm) -> None:
        self.count = int(ranges[comm.rank + 1] - ranges[comm.rank])
        self._wanted_count = len(wanted)
        owners = np.searchsorted(ranges, wanted, side="right") - 1
        self._forest = PETSc.SF().create(comm)
        self._forest.setGraph(self.count, None, np.column_stack([owners, wanted - ranges[owners]]).astype(np.int32))

    def extended(self, columns: np.ndarray) -> np.ndarray:
        """Append the rows of other processes to (N, k) or (N,) columns held here."""
        columns = np.ascontiguousarray(columns)
        result = np.empty((self.count + self._wanted_count, *columns.shape[1:]), columns.dtype)
        result[: self.count] = columns
        row, fetched = _bytes(columns.itemsize * math.prod(columns.shape[1:])), result[self.count :]
        self._forest.bcastBegin(row, columns, fetched, MPI.REPLACE)
        self._forest.bcastEnd(row, columns, fetched, MPI.REPLACE)
        return result


@cache
def _bytes(count: int) -> MPI.Datatype:
    """Create MPI's type for a block of bytes."""
    return MPI.BYTE.Create_contiguous(count).Commit()


class SpreadRows:
    """The rows of a sparse matrix that this process holds, for products with columns distributed in the same way.

    Parameters
    ----------
    matrix : (rows held here, columns held here and fetched)
    shape : of the whole matrix
    """

    def __init__(self, matrix: csr_matrix, fetching: Fetching, shape: tuple[int, int]) -> None:
        self.matrix, self.fetching, self.shape = matrix, fetching, shape
        self.dtype = matrix.dtype

    @classmethod
    def of(cls, matrix: PETSc.Mat, dtype: type) -> Self:
        """Take the rows of a PETSc matrix in a precision."""
        starts, columns, values = matrix.getValuesCSR()
        first, last = matrix.getOwnershipRangeColumn()
        is_here = (columns >= first) & (columns < last)
        wanted, places = np.unique(columns[~is_here], return_inverse=True)
        numbers = np.empty_like(columns)
        numbers[is_here], numbers[~is_here] = columns[is_here] - first, last - first + places
        own = csr_matrix((values.astype(dtype), numbers, starts), shape=(len(starts) - 1, last - first + len(wanted)))
        fetching = Fetching(matrix.getOwnershipRangesColumn(), wanted, matrix.comm.tompi4py())
        return cls(own, fetching, matrix.getSize())

    def __matmul__(self, columns: np.ndarray) -> np.ndarray:
        return self.matrix @ self.fetching.extended(columns)

    def diagonal(self) -> np.ndarray:
        """Take the diagonal of the rows held here, (N,)."""
        return self.matrix.diagonal()

    def scaled(self, row_scale: np.ndarray, column_scale: np.ndarray) -> Self:
        """Compute diag(row_scale) matrix diag(column_scale)."""
        result = copy(self)
        result.matrix = scale_matrix(self.matrix, row_scale, self.fetching.extended(column_scale))
        return result

    def unit_diagonal(self, scale: np.ndarray) -> Self:
        """Compute diag(scale) matrix diag(scale) with ones on the diagonal."""
        result = self.scaled(scale, scale)
        result.matrix.setdiag(1)
        return result

    def gathered(self, comm: MPI.Comm) -> csr_matrix:
        """Gather all rows in every process; for small matrices with as many columns as rows in each process."""
        ranges = np.concatenate([[0], np.cumsum(comm.allgather(self.fetching.count))])
        names = self.fetching.extended(np.arange(ranges[comm.rank], ranges[comm.rank + 1]))
        own = self.matrix.tocoo()
        parts = comm.allgather((own.data, own.row + ranges[comm.rank], names[own.col]))
        values, rows, columns = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
        return csr_matrix((values, (rows, columns)), shape=self.shape)


def petsc_matrix(own: csr_matrix, comm: MPI.Comm, column_count: int | None = None) -> PETSc.Mat:
    """Build a PETSc matrix from the rows of each process.

    ``own`` has the rows held here and the columns held here, or all columns if ``column_count`` says how many are.
    """
    held = own.shape[1] if column_count is None else column_count
    before = comm.scan(held) - held if column_count is None else 0
    sizes = (own.shape[0], PETSc.DETERMINE), (held, PETSc.DETERMINE)
    csr = own.indptr.astype(PETSc.IntType), (own.indices + before).astype(PETSc.IntType), own.data
    return PETSc.Mat().createAIJ(sizes, csr=csr, comm=comm)


def local_block(matrix: PETSc.Mat, dtype: type) -> csr_matrix:
    """Take the rows and columns of a square PETSc matrix that are both held here."""
    starts, columns, values = matrix.getDiagonalBlock().getValuesCSR()
    return csr_matrix((values.astype(dtype), columns, starts), shape=(len(starts) - 1,) * 2)
