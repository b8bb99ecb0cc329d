# SPDX-License-Identifier: GPL-3.0-or-later
"""Sparse products on all cores: SciPy releases the interpreter's lock, so that threads can share the rows.

The kernels of SciPy are called here without its checks of formats and types, which take half the time of a product on
the coarse levels of a multigrid cycle. A range of rows needs no matrix of its own: the kernels find its entries by the
row pointers, and write to a part of the result.
"""

from itertools import pairwise
from typing import Protocol

import numpy as np
from scipy.sparse import _sparsetools, csr_matrix

from . import workers

# Multiplications (stored entries times columns) for which one more thread pays.
WORTH_SHARING = 250_000


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
        self._ranges: dict[int, list[tuple[int, int]]] = {}

    def __matmul__(self, columns: np.ndarray) -> np.ndarray:
        matrix, (height, width) = self.matrix, self.shape
        if len(columns) > width:
            return (self @ columns.reshape(width, -1)).reshape(-1, columns.shape[1])
        if len(columns) < width:
            raise ValueError(f"{self.shape} times {columns.shape}")
        if columns.dtype != self.dtype:
            return matrix @ columns
        flat, result = np.ascontiguousarray(columns).ravel(), np.zeros((height, *columns.shape[1:]), self.dtype)
        count = len(flat) // width if width else 1

        def fill(rows: tuple[int, int]) -> None:
            first, last = rows
            entries = matrix.indptr[first : last + 1], matrix.indices, matrix.data
            part = result[first:last].ravel()  # a view
            if count == 1:
                _sparsetools.csr_matvec(last - first, width, *entries, flat, part)
            else:
                _sparsetools.csr_matvecs(last - first, width, count, *entries, flat, part)

        threads = min(workers.idle_workers(), 1 + matrix.nnz * count // WORTH_SHARING)
        if threads == 1:
            fill((0, height))
        else:
            workers.pool.map(fill, self._ranges_for(threads))
        return result

    def _ranges_for(self, threads: int) -> list[tuple[int, int]]:
        """First and last rows of ranges with about equal work."""
        if threads not in self._ranges:
            matrix, height = self.matrix, self.shape[0]
            cuts = np.searchsorted(matrix.indptr, np.linspace(0, matrix.nnz, threads + 1)).clip(0, height)
            cuts[0], cuts[-1] = 0, height
            self._ranges[threads] = list(pairwise(cuts.tolist()))
        return self._ranges[threads]
