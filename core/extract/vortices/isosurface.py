# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces on which a function on a grid has a value, by marching tetrahedra."""

from dataclasses import dataclass
from itertools import permutations

import numpy as np

from ...geometry import TriangleMesh
from ...geometry.grid import Grid
from ...geometry.smoothing import smooth_values

# Values this near to the level are moved off it, as a share of the largest difference to it.
ASIDE = 1e-9
# Smoothing goes half of the way to the mean of the neighbours, and a little further back.
_STEPS = 0.5, -0.52


@dataclass(frozen=True)
class Isosurface:
    """A surface with the places of its vertices on the grid.

    Attributes
    ----------
    mesh : TriangleMesh whose normals point to smaller values; open where it leaves the grid
    ends : (n, 2) nodes between which each vertex lies
    shares : (n,) how far from the first of them to the second; with a margin, where on that edge the vertex would be if
        it were not kept on the surface
    """

    mesh: TriangleMesh
    ends: np.ndarray
    shares: np.ndarray

    def interpolated(self, values: np.ndarray) -> np.ndarray:
        """(n, ...) values at the ``shares``, from those at the grid's nodes."""
        shares = self.shares.reshape(-1, *[1] * (values.ndim - 1))
        return (1 - shares) * values[self.ends[:, 0]] + shares * values[self.ends[:, 1]]


def smooth_surface(mesh: TriangleMesh, values: np.ndarray, times: int) -> np.ndarray:
    """(n, k) values at the vertices of a surface, or their places, without what changes from vertex to vertex.

    Each time they move half of the way to the mean of their neighbours, and then a little further back; on a boundary
    they stay.
    """
    i, j = mesh.edges.T
    rows, columns = np.concatenate([i, j]), np.concatenate([j, i])
    inside = ~mesh.boundary_vertices[rows]
    return smooth_values(values, rows[inside], columns[inside], times, _STEPS)


def isosurface(grid: Grid, values: np.ndarray, level: float, margin: float = 0.0) -> Isosurface:
    """The :class:`Isosurface` of (n,) values at the nodes of a :class:`Grid` of three dimensions.

    Along a periodic axis it goes on to the image of the first nodes, and is open there. Where the surface nearly
    touches a node there are slivers around it, which may fold when they are evened. So vertices that are nearer to a
    node than the ``margin``, a share below a half of their edge, move along the surface by what their edge has in its
    direction; on a boundary they stay.
    """
    grid, sources = _unroll_grid(grid)
    above = values[sources] - level
    nearly = np.abs(above) < ASIDE * np.abs(above).max(initial=0)
    above = np.where(nearly, ASIDE * np.abs(above).max(initial=1), above)
    inside = above > 0
    tets = _tetrahedra(grid, inside)
    count = inside[tets].sum(axis=1)
    corners = []
    # Corners in front by value: one inside and three outside, or the reverse, or two and two.
    for number in (1, 2, 3):
        chosen = tets[count == number]
        order = np.argsort(~inside[chosen], axis=1, kind="stable")
        a, b, c, d = np.take_along_axis(chosen, order, axis=1).T
        if number == 1:
            corners.append(np.stack([[a, b], [a, c], [a, d]]))
        elif number == 3:
            corners.append(np.stack([[a, d], [b, d], [c, d]]))
        else:
            corners.append(np.stack([[a, c], [a, d], [b, d]]))
            corners.append(np.stack([[a, c], [b, d], [b, c]]))
    pairs = np.concatenate([part.transpose(2, 0, 1) for part in corners])
    keys = np.sort(pairs, axis=2).reshape(-1, 2)
    numbers, vertex = np.unique(keys[:, 0] * grid.node_count + keys[:, 1], return_inverse=True)
    ends = np.column_stack(np.divmod(numbers, grid.node_count))
    shares = above[ends[:, 0]] / (above[ends[:, 0]] - above[ends[:, 1]])
    points = (1 - shares)[:, None] * grid.places[ends[:, 0]] + shares[:, None] * grid.places[ends[:, 1]]
    triangles = vertex.reshape(-1, 3)
    # Each pair begins inside: outwards is from there to the other end.
    outwards = (grid.places[pairs[:, :, 1]] - grid.places[pairs[:, :, 0]]).sum(axis=1)
    normals = np.cross(
        points[triangles[:, 1]] - points[triangles[:, 0]], points[triangles[:, 2]] - points[triangles[:, 0]]
    )
    turned = np.einsum("ij,ij->i", normals, outwards) < 0
    triangles[turned] = triangles[turned][:, ::-1]
    mesh = TriangleMesh(points, triangles)
    if margin:
        aside = np.where(mesh.boundary_vertices, shares, np.clip(shares, margin, 1 - margin))
        moves = (aside - shares)[:, None] * (grid.places[ends[:, 1]] - grid.places[ends[:, 0]])
        moves -= np.einsum("ij,ij->i", moves, mesh.vertex_normals)[:, None] * mesh.vertex_normals
        mesh, shares = TriangleMesh(points + moves, triangles), aside
    return Isosurface(mesh, sources[ends], shares)


def _unroll_grid(grid: Grid) -> tuple[Grid, np.ndarray]:
    """A grid of one period, with the first nodes of periodic axes again behind the last ones, and (n,) the nodes that
    its own are."""
    sources = np.pad(grid.numbers, [(0, int(periodic)) for periodic in grid.periodic], mode="wrap")
    return Grid(sources.shape, grid.spacing, grid.origin, solid=grid.solid.ravel()[sources]), sources.ravel()


def _tetrahedra(grid: Grid, inside: np.ndarray) -> np.ndarray:
    """(6 c, 4) nodes of the open cubes that the surface passes, each as six tetrahedra around its diagonal, which fit
    those of its neighbours."""
    numbers, corners = grid.numbers, inside.reshape(grid.shape)
    whole = [slice(None, -1), slice(1, None)]
    found = sum(corners[i, j, k].astype(np.int8) for i in whole for j in whole for k in whole)
    corner = numbers[:-1, :-1, :-1][(found > 0) & (found < 8) & grid.open_cells]
    steps = np.array([numbers[1, 0, 0], numbers[0, 1, 0], numbers[0, 0, 1]])
    parts = []
    for first, second, third in permutations(range(3)):
        ways = np.cumsum([0, steps[first], steps[second], steps[third]])
        parts.append(corner[:, None] + ways)
    return np.concatenate(parts)
