# SPDX-License-Identifier: GPL-3.0-or-later
"""Sparse matrices whose rows many processes hold, and sums over all of them.

PETSc assembles and multiplies the matrices, and knows who holds what. Products with many columns at once are SciPy's,
after PETSc has fetched the rows of the columns that others hold.
"""

import math
from copy import copy
from functools import cache

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc
from scipy.sparse import csr_matrix

from ..algebra.metric import scale_matrix
from ..algebra.reductions import Reductions


class SpreadReductions(Reductions):
    """Rows are held by all processes of a communicator.

    MPI gives all of them the same sums to the last bit, so that all decide alike.
    """

    is_whole = False

    def __init__(self, comm):
        self.comm = comm

    def sum(self, numbers):
        return self._reduced(numbers, MPI.SUM)

    def max(self, numbers):
        return self._reduced(numbers, MPI.MAX)

    def norm(self, vector):
        return np.sqrt(self.sum(float(np.linalg.norm(vector)) ** 2))

    def _reduced(self, numbers, operation):
        numbers = np.asarray(numbers, order="C")
        result = np.empty_like(numbers)
        self.comm.Allreduce(numbers, result, operation)
        return result[()]


class Fetching:
    """Rows of columns that other processes hold, fetched for each product.

    Parameters
    ----------
    ranges : (processes + 1,) first rows that each process holds, and their number
    wanted : (k,) rows of others, ascending
    comm : MPI communicator
    """

    def __init__(self, ranges, wanted, comm):
        self.count = int(ranges[comm.rank + 1] - ranges[comm.rank])
        self._wanted_count = len(wanted)
        owners = np.searchsorted(ranges, wanted, side="right") - 1
        self._forest = PETSc.SF().create(comm)
        self._forest.setGraph(self.count, None, np.column_stack([owners, wanted - ranges[owners]]).astype(np.int32))

    def extended(self, columns):
        """(N, k) or (N,) columns that are held here, and below them the rows of others."""
        columns = np.ascontiguousarray(columns)
        result = np.empty((self.count + self._wanted_count, *columns.shape[1:]), columns.dtype)
        result[: self.count] = columns
        row, fetched = _bytes(columns.itemsize * math.prod(columns.shape[1:])), result[self.count :]
        self._forest.bcastBegin(row, columns, fetched, MPI.REPLACE)
        self._forest.bcastEnd(row, columns, fetched, MPI.REPLACE)
        return result


@cache
def _bytes(count):
    """MPI's type of so many bytes."""
    return MPI.BYTE.Create_contiguous(count).Commit()


class SpreadRows:
    """The rows of a sparse matrix that this process holds, for products with columns that are held in the same way.

    Parameters
    ----------
    matrix : CSR (rows held here, columns held here and fetched)
    fetching : Fetching
    shape : of the whole matrix
    """

    def __init__(self, matrix, fetching, shape):
        self.matrix, self.fetching, self.shape = matrix, fetching, shape
        self.dtype = matrix.dtype

    @classmethod
    def of(cls, matrix, dtype):
        """Those of a PETSc matrix, in a precision."""
        starts, columns, values = matrix.getValuesCSR()
        first, last = matrix.getOwnershipRangeColumn()
        is_here = (columns >= first) & (columns < last)
        wanted, places = np.unique(columns[~is_here], return_inverse=True)
        numbers = np.empty_like(columns)
        numbers[is_here], numbers[~is_here] = columns[is_here] - first, last - first + places
        own = csr_matrix((values.astype(dtype), numbers, starts), shape=(len(starts) - 1, last - first + len(wanted)))
        fetching = Fetching(matrix.getOwnershipRangesColumn(), wanted, matrix.comm.tompi4py())
        return cls(own, fetching, matrix.getSize())

    def __matmul__(self, columns):
        return self.matrix @ self.fetching.extended(columns)

    def diagonal(self):
        """(N,) of the rows held here."""
        return self.matrix.diagonal()

    def scaled(self, row_scale, column_scale):
        """diag(row_scale) matrix diag(column_scale)."""
        result = copy(self)
        result.matrix = scale_matrix(self.matrix, row_scale, self.fetching.extended(column_scale))
        return result

    def unit_diagonal(self, scale):
        """diag(scale) matrix diag(scale) with ones on the diagonal."""
        result = self.scaled(scale, scale)
        result.matrix.setdiag(1)
        return result

    def gathered(self, comm):
        """All rows as one CSR matrix, for every process; for small matrices, with as many columns held as rows."""
        ranges = np.concatenate([[0], np.cumsum(comm.allgather(self.fetching.count))])
        names = self.fetching.extended(np.arange(ranges[comm.rank], ranges[comm.rank + 1]))
        own = self.matrix.tocoo()
        parts = comm.allgather((own.data, own.row + ranges[comm.rank], names[own.col]))
        values, rows, columns = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
        return csr_matrix((values, (rows, columns)), shape=self.shape)


def petsc_matrix(own, comm, column_count=None):
    """A PETSc matrix from the rows of each process.

    Parameters
    ----------
    own : CSR (rows held here, columns held here), or (rows held here, all columns)
    comm : MPI communicator
    column_count : of columns that are held here, where all are given
    """
    held = own.shape[1] if column_count is None else column_count
    before = comm.scan(held) - held if column_count is None else 0
    sizes = (own.shape[0], PETSc.DETERMINE), (held, PETSc.DETERMINE)
    csr = own.indptr.astype(PETSc.IntType), (own.indices + before).astype(PETSc.IntType), own.data
    return PETSc.Mat().createAIJ(sizes, csr=csr, comm=comm)


def local_block(matrix, dtype):
    """CSR of the rows and columns of a square PETSc matrix that are both held here."""
    starts, columns, values = matrix.getDiagonalBlock().getValuesCSR()
    return csr_matrix((values.astype(dtype), columns, starts), shape=(len(starts) - 1,) * 2)
