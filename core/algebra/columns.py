# SPDX-License-Identifier: GPL-3.0-or-later
"""Arithmetic on columns of real numbers with many short rows, in parts that fit into a core's cache.

NumPy is slow if the last axis is short, so that several rows are joined to one; BLAS handles a single column.
"""

from functools import cache

import numpy as np
from scipy.linalg.blas import get_blas_funcs

# Numbers that fit into the cache, and rows that are joined to one.
HELD, TOGETHER = 131072, 64


def row_parts(count: int, width: int) -> list[slice]:
    """Split ``count`` rows of ``width`` numbers into slices that fit into the cache."""
    rows = max(HELD // max(width, 1) // TOGETHER, 1) * TOGETHER
    return [slice(first, min(first + rows, count)) for first in range(0, count, rows)]


def _join_rows(rows: np.ndarray) -> np.ndarray:
    """View C-contiguous rows with TOGETHER joined to one."""
    return rows.reshape(len(rows) // TOGETHER, TOGETHER * rows.shape[1])


def inner_products(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Compute (k,) inner products of the columns of two (N, k) arrays, in their precision."""
    if first.shape[1] == 1:
        return np.dot(first.T, second)[0]
    # A product with ones is the fastest sum of long columns.
    total = np.zeros(first.shape[1], first.dtype)
    for part in row_parts(*first.shape):
        products = first[part] * second[part]
        total += _ones(products.dtype)[: len(products)] @ products
    return total


@cache
def _ones(dtype: np.dtype) -> np.ndarray:
    """As many ones as a part of :func:`row_parts` may have rows."""
    ones = np.ones(HELD, dtype)
    ones.flags.writeable = False
    return ones


def precise_inner_products(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Compute (k,) inner products, to about eight digits for single precision."""
    total = np.zeros(first.shape[1])
    ones = np.ones(TOGETHER, first.dtype)
    for part in row_parts(*first.shape):
        products = first[part] * second[part]
        whole = len(products) // TOGETHER * TOGETHER
        sums = ones @ products[:whole].reshape(-1, TOGETHER, products.shape[1])
        total += sums.sum(axis=0, dtype=float) + products[whole:].sum(axis=0, dtype=float)
    return total


def add_multiples(columns: np.ndarray, shares: np.ndarray, others: np.ndarray) -> None:
    """Add ``shares * others`` to C-contiguous columns in place."""
    if not columns.flags.c_contiguous:
        raise ValueError("the columns are not contiguous: the sum would be lost in a copy")
    shares = shares.astype(columns.dtype, copy=False)
    if columns.shape[1] == 1 and len(columns):
        get_blas_funcs("axpy", (columns,))(others.ravel(), columns.ravel(), a=shares[0])
        return
    tiled = np.empty((TOGETHER, len(shares)), shares.dtype)
    tiled[:] = shares
    tiled = tiled.ravel()
    whole = len(columns) // TOGETHER * TOGETHER
    for part in row_parts(whole, columns.shape[1]):
        changed = _join_rows(columns[part])
        changed += tiled * _join_rows(others[part])
    columns[whole:] += shares * others[whole:]
