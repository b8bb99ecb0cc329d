# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a solid or its surface touches itself in a vertex or an edge, each side gets vertices of its own."""

import numpy as np

from ..graphs import components


def split_pinched_vertices(triangles):
    """Triangles of a closed surface renumbered so that those around every vertex form one fan.

    Triangles of one fan share edges. Where more than two meet in an edge, all of them stay together.

    Parameters
    ----------
    triangles : (b, 3) int array

    Returns
    -------
    source : (v,) number of each vertex among the given ones, in increasing order
    triangles : (b, 3) in the numbering of ``source``
    """
    tails, heads = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    keys = np.minimum(tails, heads) * (triangles.max(initial=0) + 1) + np.maximum(tails, heads)
    order = np.argsort(keys, kind="stable")
    meet = keys[order[1:]] == keys[order[:-1]]
    return _merge_corners(triangles, [corner_links(triangles, order[:-1][meet], order[1:][meet]).T])


def corner_links(triangles, halves, others):
    """(2 k, 2) corners that are one vertex where pairs of half-edges are joined, whichever way each of them runs.

    Corner c = 3 t + k is the tail of half-edge c.
    """
    opposite = triangles.ravel()[halves] != triangles.ravel()[others]
    tails = np.where(opposite, following(others), others)
    heads = np.where(opposite, others, following(others))
    return np.concatenate([np.column_stack([halves, tails]), np.column_stack([following(halves), heads])])


def following(halves):
    """The next half-edge in the same triangle."""
    return halves - halves % 3 + (halves + 1) % 3


def split_solid_vertices(mesh, at):
    """Vertices doubled where the tetrahedra around them do not hang together by faces.

    Parameters
    ----------
    mesh : TetMesh
    at : (n,) bool, the vertices to look at, all of whose tetrahedra are there

    Returns
    -------
    vertices : (n + k, 3) with k copies
    tets : (m, 4)
    """
    corners = mesh.tets.ravel()
    links = []
    for k in range(3):
        shared = (mesh.face_tets[:, 1] >= 0) & at[mesh.faces[:, k]]
        sides = mesh.face_tets[shared].T
        links.append([4 * t + (mesh.tets[t] == mesh.faces[shared, k, None]).argmax(axis=1) for t in sides])
    others = np.flatnonzero(~at[corners])
    representatives = np.zeros(mesh.vertex_count, int)
    representatives[corners[others]] = others
    links.append([others, representatives[corners[others]]])
    source, numbers = _merge_corners(mesh.tets, links)
    is_copy = np.append(False, source[1:] == source[:-1])
    names = np.where(is_copy, mesh.vertex_count + np.cumsum(is_copy) - 1, source)
    return np.concatenate([mesh.vertices, mesh.vertices[source[is_copy]]]), names[numbers]


def _merge_corners(cells, links):
    """Vertices from corners of cells: corners that are linked, one way or another, make one vertex."""
    labels = components(cells.size, np.concatenate([np.column_stack(ends) for ends in links]))
    count = labels.max(initial=-1) + 1
    source, numbers = np.unique(cells.ravel() * count + labels, return_inverse=True)
    return source // max(count, 1), numbers.reshape(cells.shape)
