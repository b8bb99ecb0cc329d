# SPDX-License-Identifier: GPL-3.0-or-later
"""Connections: the transport that an edge asks for between its two nodes (paper, Def. 3.1 and Eqs. 2, 6).

An edge e = (i, j) asks for ``phi_j = g_e phi_i``. On the circle g_e multiplies by ``exp(1j * angle)``
after an optional complex conjugation (``flip``).
"""

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from .geometry.triangle_mesh import TriangleMesh


class Fibre(StrEnum):
    """Values of the nodes where transports are d x d matrices."""

    VECTORS = "vectors"
    """unit vectors in R^d"""
    ORTHOGONAL = "orthogonal"
    """frames: orthogonal d x d matrices"""
    ROTATIONS = "rotations"
    """frames of determinant 1"""

    def width(self, block: int) -> int:
        """Columns of a node's value, which has ``block`` rows."""
        return 1 if self is Fibre.VECTORS else block


@dataclass(frozen=True)
class Connection:
    """A weighted graph with one transport per edge.

    Attributes
    ----------
    edges : (e, 2) int array, from i to j
    weights : (e,) float array, positive
    transports : (e,) complex array of unit modulus for U(1), or (e, d, d) orthogonal matrices for
        any other subgroup of O(d); d = 1 is Z_2, d = 2 the circle with flips, d = 4 quaternions
    """

    node_count: int
    edges: np.ndarray
    weights: np.ndarray
    transports: np.ndarray

    def __post_init__(self) -> None:
        make_arrays(self, "edges", "weights", "transports")

    @property
    def block(self) -> int:
        """Rows per node in coordinates: 1 complex row for U(1), d real rows otherwise."""
        return 1 if self.transports.ndim == 1 else self.transports.shape[1]

    @property
    def is_circle(self) -> bool:
        """Whether phases are given and returned as complex numbers."""
        return self.transports.ndim == 1 or self.block == 2

    def energy(self, phases: np.ndarray) -> float:
        """The sum of w_e |phi_j - g_e phi_i|^2 (Eq. 17) for (n,) complex, (n, d) or (n, d, d) real values."""
        i, j = self.edges.T
        if self.transports.ndim == 1:
            moved = self.transports * phases[i]
        elif np.iscomplexobj(phases):
            return self._circle_energy(phases.real, phases.imag)
        elif phases.ndim == 3:
            moved = self.transports @ phases[i]
        else:
            moved = np.einsum("eab,eb->ea", self.transports, phases[i])
        difference = phases[j] - moved
        squares = (difference * difference.conj()).real.sum(axis=tuple(range(1, difference.ndim)))
        return float(self.weights @ squares)

    def _circle_energy(self, x: np.ndarray, y: np.ndarray) -> float:
        """:meth:`energy` of (n,) coordinates under 2 x 2 matrices, several times as fast as by products of matrices."""
        (i, j), (first, second) = self.edges.T, np.moveaxis(self.transports, 1, 0)
        tail_x, tail_y = x[i], y[i]
        off_x = x[j] - (first[:, 0] * tail_x + first[:, 1] * tail_y)
        off_y = y[j] - (second[:, 0] * tail_x + second[:, 1] * tail_y)
        return float(self.weights @ (off_x * off_x + off_y * off_y))


@dataclass(frozen=True)
class Merged:
    """``phi[nodes] = transports * phi[roots]``: transports as in :class:`Connection`."""

    nodes: np.ndarray
    roots: np.ndarray
    transports: np.ndarray

    def __post_init__(self) -> None:
        make_arrays(self, "nodes", "roots", "transports")

    @classmethod
    def none(cls) -> Self:
        """Build the empty record for the circle."""
        return cls(np.empty(0, int), np.empty(0, int), np.empty(0, complex))


@dataclass(frozen=True)
class Targets:
    """Values that nodes must have (weights None) or are drawn to by the energy w |phi_i - value|^2.

    ``values`` are complex of unit modulus on the circle, otherwise (k, d) unit vectors or (k, d, d) frames.
    """

    nodes: np.ndarray
    values: np.ndarray
    weights: np.ndarray | None = None

    def __post_init__(self) -> None:
        make_arrays(self, "nodes", "values", "weights")

    @classmethod
    def none(cls) -> Self:
        """Build the empty record for the circle, without weights."""
        return cls(np.empty(0, int), np.empty(0, complex))


def join_targets(parts: list[Targets]) -> Targets:
    """Join :class:`Targets` with weights into one, without those of weight 0."""
    parts = parts or [replace(Targets.none(), weights=np.empty(0))]
    arrays = [np.concatenate([getattr(part, name) for part in parts]) for name in ("nodes", "values", "weights")]
    return Targets(*(array[arrays[2] > 0] for array in arrays))


def make_arrays(record: object, *names: str) -> None:
    """Convert attributes of a frozen dataclass to arrays, except None."""
    for name in names:
        if getattr(record, name) is not None:
            object.__setattr__(record, name, np.asarray(getattr(record, name)))


def compose(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Compose transports, ``second`` first: (k,) numbers or (k, d, d) matrices."""
    return first * second if first.ndim == 1 else first @ second


def circle_transports(angles: ArrayLike, flips: ArrayLike | None = None) -> np.ndarray:
    """Transports on the circle for (e,) angles in radians: complex where no edge flips, otherwise 2 x 2 matrices, which
    conjugate on edges with (e,) bool flips before they turn."""
    angles = np.asarray(angles, float)
    if flips is None or not np.any(flips):
        return np.exp(1j * angles)
    sign = np.where(flips, -1.0, 1.0)
    transports = np.empty((*angles.shape, 2, 2))
    cosine, sine = np.cos(angles, out=transports[..., 0, 0]), np.sin(angles, out=transports[..., 1, 0])
    transports[..., 0, 1], transports[..., 1, 1] = -sine * sign, cosine * sign
    return transports


def are_flips(transports: np.ndarray) -> np.ndarray:
    """(k,) bool: transports that reverse orientation; complex numbers never do."""
    if transports.ndim == 1:
        return np.zeros(len(transports), bool)
    if transports.shape[1:] == (2, 2):  # several times as fast as a factorization of each
        return transports[:, 0, 0] * transports[:, 1, 1] < transports[:, 0, 1] * transports[:, 1, 0]
    return np.linalg.det(transports) < 0


def as_matrices(transports: np.ndarray) -> np.ndarray:
    """Convert complex transports to 2 x 2 matrices; matrices stay."""
    if transports.ndim == 3:
        return transports
    cosine, sine = transports.real, transports.imag
    return np.stack([np.stack([cosine, -sine], -1), np.stack([sine, cosine], -1)], -2)


def levi_civita(mesh: TriangleMesh, symmetry: int) -> np.ndarray:
    """Transport of the symmetry-th power of tangent vectors along the edges (Knöppel et al. 2013).

    A vector at angle ``a`` in the plane of i points at ``a + theta_ij`` in the plane of j, where theta_ij = direction(j
    -> i) + pi - direction(i -> j); its power turns ``symmetry`` times as far. Returns (e,) radians, for the edges of
    ``mesh`` from the lower to the higher vertex.
    """
    directions = mesh.edge_directions
    return symmetry * (directions[:, 1] + np.pi - directions[:, 0])
