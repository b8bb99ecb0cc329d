# SPDX-License-Identifier: GPL-3.0-or-later
"""Sharp edges and corners of a surface, and outlines of parts of it, restored in the solid that fills it.

Stuffing (:mod:`.stuffing`) cuts them off: an edge of its boundary runs from one smooth region of the surface to
another. One of its ends moves onto the sharp edge if the tetrahedra around it stay within the bounds of stuffing. First
one vertex moves to each corner, where sharp edges end, branch or bend, then the nearest ones to edges.
"""

from collections.abc import Callable

import numpy as np
from scipy.spatial import cKDTree

from ...graphs import ragged_arange
from ..tet_mesh import TET_EDGES, TET_FACES, TetMesh, signed_volumes
from ..triangle_mesh import TriangleMesh
from .stuffing import DIHEDRAL_BOUNDS

# Cosine of the angle between the normals of two faces, or between two sharp edges, beyond which they count as sharp.
SHARP = np.cos(np.radians(35))
# Longest move of a vertex, in mean edge lengths of the solid.
FARTHEST = 0.8
# Rounds of moves, and number of vertices that are tried for each corner.
ROUNDS, CANDIDATES = 3, 8


def sharpen_edges(
    solid: TetMesh, mesh: TriangleMesh, nearest: Callable[[np.ndarray], np.ndarray], labels: np.ndarray | None = None
) -> TetMesh:
    """Move boundary vertices of a solid onto sharp edges and corners of the surface that it fills.

    Parameters
    ----------
    solid : its boundary vertices lie on the surface
    mesh : the closed surface
    nearest : (k, 3) points -> (k,) nearest triangles
    labels : (m,) int of the surface's triangles; edges between labels also count as sharp
    """
    sharp = sharp_edges(mesh, labels)
    if len(sharp) == 0:
        return solid
    moves, reach = _Moves(solid), FARTHEST * solid.edge_lengths.mean()
    boundary = np.flatnonzero(solid.boundary_vertices)
    regions = np.full(solid.vertex_count, -1)
    regions[boundary] = mesh.parts_between(sharp)[nearest(solid.vertices[boundary])]
    sides = np.unique(np.sort(solid.boundary_triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    ends = regions[sides]
    crossing = sides[ends[:, 0] != ends[:, 1]]
    corners, segments = mesh.vertices[mesh.line_corners(sharp, SHARP)], mesh.vertices[mesh.edges[sharp]]
    # A vertex that has moved makes room for others.
    for _ in range(ROUNDS):
        corners = _move_to_corners(moves, boundary, corners, reach)
        _move_to_edges(moves, crossing, segments, reach)
    return TetMesh(moves.vertices, solid.tets)


def sharp_edges(mesh: TriangleMesh, labels: np.ndarray | None = None) -> np.ndarray:
    """Find the edges of a closed mesh that are bent by more than ``SHARP``, or between faces of different labels."""
    first, second = mesh.edge_triangles.T
    bent = np.einsum("ex,ex->e", mesh.face_normals[first], mesh.face_normals[second]) < SHARP
    return np.flatnonzero(bent if labels is None else bent | (labels[first] != labels[second]))


def _move_to_corners(moves: "_Moves", boundary: np.ndarray, corners: np.ndarray, reach: float) -> np.ndarray:
    """Move to each corner the nearest vertex that can move there; returns the other corners."""
    tree, left = cKDTree(moves.vertices[boundary]), []
    for place in corners:
        ways, rows = tree.query(place, k=min(CANDIDATES, len(boundary)), distance_upper_bound=reach)
        if not any(moves.attempt(vertex, place, for_good=True) for vertex in boundary[rows[np.isfinite(ways)]]):
            left.append(place)
    return np.array(left).reshape(-1, 3)


def _move_to_edges(moves: "_Moves", crossing: np.ndarray, segments: np.ndarray, reach: float) -> None:
    """Move one end of each edge that crosses sharp edges to the nearest place on these, nearest ones first."""
    crossing = crossing[~moves.done[crossing].any(axis=1)]
    ends = np.unique(crossing)
    places = _nearest_on_segments(segments, moves.vertices[ends], reach)
    distances = np.linalg.norm(places - moves.vertices[ends], axis=1)
    others: dict[int, list[int]] = {end: [] for end in ends.tolist()}
    for i, j in crossing.tolist():
        others[i].append(j)
        others[j].append(i)
    for row in np.argsort(distances, kind="stable")[: np.count_nonzero(distances <= reach)]:
        if not moves.done[others[ends[row]]].all():
            moves.attempt(ends[row], places[row])


def _nearest_on_segments(segments: np.ndarray, points: np.ndarray, reach: float) -> np.ndarray:
    """Find the (k, 3) points of (s, 2, 3) segments nearest to points within reach; for others farther ones."""
    begin, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    counts = np.ceil(np.linalg.norm(along, axis=1) / (reach / 4)).astype(int)
    owner, place = ragged_arange(counts)
    samples = begin[owner] + ((place + 0.5) / counts[owner])[:, None] * along[owner]
    result = np.full(points.shape, np.inf)
    if len(points):
        _, found = cKDTree(samples).query(points, k=min(4, len(samples)))
        near = owner[found.reshape(len(points), -1)]
        offsets = points[:, None] - begin[near]
        shares = np.einsum("pkx,pkx->pk", offsets, along[near]) / np.einsum("pkx,pkx->pk", along[near], along[near])
        feet = begin[near] + np.clip(shares, 0, 1)[:, :, None] * along[near]
        best = np.linalg.norm(points[:, None] - feet, axis=2).argmin(axis=1)
        result = feet[np.arange(len(points)), best]
    return result


class _Moves:
    """Moves of single vertices of a solid that keep the tetrahedra around within the bounds.

    Attributes
    ----------
    vertices : (n, 3) present places
    done : (n,) bool, whether each has moved
    """

    def __init__(self, solid: TetMesh) -> None:
        self._tets = solid.tets
        self.vertices = solid.vertices.copy()
        self.done, self._is_final = np.zeros((2, solid.vertex_count), bool)
        # The tetrahedra around vertex v are self._around[self._begins[v] : self._begins[v + 1]].
        self._around = np.argsort(solid.tets.ravel(), kind="stable") // 4
        self._begins = np.append(0, np.cumsum(np.bincount(solid.tets.ravel(), minlength=solid.vertex_count)))

    def attempt(self, vertex: int, place: np.ndarray, for_good: bool = False) -> bool:
        """Move a vertex if its tetrahedra stay within the bounds; returns whether it has moved.

        A vertex that was moved ``for_good`` is not moved again.
        """
        if self._is_final[vertex]:
            return False
        around = self._around[self._begins[vertex] : self._begins[vertex + 1]]
        old = self.vertices[vertex].copy()
        self.vertices[vertex] = place
        if not within_bounds(self.vertices, self._tets[around]):
            self.vertices[vertex] = old
            return False
        self.done[vertex], self._is_final[vertex] = True, for_good
        return True


def within_bounds(vertices: np.ndarray, tets: np.ndarray) -> bool:
    """Check that tetrahedra are positive, and their dihedral angles within ``DIHEDRAL_BOUNDS``."""
    if (signed_volumes(vertices, tets) <= 0).any():
        return False
    a, b, c = np.moveaxis(vertices[tets[:, TET_FACES]], 2, 0)
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=2, keepdims=True)
    if (lengths == 0).any():  # a face without area: the volume is a rounding error
        return False
    normals /= lengths
    i, j = np.array(TET_EDGES).T
    cosines = -np.einsum("tex,tex->te", normals[:, i], normals[:, j])
    sharpest, flattest = np.cos(np.radians(DIHEDRAL_BOUNDS))
    return bool((cosines <= sharpest).all() and (cosines >= flattest).all())
