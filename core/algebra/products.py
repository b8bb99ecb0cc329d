# SPDX-License-Identifier: GPL-3.0-or-later
"""Sparse products on all cores: SciPy releases the interpreter's lock, so that threads may share the rows."""

from functools import cached_property
from itertools import pairwise

import numpy as np

from . import workers

# Numbers multiplied (stored entries times columns) below which a thread costs more than it saves.
WORTH_SHARING = 1_000_000


class SharedRows:
    """A CSR matrix whose products with many columns are computed by all cores, each with a range of rows.

    Columns may hold several numbers for each row of the matrix, one after the other: each takes its own way.
    """

    def __init__(self, matrix):
        self.matrix = matrix
        self.dtype, self.shape = matrix.dtype, matrix.shape
        self.diagonal = matrix.diagonal

    def __matmul__(self, columns):
        matrix = self.matrix
        if len(columns) > matrix.shape[1]:
            return (self @ columns.reshape(matrix.shape[1], -1)).reshape(-1, columns.shape[1])
        if workers.idle_workers() == 1 or matrix.nnz * (columns.size // len(columns)) < WORTH_SHARING:
            return matrix @ columns
        columns = np.ascontiguousarray(columns)
        result = np.empty((matrix.shape[0], *columns.shape[1:]), np.result_type(matrix.dtype, columns.dtype))

        def fill(part):
            rows, share = part
            result[rows] = share @ columns

        workers.pool.map(fill, self._parts)
        return result

    @cached_property
    def _parts(self):
        """Row ranges of about equal work, with their matrices, which are views."""
        matrix = self.matrix
        wanted = np.linspace(0, matrix.nnz, workers.WORKERS + 1)
        cuts = np.searchsorted(matrix.indptr, wanted).clip(0, matrix.shape[0])
        cuts[0], cuts[-1] = 0, matrix.shape[0]
        return [(slice(first, last), _rows(matrix, first, last)) for first, last in pairwise(cuts)]


def _rows(matrix, first, last):
    """Rows first..last as a CSR matrix that shares the memory of ``matrix``."""
    start, end = matrix.indptr[first], matrix.indptr[last]
    parts = (matrix.data[start:end], matrix.indices[start:end], matrix.indptr[first : last + 1] - start)
    return type(matrix)(parts, shape=(last - first, matrix.shape[1]), copy=False)
