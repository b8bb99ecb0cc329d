# SPDX-License-Identifier: GPL-3.0-or-later
"""Closes tunnels and handles that are narrower than a quad: there, faces meet themselves, or edges have the same ends.

The surface is cut through a face that passes a vertex twice, or along two edges with the same ends, and both sides of
the cut are closed: the face becomes two, and each half of an edge is joined to one of the other edge.
"""

from collections.abc import Iterator

import numpy as np

from ....graphs import components, ragged_arange
from ..trace.quad_mesh import QuadMesh, repeats


def close_narrow_tunnels(quads: QuadMesh) -> QuadMesh:
    """The quad mesh with different corners in each face, and one edge between two vertices.

    Of parts that are connected through what is closed, the largest one is kept. Two faces with the same vertices are
    the two sides of what is too thin, and left out.
    """
    pieces = components(len(quads.vertices), quads.half_edges)
    faces = list(_simple_faces(quads))
    before = pieces[[face[0] for face in faces]]
    quads = _join_halves(quads.with_faces(np.concatenate(faces), np.array([len(face) for face in faces])))
    flat = quads.has_twin
    if flat.any():
        quads, before = _join_halves(quads.only(~flat)), before[~flat]
    return _largest_parts(quads, before)


def _join_halves(quads: QuadMesh) -> QuadMesh:
    """The quad mesh with two faces at each edge, and a vertex of its own for each fan of faces around one."""
    names = np.unique(np.sort(quads.half_edges, axis=1) @ [len(quads.vertices), 1], return_inverse=True)[1]
    divided = _divide_vertices(quads, names, np.empty(0, int))
    crossed = names[repeats(divided.half_edges)]
    return divided if len(crossed) == 0 else _divide_vertices(quads, names, crossed)


def _simple_faces(quads: QuadMesh) -> Iterator[np.ndarray]:
    """Corners of each face; it is divided where it passes a vertex twice, and parts with two corners are left out."""
    for corners in np.split(quads.corner_vertices, quads.starts[1:]):
        way: list[int] = []
        for corner in [*corners.tolist(), corners[0]]:
            if corner in way:
                at = way.index(corner)
                if len(way) - at > 2:
                    yield np.array(way[at:])
                del way[at:]
            way.append(corner)


def _divide_vertices(quads: QuadMesh, names: np.ndarray, crossed: np.ndarray) -> QuadMesh:
    """The quad mesh with a vertex of its own for each fan of faces around one.

    Parameters
    ----------
    names : (c,) of the two ends of each half-edge
    crossed : names of edges with the same ends whose halves are joined in another order
    """
    first, second = _opposite(quads, names, crossed)
    following = quads.next_corners
    pairs = np.concatenate([np.stack([first, following[second]]), np.stack([following[first], second])], axis=1)
    fans = components(len(names), pairs.T)
    _, corners = np.unique(fans, return_index=True)
    at = quads.corner_vertices[corners]
    return QuadMesh(quads.vertices[at], quads.triangles[at], quads.weights[at], fans, quads.sizes)


def _opposite(quads: QuadMesh, names: np.ndarray, crossed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(k,) half-edges and (k,) those in the opposite direction that they are joined to."""
    tails, heads = quads.half_edges.T
    first, ranks = _ranked(np.flatnonzero(tails < heads), names)
    second, others = _ranked(np.flatnonzero(tails > heads), names)
    turned = np.isin(names[second], crossed)
    others[turned] = np.bincount(names[second])[names[second[turned]]] - 1 - others[turned]
    keys, other_keys = names[first] * len(names) + ranks, names[second] * len(names) + others
    _, at, there = np.intersect1d(keys, other_keys, assume_unique=True, return_indices=True)
    return first[at], second[there]


def _ranked(halves: np.ndarray, names: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Half-edges in the order of their names, and the rank of each among those of its name."""
    halves = halves[np.argsort(names[halves], kind="stable")]
    _, counts = np.unique(names[halves], return_counts=True)
    return halves, ragged_arange(counts)[1]


def _largest_parts(quads: QuadMesh, before: np.ndarray) -> QuadMesh:
    """The quad mesh with the largest of all parts whose faces have the same one of (f,) numbers."""
    now = components(len(quads.vertices), quads.half_edges)[quads.corner_vertices[quads.starts]]
    order = np.lexsort((now, np.bincount(now)[now], before))
    last = np.append(before[order][1:] != before[order][:-1], True)
    return quads.only(np.isin(now, now[order[last]]))
