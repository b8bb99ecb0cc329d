# SPDX-License-Identifier: GPL-3.0-or-later
"""Proofs that a sparse Hermitian matrix is positive definite, by a multifrontal Cholesky factorization (Duff and Reid
1983) that keeps no factor.

Nearly all entries of a factor lie in dense blocks: a factorization by dense blocks is up to three times as fast as one
column by column on surfaces, many times in solids, and takes the memory of the largest blocks alone.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import get_blas_funcs
from scipy.sparse import bsr_matrix, csr_matrix

from ..graphs import inverse
from .blocks import rows_of
from .dissection import dissect

# Rows of a panel, which are eliminated at once, and of a strip of the rest.
_PANEL, _STRIP = 256, 256


@dataclass(frozen=True)
class Elimination:
    """Blocks of rows in the order in which they are eliminated, and which later rows each changes.

    The rows of a node are all in one block.

    Attributes
    ----------
    order : (n,) rows
    starts : (b + 1,) where each block begins in the order
    reaches : of each block the places in the order, ascending, of later rows
    """

    order: np.ndarray
    starts: np.ndarray
    reaches: list[np.ndarray]

    @classmethod
    def of(
        cls, matrix: csr_matrix, block: int = 1, most: float = np.inf, widest: float = np.inf
    ) -> "Elimination | None":
        """An order by nested dissection of a matrix with a symmetric pattern, of nodes with ``block`` rows each.

        Returns None if it takes more than ``most`` multiplications, or a dense block of more than ``widest`` rows.
        """
        nodes = matrix if block == 1 else bsr_matrix(matrix, blocksize=(block, block))
        count = len(nodes.indptr) - 1
        pattern = csr_matrix((np.ones(len(nodes.indices), np.int8), nodes.indices, nodes.indptr), (count, count))
        number = dissect(pattern)
        order, starts = np.argsort(number, kind="stable"), np.append(0, np.cumsum(np.bincount(number)))
        place = inverse(order)
        permuted = pattern[order]
        heads, pointers = place[permuted.indices], permuted.indptr
        own, reaches, products = number[order], [], 0.0
        waiting: list[list[np.ndarray]] = [[] for _ in starts[1:]]
        for step, (start, end) in enumerate(zip(starts[:-1].tolist(), starts[1:].tolist(), strict=True)):
            reach = np.unique(np.concatenate([heads[pointers[start] : pointers[end]], *waiting[step]]))
            reach = reach[np.searchsorted(reach, end) :]
            products += float(_products(block * (end - start), block * len(reach)))
            if products > most or block * (end - start + len(reach)) > widest:
                return None
            reaches.append(reach)
            waiting[step] = []
            if len(reach):
                waiting[own[reach[0]]].append(reach)
        return cls(rows_of(order, block), block * starts, [rows_of(reach, block) for reach in reaches])

    @cached_property
    def sizes(self) -> tuple[np.ndarray, np.ndarray]:
        """(b,) rows of each block, and (b,) rows that it reaches."""
        return np.diff(self.starts), np.array([len(reach) for reach in self.reaches], int)

    @property
    def parents(self) -> np.ndarray:
        """(b,) the parent of each block in the elimination tree, -1 for a root."""
        owner = np.repeat(np.arange(len(self.reaches)), self.sizes[0])
        return np.array([owner[reach[0]] if len(reach) else -1 for reach in self.reaches], int)

    @property
    def products(self) -> float:
        """Number of multiplications."""
        return float(_products(*self.sizes).sum())

    @property
    def entries(self) -> int:
        """The most entries of dense blocks at a time."""
        own, later = self.sizes
        kept, most, parents = np.zeros(len(own), np.int64), 0, self.parents
        total = 0
        for block, (one, two) in enumerate(zip(own.tolist(), later.tolist(), strict=True)):
            most = max(most, total + (one + two) ** 2 + two**2)
            total += two**2 - int(kept[block])
            if parents[block] >= 0:
                kept[parents[block]] += two**2
        return most

    @cached_property
    def chains(self) -> np.ndarray:
        """(b,) the most roundings of a product of entries in each block's rows, and of an entry of the matrix.

        A product is added to the others of its panel, their sum to the rest of the block, and that to the parent's,
        up to the root; an entry of the matrix goes through the additions alone.
        """
        own, parents = self.sizes[0], self.parents
        panels = -(-own // _PANEL)
        children = np.bincount(parents[parents >= 0], minlength=len(own))
        added, above = panels + children, np.zeros(len(own), int)
        for block in range(len(own) - 1, -1, -1):
            if parents[block] >= 0:
                above[block] = above[parents[block]] + added[parents[block]]
        return np.minimum(own, _PANEL) + 3 + panels + above + int((above + added).max(initial=0))


def _products(own: ArrayLike, later: ArrayLike) -> np.ndarray:
    """Count the multiplications for blocks with ``own`` rows that reach ``later`` ones."""
    own, later = np.asarray(own, float), np.asarray(later, float)
    return own**3 / 6 + own**2 * later / 2 + own * later**2 / 2


def rounding_error(matrix: csr_matrix, elimination: Elimination) -> np.ndarray | None:
    """Factorize a Hermitian matrix with positive diagonal in the order of an elimination of its pattern.

    Returns None if the factorization does not run to its end: the matrix is not positive definite. Otherwise A + E is
    positive semidefinite, where the computed factor bounds the error of rounding: |E| <= t eps |R|^H |R|, with t the
    roundings of one term (Higham 2002, Theorem 10.3; an eps of twice the unit roundoff leaves room for terms of second
    order), for real numbers. The result are the (n,) row sums of that bound, in units of eps.
    """
    starts, parents = elimination.starts, elimination.parents
    permuted = matrix[elimination.order]
    heads, pointers, data = inverse(elimination.order)[permuted.indices], permuted.indptr, permuted.data
    waiting: list[list[tuple[np.ndarray, np.ndarray]]] = [[] for _ in parents]
    errors = np.zeros(matrix.shape[0])
    for block, reach in enumerate(elimination.reaches):
        start, end = starts[block : block + 2].tolist()
        rows = np.concatenate([np.arange(start, end), reach])
        # Of dense blocks the upper triangle is used.
        front = np.zeros((len(rows), len(rows)), data.dtype)
        entries = slice(pointers[start], pointers[end])
        inner = np.repeat(np.arange(end - start), np.diff(pointers[start : end + 1]))
        later = heads[entries] >= start
        columns = heads[entries][later]
        at = np.searchsorted(rows, columns)
        if (rows[np.minimum(at, len(rows) - 1)] != columns).any():
            raise ValueError("the matrix has entries outside of the elimination's pattern")
        front[inner[later], at] = data[entries][later]
        while waiting[block]:
            rest, those = waiting[block].pop()
            at = np.searchsorted(rows, those)
            for strip in range(0, len(at), _STRIP):
                front[np.ix_(at[strip : strip + _STRIP], at[strip:])] += rest[strip : strip + _STRIP, strip:]
            del rest
        sums = _eliminate(front, end - start)
        if sums is None:
            return None
        errors[rows] += elimination.chains[block] * sums
        if len(reach):
            waiting[parents[block]].append((front[end - start :, end - start :].copy(), reach))
        del front
    result = np.empty_like(errors)
    result[elimination.order] = errors
    return result


def _eliminate(front: np.ndarray, count: int) -> np.ndarray | None:
    """Eliminate the first rows of the upper triangle of a dense block; None where that is not possible.

    Returns the row sums of |R|^H |R| for the rows R of the factor. Products come from NumPy, which lets other threads
    run meanwhile; functions of scipy.linalg do not.
    """
    (solve,) = get_blas_funcs(("trsm",), dtype=front.dtype)
    sums = np.zeros(len(front))
    for first in range(0, count, _PANEL):
        last = min(first + _PANEL, count)
        try:
            factor = np.linalg.cholesky(front[first:last, first:last].conj().T)
        except np.linalg.LinAlgError:
            return None
        if not np.isfinite(factor).all():
            return None
        panel = np.ascontiguousarray(front[first:last, last:])
        if panel.size:
            panel = solve(1, factor, panel.T, side=1, lower=1, trans_a=1, overwrite_b=1).T
        sizes, later = np.abs(factor), np.abs(panel)
        of_rows = sizes.sum(axis=0) + later.sum(axis=1)
        sums[first:last] += sizes @ of_rows
        sums[last:] += of_rows @ later
        for strip in range(last, len(front), _STRIP):
            here = slice(strip, strip + _STRIP)
            front[here, strip:] -= panel[:, strip - last : strip - last + _STRIP].conj().T @ panel[:, strip - last :]
    return sums
