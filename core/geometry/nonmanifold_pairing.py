# SPDX-License-Identifier: GPL-3.0-or-later
"""Pairing of faces across edges, also those in which three or more faces meet."""

import numpy as np

from ..graphs import components, pair_keys, ragged_arange
from ..unit_vectors import unit_vectors
from .triangle_mesh import TriangleMesh
from .vertex_splitting import corner_links, next_half_edges

# Extra cost of a concave bend when cosines of bends are compared, so that solids that touch in an edge are separated.
_CONCAVE = 0.01
# From this many faces at an edge on, none are joined, as the number of pairs grows with its square.
_MOST = 64


def pair_half_edges(mesh: TriangleMesh, faces: np.ndarray) -> np.ndarray:
    """Choose (j, 2) half-edges across which faces stay joined, each half-edge in at most one pair.

    At an edge with more than two faces, the two that bend least are joined, then the next two, and so on; a face left
    over has a boundary there. Where as many faces run one way along the edge as the other, as where solids touch, only
    faces of consistent orientation are joined. Faces along a chain of such edges are joined in the same way all along.

    Parameters
    ----------
    mesh : with any number of triangles at an edge
    faces : (m,) face of each triangle; triangles of one face are joined
    """
    edges = mesh.triangle_edges.ravel()
    order = np.argsort(edges, kind="stable")
    ends = np.cumsum(mesh.edge_face_counts)
    ordinary = (ends - 2)[mesh.edge_face_counts == 2]
    halves = order[(mesh.edge_face_counts > 2)[edges[order]]]
    halves = halves[np.lexsort((faces[halves // 3], edges[halves]))]
    inside = np.flatnonzero(
        (edges[halves][1:] == edges[halves][:-1]) & (faces[halves // 3][1:] == faces[halves // 3][:-1])
    )
    pairs = [np.column_stack([order[ordinary], order[ordinary + 1]]), halves[np.column_stack([inside, inside + 1])]]
    halves = np.delete(halves, np.concatenate([inside, inside + 1]))
    halves = halves[np.bincount(edges[halves], minlength=len(mesh.edges))[edges[halves]] < _MOST]
    if len(halves):
        pages = _label_sheets(mesh, np.concatenate(pairs), halves)
        pairs.append(halves[_match_pairs(edges[halves], *_list_candidates(mesh, halves, pages))])
    return np.concatenate(pairs)


def _label_sheets(mesh: TriangleMesh, joins: np.ndarray, halves: np.ndarray) -> np.ndarray:
    """Label half-edges at crowded edges, (k,), by the connected sheets beside chains of such edges."""
    fans = components(3 * mesh.triangle_count, corner_links(mesh.triangles, *joins.T))
    crowded = np.unique(mesh.triangle_edges.ravel()[halves])
    degrees = np.bincount(mesh.edges[crowded].ravel(), minlength=mesh.vertex_count)
    number, ends = np.tile(np.arange(len(halves)), 2), np.concatenate([halves, next_half_edges(halves)])
    fan, inside = fans[ends], degrees[mesh.triangles.ravel()[ends]] == 2
    number, fan = number[inside], fan[inside]
    order = np.argsort(fan, kind="stable")
    both = np.flatnonzero(fan[order][1:] == fan[order][:-1])
    return components(len(halves), np.column_stack([number[order[both]], number[order[both + 1]]]))


def _list_candidates(mesh: TriangleMesh, halves: np.ndarray, pages: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """List (c, 2) positions in ``halves``, sorted by edges, that could be joined, and the (c,) costs."""
    edges = mesh.triangle_edges.ravel()[halves]
    _, starts, sizes = np.unique(edges, return_index=True, return_counts=True)
    ends = np.repeat(starts + sizes, sizes)
    first, steps = ragged_arange(ends - np.arange(len(halves)) - 1)
    second = first + 1 + steps
    signs = mesh.triangle_edge_signs.ravel()[halves]
    balanced = np.repeat(np.add.reduceat(signs, starts) == 0, sizes)
    agrees = signs[first] != signs[second]
    allowed = agrees | ~balanced[first]
    first, second, agrees = first[allowed], second[allowed], agrees[allowed]
    away, normals = _inward_directions(mesh, halves), mesh.face_normals[halves // 3]
    costs = np.einsum("cx,cx->c", away[first], away[second])
    costs += np.where(agrees, _CONCAVE * np.einsum("cx,cx->c", normals[first], away[second]), 0)
    lengths = mesh.edge_lengths[edges[first]]
    keys = pair_keys(np.column_stack([pages[first], pages[second]]), len(halves))
    _, kinds = np.unique(keys, return_inverse=True)
    means = np.bincount(kinds, lengths * costs) / np.maximum(np.bincount(kinds, lengths), np.finfo(float).tiny)
    return np.column_stack([first, second]), means[kinds]


def _inward_directions(mesh: TriangleMesh, halves: np.ndarray) -> np.ndarray:
    """Compute (k, 3) unit vectors from edges into their triangles, normal to the edge; zero for flat triangles."""
    tails, heads, apexes = (mesh.vertices[mesh.triangles[halves // 3, (halves + k) % 3]] for k in range(3))
    along = unit_vectors(heads - tails)
    away = apexes - tails
    return unit_vectors(away - np.einsum("kx,kx->k", away, along)[:, None] * along)


def _match_pairs(edges: np.ndarray, pairs: np.ndarray, costs: np.ndarray) -> np.ndarray:
    """Select disjoint pairs, (j, 2), in the order of their costs at each edge."""
    order = np.lexsort((costs, edges[pairs[:, 0]]))
    pairs = pairs[order]
    free = np.ones(len(edges), bool)
    chosen = [np.empty((0, 2), int)]
    while len(pairs):
        _, best = np.unique(edges[pairs[:, 0]], return_index=True)
        chosen.append(pairs[best])
        free[pairs[best]] = False
        pairs = pairs[free[pairs].all(axis=1)]
    return np.concatenate(chosen)
