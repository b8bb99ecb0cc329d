# SPDX-License-Identifier: GPL-3.0-or-later
"""The matrix of a piece as a function of the angles of its transports: a constant, and a part that is linear in their
cosines and sines.

Where only the angles change, as with the spacing of a pattern, one sparse product makes the next matrix; two sparse
matrices and their product would take many times as long.
"""

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix

from ..connection import are_flips, as_matrices
from ..piece import Piece
from ..problem import SynchronizationProblem


class AngleMatrix:
    """The matrix of a piece, in single precision, for any angles of the transports of its problem, on the circle.

    Parameters
    ----------
    piece : of the problem, scaled
    weight : the divisor of its energies by its scale
    """

    def __init__(self, problem: SynchronizationProblem, piece: Piece, weight: float) -> None:
        parts = [_entries(problem, piece, unit) for unit in (1, 1j)]
        rows, columns, values, sources = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
        matrix, numbers = piece.matrix, _numbers(piece.matrix, rows, columns)
        if (numbers < 0).any():  # entries that are zero for the present angles
            known = matrix.tocoo()
            places = np.append(known.row, rows), np.append(known.col, columns)
            matrix = coo_matrix((np.append(known.data, np.zeros(len(rows))), places), matrix.shape).tocsr()
            numbers = _numbers(matrix, rows, columns)
        if piece.is_complex:  # real and imaginary parts
            numbers, sources = (2 * numbers[:, None] + np.arange(2)).ravel(), np.repeat(sources, 2)
        constant, components = matrix.data.view(float), _components(problem.connection.transports)
        turning = coo_matrix(
            (values.view(float) / weight, (numbers, sources)), (len(constant), len(components))
        ).tocsr()
        self._constant = (constant - turning @ components).astype(np.float32)
        self._turning = turning.astype(np.float32)
        self._matrix = matrix.astype(np.complex64 if piece.is_complex else np.float32)

    def at(self, transports: np.ndarray) -> csr_matrix:
        """The matrix for (e,) or (e, 2, 2) transports that differ from the problem's in their angles."""
        data = self._turning @ _components(transports).astype(np.float32)
        data += self._constant
        matrix = self._matrix
        return csr_matrix((data.view(matrix.dtype), matrix.indices, matrix.indptr), matrix.shape)


def _numbers(matrix: csr_matrix, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """(k,) numbers of entries of a matrix with sorted indices, -1 where a place has none."""
    width = matrix.shape[1]
    keys = np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr)) * width + matrix.indices
    wanted = rows * width + columns
    numbers = np.searchsorted(keys, wanted).clip(0, len(keys) - 1)
    return np.where(keys[numbers] == wanted, numbers, -1)


def _components(transports: np.ndarray) -> np.ndarray:
    """(2 e,) cosine and sine of the angle of each transport."""
    return transports.view(float) if transports.ndim == 1 else transports[:, :, 0].ravel()


def _entries(
    problem: SynchronizationProblem, piece: Piece, unit: complex
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """The part of the matrix that is linear in the cosines, for the unit 1, or sines, for 1j, before it is scaled.

    Returns rows, columns and values of entries, which may repeat a place, and the numbers of their :func:`_components`.
    """
    transports, block = problem.connection.transports, piece.block
    count = len(transports)
    units = np.full(count, unit, complex)
    if transports.ndim == 3:
        signs = np.column_stack([np.ones(count), np.where(are_flips(transports), -1.0, 1.0)])
        units = as_matrices(units) * signs[:, None]
    links = problem.with_transports(units).links
    nodes = np.full(len(problem.unit_coordinates()) // block, -1)
    nodes[piece.rows[::block] // block] = np.arange(piece.node_count)
    edges = np.flatnonzero(nodes[links.tails[:count]] >= 0)
    tails, heads, weights = nodes[links.tails[edges]], nodes[links.heads[edges]], links.weights[edges]
    before, after = (array[edges].reshape(-1, block, block) for array in (links.before, links.after))
    values = -weights[:, None, None] * (after.conj().swapaxes(1, 2) @ before)
    edge, row, column = np.nonzero(values)
    rows, columns, values = block * heads[edge] + row, block * tails[edge] + column, values[edge, row, column]
    numbers = 2 * edges[edge] + (unit == 1j)
    return (
        np.append(rows, columns),
        np.append(columns, rows),
        np.append(values, values.conj()),
        np.append(numbers, numbers),
    )
