# SPDX-License-Identifier: GPL-3.0-or-later
"""Edges between quads turned where a corner is nearly straight.

Where a line, the boundary or a disclination forces a vertex with one face too few on a side, that face has a straight
corner there, which no move of vertices mends. Two faces beside each other make a hexagon, which falls into two quads in
three ways; another one of these gives the vertex the edge that it lacks.
"""

import numpy as np

from .all_quads import Faces, edge_of, join_faces

# Corners that are off a right angle by more degrees than this are straight, and what a turn has to win of it.
STRAIGHT, GAIN = 60.0, 10.0
# What a vertex more with another number of edges than it should have counts for, in degrees.
IRREGULAR = 10.0
# Rounds over all faces with a straight corner.
ROUNDS = 3


def flip_edges(quads, normals, keep=()):
    """The :class:`QuadMesh` with edges turned, on the same vertices.

    Parameters
    ----------
    quads : QuadMesh
    normals : (n, 3) of the surface at its vertices
    keep : (k, 2) vertices of edges that stay
    """
    faces = Faces.of(quads, normals, np.asarray(keep, int).reshape(-1, 2).tolist())
    edges, counts = quads.edges
    valences = np.bincount(edges.ravel(), minlength=len(quads.vertices))
    # What is missing to a regular vertex: four edges inside, three on the boundary.
    wanted = np.full(len(valences), 4)
    wanted[edges[counts == 1]] = 3
    turned = False
    for _ in range(ROUNDS):
        numbers = [number for number, corners in faces.corners.items() if len(corners) == 4]
        offs = _off(faces, np.reshape([faces.corners[number] for number in numbers], (-1, 4)).astype(int))
        straight = [numbers[k] for k in np.argsort(-offs, kind="stable")[: (offs > STRAIGHT).sum()]]
        done = [_turn(faces, number, valences, wanted) for number in straight if number in faces.corners]
        if not any(done):
            break
        turned = True
    return faces.put_on(quads) if turned else quads


def _turn(faces, number, valences, wanted):
    """Turn the edge of a face that makes most of it, and say whether there is one."""
    best, chosen = 0.0, None
    for (a, b), other in faces.beside(number):
        if other is None or edge_of((a, b)) in faces.kept or len(faces.corners[other]) != 4:
            continue
        hexagon = join_faces(faces.corners[number], faces.corners[other], a, b)
        if hexagon is None or min(valences[a] - wanted[a], valences[b] - wanted[b]) < -1:
            continue
        before = max(_off(faces, faces.corners[n]) for n in (number, other))
        for first in range(3):
            p, q = hexagon[first], hexagon[first + 3]
            if {p, q} == {a, b} or (p, q) in faces.left or (q, p) in faces.left:
                continue
            pair = hexagon[first : first + 4], [*hexagon[first + 3 :], *hexagon[: first + 1]]
            won = before - max(_off(faces, corners) for corners in pair)
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


def _more_irregular(valences, wanted, removed, added):
    """By how many there are more irregular vertices when an edge is removed and another one added."""
    ends = [*removed, *added]
    after = valences[ends] + [-1, -1, 1, 1]
    return int((after != wanted[ends]).sum() - (valences[ends] != wanted[ends]).sum())


def _off(faces, corners):
    """By how many degrees the worst corner of a face is off a right angle, of (..., k) corners; corners that are turned
    over count as those beyond a full turn, seen along the face's normal."""
    points = faces.vertices[corners]
    ahead, behind = np.roll(points, -1, axis=-2) - points, np.roll(points, 1, axis=-2) - points
    crosses = np.cross(ahead, behind)
    angles = np.degrees(np.arctan2(np.linalg.norm(crosses, axis=-1), np.einsum("...ij,...ij->...i", ahead, behind)))
    along = faces.normals[corners].sum(axis=-2)
    is_over = np.einsum("...ij,...j->...i", crosses, along) < 0
    return np.abs(np.where(is_over, 360 - angles, angles) - 90).max(axis=-1)
