# SPDX-License-Identifier: GPL-3.0-or-later
"""Products of spheres and of Stiefel manifolds: the manifolds of lifted fields and of sets of candidates.

An array has one group of ``block`` rows per node. :class:`Lifted` (Eq. 24): the whole group, all columns, is one unit
vector, or ``width`` orthonormal ones where nodes carry frames. Candidates: each column is a separate field with one
unit vector per node, either on the circle (:class:`Circles`, whose tangent vectors are angles) or in any R^d
(:class:`Columns`). A field of frames, (N, width), is one column, too: (N * width,), row by row.

All have the same methods. ``point`` and ``image`` (the matrix times the point) are arrays in rows of the matrix;
tangent vectors are real arrays, whose sums go over everything (:class:`Lifted`, one value) or over each column (k
values). ``memory`` is the number of moves that a descent stores; ``reductions`` sums over all processes.
"""

from dataclasses import KW_ONLY, dataclass
from typing import Protocol, TypeAlias

import numpy as np

from ...algebra.blocks import traces
from ...algebra.columns import add_multiples, inner_products, precise_inner_products, row_parts, sum_rows
from ...algebra.orthonormal import gram, nearest, orthonormalize, tangent_part
from ...algebra.reductions import HERE, Reductions
from ...connection import Fibre
from ...piece import Piece

# Columns whose singular value is below this share of the largest are empty.
EMPTY = 1e-6


class Preconditioner(Protocol):
    """A metric with an approximate inverse."""

    def precondition(self, columns: np.ndarray) -> np.ndarray: ...


@dataclass(frozen=True)
class Lifted:
    """One lifted field: (N, r) with ``width`` orthonormal vectors per node; tangent vectors are like those.

    A vector has block / width rows: of a unit vector the whole group, of frames one.
    """

    block: int
    width: int = 1
    reductions: Reductions = HERE
    # The metric is close to the Hessian: storing more saves no step.
    memory = 2

    def _vectors(self, array: np.ndarray) -> np.ndarray:
        """(nodes, width, m) real coordinates, a view. Row sums over contiguous floats are fast in NumPy."""
        array = np.ascontiguousarray(array)
        return array.view(array.real.dtype).reshape(len(array) // self.block, self.width, -1)

    def normalize(self, point: np.ndarray) -> np.ndarray:
        """Every vector scaled to length one, those of a frame made orthogonal; zero vectors stay zero."""
        return _like(orthonormalize(self._vectors(point).copy()), point)

    def multipliers(self, point: np.ndarray, image: np.ndarray) -> np.ndarray:
        """(nodes,) lambda_i = Re<Y_i, (L Y)_i>; of frames symmetric blocks (nodes, d, d)."""
        products: np.ndarray = gram(self._vectors(point), self._vectors(image))
        return products[:, 0, 0] if self.width == 1 else products

    def energies(self, point: np.ndarray, image: np.ndarray) -> np.ndarray:
        """(1,) energy Re<Y, L Y>."""
        return self.reductions.sum(traces(self.multipliers(point, image)).sum(keepdims=True, dtype=float))

    def gradient(self, point: np.ndarray, image: np.ndarray) -> np.ndarray:
        """Half the energy's gradient: the part of the image that is tangent."""
        return tangent_part(self._vectors(point), self._vectors(image))

    def precondition(self, vector: np.ndarray, metric: Preconditioner, point: np.ndarray) -> np.ndarray:
        """The inverse metric applied to real coordinates like those of ``point``."""
        return self._vectors(metric.precondition(_like(vector, point)))

    def tangent(self, point: np.ndarray, vector: np.ndarray) -> np.ndarray:
        """Part of real coordinates that is tangent at the point."""
        vectors = self._vectors(point)
        return tangent_part(vectors, vector.reshape(vectors.shape))

    def move(self, point: np.ndarray, tangent: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Step along a tangent vector, and back to the spheres."""
        moved: np.ndarray = tangent * tangent.dtype.type(lengths[0])
        moved += self._vectors(point)
        return _like(orthonormalize(moved), point)

    def inner(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        """(1,) inner product of tangent vectors."""
        return self.reductions.sum(inner_products(first.reshape(-1, 1), second.reshape(-1, 1)).astype(float))

    @staticmethod
    def add(vector: np.ndarray, shares: np.ndarray, other: np.ndarray) -> None:
        """Add a multiple of another tangent vector, in place and in one pass through memory."""
        if not vector.flags.c_contiguous:
            raise ValueError("the vector is not contiguous: the sum would be lost in a copy")
        add_multiples(vector.reshape(-1, 1), shares, other.reshape(-1, 1))


@dataclass(frozen=True)
class _Fields:
    """The methods that all columns share."""

    block: int
    _: KW_ONLY
    reductions: Reductions = HERE
    memory = 4

    def energies(self, point: np.ndarray, image: np.ndarray) -> np.ndarray:
        """(k,) energies Re<x, L x>."""
        products = precise_inner_products(_real_columns(point), _real_columns(image))
        return self.reductions.sum(products.reshape(-1, 2 if np.iscomplexobj(point) else 1).sum(axis=1))

    def inner(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        """(k,) inner products of tangent vectors."""
        return self.reductions.sum(inner_products(first, second).astype(float))

    @staticmethod
    def add(vector: np.ndarray, shares: np.ndarray, other: np.ndarray) -> None:
        """Add multiples of another tangent vector's columns, in place."""
        add_multiples(vector, shares, other)

    def aligned(self, columns: np.ndarray, targets: np.ndarray) -> np.ndarray:
        """Columns times the global phase (a sign in real coordinates) that brings each nearest its target."""
        products = sum_rows(targets * columns.conj())
        sizes = np.abs(products)
        turns = np.where(sizes > 0, products / np.where(sizes > 0, sizes, 1), 1)
        return columns * turns.astype(columns.dtype)

    def agreements(self, columns: np.ndarray) -> np.ndarray:
        """(k, k) how far columns agree when they are turned as a whole, at most the number of nodes."""
        return np.abs(columns.conj().T @ columns)

    def ground_to_one(self, columns: np.ndarray, ground: int) -> np.ndarray:
        """Columns turned as a whole, so that a node has the phase 1."""
        value = columns[ground * self.block]
        return columns * np.conj(value / np.abs(value))


@dataclass(frozen=True)
class Circles(_Fields):
    """Fields on the circle, complex (block 1) or as pairs of rows (block 2); tangent vectors are (nodes, k) angles."""

    def _pair(self, array: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        if self.block == 1:
            return array.real, array.imag
        pairs = array.reshape(len(array) // 2, 2, -1)
        return pairs[:, 0], pairs[:, 1]

    def normalize(self, point: np.ndarray) -> np.ndarray:
        """Nearest point: every vector scaled to length one; where it vanishes, the phase 1."""
        if self.block == 1:
            lengths = np.abs(point)
            return _fill_zero_columns(point * _inverse(lengths), lengths, 1)
        cosine, sine = self._pair(point)
        lengths = np.sqrt(cosine * cosine + sine * sine)
        return _fill_zero_columns(point * np.repeat(_inverse(lengths), 2, axis=0), lengths, 2)

    def gradient(self, point: np.ndarray, image: np.ndarray) -> np.ndarray:
        """Half the energy's derivative by the angles."""
        cosine, sine = self._pair(point)
        along, across = self._pair(image)
        return cosine * across - sine * along

    def precondition(self, vector: np.ndarray, metric: Preconditioner, _point: np.ndarray) -> np.ndarray:
        """The inverse metric of turns applied to angles."""
        return metric.precondition(vector)

    def tangent(self, _point: np.ndarray, vector: np.ndarray) -> np.ndarray:
        """All angles are tangent."""
        return vector

    def move(self, point: np.ndarray, tangent: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Turn every value by an angle, given by its tangent."""
        lengths = lengths.astype(tangent.dtype)
        if self.block == 1:
            moved = np.empty_like(point)
            for part in row_parts(len(point), 2 * point.shape[1]):
                turn = np.empty(tangent[part].shape, point.dtype)
                turn.real, turn.imag = 1, tangent[part] * lengths
                turn *= point[part]
                np.multiply(turn, _inverse(np.abs(turn)), out=moved[part])
            return moved
        angles = tangent * lengths
        inverse = 1 / np.sqrt(1 + angles * angles)
        cosine, sine = self._pair(point)
        turned = np.stack([cosine - angles * sine, sine + angles * cosine], axis=1)
        turned *= inverse[:, None]
        return turned.reshape(point.shape)


@dataclass(frozen=True)
class CirclesByFields(Circles):
    """Circles that descend in the metric of fields, which fits less well than that of turns but exists already."""

    def precondition(self, vector: np.ndarray, metric: Preconditioner, point: np.ndarray) -> np.ndarray:
        """The preconditioned vector of angular velocities: the metric acts on the velocities of the unit numbers."""
        cosine, sine = self._pair(point)
        if self.block == 1:
            along = metric.precondition(1j * point * vector)
        else:
            along = metric.precondition(np.stack([-sine * vector, cosine * vector], axis=1).reshape(point.shape))
        x, y = self._pair(along)
        return cosine * y - sine * x


@dataclass(frozen=True)
class Columns(_Fields):
    """Fields of unit vectors in R^d, d = block, or of frames; tangent vectors are rows like the points."""

    fibre: Fibre = Fibre.VECTORS

    @property
    def _width(self) -> int:
        return self.fibre.width(self.block)

    @property
    def _is_special(self) -> bool:
        return self.fibre is Fibre.ROTATIONS

    def _vectors(self, columns: np.ndarray) -> np.ndarray:
        """(nodes, width, m, k) coordinates, a view: the orthonormal vectors of a node are the rows of its frame."""
        return columns.reshape(len(columns) // (self.block * self._width), self._width, -1, columns.shape[1])

    def _matrices(self, columns: np.ndarray) -> np.ndarray:
        """(nodes, k, d, d) frames."""
        return self._vectors(columns).transpose(0, 3, 1, 2)

    def normalize(self, point: np.ndarray) -> np.ndarray:
        """Nearest point: every vector scaled to length one; where it vanishes, the first unit vector.

        Frames become the nearest rotations or orthogonal matrices; fields of rotations with more reflections than
        rotations are reflected as a whole first.
        """
        if self._width > 1:
            frames = nearest(self._matrices(point), self._is_special, among=0)
            return frames.transpose(0, 2, 3, 1).reshape(point.shape)
        vectors = self._vectors(point)
        lengths = np.sqrt(gram(vectors, vectors)[:, 0, 0])
        columns = (vectors * _inverse(lengths)[:, None, None]).reshape(point.shape)
        return _fill_zero_columns(columns, lengths, self.block)

    def gradient(self, point: np.ndarray, image: np.ndarray) -> np.ndarray:
        """Half the energy's gradient: the part of the image that is tangent."""
        return tangent_part(self._vectors(point), self._vectors(image)).reshape(image.shape)

    def precondition(self, vector: np.ndarray, metric: Preconditioner, _point: np.ndarray) -> np.ndarray:
        """The inverse metric applied to rows."""
        return metric.precondition(vector)

    def tangent(self, point: np.ndarray, vector: np.ndarray) -> np.ndarray:
        """Part of rows that is tangent at the point."""
        return self.gradient(point, vector)

    def move(self, point: np.ndarray, tangent: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Step along a tangent vector, and back to the spheres."""
        moved = np.ascontiguousarray(point + tangent * lengths.astype(tangent.dtype))
        orthonormalize(self._vectors(moved))
        return moved

    def aligned(self, columns: np.ndarray, targets: np.ndarray) -> np.ndarray:
        if self._width == 1:
            return super().aligned(columns, targets)
        turns = nearest(np.einsum("iabk,iack->kbc", self._vectors(columns), self._vectors(targets)), self._is_special)
        return self._turned(columns, turns.astype(columns.dtype))

    def agreements(self, columns: np.ndarray) -> np.ndarray:
        if self._width == 1:
            return super().agreements(columns)
        width, count = self._width, columns.shape[1]
        rows = columns.reshape(-1, width * count)
        products = (rows.T @ rows).reshape(width, count, width, count).transpose(1, 3, 0, 2)
        nuclear_norms: np.ndarray = np.linalg.svd(products, compute_uv=False).sum(axis=2)
        return nuclear_norms / width

    def ground_to_one(self, columns: np.ndarray, ground: int) -> np.ndarray:
        if self._width == 1:
            return super().ground_to_one(columns, ground)
        return self._turned(columns, self._matrices(columns)[ground].swapaxes(1, 2))

    def _turned(self, columns: np.ndarray, turns: np.ndarray) -> np.ndarray:
        """Frames of each column times its (k, d, d) matrix."""
        return np.einsum("iabk,kbc->iack", self._vectors(columns), turns).reshape(columns.shape)


Candidates: TypeAlias = Circles | Columns
Manifold: TypeAlias = Lifted | Candidates


def candidates(block: int, is_circle: bool, fibre: Fibre = Fibre.VECTORS) -> Candidates:
    """The manifold of columns that are separate fields."""
    return Circles(block) if is_circle else Columns(block, fibre)


def fields_of(piece: Piece) -> Candidates:
    """The candidates of a piece."""
    return candidates(piece.block, piece.is_circle, piece.fibre)


def _like(reals: np.ndarray, array: np.ndarray) -> np.ndarray:
    """Real coordinates as an array of the dtype and shape of another."""
    return reals.reshape(len(array), -1).view(array.dtype)


def _real_columns(columns: np.ndarray) -> np.ndarray:
    """(N, m) real numbers of (N, k) columns, a view where their rows lie together."""
    if columns.strides[1] != columns.itemsize:
        columns = np.ascontiguousarray(columns)
    return columns.view(columns.real.dtype)


def _inverse(lengths: np.ndarray) -> np.ndarray:
    """1 / lengths, an arbitrary number for zero."""
    return 1 / np.maximum(lengths, np.finfo(lengths.dtype).tiny)


def _fill_zero_columns(columns: np.ndarray, lengths: np.ndarray, block: int) -> np.ndarray:
    """Columns, changed in place, with a unit vector where the (nodes, k) lengths are zero.

    Any unit vector is as good there; with none, the edges of the node would cost too little.
    """
    empty = lengths < np.finfo(lengths.dtype).tiny
    if empty.any():
        columns[::block][empty] = 1
        for row in range(1, block):
            columns[row::block][empty] = 0
    return columns


def random_columns(piece: Piece, columns: int, random: np.random.Generator) -> np.ndarray:
    """(N, columns) Gaussian start for a piece; the ground's unused rows are zero."""
    start = gaussian((len(piece.rows), columns), piece.is_complex, random)
    start[piece.unused_rows] = 0
    return start


def gaussian(shape: tuple[int, ...], is_complex: bool, random: np.random.Generator) -> np.ndarray:
    """Independent normal numbers, real or complex."""
    numbers = random.standard_normal(shape)
    return numbers + 1j * random.standard_normal(shape) if is_complex else numbers


def principal(point: np.ndarray, reductions: Reductions = HERE) -> tuple[np.ndarray, np.ndarray]:
    """Columns rotated onto the singular directions, which keeps Y Y^H, without empty ones; and singular values."""
    squares, rotation = np.linalg.eigh(reductions.sum(point.conj().T @ point))
    singular = np.sqrt(np.maximum(squares[::-1], 0))
    keep = singular > EMPTY * singular[0]
    return point @ rotation[:, ::-1][:, keep], singular[keep]
