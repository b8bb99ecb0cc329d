# SPDX-License-Identifier: GPL-3.0-or-later
"""Sparse products on all cores: SciPy releases the interpreter's lock, so that threads can share the rows."""

from functools import cached_property
from itertools import pairwise
from typing import Protocol

import numpy as np
from scipy.sparse import csr_matrix

from . import workers

# Multiplications (stored entries times columns) below which a thread costs more than it saves.
WORTH_SHARING = 1_000_000


class Matrix(Protocol):
    """A matrix that multiplies columns."""

    dtype: np.dtype

    def diagonal(self) -> np.ndarray: ...

    def __matmul__(self, columns: np.ndarray) -> np.ndarray: ...


class SharedRows:
    """A matrix whose products with many columns are computed by all cores, each with a range of rows.

    Columns may have several consecutive numbers per row of the matrix, which are multiplied independently.
    """

    def __init__(self, matrix: csr_matrix) -> None:
        self.matrix = matrix
        self.dtype, self.shape = matrix.dtype, matrix.shape
        self.diagonal = matrix.diagonal

    def __matmul__(self, columns: np.ndarray) -> np.ndarray:
        matrix = self.matrix
        if len(columns) > matrix.shape[1]:
            return (self @ columns.reshape(matrix.shape[1], -1)).reshape(-1, columns.shape[1])
        if workers.idle_workers() == 1 or matrix.nnz * (columns.size // len(columns)) < WORTH_SHARING:
            return matrix @ columns
        columns = np.ascontiguousarray(columns)
        result = np.empty((matrix.shape[0], *columns.shape[1:]), np.result_type(matrix.dtype, columns.dtype))

        def fill(part: tuple[slice, csr_matrix]) -> None:
            rows, share = part
            result[rows] = share @ columns

        workers.pool.map(fill, self._parts)
        return result

    @cached_property
    def _parts(self) -> list[tuple[slice, csr_matrix]]:
        """Row ranges of about equal work, and views of their matrices."""
        matrix = self.matrix
        wanted = np.linspace(0, matrix.nnz, workers.WORKERS + 1)
        cuts = np.searchsorted(matrix.indptr, wanted).clip(0, matrix.shape[0])
        cuts[0], cuts[-1] = 0, matrix.shape[0]
        return [(slice(first, last), _rows(matrix, first, last)) for first, last in pairwise(cuts)]


def _rows(matrix: csr_matrix, first: int, last: int) -> csr_matrix:
    """View the rows first..last as a matrix that shares the memory of ``matrix``."""
    start, end = matrix.indptr[first], matrix.indptr[last]
    parts = (matrix.data[start:end], matrix.indices[start:end], matrix.indptr[first : last + 1] - start)
    return type(matrix)(parts, shape=(last - first, matrix.shape[1]), copy=False)
