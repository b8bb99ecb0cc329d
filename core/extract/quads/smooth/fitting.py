# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad meshes whose faces are made as near to rectangles as the surface and its lines allow.

Each face asks its corners to the nearest rectangle of its own plane, and a vertex goes to the mean of what its faces
ask for (Bouaziz et al. 2012, Shape-Up), then back onto the surface, its feature line or its mirror plane. A face that
has turned over asks for a rectangle that has not.
"""

import numpy as np

from ....geometry.barycentric import barycentric
from ....geometry.nearest import NearestTriangles
from ..features.chains import SMALLEST_GAP, move_vertices
from ..measure.quality import corner_angles

# How far a rectangle's sides are drawn to their mean length in the first round, and evenly less up to the last: squares
# where nothing else is asked.
SQUARE = 0.5
# Corners that are off a right angle by up to so many degrees are good enough; how much worse ones count beyond.
GOOD, URGENCY = 30.0, 4.0
# What part of its room before the next one on its line a vertex may take in a round: no two meet.
NEARER = 0.4
_TINY = np.finfo(float).tiny


def fit_quads(quads, mesh, free, planes, rounds, chains=None):
    """The :class:`QuadMesh` after some rounds.

    Parameters
    ----------
    quads : QuadMesh, whose faces that are no quads ask for regular polygons of their own size
    mesh : TriangleMesh that it is on
    free : (n,) bool, vertices that may move; those on lines stay on their lines
    planes : pairs of a (3,) unit normal of a plane through the origin, and (n,) bool of the vertices that stay on it
    rounds : how often
    chains : Chains of its vertices on lines, or None
    """
    surface = NearestTriangles(mesh.vertices, mesh.triangles)
    lines = slid_lines(free, chains)
    movable = np.flatnonzero(free)
    for number in range(rounds):
        square = SQUARE * (1 - number / rounds)
        weights = _urgencies(quads)[quads.corner_faces, None]
        moved, sums = np.zeros_like(quads.vertices), np.zeros((len(quads.vertices), 1))
        np.add.at(moved, quads.corner_vertices, weights * _target_corners(quads, mesh, surface, square))
        np.add.at(sums, quads.corner_vertices, weights)
        moved /= np.maximum(sums, _TINY)
        for unit, on_plane in planes:
            moved[on_plane] -= np.outer(moved[on_plane] @ unit, unit)
        quads = project_vertices(quads, mesh, surface, lines, chains, movable, moved[movable])
    return quads


def slid_lines(free, chains):
    """(n,) line on which each vertex slides, -1 for none; arguments as of :func:`fit_quads`."""
    return np.full(len(free), -1) if chains is None else np.where(free, chains.lines, -1)


def project_vertices(quads, mesh, surface, lines, chains, which, places):
    """The quad mesh with (k,) vertices where the surface, or the line of each, is nearest to (k, 3) places.

    Arguments as of :func:`fit_quads`; ``surface`` of NearestTriangles, and (n,) ``lines`` on which vertices slide, -1
    for none. On a line vertices pass neither each other nor its ends.
    """
    loose = lines[which] < 0
    ends, triangles = surface.nearest(places[loose])
    quads = move_vertices(quads, which[loose], ends, triangles, barycentric(mesh, triangles, ends))
    for number in np.unique(lines[which[~loose]]):
        sliding = lines[which] == number
        ways = _slid(quads, chains, number, which[sliding], places[sliding])
        quads = move_vertices(quads, which[sliding], *chains.features.at(number, ways))
    return quads


def _slid(quads, chains, number, which, places):
    """(k,) ways along a line to what is nearest to places, in the order in which its vertices are on it now."""
    features, length = chains.features, chains.features.lengths[number][-1]
    line = np.flatnonzero(chains.lines == number)
    ways, _ = features.nearest(number, quads.vertices[line])
    order = np.argsort(ways)
    line, ways = line[order], ways[order]
    first, last = features.lines[number][[0, -1]]
    is_closed = first == last and first not in features.corners
    ends = (ways[-1] - length, ways[0] + length) if is_closed else (0, length)
    gaps = np.diff(np.concatenate([ends[:1], ways, ends[1:]]))
    by_name = np.argsort(line)
    at = by_name[np.searchsorted(line, which, sorter=by_name)]
    rooms = NEARER * np.maximum(gaps - SMALLEST_GAP * length / len(gaps), 0)
    steps = features.nearest(number, places)[0] - ways[at]
    if is_closed:
        steps -= length * np.rint(steps / length)
    ways = ways[at] + np.clip(steps, -rooms[at], rooms[at + 1])
    return ways % length if is_closed else ways


def _urgencies(quads):
    """(f,) how much faces count in the mean of what is asked: the more, the worse their worst corner is."""
    worst = np.maximum.reduceat(np.abs(corner_angles(quads) - 90), quads.starts)
    return 1 + URGENCY * np.maximum(worst / GOOD - 1, 0) ** 2


def _target_corners(quads, mesh, surface, square):
    """(c, 3) where the corners of each face should be."""
    asked = quads.vertices[quads.corner_vertices]
    for size in np.unique(quads.sizes):
        corners = quads.starts[quads.sizes == size, None] + np.arange(size)
        places = asked[corners]
        up = mesh.face_normals[surface.nearest(places.mean(axis=1))[1]]
        asked[corners] = _rectangles(places, up, square) if size == 4 else _regular(places, up)
    return asked


def _rectangles(corners, up, square):
    """(f, 4, 3) corners of the rectangles nearest to quads, seen from (f, 3) up; of squares for a share of 1."""
    middle = corners.mean(axis=1, keepdims=True)
    first = (corners[:, 1] - corners[:, 0] + corners[:, 2] - corners[:, 3]) / 2
    second = (corners[:, 3] - corners[:, 0] + corners[:, 2] - corners[:, 1]) / 2
    normals = np.cross(first, second)
    normals = _unit(np.where(np.einsum("fx,fx->f", normals, up)[:, None] > 0, normals, up))
    lengths = np.stack([np.linalg.norm(first, axis=1), np.linalg.norm(second, axis=1)], axis=1)
    lengths += square * (lengths.mean(axis=1, keepdims=True) - lengths)
    along = _unit(first) + np.cross(_unit(second), normals)
    along = _unit(along - np.einsum("fx,fx->f", along, normals)[:, None] * normals)
    u = lengths[:, :1] / 2 * along
    v = lengths[:, 1:] / 2 * np.cross(normals, along)
    return middle + np.stack([-u - v, u - v, u + v, v - u], axis=1)


def _regular(corners, up):
    """(f, k, 3) corners of the regular polygons nearest to others, seen from (f, 3) up."""
    size = corners.shape[1]
    middle = corners.mean(axis=1, keepdims=True)
    offsets = corners - middle
    normals = np.cross(offsets, np.roll(offsets, -1, axis=1)).sum(axis=1)
    normals = _unit(np.where(np.einsum("fx,fx->f", normals, up)[:, None] > 0, normals, up))
    angles = 2 * np.pi / size * np.arange(size)[:, None]
    # Each corner, turned back to where the first one is.
    across = np.cross(normals[:, None], offsets)
    spoke = (np.cos(angles) * offsets - np.sin(angles) * across).mean(axis=1)
    spoke -= np.einsum("fx,fx->f", spoke, normals)[:, None] * normals
    return middle + np.cos(angles) * spoke[:, None] + np.sin(angles) * np.cross(normals, spoke)[:, None]


def _unit(vectors):
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), _TINY)
