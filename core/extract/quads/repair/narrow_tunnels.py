# SPDX-License-Identifier: GPL-3.0-or-later
"""Closes tunnels and handles that are narrower than a quad: there, faces meet themselves, or edges have the same ends.

The surface is cut through a face that passes a vertex twice, or along two edges with the same ends, and both sides of
the cut are closed: the face becomes two, and each half of an edge is joined to one of the other edge.
"""

import numpy as np

from ....graphs import components, label_rows
from ..trace.quad_mesh import QuadMesh, repeats

# Parts with fewer faces that are cut off are left out.
FEWEST_FACES = 8


def close_narrow_tunnels(quads: QuadMesh) -> QuadMesh:
    """The quad mesh with different corners in each face, and one edge between two vertices.

    Two faces on the same vertices enclose no volume and are left out. So are small parts that the cuts separate from
    the rest. Edges with the same ends stay where more than two of them cross.
    """
    pieces = components(len(quads.vertices), quads.half_edges)
    faces = [part for corners in _face_corners(quads) for part in _simple_faces(corners)]
    if not faces:
        return quads.only(np.zeros(len(quads.sizes), bool))
    before = pieces[[face[0] for face in faces]]
    quads = _join_halves(quads.with_faces(np.concatenate(faces), np.array([len(face) for face in faces])))
    flat = find_flat_faces(quads)
    thick = quads.only(~flat)
    return thick if flat.all() else _without_crumbs(_join_halves(thick), before[~flat])


def find_flat_faces(quads: QuadMesh) -> np.ndarray:
    """Find the faces that go around the same vertices as another one, in the other direction, (f,) bool."""
    flat = np.zeros(len(quads.sizes), bool)
    for size in np.unique(quads.sizes):
        faces, places = np.flatnonzero(quads.sizes == size), np.arange(size)
        corners = quads.corner_vertices[quads.starts[faces, None] + places]
        first = corners.argmin(axis=1)[:, None]
        ahead, back = (np.take_along_axis(corners, (first + way) % size, axis=1) for way in (places, -places))
        labels = label_rows(np.concatenate([ahead, back]))
        flat[faces] = np.isin(labels[: len(faces)], labels[len(faces) :])
    return flat


def _face_corners(quads: QuadMesh) -> list[np.ndarray]:
    return np.split(quads.corner_vertices, quads.starts[1:]) if len(quads.sizes) else []


def _simple_faces(corners: np.ndarray) -> list[list[int]]:
    """Divide a face where it passes a vertex twice; returns the corners of each part that has more than two."""
    parts, way = [], list[int]()
    for corner in [*corners.tolist(), int(corners[0])]:
        if corner in way:
            at = way.index(corner)
            parts.append(way[at:])
            del way[at:]
        way.append(corner)
    return [part for part in parts if len(part) > 2]


def _join_halves(quads: QuadMesh) -> QuadMesh:
    """Join edges of faces in pairs, and divide each vertex around which there are several fans of faces.

    Several edges may have the same ends. Two of their halves are joined if one fan of faces lies between them. That
    cuts the surface along these edges.
    """
    names = label_rows(np.sort(quads.half_edges, axis=1))
    forward = quads.half_edges[:, 0] < quads.half_edges[:, 1]
    # A forward half and a backward one have the same tail and head if the corners after them change places.
    tails = np.where(forward, np.arange(len(names)), quads.next_corners)
    heads = np.where(forward, quads.next_corners, np.arange(len(names)))
    alone = ~repeats(np.column_stack([names, forward]))
    joined = _pairs(names, forward, alone)
    fans = _fans(tails, heads, joined)
    several = np.flatnonzero(~alone)
    in_fan = label_rows(np.column_stack([names, fans[tails]]))
    joined = np.concatenate([joined, _pairs(in_fan, forward, ~alone)])
    left = np.setdiff1d(several, joined)
    for name in np.unique(names[left]):
        halves = left[names[left] == name]
        ahead, back = halves[forward[halves]], halves[~forward[halves]]
        count = min(len(ahead), len(back))
        joined = np.concatenate([joined, np.column_stack([ahead[:count], back[:count]])])
    fans = _fans(tails, heads, joined)
    at = quads.corner_vertices[np.unique(fans, return_index=True)[1]]
    return QuadMesh(quads.vertices[at], quads.triangles[at], quads.weights[at], fans, quads.sizes)


def _pairs(names: np.ndarray, forward: np.ndarray, allowed: np.ndarray) -> np.ndarray:
    """(k, 2) the forward and the backward half-edge of a name, one pair for each name that has both."""
    ahead, back = np.flatnonzero(allowed & forward), np.flatnonzero(allowed & ~forward)
    _, first, second = np.intersect1d(names[ahead], names[back], return_indices=True)
    return np.column_stack([ahead[first], back[second]])


def _fans(tails: np.ndarray, heads: np.ndarray, joined: np.ndarray) -> np.ndarray:
    """(c,) label of the fan of faces that each corner is in, of faces that are joined at (k, 2) half-edges.

    ``tails`` and ``heads`` are the corners at the two ends of each half-edge, in the same direction for both halves.
    """
    return components(len(tails), np.concatenate([tails[joined], heads[joined]]))


def _without_crumbs(quads: QuadMesh, before: np.ndarray) -> QuadMesh:
    """The quad mesh without its small parts; of the parts of one piece before, the largest stays.

    ``before``: (f,) piece of each face before the cuts.
    """
    parts = components(len(quads.vertices), quads.half_edges)[quads.corner_vertices[quads.starts]]
    sizes = np.bincount(parts)[parts]
    largest = np.zeros(before.max() + 1, int)
    np.maximum.at(largest, before, sizes)
    return quads.only(sizes >= np.minimum(largest[before], FEWEST_FACES))
