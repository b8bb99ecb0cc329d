# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces of a quad mesh that cut off a tip of the surface, such as that of a horn, climb to it.

Where grid lines pass on both sides of a tip, one face lies across below it. It goes towards the point that it cuts off
the most, with some rings of vertices around, as long as the patch gets nearer to the surface and no corner gets bad.
"""

import numpy as np
from scipy.spatial import cKDTree

from ....geometry.nearest import NearestTriangles
from ..smooth.fitting import slid_lines
from ..smooth.patches import Ground, Patches, faces_near, middles_of

# What is farther from all faces than this part of their mean edge is cut off.
CUT_OFF = 0.5
# How often faces climb at most, how many rings around follow them, and what share of the way of the one before.
ROUNDS, RINGS, FOLLOWING = 10, 2, 0.6
# What part of its way a patch takes, the first that is better.
PARTS = (1.0, 0.5, 0.25)
# A patch gets nearer to the surface by this share at least, and no corner, unless one was before, off a right angle
# by more than so many degrees.
GAIN, WORST = 0.01, 50.0
# Points within so many mean edges of those that are cut off are looked at.
AROUND = 3.0


def recover_tips(quads, mesh, free, planes, chains=None):
    """The :class:`QuadMesh` with vertices moved where it cuts tips off; arguments as of :func:`fitted`."""
    lines, ground = slid_lines(free, chains), Ground.of(mesh, quads)
    side = np.linalg.norm(np.diff(quads.vertices[quads.half_edges], axis=1), axis=2).mean()
    gaps, faces = _gaps(quads, ground.samples)
    cut_off = np.linalg.norm(gaps, axis=1) > CUT_OFF * side
    if not cut_off.any():
        return quads
    tree = cKDTree(ground.samples[cut_off])
    samples = ground.samples[np.isfinite(tree.query(ground.samples, distance_upper_bound=AROUND * side)[0])]
    for _ in range(ROUNDS):
        gaps, faces = _gaps(quads, samples)
        ways, goes = _ways(quads, gaps, faces, CUT_OFF * side)
        moving = np.flatnonzero(goes & free)
        if len(moving) == 0:
            break
        for unit, on_plane in planes:
            ways[on_plane] -= np.outer(ways[on_plane] @ unit, unit)
        patches = Patches.of(quads, ground, moving)
        quads, moved = patches.moved(ways[moving], PARTS, lines, chains, _judge(patches, samples, faces))
        if not moved.any():
            break
    return quads


def _gaps(quads, samples):
    """(s, 3) from the nearest point of the quad mesh to each sample, and (s,) the face of that point."""
    places = np.concatenate([quads.vertices, middles_of(quads, quads.vertices)])
    fans = np.column_stack([quads.half_edges, len(quads.vertices) + quads.corner_faces])
    there, nearest = NearestTriangles(places, fans).nearest(samples)
    return samples - there, quads.corner_faces[nearest]


def _ways(quads, gaps, faces, far):
    """(n, 3) ways of the vertices to what their faces cut off the most, farther than ``far``, and (n,) bool: which have
    one, or a ring of neighbours that has."""
    lengths = np.linalg.norm(gaps, axis=1)
    order = np.argsort(lengths)
    order = order[lengths[order] > far]
    farthest = np.zeros((len(quads.sizes), 4))
    # Of a face's samples the farthest one is the last.
    farthest[faces[order]] = np.column_stack([gaps, lengths])[order]
    weights = farthest[quads.corner_faces, 3:]
    ways, sums = np.zeros_like(quads.vertices), np.zeros((len(quads.vertices), 1))
    np.add.at(ways, quads.corner_vertices, weights * farthest[quads.corner_faces, :3])
    np.add.at(sums, quads.corner_vertices, weights)
    goes = sums[:, 0] > 0
    ways[goes] /= sums[goes]
    edges, _ = quads.edges
    both = np.concatenate([edges, edges[:, ::-1]])
    for _ in range(RINGS):
        joined = both[goes[both[:, 0]] & ~goes[both[:, 1]]]
        numbers = np.bincount(joined[:, 1], minlength=len(goes))
        np.add.at(ways, joined[:, 1], FOLLOWING * ways[joined[:, 0]] / numbers[joined[:, 1], None])
        goes = goes | (numbers > 0)
    return ways, goes


def _judge(patches, samples, faces):
    """Says which patches are better with vertices at other places: nearer to the samples of their faces, too."""
    labels = np.full(len(patches.quads.sizes), -1)
    labels[patches.touched] = patches.of_faces
    own = labels[faces] >= 0
    below = samples[own], labels[faces[own]], faces_near(patches.quads, samples[own])
    ground, before = patches.ground, patches.quads.vertices
    limits = np.maximum(patches.norms(before)[1], np.radians(WORST))
    apart = ground.apart(patches, before, np.ones(len(limits), bool), below)

    def are_better(vertices, waiting):
        better = waiting & (patches.norms(vertices)[1] <= limits)
        return better & (ground.apart(patches, vertices, better, below) < (1 - GAIN) * apart)

    return are_better
