# SPDX-License-Identifier: GPL-3.0-or-later
"""Tubes around vortices (paper, Section 3.6), and other surfaces on which a function on a grid has a value."""

import math
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np

from ...fields.clebsch import SphericalMap
from ...geometry import TriangleMesh
from ...geometry.grid import Grid
from ...geometry.smoothing import smooth_values

# Values this near to the level are moved off it, as a share of the largest difference to it.
ASIDE = 1e-9
# Smoothing goes half of the way to the mean of the neighbours, and a little further back.
_STEPS = 0.5, -0.52
# Vertices of tubes are moved so far from the nodes of the grid before they are smoothed, as a share of its edges.
_MARGIN = 0.25
NORTH = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Isosurface:
    """A surface with the places of its vertices on the grid.

    Attributes
    ----------
    mesh : its normals point to smaller values; open where it leaves the grid
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
    """Smooth (n, k) values at the vertices of a surface, or the vertices' places; those on a boundary stay.

    Each time they move half of the way to the mean of their neighbours, and then a little further back.
    """
    i, j = mesh.edges.T
    rows, columns = np.concatenate([i, j]), np.concatenate([j, i])
    inside = ~mesh.boundary_vertices[rows]
    return smooth_values(values, rows[inside], columns[inside], times, _STEPS)


def isosurface(grid: Grid, values: np.ndarray, level: float, margin: float = 0.0) -> Isosurface:
    """The :class:`Isosurface` of (n,) values at the nodes of a grid in space, by marching tetrahedra.

    Along a periodic axis it continues to the image of the first nodes, and is open there. Where the surface nearly
    touches a node, slivers around it may fold when they are smoothed. So vertices nearer to a node than the
    ``margin``, a share of their edge below a half, move along the surface; on a boundary they stay.
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
        if number == 2:
            corners += [np.stack([[a, c], [a, d], [b, d]]), np.stack([[a, c], [b, d], [b, c]])]
        else:
            corners.append(np.stack([[a, b], [a, c], [a, d]] if number == 1 else [[a, d], [b, d], [c, d]]))
    pairs = np.concatenate([part.transpose(2, 0, 1) for part in corners])
    keys = np.sort(pairs, axis=2).reshape(-1, 2)
    numbers, vertex = np.unique(keys[:, 0] * grid.node_count + keys[:, 1], return_inverse=True)
    ends = np.column_stack(np.divmod(numbers, grid.node_count))
    shares = above[ends[:, 0]] / (above[ends[:, 0]] - above[ends[:, 1]])
    points = (1 - shares)[:, None] * grid.places[ends[:, 0]] + shares[:, None] * grid.places[ends[:, 1]]
    triangles = vertex.reshape(-1, 3)
    # Each pair begins inside: outwards is from there to the other end.
    outwards = (grid.places[pairs[:, :, 1]] - grid.places[pairs[:, :, 0]]).sum(axis=1)
    a, b, c = points[triangles.T]
    turned = np.einsum("ij,ij->i", np.cross(b - a, c - a), outwards) < 0
    triangles[turned] = triangles[turned][:, ::-1]
    mesh = TriangleMesh(points, triangles)
    if margin:
        aside = np.where(mesh.boundary_vertices, shares, np.clip(shares, margin, 1 - margin))
        moves = (aside - shares)[:, None] * (grid.places[ends[:, 1]] - grid.places[ends[:, 0]])
        moves -= np.einsum("ij,ij->i", moves, mesh.vertex_normals)[:, None] * mesh.vertex_normals
        mesh, shares = TriangleMesh(points + moves, triangles), aside
    return Isosurface(mesh, sources[ends], shares)


def _unroll_grid(grid: Grid) -> tuple[Grid, np.ndarray]:
    """Repeat the first nodes of periodic axes after the last ones: the grid, and (n,) its nodes in the given one."""
    sources = np.pad(grid.numbers, [(0, int(periodic)) for periodic in grid.periodic], mode="wrap")
    return Grid(sources.shape, grid.spacing, grid.origin, solid=grid.solid.ravel()[sources]), sources.ravel()


def _tetrahedra(grid: Grid, inside: np.ndarray) -> np.ndarray:
    """(6 c, 4) nodes of the open cubes that the surface passes, each as six tetrahedra around its diagonal, which fit
    those of its neighbours."""
    numbers, corners = grid.numbers, inside.reshape(grid.shape)
    ends = slice(None, -1), slice(1, None)
    found = sum(corners[place].astype(np.int8) for place in product(ends, repeat=3))
    corner = numbers[:-1, :-1, :-1][(found > 0) & (found < 8) & grid.open_cells]
    steps = np.array([numbers[1, 0, 0], numbers[0, 1, 0], numbers[0, 0, 1]])
    return np.concatenate([corner[:, None] + np.cumsum([0, *steps[list(axes)]]) for axes in permutations(range(3))])


@dataclass(frozen=True)
class Tubes:
    """A surface around vortices.

    Attributes
    ----------
    vertices, triangles : (n, 3) and (m, 3)
    sphere : (n, 3) point of the sphere at each vertex
    strength : circulation of a tube that the map covers once
    pieces : number of connected parts
    blobs : pieces without a hole, which surround no filament: their Euler characteristic is positive
    """

    vertices: np.ndarray
    triangles: np.ndarray
    sphere: np.ndarray
    strength: float
    pieces: int
    blobs: int = 0


def vortex_tubes(
    sphere: SphericalMap, point: tuple[float, float, float] | None, opening: float, smoothing: int
) -> Tubes:
    """The :class:`Tubes` of a map on a grid in space.

    Parameters
    ----------
    point : of the sphere, of any length; tubes are around its antipode. None for the north
    opening : degrees around the antipode that are inside
    smoothing : how often vertices move to the middle of their neighbours
    """
    axis = -np.array(point or NORTH, float)
    axis /= np.linalg.norm(axis)
    angle, margin = math.radians(opening), _MARGIN if smoothing else 0
    surface = isosurface(sphere.found.regular_grid, sphere.sphere @ axis, math.cos(angle), margin)
    mesh = surface.mesh
    between = smooth_surface(mesh, surface.interpolated(sphere.sphere), smoothing)
    # There the map is on a circle: only the place along it is interpolated.
    around = between - (between @ axis)[:, None] * axis
    around /= np.maximum(np.linalg.norm(around, axis=1, keepdims=True), 1e-12)
    shown = math.cos(angle) * axis + math.sin(angle) * around
    places = smooth_surface(mesh, mesh.vertices, smoothing)
    strength = sphere.found.quantum * 0.5 * (1 - math.cos(angle))
    pieces = int(mesh.pieces.max(initial=-1)) + 1
    parts = (mesh.pieces, mesh.pieces[mesh.edges[:, 0]], mesh.pieces[mesh.triangles[:, 0]])
    vertices, edges, faces = (np.bincount(part, minlength=pieces) for part in parts)
    blobs = int((vertices - edges + faces > 0).sum())
    return Tubes(places, mesh.triangles, shown, strength, pieces, blobs)
