# SPDX-License-Identifier: GPL-3.0-or-later
"""A regular grid of nodes in two or three dimensions, with its edges, faces and cells.

Obstacles are nodes that the flow does not reach. A cell is open if none of its corners is an obstacle. Dual areas and
volumes count open cells only, so that a grid whose last nodes are obstacles is the same as the smaller grid.
"""

from collections.abc import Iterable, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError

# Axes of the faces' edges: a face runs counterclockwise from the first to the second, seen from the head of its normal.
_PLANES = {2: ((0, 1),), 3: ((1, 2), (2, 0), (0, 1))}
# Least length of a box, so that one without an extent has a spacing whose cube is not 0.
_SHORTEST = 1e-30


class Grid:
    """Nodes in rows along the axes.

    Raises MeshError for fewer than two nodes along an axis (three if periodic), a spacing that is not positive, and
    obstacles that leave no cell open.

    Parameters
    ----------
    shape : nodes along each of two or three axes
    spacing : distance of neighbours, one or one per axis, in scene units
    origin : position of the first node
    periodic : whether the last node of an axis is followed by the first, one or one per axis
    solid : bool of the grid's shape, whether a node lies in an obstacle
    """

    def __init__(
        self,
        shape: ArrayLike,
        spacing: ArrayLike = 1.0,
        origin: ArrayLike = 0.0,
        periodic: ArrayLike = False,
        solid: np.ndarray | None = None,
    ) -> None:
        self.shape = tuple(int(count) for count in np.asarray(shape))
        dimension = len(self.shape)
        if dimension not in _PLANES:
            raise MeshError(f"a grid of {dimension} axes: give it two or three")
        self.spacing = np.broadcast_to(np.asarray(spacing, float), dimension)
        self.origin = np.broadcast_to(np.asarray(origin, float), dimension)
        self.periodic = tuple(bool(p) for p in np.broadcast_to(periodic, dimension))
        for axis, count in enumerate(self.shape):
            fewest = 3 if self.periodic[axis] else 2
            if count < fewest:
                raise MeshError(f"{count} nodes along axis {'XYZ'[axis]}: a grid needs {fewest} at least there")
        if not (np.isfinite(self.spacing).all() and (self.spacing > 0).all()):
            raise MeshError(f"the grid's spacing is {self.spacing.tolist()}: give positive lengths")
        if solid is not None:
            self.solid = np.asarray(solid, bool)
            if self.solid.shape != self.shape:
                raise MeshError(f"obstacles of the shape {self.solid.shape} on a grid of {self.shape}: give one a node")
            if not self.open_cells.any():
                raise MeshError("obstacles leave no cell of the grid open: leave room for the flow")

    @property
    def dimension(self) -> int:
        return len(self.shape)

    @property
    def node_count(self) -> int:
        return int(np.prod(self.shape))

    @cached_property
    def solid(self) -> np.ndarray:
        """Array of the grid's shape: whether each node lies in an obstacle."""
        return np.zeros(self.shape, bool)

    @cached_property
    def numbers(self) -> np.ndarray:
        """Array of the grid's shape: the number of each node, the last axis counting fastest."""
        return np.arange(self.node_count).reshape(self.shape)

    @cached_property
    def places(self) -> np.ndarray:
        """(n, d) coordinates of the nodes."""
        axes = [o + s * np.arange(c) for o, s, c in zip(self.origin, self.spacing, self.shape, strict=True)]
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, self.dimension)

    def _cells(self, axes: Sequence[int]) -> np.ndarray:
        """List the first nodes of the elements that extend along some axes."""
        return self.numbers[tuple(map(slice, self.element_shape(axes)))].ravel()

    def element_shape(self, axes: Sequence[int]) -> tuple[int, ...]:
        """Count, along each axis, the elements that extend along some axes: edges along one, faces along two."""
        return tuple(count - (axis in axes and not self.periodic[axis]) for axis, count in enumerate(self.shape))

    def _numbered(self, nodes: np.ndarray, axes: Sequence[int]) -> np.ndarray:
        """Number the elements that extend along some axes from their first nodes."""
        return np.asarray(np.ravel_multi_index(np.unravel_index(nodes, self.shape), self.element_shape(axes)))

    def _stepped(self, nodes: np.ndarray, axis: int) -> np.ndarray:
        """Find the next node along an axis, wrapping around a periodic one."""
        place = np.array(np.unravel_index(nodes, self.shape))
        place[axis] = (place[axis] + 1) % self.shape[axis]
        return np.ravel_multi_index(tuple(place), self.shape)

    # Edges

    @cached_property
    def edges(self) -> np.ndarray:
        """(e, 2) nodes, from each to the next along an axis; all along the first axis come first, and so on."""
        parts = []
        for axis in range(self.dimension):
            tails = self._cells([axis])
            parts.append(np.column_stack([tails, self._stepped(tails, axis)]))
        return np.concatenate(parts)

    @cached_property
    def edge_axes(self) -> np.ndarray:
        """(e,) axis of each edge."""
        return np.repeat(np.arange(self.dimension), [len(self._cells([a])) for a in range(self.dimension)])

    @property
    def can_halve(self) -> bool:
        """Whether every other node makes a grid: enough of them, and an even number along periodic axes."""
        is_even = all(count % 2 == 0 for count, ring in zip(self.shape, self.periodic, strict=True) if ring)
        return is_even and min(self.shape) >= 8

    def edges_at(self, nodes: np.ndarray, axis: int) -> np.ndarray:
        """Find the edges that start at nodes along an axis."""
        before = sum(len(self._cells([other])) for other in range(axis))
        return before + self._numbered(nodes, [axis])

    @cached_property
    def weights(self) -> np.ndarray:
        """(e,) dual area over length, as in the cotangent rule; 0 where the flow does not reach."""
        axes = set(range(self.dimension))
        return np.concatenate(
            [
                self._open_shares(axes - {axis}).ravel() * (np.prod(self.spacing) / self.spacing[axis] ** 2)
                for axis in range(self.dimension)
            ]
        )

    @cached_property
    def masses(self) -> np.ndarray:
        """(n,) dual volume of each node; the full volume for nodes that the flow does not reach."""
        shares = self._open_shares(range(self.dimension)).ravel()
        return np.where(shares > 0, shares, 1) * np.prod(self.spacing)

    def _open_shares(self, axes: Iterable[int]) -> np.ndarray:
        """Compute the share of existing, open cells around each element that extends along all axes but some."""
        shares = self.open_cells.astype(float)
        for axis in axes:
            if self.periodic[axis]:
                shares = (shares + np.roll(shares, 1, axis=axis)) / 2
                continue
            room = [(int(axis == other),) * 2 for other in range(self.dimension)]
            shares = np.moveaxis(np.pad(shares, room), axis, 0)
            shares = np.moveaxis((shares[1:] + shares[:-1]) / 2, 0, axis)
        return shares

    # Faces and cells

    @cached_property
    def open_cells(self) -> np.ndarray:
        """Array of the cells: whether no corner lies in an obstacle."""
        result = ~self.solid
        for axis, is_periodic in enumerate(self.periodic):
            after = np.roll(result, -1, axis=axis)
            result = result & after
            if not is_periodic:
                result = np.moveaxis(np.moveaxis(result, axis, 0)[:-1], 0, axis)
        return result

    @cached_property
    def faces(self) -> np.ndarray:
        """(f, 4) nodes around each face, counterclockwise seen from the head of its normal."""
        parts = []
        for first, second in _PLANES[self.dimension]:
            corner = self._cells([first, second])
            along = self._stepped(corner, first)
            parts.append(np.column_stack([corner, along, self._stepped(along, second), self._stepped(corner, second)]))
        return np.concatenate(parts)

    @cached_property
    def face_edges(self) -> np.ndarray:
        """(f, 4) edges around each face, with the directions of :attr:`face_signs`."""
        parts, start = [], 0
        for first, second in _PLANES[self.dimension]:
            count = len(self._cells([first, second]))
            corner, along, _, across = self.faces[start : start + count].T
            start += count
            sides = (corner, first), (along, second), (across, first), (corner, second)
            parts.append(np.column_stack([self.edges_at(nodes, axis) for nodes, axis in sides]))
        return np.concatenate(parts)

    @cached_property
    def face_signs(self) -> np.ndarray:
        """(f, 4) +1 where a face's edge runs forwards, else -1; 0 around faces without an open cell."""
        is_open = [self._open_shares(set(range(self.dimension)) - set(plane)).ravel() > 0 for plane in self.planes]
        return np.concatenate(is_open)[:, None] * np.array([1, 1, -1, -1])

    @property
    def planes(self) -> tuple[tuple[int, int], ...]:
        """Axes that the faces of each kind extend along, in the order of the faces."""
        return _PLANES[self.dimension]

    @cached_property
    def face_planes(self) -> np.ndarray:
        """(f, 2) axes that each face extends along."""
        planes = _PLANES[self.dimension]
        return np.repeat(planes, [len(self._cells(plane)) for plane in planes], axis=0)

    @cached_property
    def face_layers(self) -> np.ndarray:
        """(f,) number of the plane through the grid of each face, in three dimensions; numbered normal by normal."""
        normals = 3 - self.face_planes.sum(axis=1)
        places = np.array(np.unravel_index(self.faces[:, 0], self.shape))
        return np.cumsum((0, *self.shape[:2]))[normals] + places[normals, np.arange(len(normals))]

    @cached_property
    def cell_faces(self) -> np.ndarray:
        """(c, 6) faces of the open cells in three dimensions: for each normal, the one before and the one after."""
        corners = self._cells([0, 1, 2])[self.open_cells.ravel()]
        parts, before = [], 0
        for normal, plane in enumerate(_PLANES[3]):
            parts += [before + self._numbered(nodes, plane) for nodes in (corners, self._stepped(corners, normal))]
            before += len(self._cells(plane))
        return np.column_stack(parts)

    @property
    def outward(self) -> np.ndarray:
        """(6,) +1 where the normal of a cell's face points outwards, else -1, in the order of :attr:`cell_faces`."""
        return np.tile([-1, 1], 3)


def box_grid(low: np.ndarray, high: np.ndarray, resolution: int) -> Grid:
    """Build a :class:`Grid` of cubes over a box with ``resolution`` nodes along its longest side."""
    size = np.maximum(high - low, _SHORTEST)
    spacing = size.max() / (resolution - 1)
    counts = np.maximum(np.round(size / spacing).astype(int) + 1, 4)
    origin = (low + high) / 2 - spacing * (counts - 1) / 2
    return Grid(counts, spacing, origin)
