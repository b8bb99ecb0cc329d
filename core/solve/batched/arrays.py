# SPDX-License-Identifier: GPL-3.0-or-later
"""Arithmetic on fields of a stack: (k, N, c) arrays, c columns of each of its k pieces, on the circle.

For the descent they stand side by side, as (N, k c) columns. Lifted fields become one column a piece, (n d, k) real
numbers with d a node, so that each piece descends on its own.
"""

import numpy as np

from ...pieces import Stack
from ..methods.manifolds import EMPTY


def side_by_side(fields: np.ndarray) -> np.ndarray:
    """(N, k c) columns of (k, N, c) fields."""
    return np.ascontiguousarray(fields.transpose(1, 0, 2)).reshape(fields.shape[1], -1)


def stacked_fields(columns: np.ndarray, count: int) -> np.ndarray:
    """(k, N, c) fields of (N, k c) columns."""
    return np.ascontiguousarray(columns.reshape(len(columns), count, -1).transpose(1, 0, 2))


class SideBySide:
    """(k, N, N) matrices that act on (N, k c) columns, c of each."""

    def __init__(self, matrices: np.ndarray) -> None:
        self._matrices, self.dtype = matrices, matrices.dtype

    def diagonal(self) -> np.ndarray:
        """(N,) the longest of their diagonals, which bounds the rounding error."""
        found = np.abs(np.diagonal(self._matrices, axis1=1, axis2=2))
        return found[np.argmax((found**2).sum(axis=1))]

    def __matmul__(self, columns: np.ndarray) -> np.ndarray:
        shape = (len(columns), len(self._matrices), columns.shape[1] // len(self._matrices))
        result = np.empty(shape, np.result_type(columns, self._matrices))
        np.matmul(self._matrices, columns.reshape(shape).transpose(1, 0, 2), out=result.transpose(1, 0, 2))
        return result.reshape(columns.shape)

    precondition = __matmul__


class OfLifted(SideBySide):
    """(k, N, N) matrices that act on (n d, k) columns of lifted fields."""

    def __init__(self, matrices: np.ndarray) -> None:
        super().__init__(matrices)
        self.dtype = matrices.real.dtype

    def __matmul__(self, columns: np.ndarray) -> np.ndarray:
        return as_columns(self._matrices @ self.fields(columns))

    precondition = __matmul__

    def fields(self, columns: np.ndarray) -> np.ndarray:
        """(k, N, r) lifted fields."""
        count, size = self._matrices.shape[:2]
        fields = np.ascontiguousarray(columns.T).reshape(count, size, len(columns) // size)
        return fields.view(complex) if np.iscomplexobj(self._matrices) else fields


def as_columns(fields: np.ndarray) -> np.ndarray:
    """(n d, k) real columns of (k, N, r) lifted fields."""
    fields = np.ascontiguousarray(fields)
    return np.ascontiguousarray(fields.view(fields.real.dtype).reshape(len(fields), -1).T)


def positive_inverse(matrices: np.ndarray, least: np.ndarray) -> np.ndarray:
    """Inverses of Hermitian matrices whose eigenvalues are replaced by their absolute values, at least (k,) numbers."""
    values, vectors = np.linalg.eigh(matrices)
    values = np.maximum(np.abs(values), least[:, None])
    return (vectors / values[:, None, :]) @ np.conj(vectors).swapaxes(1, 2)


def with_diagonal(matrices: np.ndarray, diagonal: np.ndarray) -> np.ndarray:
    """Matrices with (k, N) added to their diagonals."""
    result = matrices.copy()
    places = np.arange(result.shape[1])
    result[:, places, places] += diagonal
    return result


def set_unused(matrices: np.ndarray, stack: Stack, value: float) -> None:
    """Set the diagonal to a number where the stack is padded."""
    piece, row = np.nonzero(~stack.used)
    matrices[piece, row, row] = value


def diagonals(stack: Stack) -> np.ndarray:
    """(k, N) absolute values of the diagonals."""
    return np.abs(np.diagonal(stack.matrices, axis1=1, axis2=2))


def multipliers(stack: Stack, fields: np.ndarray) -> np.ndarray:
    """(k, n) lambda_i = Re<Y_i, (L Y)_i>."""
    return _at_nodes(stack, (np.conj(fields) * (stack.matrices @ fields)).real)


def _at_nodes(stack: Stack, numbers: np.ndarray) -> np.ndarray:
    """(k, n) sums of (k, N, c) over columns and the rows of each node."""
    return numbers.sum(axis=2).reshape(len(stack), -1, stack.block).sum(axis=2)


def unit_lifted(stack: Stack, fields: np.ndarray) -> np.ndarray:
    """(k, N, r) lifted fields with a unit vector per node."""
    lengths = np.sqrt(_at_nodes(stack, np.abs(fields) ** 2))
    return fields / np.repeat(np.where(lengths > 0, lengths, 1), stack.block, axis=1)[:, :, None]


def principal_columns(stack: Stack, fields: np.ndarray) -> np.ndarray:
    """Lifted fields with their columns rotated onto the singular directions; empty columns are zero."""
    own = np.where(stack.used[:, :, None], fields, 0)
    squares, rotation = np.linalg.eigh(np.conj(own).swapaxes(1, 2) @ own)
    empty = squares <= EMPTY**2 * squares[:, -1:]
    rotation = np.where(empty[:, None, :], 0, rotation)
    return own @ rotation[:, :, ::-1]


def turning_hessian(stack: Stack, fields: np.ndarray) -> np.ndarray:
    """(k, n, n) half the Hessian of the energy in the angles of (k, N, 1) phases."""
    turned = 1j * fields if stack.is_complex else _quarter_turns(fields)
    hessian = (np.conj(turned) * stack.matrices * turned.swapaxes(1, 2)).real
    if stack.block == 2:
        count, size = stack.mass.shape
        hessian = hessian.reshape(count, size, 2, size, 2).sum(axis=(2, 4))
    return with_diagonal(hessian, -multipliers(stack, fields))


def _quarter_turns(fields: np.ndarray) -> np.ndarray:
    """(k, N, c) pairs of real rows turned by a right angle."""
    pairs = fields.reshape(len(fields), -1, 2, fields.shape[2])
    return np.stack([-pairs[:, :, 1], pairs[:, :, 0]], axis=2).reshape(fields.shape)


def turning_laplacians(stack: Stack) -> np.ndarray:
    """(k, n, n) Laplacians of the turns that phases can make (see :mod:`core.algebra.coarsening`)."""
    matrices = stack.matrices
    if stack.block == 1:
        return with_diagonal(-np.abs(matrices), 2 * diagonals(stack))
    count, size = stack.mass.shape
    places = np.arange(size)
    blocks = matrices.reshape(count, size, 2, size, 2).transpose(0, 1, 3, 2, 4)
    determinants = np.linalg.det(blocks)
    result: np.ndarray = -np.sign(determinants) * np.sqrt(np.abs(determinants))
    result[:, places, places] = 0.5 * np.trace(blocks[:, places, places], axis1=2, axis2=3)
    return result
