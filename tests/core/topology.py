# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Counting vertices, edges and faces of polygon meshes, even of those that no one would call a surface."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components


def edges_of(quads):
    """(e, 2) pairs of vertices, the lower first, and how often faces pass each forwards and backwards."""
    tails, heads = quads.half_edges.T
    pairs, place = np.unique(np.sort(quads.half_edges, axis=1), axis=0, return_inverse=True)
    return (
        pairs,
        np.bincount(place[tails <= heads], minlength=len(pairs)),
        np.bincount(place[tails > heads], minlength=len(pairs)),
    )


def euler(quads):
    """V - E + F, pairs of vertices with several edges between them counted that often."""
    pairs, forward, backward = edges_of(quads)
    loops = pairs[:, 0] == pairs[:, 1]
    edges = np.where(loops, (forward + 1) // 2, np.maximum(forward, backward)).sum()
    return len(quads.vertices) - int(edges) + len(quads.sizes)


def on_rim(quads):
    """(n,) bool, vertices of edges with one face."""
    pairs, forward, backward = edges_of(quads)
    rim = np.zeros(len(quads.vertices), bool)
    rim[pairs[forward != backward]] = True
    return rim


def valences(quads):
    """(n,) edges at each vertex."""
    pairs, forward, backward = edges_of(quads)
    return np.bincount(pairs.ravel(), np.repeat(np.maximum(forward, backward), 2), len(quads.vertices)).astype(int)


def pieces(quads):
    """(n,) label of the connected piece of each vertex."""
    count = len(quads.vertices)
    graph = coo_matrix((np.ones(len(quads.half_edges)), quads.half_edges.T), shape=(count, count))
    return connected_components(graph, directed=False)[1]


def fans(quads):
    """(n,) number of fans of faces at each vertex: one where the mesh is a surface. No edge may be there twice."""
    corners, following = quads.corner_vertices, quads.next_corners
    lookup = {(a, b): c for c, (a, b) in enumerate(quads.half_edges.tolist())}
    # The corner at the same vertex in the face on the other side of the edge that leaves it.
    across = np.array([lookup.get((b, a), -1) for a, b in quads.half_edges.tolist()])
    met = np.flatnonzero(across >= 0)
    count = len(corners)
    graph = coo_matrix((np.ones(len(met)), (met, following[across[met]])), shape=(count, count))
    labels = connected_components(graph, directed=False)[1]
    first = np.unique(labels, return_index=True)[1]
    return np.bincount(corners[first], minlength=len(quads.vertices))


def is_surface(quads):
    """Whether every edge has one face, or two that pass it in opposite directions, and every vertex one fan of faces
    none of which meets it twice."""
    _, forward, backward = edges_of(quads)
    faces = quads.corner_faces * len(quads.vertices) + quads.corner_vertices
    return bool(
        max(forward.max(initial=0), backward.max(initial=0)) == 1
        and len(np.unique(faces)) == len(faces)
        and (fans(quads) == 1).all()
    )


def face_vectors(quads):
    """(f, 3) areas of the faces times their normals."""
    here = quads.vertices[quads.corner_vertices]
    there = here[quads.next_corners]
    vectors = np.zeros((len(quads.sizes), 3))
    np.add.at(vectors, quads.corner_faces, 0.5 * np.cross(here, there))
    return vectors


def irregular(quads):
    """What the vertices and faces off the rim lack to four edges: (k,) of vertices, (l,) of faces, zeros left out."""
    rim = on_rim(quads)
    touching = np.bincount(quads.corner_faces, rim[quads.corner_vertices]) > 0
    of_vertices, of_faces = 4 - valences(quads)[~rim], 4 - quads.sizes[~touching]
    return of_vertices[of_vertices != 0], of_faces[of_faces != 0]
