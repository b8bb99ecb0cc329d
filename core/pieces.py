# SPDX-License-Identifier: GPL-3.0-or-later
"""The connected pieces of a problem: each on its own, or many small ones as a stack of dense matrices."""

from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np
from scipy.sparse import csr_matrix, diags_array

from .algebra.blocks import rows_of
from .connection import Fibre
from .graphs import ragged_arange
from .piece import NOISE, PERFECT, Piece


class Pieces:
    """The connected pieces with at least one row of the factor, each made when first used.

    Without a factor (:meth:`with_factor`) only sizes, rows and scales are available.

    Parameters
    ----------
    labels : (r,) component label of each row of the factor
    scales : (r,) sum of the weights that were combined in each of its rows
    masses, components : (c,) mass and component label of each column of a node
    grounds : (labels,) column of each component's ground, or -1
    places : (c,) order of the columns in a piece
    block, is_complex, fibre : as in :class:`Piece`

    Attributes
    ----------
    sizes : (k,) nodes of each piece
    scales : (k,) sum of the diagonal of each piece's matrix, without unused rows, before weights cancelled
    grounds : (k,) column of each piece's ground, or -1
    roots : (k,) column of each piece's ground, or of its first node
    """

    def __init__(
        self,
        labels: np.ndarray,
        scales: np.ndarray,
        masses: np.ndarray,
        components: np.ndarray,
        grounds: np.ndarray,
        places: np.ndarray,
        block: int,
        is_complex: bool,
        fibre: Fibre = Fibre.VECTORS,
    ) -> None:
        self._masses, self._block, self._is_complex = masses, block, is_complex
        self._fibre = fibre
        self._order = np.lexsort((places, components))
        self._rows = np.argsort(labels, kind="stable")
        sizes, row_counts = (np.bincount(of, minlength=len(grounds)) for of in (components, labels))
        kept = np.flatnonzero((sizes > 0) & (row_counts > 0))
        self.sizes, self._starts = sizes[kept], (np.cumsum(sizes) - sizes)[kept]
        self._row_counts, self._row_starts = row_counts[kept], (np.cumsum(row_counts) - row_counts)[kept]
        self.grounds = grounds[kept]
        firsts = np.full(len(grounds), len(components))
        np.minimum.at(firsts, components, np.arange(len(components)))
        self.roots = np.where(self.grounds >= 0, self.grounds, firsts[kept])
        self._piece_of_row = np.empty(len(labels), int)
        self._piece_of_row[self._rows] = np.repeat(np.arange(len(kept)), self._row_counts)
        self.scales = self._sums(scales)

    def with_factor(self, factor: csr_matrix) -> Self:
        """The pieces of an (r, N) CSR factor of the whole problem."""
        twin = copy(self)
        twin._factor, twin._made = factor, {}
        return twin

    @cached_property
    def weights(self) -> np.ndarray:
        """(k,) sum of the diagonal of each piece's matrix, without unused rows."""
        squares = np.abs(self._factor.data) ** 2
        return self._sums(np.add.reduceat(np.append(squares, 0.0), self._factor.indptr[:-1]))

    _factor: csr_matrix
    _made: dict[int, Piece]

    def __len__(self) -> int:
        return len(self.sizes)

    def __getitem__(self, number: int) -> Piece:
        if number not in self._made:
            self._made[number] = self._piece(number)
        return self._made[number]

    def __iter__(self) -> Iterator[Piece]:
        return map(self.__getitem__, range(len(self)))

    @property
    def noise(self) -> np.ndarray:
        """(k,) energy that rounding alone can cause."""
        return NOISE * self.scales

    def aligned(self, frames: np.ndarray) -> np.ndarray:
        """Compute the (N,) best-fitting unit coordinates that are constant in (N, block) frames of each piece.

        With a ground they are its value, otherwise the first axis wherever it fits. Nodes that carry frames keep these.
        """
        if self._fibre is not Fibre.VECTORS:
            return frames
        count = len(self)
        axes = np.zeros((count + 1, self._block), frames.dtype)  # the last row is for nodes in no piece
        axes[:, 0] = 1
        differences = self._factor @ frames
        products = np.conj(differences[:, :, None]) * differences[:, None, :]
        squares = np.stack([self._sums(column) for column in products.reshape(len(products), -1).real.T], axis=1)
        squares = squares.reshape(count, self._block, self._block)
        free = np.flatnonzero((self.grounds < 0) & (squares[:, 0, 0] > PERFECT * self.scales))
        if self._block > 1:
            axes[free] = np.linalg.eigh(squares[free])[1][:, :, 0]
        owners = np.full(len(frames), count)
        owners[self.rows(np.arange(count))] = np.repeat(np.arange(count), self.sizes * self._block)
        fields = np.einsum("rb,rb->r", frames, axes[owners])
        nodes = fields.reshape(-1, self._block)
        return (nodes / np.linalg.norm(nodes, axis=1, keepdims=True)).ravel()

    def fitted(self, coordinates: np.ndarray, with_noise: bool = False) -> np.ndarray:
        """Tell which pieces (N,) or (N, width) coordinates fit perfectly, or up to the noise of a solve, (k,) bool."""
        return self.energies(coordinates) <= (self.noise if with_noise else PERFECT * self.scales)

    def energies(self, coordinates: np.ndarray) -> np.ndarray:
        """Compute the (k,) energies of (N,) or (N, width) coordinates as sums of squares."""
        squares = np.abs(self._factor @ coordinates) ** 2
        return self._sums(squares.sum(axis=1) if squares.ndim == 2 else squares)

    def energies_of(self, numbers: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """Compute (k,) energies, summed over columns, of pieces whose rows are concatenated in (m, c) columns."""
        rows = self.rows(numbers)
        factor = _with_columns(self._factor[self._factor_rows(numbers)], rows, np.arange(len(rows)), len(rows))
        squares = (np.abs(factor @ columns) ** 2).sum(axis=1)
        return np.add.reduceat(squares, np.append(0, np.cumsum(self._row_counts[numbers])[:-1]))

    def _sums(self, of_rows: np.ndarray) -> np.ndarray:
        """Sum (r,) values of the factor's rows per piece."""
        rows = self._rows
        return np.bincount(self._piece_of_row[rows], of_rows[rows], len(self))

    def rows(self, numbers: np.ndarray) -> np.ndarray:
        """Concatenate the rows of pieces in the whole problem's coordinates."""
        columns, _ = self._columns(numbers)
        return rows_of(columns, self._block)

    def masses(self, numbers: np.ndarray) -> np.ndarray:
        """Concatenate the masses of the nodes of pieces."""
        return self._masses[self._columns(numbers)[0]]

    def _columns(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Concatenate the columns of pieces; also returns the position in ``numbers`` of each column's piece."""
        owners, places = ragged_arange(self.sizes[numbers])
        return self._order[self._starts[numbers][owners] + places], owners

    def _factor_rows(self, numbers: np.ndarray) -> np.ndarray:
        owners, places = ragged_arange(self._row_counts[numbers])
        return self._rows[self._row_starts[numbers][owners] + places]

    def _piece(self, number: int) -> Piece:
        """The :class:`Piece` of a number: its rows of the factor, in coordinates of its own."""
        block, numbers = self._block, np.array([number])
        rows = self.rows(numbers)
        whole = len(rows) == self._factor.shape[1]
        factor = self._factor if whole else self._factor[self._factor_rows(numbers)]
        factor = _with_columns(factor, rows, np.arange(len(rows)), len(rows))
        matrix = (factor.conj().T @ factor).tocsr()
        matrix.sum_duplicates()
        ground, ground_column = None, self.grounds[number]
        if ground_column >= 0:
            ground = int(np.flatnonzero(rows[::block] == ground_column * block)[0])
            unused = ground * block + np.arange(self._fibre.width(block), block)
            # Rows of the ground beyond its first are zero at every optimum if they cost this much.
            penalty = np.zeros(len(rows))
            penalty[unused] = max(2 * abs(matrix[ground * block, ground * block]), abs(matrix.diagonal()).mean())
            matrix = (matrix + diags_array(penalty)).tocsr() if len(unused) else matrix
        masses = self._masses[rows[::block] // block]
        return Piece(matrix, factor, masses, block, self._is_complex, ground, rows, self._fibre)

    def stack(self, numbers: np.ndarray) -> "Stack":
        """Build the :class:`Stack` of pieces with positive weights."""
        block, sizes = self._block, self.sizes[numbers]
        count, most = len(numbers), sizes.max()
        columns, owners = self._columns(numbers)
        nodes = owners * most + ragged_arange(sizes)[1]
        rows = rows_of(nodes, block)
        weights = self.weights[numbers] / (block * sizes)
        factor = self._factor[self._factor_rows(numbers)]
        factor = _with_columns(factor, rows_of(columns, self._block), rows, count * most * block)
        product = (factor.conj().T @ factor).tocoo()
        size = most * block
        matrices = np.zeros((count, size, size), product.dtype)
        owner = product.row // size
        matrices[owner, product.row % size, product.col % size] = product.data / weights[owner]
        mass = np.ones(count * most)
        mass[nodes] = self._masses[columns] / (np.bincount(owners, self._masses[columns]) / sizes)[owners]
        used = np.zeros(count * size, bool)
        used[rows] = True
        grounds = np.full(count, -1)
        is_ground = np.flatnonzero(columns == self.grounds[numbers][owners])
        grounds[owners[is_ground]] = nodes[is_ground] % most
        held = np.flatnonzero(grounds >= 0)
        first = grounds[held] * block
        for row in range(1, block):
            # The penalty of _piece, for a mean diagonal of 1.
            matrices[held, first + row, first + row] = np.maximum(2 * np.abs(matrices[held, first, first]), 1.0)
        return Stack(
            matrices, mass.reshape(count, most), used.reshape(count, size), grounds, block, self._is_complex, weights
        )


@dataclass(frozen=True)
class Stack:
    """k pieces as dense matrices, scaled as by :meth:`Piece.scaled` and padded to the same number n of nodes.

    Attributes
    ----------
    matrices : (k, N, N) complex Hermitian or real symmetric, N = n * block; zero in the padding
    mass : (k, n) positive
    used : (k, N) bool, rows of the pieces
    grounds : (k,) ground of each piece among its nodes, or -1
    block, is_complex : as in :class:`Piece`
    weights : (k,) divisors of the energies
    """

    matrices: np.ndarray
    mass: np.ndarray
    used: np.ndarray
    grounds: np.ndarray
    block: int
    is_complex: bool
    weights: np.ndarray

    def __len__(self) -> int:
        return len(self.matrices)

    def __getitem__(self, chosen: np.ndarray) -> "Stack":
        """Select pieces by any index of a (k,) array."""
        names = ("matrices", "mass", "used", "grounds", "weights")
        return replace(self, **{name: getattr(self, name)[chosen] for name in names})

    @property
    def row_mass(self) -> np.ndarray:
        """(k, N) mass of each row's node; 1 in the padding."""
        return np.repeat(self.mass, self.block, axis=1)


def _with_columns(matrix: csr_matrix, columns: np.ndarray, places: np.ndarray, count: int) -> csr_matrix:
    """Move (c,) columns of a CSR matrix, the only ones with entries, to (c,) places among ``count``."""
    moved = np.empty(matrix.shape[1], matrix.indices.dtype)
    moved[columns] = places
    return csr_matrix((matrix.data.copy(), moved[matrix.indices], matrix.indptr), shape=(matrix.shape[0], count))
