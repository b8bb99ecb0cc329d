# SPDX-License-Identifier: GPL-3.0-or-later
"""Arithmetic on columns of real numbers with many short rows, in parts that fit into a core's cache.

NumPy is slow if the last axis is short, so that several rows are joined to one; BLAS handles a single column.

Among two columns or more, the bits of one do not depend on how many others there are, so that cores can share them.
BLAS gets two columns at a time.
"""

from itertools import pairwise

import numpy as np
from scipy.linalg.blas import get_blas_funcs

# Numbers that fit into the cache, and rows that are joined to one.
HELD, TOGETHER = 131072, 64
# Rows that are summed at once, and rows of joined ones that are summed in single precision.
SUMMED, FEW = 8192, 8
# Sum over the first axis, without the checks of ``np.sum``.
_sum = np.add.reduce
# Columns that stay side by side.
PAIR = 2


def row_parts(count: int, width: int) -> list[slice]:
    """Split ``count`` rows of ``width`` numbers into slices that fit into the cache."""
    rows = max(HELD // max(width, 1) // TOGETHER, 1) * TOGETHER
    return [slice(first, min(first + rows, count)) for first in range(0, count, rows)]


def _join_rows(rows: np.ndarray) -> np.ndarray:
    """View C-contiguous rows with TOGETHER joined to one."""
    return rows.reshape(len(rows) // TOGETHER, TOGETHER * rows.shape[1])


def split_columns(count: int, parts: int) -> list[slice]:
    """Split ``count`` columns into at most ``parts`` parts, of whole pairs and without a part of a single column."""
    cuts = np.arange(0, max(count - 1, 1), PAIR)
    firsts = [int(part[0]) for part in np.array_split(cuts, min(parts, len(cuts)))]
    return [slice(*ends) for ends in pairwise([*firsts, count])]


def inner_products(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Compute (k,) inner products of the columns of two (N, k) arrays, in their precision."""
    if first.shape[1] == 1:
        return np.dot(first.T, second)[0]
    total = np.zeros(first.shape[1], first.dtype)
    for start in range(0, len(first), SUMMED):
        total += _sum_rows(first[start : start + SUMMED] * second[start : start + SUMMED])
    return total


def sum_rows(rows: np.ndarray) -> np.ndarray:
    """Compute (k,) sums of (N, k) real or complex rows, in their precision."""
    total = np.zeros(rows.shape[1], rows.dtype)
    for start in range(0, len(rows), SUMMED):
        total += _sum_rows(rows[start : start + SUMMED])
    return total


def _sum_rows(rows: np.ndarray) -> np.ndarray:
    whole = len(rows) // TOGETHER * TOGETHER
    sums = _sum(_sum(_join_rows(rows[:whole])).reshape(TOGETHER, -1))
    return sums + _sum(rows[whole:]) if whole < len(rows) else sums


def precise_inner_products(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Compute (k,) inner products, to about eight digits for single precision."""
    total = np.zeros(first.shape[1])
    for start in range(0, len(first), SUMMED):
        products = first[start : start + SUMMED] * second[start : start + SUMMED]
        whole = len(products) // (FEW * TOGETHER) * FEW * TOGETHER
        sums = _join_rows(products[:whole]).reshape(-1, FEW, TOGETHER * products.shape[1]).sum(axis=1)
        total += sums.sum(axis=0, dtype=float).reshape(TOGETHER, -1).sum(axis=0)
        total += products[whole:].sum(axis=0, dtype=float)
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
