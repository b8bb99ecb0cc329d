# SPDX-License-Identifier: GPL-3.0-or-later
"""The body-centred cubic lattice: the corners and the centres of a block of cubes, and the tetrahedra between them.

Vertices are the corners, numbered first, and the centres of the cubes. A long edge joins two corners or two centres
along an axis, a short one a centre to a corner of its cube. A tetrahedron has two long edges, one between the centres
of two cubes that share a square and one of the sides of this square, and four short ones.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

UNIT = np.eye(3, dtype=int)


@dataclass(frozen=True)
class Lattice:
    """The lattice's first corner, (3,), the edge of a cube, and the number of cubes along each axis, (3,) int."""

    origin: np.ndarray
    size: float
    cells: np.ndarray

    @property
    def corner_count(self) -> int:
        return int(np.prod(self.cells + 1))

    @property
    def vertex_count(self) -> int:
        return self.corner_count + int(np.prod(self.cells))

    def corner_points(self, indices: np.ndarray) -> np.ndarray:
        """Compute (k, 3) positions of corners from (k, 3) indices; half of one more along each axis is a centre."""
        return self.origin + self.size * indices

    def points(self, vertices: np.ndarray) -> np.ndarray:
        """Compute (k, 3) positions of vertices from their numbers."""
        are_corners = vertices < self.corner_count
        points = np.empty((len(vertices), 3))
        corners = np.unravel_index(vertices[are_corners], self.cells + 1)
        points[are_corners] = self.corner_points(np.column_stack(corners))
        centres = np.unravel_index(vertices[~are_corners] - self.corner_count, self.cells)
        points[~are_corners] = self.corner_points(np.column_stack(centres) + 0.5)
        return points

    def edges_across(self, sides: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Find the edges whose ends lie on different sides.

        ``sides``: (v,) int8, 1 inside, -1 outside, 0 on the surface.

        Returns
        -------
        edges : (k, 2) vertices, the inner one first
        are_long : (k,) bool
        """
        edges, lengths = [], []
        for offsets, kinds in self._edge_classes():
            tails, heads = self._ends(sides, offsets, kinds, lambda a, b: a * b < 0)
            inner_first = sides[tails] > 0
            edges.append(np.column_stack([np.where(inner_first, tails, heads), np.where(inner_first, heads, tails)]))
            lengths.append(np.full(len(tails), kinds[0] == kinds[1]))
        return np.concatenate(edges), np.concatenate(lengths)

    def tets_inside(self, sides: np.ndarray) -> tuple[np.ndarray, ...]:
        """Find the tetrahedra with at least one vertex inside, from (v,) int8 sides.

        Returns
        -------
        tets : (m, 4) vertices: the ends of one long edge along its axis, then those of the other
        are_positive : (m,) bool, their orientation
        lower_at_2, lower_at_0 : (m,) bool, which ends the parity rule picks, see :func:`stencils.stencil`
        """
        kinds = (1, 1, 0, 0)
        tets, orientations, at_2, at_0 = [], [], [], []
        for offsets in self._tet_classes():
            some = self._ends(sides, offsets, kinds, lambda *four: np.maximum.reduce(four) > 0)
            steps = np.array(offsets) + 0.5 * np.array(kinds)[:, None]
            tets.append(np.column_stack(some))
            orientations.append(np.full(len(some[0]), np.linalg.det(steps[1:] - steps[0]) > 0))
            at_2.append(self._is_even(some[2], 0))
            at_0.append(self._is_even(some[0], 1))
        return tuple(np.concatenate(parts) for parts in (tets, orientations, at_2, at_0))

    @staticmethod
    def _edge_classes() -> Iterator[tuple[tuple[np.ndarray, np.ndarray], tuple[int, int]]]:
        """Generate offsets of both ends from a cube, and whether each is a first corner (0) or a centre (1)."""
        origin = np.zeros(3, int)
        for axis, kind in product(range(3), (0, 1)):
            yield (origin, UNIT[axis]), (kind, kind)
        for corner in product((0, 1), repeat=3):
            yield (origin, np.array(corner)), (1, 0)

    @staticmethod
    def _tet_classes() -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
        """Generate offsets of the four vertices from a cube: two centres, and two corners of the square between."""
        origin = np.zeros(3, int)
        for axis in range(3):
            square = [UNIT[axis] + UNIT[other] for other in range(3) if other != axis]
            opposite = square[0] + square[1] - UNIT[axis]
            for side in square:
                yield origin, UNIT[axis], UNIT[axis], side
                yield origin, UNIT[axis], side, opposite

    def _ends(
        self, sides: np.ndarray, offsets: Sequence[np.ndarray], kinds: Sequence[int], wanted: Callable[..., np.ndarray]
    ) -> list[np.ndarray]:
        """Number the vertices at offsets from every cube for whose sides ``wanted`` holds."""
        grids = (sides[: self.corner_count].reshape(self.cells + 1), sides[self.corner_count :].reshape(self.cells))
        room = np.min([grids[kind].shape - offset for offset, kind in zip(offsets, kinds, strict=True)], axis=0)
        views = [
            grids[kind][tuple(slice(first, first + count) for first, count in zip(offset, room, strict=True))]
            for offset, kind in zip(offsets, kinds, strict=True)
        ]
        cubes = np.nonzero(wanted(*views))
        return [
            kind * self.corner_count
            + np.ravel_multi_index([c + o for c, o in zip(cubes, offset, strict=True)], grids[kind].shape)
            for offset, kind in zip(offsets, kinds, strict=True)
        ]

    def _is_even(self, vertices: np.ndarray, kind: int) -> np.ndarray:
        i, j, k = np.unravel_index(vertices - kind * self.corner_count, self.cells + 1 - kind)
        return (i + j + k) % 2 == 0


def build_lattice(bounds: ArrayLike, size: float, multiple: int) -> Lattice:
    """Build a lattice around a box, (2, 3) lowest and highest corner, with at least a cube beyond it on all sides.

    The number of cubes along each axis is a multiple of ``multiple``.
    """
    low, high = np.asarray(bounds, float)
    cells = np.ceil((high - low) / size).astype(int) + 2
    cells = -(-cells // multiple) * multiple
    return Lattice((low + high - cells * size) / 2, size, cells)
