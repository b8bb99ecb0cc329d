# SPDX-License-Identifier: GPL-3.0-or-later
"""A connected piece of a problem: the matrices that the solver works on, and their scales."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix

from .algebra.reductions import HERE, Reductions
from .connection import Fibre

# As shares of the sum of the weights: the rounding error of the quadratic form <x, L x>, and the energy, as a sum of
# squares, below which a fit is perfect to the last digit.
NOISE, PERFECT = 1e-13, 1e-18


@dataclass(frozen=True)
class Piece:
    """One connected piece in the coordinates that are solved.

    Attributes
    ----------
    matrix : (N, N) CSR, complex Hermitian (block 1) or real symmetric, N = nodes * block
    factor : CSR, matrix = factor^H factor apart from the ground's unused rows
    mass : (nodes,) positive
    block : rows per node
    is_complex : whether nodes have one complex row
    ground : index of the ground node among the piece's nodes
    rows : (N,) rows of the whole problem's coordinates
    reductions : sums over all processes that hold rows of the piece; mass, rows and fields are this process's
    """

    matrix: csr_matrix
    factor: csr_matrix
    mass: np.ndarray
    block: int
    is_complex: bool
    ground: int | None
    rows: np.ndarray
    fibre: Fibre = Fibre.VECTORS
    reductions: Reductions = HERE

    @property
    def node_count(self) -> int:
        return len(self.mass)

    @property
    def width(self) -> int:
        """Columns of a field, (N, width); as one column among others it is flattened, (N * width,)."""
        return self.fibre.width(self.block)

    @property
    def is_circle(self) -> bool:
        """Whether a node's unit vector is a point of the circle."""
        return self.width == 1 and (self.is_complex or self.block == 2)

    @property
    def total_mass(self) -> float:
        """Mass of every field: the masses of its nodes times the squares of their values."""
        return self.reductions.sum(self.mass.sum()) * self.width

    @property
    def row_mass(self) -> np.ndarray:
        """(N,) mass of each row's node."""
        return np.repeat(self.mass, self.block)

    @cached_property
    def total_weight(self) -> float:
        """Sum of the matrix's diagonal, without the ground's unused rows."""
        diagonal = np.abs(self.matrix.diagonal())
        return float(self.reductions.sum(diagonal.sum() - diagonal[self.unused_rows].sum()))

    @property
    def stiffness(self) -> float:
        """Mean diagonal of the matrix per mass: an upper scale for eigenvalues, times and shifts."""
        return self.total_weight / float(self.reductions.sum(self.row_mass.sum()))

    def scaled(self) -> tuple["Piece", float]:
        """Scale the piece to a mean diagonal and a mean mass of 1; also returns the divisor of its energies."""
        weight = self.total_weight / self.matrix.shape[0]
        matrix, factor = self.matrix / weight, self.factor / np.sqrt(weight)
        return replace(self, matrix=matrix, factor=factor, mass=self.mass / self.mass.mean()), weight

    @property
    def noise(self) -> float:
        """Rounding error of the quadratic form <x, L x>; smaller energies need sums of squares."""
        return NOISE * self.total_weight

    @property
    def perfect(self) -> float:
        """Energy, as a sum of squares, below which a fit counts as perfect."""
        return PERFECT * self.total_weight

    @property
    def unused_rows(self) -> np.ndarray:
        """Rows of the ground's block beyond the first of a vector: zero at every feasible start and optimum."""
        if self.ground is None:
            return np.empty(0, int)
        return self.ground * self.block + np.arange(self.width, self.block)

    def energy(self, columns: np.ndarray) -> np.ndarray:
        """Compute (k,) energies of k columns (Eq. 17) as sums of squares, exactly zero for a perfect fit."""
        differences = self.factor @ columns.reshape(len(self.rows), -1)
        if self.is_complex:
            return self.reductions.sum((differences.real**2 + differences.imag**2).sum(axis=0))
        return self.reductions.sum((differences**2).sum(0).reshape(-1, columns.shape[1]).sum(0))
