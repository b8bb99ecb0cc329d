# SPDX-License-Identifier: GPL-3.0-or-later
"""Signed distance to a closed triangle surface of one or several shells, oriented away from the solid.

The sign is that of the angle-weighted normal at the nearest point (Bærentzen and Aanæs, "Signed distance computation
using the angle weighted pseudonormal", 2005), which is exact if the surface does not intersect itself.
"""

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ...errors import MeshError
from ..check import check_mesh
from ..nearest import NearestTriangles, nearest_in_triangles
from ..triangle_mesh import TriangleMesh
from ..welding import welded_vertices

# Pairs of a point and a triangle per batch of winding numbers, which take about 200 bytes each.
BATCH = 400_000


class SurfaceDistance:
    """The signed distance to a closed surface, negative inside: a callable, (k, 3) -> (k,).

    Raises MeshError as :func:`check_mesh`, and for open edges, with their vertices. ``mesh``: closed, without
    self-intersections; shells may face either way: one in another is a cavity.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        check_mesh(mesh)
        check_closed(mesh, np.arange(mesh.vertex_count))
        self.mesh = orient_outwards(mesh)
        self._surface = NearestTriangles(mesh.vertices, mesh.triangles)

    @property
    def bounds(self) -> np.ndarray:
        """(2, 3) lowest and highest corner of the surface's box."""
        points = self.mesh.vertices[np.unique(self.mesh.triangles)]
        return np.stack([points.min(axis=0), points.max(axis=0)])

    @cached_property
    def volume(self) -> float:
        """Volume of the space inside."""
        a, b, c = np.moveaxis(self.mesh.vertices[self.mesh.triangles] - self.bounds[0], 1, 0)
        return float(np.einsum("tx,tx->", np.cross(a, b), c)) / 6

    @property
    def area(self) -> float:
        """Area of the surface."""
        return float(self.mesh.areas.sum())

    def nearest(self, points: np.ndarray) -> np.ndarray:
        """Find the (k,) nearest triangles to (k, 3) points."""
        return self._surface.nearest(points)[1]

    def __call__(self, points: ArrayLike) -> np.ndarray:
        """Compute the (k,) signed distances of (k, 3) points, negative inside."""
        points = np.asarray(points, float)
        triangles = self.nearest(points)
        corners = self.mesh.vertices[self.mesh.triangles[triangles].T]
        shares = nearest_in_triangles(points, corners)
        offsets = points - np.einsum("pc,cpx->px", shares, corners)
        outside = np.einsum("px,px->p", offsets, normals_at(self.mesh, triangles, shares)) >= 0
        return np.where(outside, 1, -1) * np.linalg.norm(offsets, axis=1)


def normals_at(mesh: TriangleMesh, triangles: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Compute (k, 3) normals, of any length, of the vertices, edges or faces that points of (k,) triangles lie on.

    ``shares`` are (k, 3) barycentric coordinates, exactly 0 for corners that the point does not depend on.
    """
    inner = shares > 0
    count = inner.sum(axis=1)
    normals = mesh.face_normals[triangles]
    on_edge, on_vertex = np.flatnonzero(count == 2), np.flatnonzero(count == 1)
    # Edge k of a triangle joins corners k and k + 1, and corner k + 2 has the share 0 on it.
    edge = (np.argmin(inner[on_edge], axis=1) + 1) % 3
    twins = mesh.twins[3 * triangles[on_edge] + edge]
    normals[on_edge[twins >= 0]] += mesh.face_normals[twins[twins >= 0] // 3]
    normals[on_vertex] = mesh.vertex_normals[mesh.triangles[triangles[on_vertex], np.argmax(inner[on_vertex], axis=1)]]
    return normals


def check_closed(mesh: TriangleMesh, source: np.ndarray) -> None:
    """Raise a MeshError for open edges, with their vertices as (n,) ``source`` numbers them."""
    if len(mesh.boundary_edges):
        edges = source[mesh.edges[mesh.boundary_edges]]
        i, j = edges[0]
        more = f" and {len(mesh.boundary_edges) - 1} more" if len(mesh.boundary_edges) > 1 else ""
        is_torn = (welded_vertices(mesh.vertices, mesh.triangles) != np.arange(mesh.vertex_count)).any()
        remedy = (
            "join vertices at the same place with Mesh > Clean Up > Merge by Distance"
            if is_torn
            else "fill the holes with Mesh > Clean Up > Fill Holes (Sides 0)"
        )
        raise MeshError(
            f"the edge between vertices {i} and {j}{more} has one face only, and a solid needs a closed surface: "
            f"{remedy}",
            edges,
        )


def orient_outwards(mesh: TriangleMesh) -> TriangleMesh:
    """Orient the faces away from the solid: outwards on shells at an even depth, inwards on cavities.

    The mesh is closed, does not intersect itself, and each shell is oriented consistently. Returned as it is if its
    faces are so already.
    """
    names, owners = np.unique(mesh.pieces[mesh.triangles[:, 0]], return_inverse=True)
    shells = np.split(np.argsort(owners, kind="stable"), np.cumsum(np.bincount(owners))[:-1])
    marks = mesh.vertices[[mesh.triangles[shell[0], 0] for shell in shells]]
    depths, volumes = np.zeros(len(names), int), np.empty(len(names))
    for number, shell in enumerate(shells):
        corners = mesh.vertices[mesh.triangles[shell]]
        a, b, c = np.moveaxis(corners - marks[number], 1, 0)
        volumes[number] = np.einsum("tx,tx->", np.cross(a, b), c)
        in_box = ((marks >= corners.min(axis=(0, 1))) & (marks <= corners.max(axis=(0, 1)))).all(axis=1)
        in_box[number] = False
        others = np.flatnonzero(in_box)
        depths[others] += np.abs(winding_numbers(corners, marks[others])) > 0.5
    wrong = np.where(depths % 2, volumes > 0, volumes < 0)[owners]
    if not wrong.any():
        return mesh
    return TriangleMesh(mesh.vertices, np.where(wrong[:, None], mesh.triangles[:, ::-1], mesh.triangles))


def winding_numbers(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Compute (k,) winding numbers of closed triangles, (t, 3, 3), around points, (k, 3): 1 inside outward faces.

    Van Oosterom and Strackee, "The solid angle of a plane triangle" (1983).
    """
    step = max(1, BATCH // len(corners))
    parts = [_winding(corners, points[start : start + step]) for start in range(0, len(points), step)]
    return np.concatenate(parts) if parts else np.zeros(0)


def _winding(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    a, b, c = np.moveaxis(corners - points[:, None, None], -2, 0)
    la, lb, lc = (np.linalg.norm(v, axis=-1) for v in (a, b, c))
    volume = np.einsum("ptx,ptx->pt", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("ptx,ptx->pt", u, v) for u, v in ((a, b), (b, c), (c, a)))
    return np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb).sum(axis=1) / (2 * np.pi)
