# SPDX-License-Identifier: GPL-3.0-or-later
"""Pieces of a surface that no grid line crosses, as faces of their own."""

from dataclasses import replace

import numpy as np

from .boundary_graph import SHARP, farthest_added, turns

# Corners of the face of a round piece.
_CORNERS = 4


def with_whole_islands(quads, mesh):
    """The :class:`QuadMesh` with one face for each piece of the surface that has none and is a disk.

    Parameters
    ----------
    quads : QuadMesh, without faces of fewer than three corners
    mesh : TriangleMesh that it is on
    """
    faces = [_corners_of(mesh, rim) for rim in _rims_of_empty_disks(quads, mesh)]
    if not faces:
        return quads
    corners = np.concatenate(faces)
    half_of = np.zeros(mesh.vertex_count, int)
    half_of[mesh.triangles.ravel()] = np.arange(3 * mesh.triangle_count)
    half = half_of[corners]
    return replace(
        quads,
        vertices=np.concatenate([quads.vertices, mesh.vertices[corners]]),
        triangles=np.concatenate([quads.triangles, half // 3]),
        weights=np.concatenate([quads.weights, np.eye(3)[half % 3]]),
        corner_vertices=np.append(quads.corner_vertices, len(quads.vertices) + np.arange(len(corners))),
        sizes=np.append(quads.sizes, [len(face) for face in faces]),
    )


def _rims_of_empty_disks(quads, mesh):
    """Lists of the vertices around each piece without a face that is a disk, counterclockwise."""
    pieces = mesh.pieces
    vertices, edges, triangles = (
        np.bincount(pieces[of], minlength=mesh.vertex_count)
        for of in (np.unique(mesh.triangles), mesh.edges[:, 0], mesh.triangles[:, 0])
    )
    is_empty_disk = vertices - edges + triangles == 1
    is_empty_disk[pieces[mesh.triangles[quads.triangles[quads.corner_vertices], 0]]] = False
    tails, heads = mesh.triangles.ravel(), np.roll(mesh.triangles, -1, axis=1).ravel()
    half = np.flatnonzero((mesh.twins < 0) & is_empty_disk[pieces[tails]])
    following = dict(zip(tails[half].tolist(), heads[half].tolist(), strict=True))
    while following:
        first, vertex = following.popitem()
        rim = [first]
        while vertex != first:
            rim.append(vertex)
            vertex = following.pop(vertex)
        yield np.array(rim)


def _corners_of(mesh, rim):
    """The vertices of a closed line at which it turns sharply; where these make no face, some far apart."""
    points, places = mesh.vertices[rim], np.arange(len(rim))
    chosen = places[turns(points, places) > SHARP].tolist()
    if len(chosen) < 3:
        chosen = chosen or [0]
        chosen += farthest_added(points, chosen, places, _CORNERS)
    return rim[np.sort(chosen)]
