# SPDX-License-Identifier: GPL-3.0-or-later
"""Signed distance to a closed triangle surface, by NumPy and SciPy alone, or with another program's nearest triangles.

The nearest triangle is found among those whose pieces are near, and proved to be the nearest by the size of the pieces.
The sign is that of the angle-weighted normal at the nearest point (Bærentzen and Aanæs, "Signed distance computation
using the angle weighted pseudonormal", 2005), which is exact where the surface does not meet itself.
"""

from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from ...errors import MeshError
from ..check import check_mesh
from ..nearest import nearest_in_triangles
from .shells import turned_outwards

# Triangles are cut into pieces until these cover about as much area each as the surface's over this number, at least.
FEWEST_PIECES = 5000
FIRST_CANDIDATES = 8
# Candidates that are looked at together, which bounds the memory to about 200 bytes times as many.
BATCH = 400_000


class SurfaceDistance:
    """Distances of points to a closed surface, negative inside: a callable, (k, 3) -> (k,).

    Parameters
    ----------
    mesh : TriangleMesh, closed, not meeting itself; which way the faces of a shell look does not matter: one in
        another is a cavity
    nearest : callable, (k, 3) points -> (k,) the triangle nearest to each, in place of the search here; optional

    Raises
    ------
    MeshError
        as :func:`check_mesh`, and for open edges, whose vertices it carries
    """

    def __init__(self, mesh, nearest=None):
        check_mesh(mesh)
        _refuse_open(mesh)
        mesh = turned_outwards(mesh)
        self.mesh, self._nearest = mesh, nearest
        self._corners = mesh.vertices[mesh.triangles]
        if nearest is not None:
            return
        self._radius = 1.2 * np.sqrt(self.area / max(FEWEST_PIECES, mesh.triangle_count))
        centres, self._owners = _pieces(self._corners, self._radius)
        self._tree = cKDTree(centres)

    @property
    def bounds(self):
        """(2, 3) lowest and highest corner of the surface's box."""
        points = self.mesh.vertices[np.unique(self.mesh.triangles)]
        return np.stack([points.min(axis=0), points.max(axis=0)])

    @cached_property
    def volume(self):
        """Of the space inside."""
        a, b, c = np.moveaxis(self._corners - self.bounds[0], 1, 0)
        return float(np.einsum("tx,tx->", np.cross(a, b), c)) / 6

    @property
    def area(self):
        """Of the surface."""
        return float(self.mesh.areas.sum())

    def __call__(self, points):
        points = np.asarray(points, float)
        signed = np.empty(len(points))
        if self._nearest is not None:
            self._measure_from(self._nearest(points)[:, None], points, signed, np.arange(len(points)))
            return signed
        waiting, count = np.arange(len(points)), FIRST_CANDIDATES
        while len(waiting):
            count = min(count, self._tree.n)
            batches = np.array_split(waiting, -(-len(waiting) * count // BATCH))
            waiting = np.concatenate([at[~self._measure(points, signed, at, count)] for at in batches])
            count *= 4
        return signed

    def _measure(self, points, signed, at, count):
        """Fill in the distances of some points as far as so many pieces near each tell: (k,) bool, where they do."""
        ways, pieces = self._tree.query(points[at], k=count)
        ways, triangles = ways.reshape(len(at), count), self._owners[pieces.reshape(len(at), count)]
        distances = self._measure_from(triangles, points, signed, at)
        # A piece that was not looked at is farther than the last one by centre, and has no point beyond its radius.
        return (ways[:, -1] >= distances + self._radius) | (count == self._tree.n)

    def _measure_from(self, triangles, points, signed, at):
        """Fill in the distances of some points from the nearest of (k, c) triangles; (k,) these without their signs."""
        here = points[at][:, None]
        shares = nearest_in_triangles(here, np.moveaxis(self._corners[triangles], -2, 0))
        offsets = here - np.einsum("pcx,pcxy->pcy", shares, self._corners[triangles])
        squares = np.einsum("pcy,pcy->pc", offsets, offsets)
        best = np.argmin(squares, axis=1)
        rows = np.arange(len(at))
        distances = np.sqrt(squares[rows, best])
        normals = normals_at(self.mesh, triangles[rows, best], shares[rows, best])
        outside = np.einsum("py,py->p", offsets[rows, best], normals) >= 0
        signed[at] = np.where(outside, distances, -distances)
        return distances


def normals_at(mesh, triangles, shares):
    """Normals of the vertex, edge or face that points of triangles lie on, of any length.

    Parameters
    ----------
    mesh : TriangleMesh, manifold
    triangles : (k,)
    shares : (k, 3) of their corners, exactly 0 for those that do not count

    Returns
    -------
    (k, 3)
    """
    inner = shares > 0
    count = inner.sum(axis=1)
    normals = mesh.face_normals[triangles]
    on_edge, on_vertex = np.flatnonzero(count == 2), np.flatnonzero(count == 1)
    # Edge k of a triangle lies between its corners k and k + 1: corner k + 2 has no share there.
    edge = (np.argmin(inner[on_edge], axis=1) + 1) % 3
    twins = mesh.twins[3 * triangles[on_edge] + edge]
    normals[on_edge[twins >= 0]] += mesh.face_normals[twins[twins >= 0] // 3]
    normals[on_vertex] = mesh.vertex_normals[mesh.triangles[triangles[on_vertex], np.argmax(inner[on_vertex], axis=1)]]
    return normals


def _pieces(corners, radius):
    """Centres of pieces of triangles, (k, 3), none reaching beyond ``radius``, and (k,) whose they are."""
    owners = np.arange(len(corners))
    centres, numbers = [], []
    while len(corners):
        middle = corners.mean(axis=1)
        large = ((corners - middle[:, None]) ** 2).sum(axis=2).max(axis=1) > radius**2
        centres.append(middle[~large])
        numbers.append(owners[~large])
        corners, owners = corners[large], np.tile(owners[large], 2)
        # Halve the longest edge, turned to be the one between the first two corners.
        longest = ((np.roll(corners, -1, axis=1) - corners) ** 2).sum(axis=2).argmax(axis=1)
        corners = np.take_along_axis(corners, ((longest[:, None] + np.arange(3)) % 3)[:, :, None], axis=1)
        first, second, third = np.moveaxis(corners, 1, 0)
        middle = (first + second) / 2
        corners = np.concatenate([np.stack([first, middle, third], axis=1), np.stack([middle, second, third], axis=1)])
    return np.concatenate(centres), np.concatenate(numbers)


def _refuse_open(mesh):
    if len(mesh.boundary_edges):
        i, j = mesh.edges[mesh.boundary_edges[0]]
        more = f" and {len(mesh.boundary_edges) - 1} more" if len(mesh.boundary_edges) > 1 else ""
        raise MeshError(
            f"the edge between vertices {i} and {j}{more} has one face only, and a solid needs a closed surface: "
            "fill the holes with Mesh > Clean Up > Fill Holes",
            mesh.edges[mesh.boundary_edges],
        )
