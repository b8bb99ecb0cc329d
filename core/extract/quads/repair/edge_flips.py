# SPDX-License-Identifier: GPL-3.0-or-later
"""Flips edges between quads where a corner is nearly straight.

Where a line, the boundary or a disclination forces a vertex with one face too few on a side, that face has a straight
corner there, which moving vertices cannot mend. Two adjacent quads form a hexagon, which can be divided into two quads
in three ways; another one of them gives the vertex the missing edge.
"""

import numpy as np
from numpy.typing import ArrayLike

from ..trace.quad_mesh import QuadMesh
from .all_quads import Edge, Faces, edge_of, join_faces

# Corners that deviate more than this from a right angle are straight, and what a flip must gain, in degrees.
STRAIGHT, GAIN = 60.0, 10.0
# Cost of an additional irregular vertex, in degrees.
IRREGULAR = 10.0
# Rounds over all faces with a straight corner.
ROUNDS = 3


def flip_edges(quads: QuadMesh, normals: np.ndarray, keep: ArrayLike = (), apart: ArrayLike = ()) -> QuadMesh:
    """The quad mesh with edges flipped, on the same vertices, whose (n, 3) surface normals are given.

    The (k, 2) edges to keep stay, and no new edge joins two of the vertices ``apart``.
    """
    edges, counts = quads.edges
    faces = Faces.of(quads, normals, keep, apart)
    valences = np.bincount(edges.ravel(), minlength=len(quads.vertices))
    wanted = np.full(len(valences), 4)
    wanted[edges[counts == 1]] = 3
    changed = False
    for _ in range(ROUNDS):
        numbers = [number for number, corners in faces.corners.items() if len(corners) == 4]
        offs = _worst_deviations(faces, np.reshape([faces.corners[number] for number in numbers], (-1, 4)).astype(int))
        straight = [numbers[k] for k in np.argsort(-offs, kind="stable")[: (offs > STRAIGHT).sum()]]
        done = [_flip_best(faces, number, valences, wanted) for number in straight if number in faces.corners]
        if not any(done):
            break
        changed = True
    return faces.put_on(quads) if changed else quads


def _flip_best(faces: Faces, number: int, valences: np.ndarray, wanted: np.ndarray) -> bool:
    """Flip the edge of a face that gains the most; False if none gains enough."""
    best, chosen = 0.0, None
    for (a, b), other in faces.beside(number):
        if other is None or edge_of((a, b)) in faces.kept or len(faces.corners[other]) != 4:
            continue
        hexagon = join_faces(faces.corners[number], faces.corners[other], a, b)
        if hexagon is None or min(valences[a] - wanted[a], valences[b] - wanted[b]) < -1:
            continue
        before = max(_worst_deviations(faces, faces.corners[n]) for n in (number, other))
        for first in range(3):
            p, q = hexagon[first], hexagon[first + 3]
            if {p, q} == {a, b} or (p, q) in faces.left or (q, p) in faces.left or faces.apart.issuperset((p, q)):
                continue
            pair = hexagon[first : first + 4], [*hexagon[first + 3 :], *hexagon[: first + 1]]
            won = before - max(_worst_deviations(faces, corners) for corners in pair)
            won -= IRREGULAR * _more_irregular(valences, wanted, (a, b), (p, q))
            if won > max(best, GAIN):
                best, chosen = won, (other, (a, b), (p, q), pair)
    if chosen is None:
        return False
    other, removed, added, pair = chosen
    for face in (number, other):
        faces.remove(face)
    for corners in pair:
        faces.add(corners)
    valences[list(removed)] -= 1
    valences[list(added)] += 1
    return True


def _more_irregular(valences: np.ndarray, wanted: np.ndarray, removed: Edge, added: Edge) -> int:
    """By how much the number of irregular vertices grows if an edge is removed and another one added."""
    ends = [*removed, *added]
    after = valences[ends] + [-1, -1, 1, 1]
    return int((after != wanted[ends]).sum() - (valences[ends] != wanted[ends]).sum())


def _worst_deviations(faces: Faces, corners: np.ndarray | list[int]) -> np.ndarray:
    """Largest deviation from a right angle, in degrees, over the (..., k) corners of each face.

    Angles of corners that are turned over are reflex, seen along the face's normal.
    """
    points = faces.vertices[corners]
    ahead, behind = np.roll(points, -1, axis=-2) - points, np.roll(points, 1, axis=-2) - points
    crosses = np.cross(ahead, behind)
    angles = np.degrees(np.arctan2(np.linalg.norm(crosses, axis=-1), np.einsum("...ij,...ij->...i", ahead, behind)))
    along = faces.normals[corners].sum(axis=-2)
    is_over = np.einsum("...ij,...j->...i", crosses, along) < 0
    return np.abs(np.where(is_over, 360 - angles, angles) - 90).max(axis=-1)
