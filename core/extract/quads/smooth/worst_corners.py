# SPDX-License-Identifier: GPL-3.0-or-later
"""Vertices around the worst corners of a quad mesh moved until these are nearer to right angles.

Fitting brings faces near to rectangles on the whole; one bad corner counts little among many good ones. Here the
vertices of each patch of faces with bad corners lower a norm of what its corners are off that the largest ones rule, as
long as the patch stays as near to the surface as it was.
"""

import numpy as np

from ..measure.quality import corner_angles
from .fitting import slid_lines
from .patches import Ground, Patches, regular_degrees

# Corners that are off a right angle by more degrees than this are bad.
BAD = 25.0
# How many rings of faces around the bad ones move, too, from one round to the next.
RINGS = (0, 1, 2)
# What part of its way a patch takes, the first that is better.
PARTS = (1.0, 0.4)
# Norms are lower where they are by this share.
GAIN = 0.01
# A patch may be as far from the surface as it was and this share more, or this part of its mean edge.
FARTHER, NEAR = 0.01, 0.08
# Half of the piece of a line whose direction is taken, as a part of the line.
_PIECE = 1e-3
_TINY = np.finfo(float).tiny


def move_worst_corners(quads, mesh, free, planes, chains=None):
    """The :class:`QuadMesh` with vertices moved where corners are bad; arguments as of :func:`fitted`.

    No patch's worst corner gets worse, with those that have turned over counted as worst.
    """
    lines = slid_lines(free, chains)
    moving = _moving(quads, free, RINGS[0])
    if len(moving) == 0:
        return quads
    ground = Ground.of(mesh, quads)
    for rings in RINGS:
        moving = _moving(quads, free, rings)
        if len(moving) == 0:
            break
        patches = Patches.of(quads, ground, moving)
        moves = patches.moves(_directions(quads, mesh, moving, planes, lines, chains))
        quads, _ = patches.moved(moves, PARTS, lines, chains, _judge(patches))
    return quads


def _moving(quads, free, rings):
    """(k,) vertices that may move, of faces with bad corners and of rings around them."""
    faces = quads.corner_faces
    bad = np.zeros(len(quads.sizes), bool)
    bad[faces[np.abs(corner_angles(quads) - regular_degrees(quads.sizes)[faces]) > BAD]] = True
    near = np.zeros(len(quads.vertices), bool)
    for _ in range(1 + rings):
        near[quads.corner_vertices[bad[faces]]] = True
        bad[faces[near[quads.corner_vertices]]] = True
    return np.flatnonzero(near & free)


def _judge(patches):
    """Says which patches are better with vertices at other places."""
    ground, before = patches.ground, patches.quads.vertices
    norms, worst, _ = patches.norms(before)
    apart = ground.apart(patches, before, np.ones(len(norms), bool), patches.below)
    limits = np.maximum((1 + FARTHER) * apart, NEAR * patches.sides)

    def are_better(vertices, waiting):
        new_norms, new_worst, _ = patches.norms(vertices)
        better = waiting & (new_norms < (1 - GAIN) * norms) & (new_worst <= worst)
        return better & (ground.apart(patches, vertices, better, patches.below) <= limits)

    return are_better


def _directions(quads, mesh, moving, planes, lines, chains):
    """(k, 2, 3) unit directions in which vertices may move, across one another, 0 where there is none."""
    up = mesh.face_normals[quads.triangles[moving]]
    first = _unit(np.cross(up, np.eye(3)[np.abs(up).argmin(axis=1)]))
    result = np.stack([first, np.cross(up, first)], axis=1)
    for unit, on_plane in planes:
        held = on_plane[moving]
        result[held, 0], result[held, 1] = _unit(np.cross(unit, up[held])), 0
    on_lines = lines[moving]
    for number in np.unique(on_lines[on_lines >= 0]):
        sliding = on_lines == number
        ways, _ = chains.features.nearest(number, quads.vertices[moving[sliding]])
        length = chains.features.lengths[number][-1]
        ends = [np.clip(ways + step * length, 0, length) for step in (-_PIECE, _PIECE)]
        behind, ahead = (chains.features.at(number, end)[0] for end in ends)
        result[sliding, 0], result[sliding, 1] = _unit(ahead - behind), 0
    return result


def _unit(vectors):
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), _TINY)
