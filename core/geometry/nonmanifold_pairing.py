# SPDX-License-Identifier: GPL-3.0-or-later
"""Which faces go on into which across an edge, be it one in which three and more of them meet."""

import numpy as np

from ..graphs import components, ragged_arange
from .triangle_mesh import TriangleMesh
from .vertex_splitting import corner_links, following

# How much a concave bend counts above a convex one, where cosines of the bends are compared: solids that touch in an
# edge come apart rather than grow together.
_CONCAVE = 0.01
# Faces at an edge from which on all of them come apart: pairs to choose from grow with their square.
_MOST = 64


def pair_half_edges(mesh: TriangleMesh, faces):
    """(j, 2) half-edges across which faces stay joined, each half-edge in one pair at most.

    Of an edge with more than two faces, the two that bend least are joined, then the two of the others that do, and
    so on; what is left has a boundary there. Where as many faces run one way along the edge as the other, as where
    solids touch, only those are joined that agree in their winding. Faces that meet along a chain of such edges are
    joined in the same way all along.

    Parameters
    ----------
    mesh : TriangleMesh, with any number of triangles at an edge
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
        pages = _pages(mesh, np.concatenate(pairs), halves)
        pairs.append(halves[_match_pairs(edges[halves], *_candidates(mesh, halves, pages))])
    return np.concatenate(pairs)


def _pages(mesh, joins, halves):
    """(k,) label of what hangs together on one side of a chain of crowded edges, for half-edges at them."""
    fans = components(3 * mesh.triangle_count, corner_links(mesh.triangles, *joins.T))
    crowded = np.unique(mesh.triangle_edges.ravel()[halves])
    degrees = np.bincount(mesh.edges[crowded].ravel(), minlength=mesh.vertex_count)
    number, ends = np.tile(np.arange(len(halves)), 2), np.concatenate([halves, following(halves)])
    fan, inside = fans[ends], degrees[mesh.triangles.ravel()[ends]] == 2
    number, fan = number[inside], fan[inside]
    order = np.argsort(fan, kind="stable")
    both = np.flatnonzero(fan[order][1:] == fan[order][:-1])
    return components(len(halves), np.column_stack([number[order[both]], number[order[both + 1]]]))


def _candidates(mesh, halves, pages):
    """(c, 2) places in ``halves``, sorted by edges, that could be joined, and (c,) what that costs."""
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
    away, normals = _away(mesh, halves), mesh.face_normals[halves // 3]
    costs = np.einsum("cx,cx->c", away[first], away[second])
    costs += np.where(agrees, _CONCAVE * np.einsum("cx,cx->c", normals[first], away[second]), 0)
    lengths = mesh.edge_lengths[edges[first]]
    low, high = np.minimum(pages[first], pages[second]), np.maximum(pages[first], pages[second])
    _, kinds = np.unique(low * len(halves) + high, return_inverse=True)
    means = np.bincount(kinds, lengths * costs) / np.maximum(np.bincount(kinds, lengths), np.finfo(float).tiny)
    return np.column_stack([first, second]), means[kinds]


def _away(mesh, halves):
    """(k, 3) unit vectors from edges into their triangles, at right angles to the edge; zero for a flat triangle."""
    tails, heads, apexes = (mesh.vertices[mesh.triangles[halves // 3, (halves + k) % 3]] for k in range(3))
    along = heads - tails
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), np.finfo(float).tiny)
    away = apexes - tails
    away -= np.einsum("kx,kx->k", away, along)[:, None] * along
    return away / np.maximum(np.linalg.norm(away, axis=1, keepdims=True), np.finfo(float).tiny)


def _match_pairs(edges, pairs, costs):
    """(j, 2) of the pairs, chosen at each edge by their costs, so that none has a place of another."""
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
