# SPDX-License-Identifier: GPL-3.0-or-later
"""Smaller tetrahedra in thin walls, so that what is given on both sides leaves vertices between them.

Tetrahedra are bisected at their longest edges, and with each the neighbours around that edge; where an edge that is
divided is not the longest of a neighbour, the neighbour's longest edge is divided too (Rivara, "Algorithms for refining
triangular grids suitable for adaptive and multigrid techniques", 1984), so that the sizes fall off gradually.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from ...graphs import find, pair_keys, pairs_within
from ...unit_vectors import unit_vectors
from ..nearest import nearest_in_triangles
from ..tet_mesh import TET_EDGES, TetMesh, signed_volumes
from ..triangle_mesh import TriangleMesh
from .lengths import MOST_TETS

# A wall is thin if its thickness is less than the first number times the mean edge length. Its tetrahedra are bisected
# until their longest edge is at most the second number times the thickness. The third number is the largest ratio of
# tetrahedra after to before.
THIN, SHARE, MOST = 2.0, 0.5, 2.0
# Sides of a wall look apart by this cosine, and a way across it is along their normals by that one.
_APART, _ALONG = -0.8, 0.8
# Rounds of bisections: three of them halve the edges.
_ROUNDS = 12
_BATCH = 4096


class Filling(NamedTuple):
    """A solid, and the share of the volume of its thin walls in which the tetrahedra are longer than wanted."""

    solid: TetMesh
    coarse: float = 0.0


def refine_thin_walls(
    solid: TetMesh, mesh: TriangleMesh, nearest: Callable[[np.ndarray], np.ndarray], chosen: np.ndarray
) -> Filling:
    """Divide the tetrahedra in thin walls of a solid whose two sides are both chosen; elsewhere it stays as it is.

    Where that would make more than ``MOST`` times as many tetrahedra, or more than ``MOST_TETS``, the last tetrahedra
    to be divided are those with the longest edges for the thickness of their wall: the thinnest walls come first.

    Parameters
    ----------
    solid : its boundary vertices lie on the surface
    mesh : the closed surface
    nearest : (k, 3) points -> (k,) nearest triangles
    chosen : (m,) bool of the surface's triangles
    """
    limit = THIN * float(solid.edge_lengths.mean())
    wanted = SHARE * _thickness(solid, nearest, chosen, limit)
    most = min(MOST * solid.tet_count, MOST_TETS)
    for _ in range(_ROUNDS):
        over = _over(solid, wanted)
        if not (over > 1).any():
            break
        marked = _edges_to_divide(solid, over > 1)
        is_last = _count(solid, marked) > most
        if is_last:
            marked = _edges_that_fit(solid, over, most)
            if not len(marked):
                break
        wanted = np.append(wanted, wanted[solid.edges[marked]].max(axis=1))
        solid = _divide(solid, marked, mesh, nearest)
        if is_last:
            break
    over = _over(solid, wanted)
    walls = float(solid.volumes[over > 0].sum())
    return Filling(solid, float(solid.volumes[over > 1].sum()) / walls if walls else 0.0)


def _over(solid: TetMesh, wanted: np.ndarray) -> np.ndarray:
    """(m,) longest edge of each tetrahedron over the length that is wanted at its vertices, 0 outside thin walls."""
    return solid.edge_lengths[solid.tet_edges].max(axis=1) / wanted[solid.tets].max(axis=1)


def _edges_that_fit(solid: TetMesh, over: np.ndarray, most: float) -> np.ndarray:
    """Choose edges to divide so that at most ``most`` tetrahedra result: those of as many tetrahedra as possible, the
    longest for their walls first. The number is found by bisection, to 1 % of all that are too long."""
    order = np.argsort(-over, kind="stable")
    low, high = 0, int((over > 1).sum())
    close = max(high // 100, 1)
    marked = np.zeros(0, int)
    while high - low > close:
        middle = (low + high) // 2
        is_large = np.zeros(solid.tet_count, bool)
        is_large[order[:middle]] = True
        more = _edges_to_divide(solid, is_large)
        if _count(solid, more) <= most:
            low, marked = middle, more
        else:
            high = middle
    return marked


def _thickness(
    solid: TetMesh, nearest: Callable[[np.ndarray], np.ndarray], chosen: np.ndarray, limit: float
) -> np.ndarray:
    """(n,) thickness of the wall around each vertex, as far as it is below the limit, infinite elsewhere."""
    result = np.full(solid.vertex_count, np.inf)
    boundary = np.flatnonzero(solid.boundary_vertices)
    faces = nearest(solid.vertices[boundary])
    boundary = boundary[chosen[faces]]
    if not len(boundary):
        return result
    normals = np.zeros((solid.vertex_count, 3))
    triangles = solid.boundary_triangles
    a, b, c = np.moveaxis(solid.vertices[triangles], 1, 0)
    np.add.at(normals, triangles, np.cross(b - a, c - a)[:, None])
    normals, places = unit_vectors(normals[boundary]), solid.vertices[boundary]
    tree, ways = cKDTree(places), np.full(len(boundary), np.inf)
    for part in np.array_split(np.arange(len(boundary)), len(boundary) // _BATCH + 1):
        row, other = pairs_within(tree, places[part], limit)
        row = part[row]
        across = places[row] - places[other]
        lengths = np.linalg.norm(across, axis=1)
        inwards = np.einsum("kx,kx->k", across, normals[row])
        is_wall = (np.einsum("kx,kx->k", normals[row], normals[other]) < _APART) & (inwards > _ALONG * lengths)
        np.minimum.at(ways, row[is_wall], inwards[is_wall])
    walls = np.flatnonzero(np.isfinite(ways))
    if len(walls):
        away, found = cKDTree(places[walls]).query(solid.vertices, distance_upper_bound=limit)
        near = np.flatnonzero(np.isfinite(away))
        near = near[away[near] <= ways[walls[found[near]]]]
        result[near] = ways[walls[found[near]]]
    return result


def _edges_to_divide(solid: TetMesh, is_large: np.ndarray) -> np.ndarray:
    """Find the longest edges of (m,) large tetrahedra, and of the tetrahedra at these edges; the shortest first."""
    rank = np.empty(len(solid.edges), int)
    by_length = np.argsort(solid.edge_lengths, kind="stable")
    rank[by_length] = np.arange(len(solid.edges))
    ranks = rank[solid.tet_edges]
    longest = solid.tet_edges[np.arange(solid.tet_count), ranks.argmax(axis=1)]
    marked = np.zeros(len(solid.edges), bool)
    marked[longest[is_large]] = True
    while True:
        more = marked[solid.tet_edges].any(axis=1) & ~marked[longest]
        if not more.any():
            return by_length[marked[by_length]]
        marked[longest[more]] = True


def _divide(
    solid: TetMesh, marked: np.ndarray, mesh: TriangleMesh, nearest: Callable[[np.ndarray], np.ndarray]
) -> TetMesh:
    """Divide edges in their middles, those of the boundary on the surface, and the tetrahedra at them."""
    count, edges = solid.vertex_count, solid.edges[marked]
    tets = _divided_tets(solid, marked)
    middles = solid.vertices[edges].mean(axis=1)
    sides = solid.boundary_triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    outer = np.flatnonzero(np.isin(pair_keys(edges, count), pair_keys(sides, count)))
    return TetMesh(_put_on_surface(solid.vertices, middles, outer, tets, mesh, nearest), tets)


def _count(solid: TetMesh, marked: np.ndarray) -> int:
    """Count the tetrahedra after edges are divided."""
    return len(_divided_tets(solid, marked))


def _divided_tets(solid: TetMesh, marked: np.ndarray) -> np.ndarray:
    """(k, 4) tetrahedra after edges are divided, which are sorted by length; their middles follow the vertices.

    The longest edges are divided first, so that both sides of a face divide it alike.
    """
    count = solid.vertex_count
    keys, tets = pair_keys(solid.edges[marked], count), solid.tets
    done = []
    while len(tets):
        ends = tets[:, TET_EDGES]
        place = find(keys, np.where(ends.max(axis=2) < count, pair_keys(ends, count), -1))
        best = place.argmax(axis=1)
        rows = np.arange(len(tets))
        middle = place[rows, best]
        done.append(tets[middle < 0])
        tets, best, middle = tets[middle >= 0], best[middle >= 0], middle[middle >= 0]
        halves = []
        for side in np.array(TET_EDGES)[best].T:
            half = tets.copy()
            half[np.arange(len(half)), side] = count + middle
            halves.append(half)
        tets = np.concatenate(halves)
    return np.concatenate(done)


def _put_on_surface(
    vertices: np.ndarray,
    middles: np.ndarray,
    outer: np.ndarray,
    tets: np.ndarray,
    mesh: TriangleMesh,
    nearest: Callable[[np.ndarray], np.ndarray],
) -> np.ndarray:
    """Vertices with the middles of edges after them, the outer ones on the surface where no tetrahedron loses more than
    half of its volume."""
    straight = np.concatenate([vertices, middles])
    if not len(outer):
        return straight
    corners = mesh.vertices[mesh.triangles[nearest(middles[outer])]]
    moved = straight.copy()
    moved[len(vertices) + outer] = np.einsum(
        "pc,pcx->px", nearest_in_triangles(middles[outer], np.moveaxis(corners, 1, 0)), corners
    )
    least = signed_volumes(straight, tets) / 2
    while True:
        flat = np.unique(tets[signed_volumes(moved, tets) < least])
        flat = flat[(moved[flat] != straight[flat]).any(axis=1)]
        if not len(flat):
            return moved
        moved[flat] = straight[flat]
