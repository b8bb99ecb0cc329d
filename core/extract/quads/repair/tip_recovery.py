# SPDX-License-Identifier: GPL-3.0-or-later
"""Recovers tips of the surface, such as that of a horn, which faces of a quad mesh cut off.

Where grid lines pass on both sides of a tip, one face lies across below it. It is moved towards the farthest point that
it cuts off, with some rings of vertices around it, as long as the patch gets nearer to the surface and no corner
becomes bad.
"""

import numpy as np
from scipy.spatial import cKDTree

from ....geometry import TriangleMesh
from ....geometry.nearest import NearestTriangles
from ..features.chains import Chains
from ..smooth.fitting import sliding_lines
from ..smooth.patches import Ground, Judge, Patches, faces_near
from ..trace.quad_mesh import QuadMesh

# Points farther from all faces than this part of their mean edge are cut off.
CUT_OFF = 0.5
# Most rounds, rings around a face that move with it, and by what share of the previous ring's move.
ROUNDS, RINGS, FOLLOWING = 10, 2, 0.6
# Parts of its move that a patch tries; it takes the first that is better.
PARTS = (1.0, 0.5, 0.25)
# Smallest share by which the distance of a patch from the surface shrinks, and largest deviation of its corners from
# right angles in degrees, unless it was larger before.
GAIN, WORST = 0.01, 50.0
# Points within this many mean edges of a cut-off point are considered.
AROUND = 3.0


def recover_tips(quads: QuadMesh, mesh: TriangleMesh, free: np.ndarray, chains: Chains | None = None) -> QuadMesh:
    """The quad mesh with vertices moved where it cuts tips off; arguments as of :func:`fit_quads`."""
    lines, ground = sliding_lines(free, chains), Ground.of(mesh, quads)
    side = np.linalg.norm(np.diff(quads.vertices[quads.half_edges], axis=1), axis=2).mean()
    gaps, faces = _gaps(quads, ground.samples, CUT_OFF * side)
    cut_off = np.linalg.norm(gaps, axis=1) > CUT_OFF * side
    if not cut_off.any():
        return quads
    tree = cKDTree(ground.samples[cut_off])
    samples = ground.samples[np.isfinite(tree.query(ground.samples, distance_upper_bound=AROUND * side)[0])]
    for _ in range(ROUNDS):
        gaps, faces = _gaps(quads, samples)
        moves, goes = _moves(quads, gaps, faces, CUT_OFF * side)
        moving = np.flatnonzero(goes & free)
        if len(moving) == 0:
            break
        patches = Patches.of(quads, ground, moving)
        quads, moved = patches.move_better(moves[moving], PARTS, lines, chains, _judge(patches, samples, faces))
        if not moved.any():
            break
    return quads


def _gaps(quads: QuadMesh, samples: np.ndarray, enough: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """(s, 3) from the nearest point of the quad mesh to each sample, and (s,) the face of that point.

    Up to a distance of ``enough`` another point of the mesh will do.
    """
    places = np.concatenate([quads.vertices, quads.middles(quads.vertices)])
    fans = np.column_stack([quads.half_edges, len(quads.vertices) + quads.corner_faces])
    there, nearest = NearestTriangles(places, fans).nearest(samples, enough)
    return samples - there, quads.corner_faces[nearest]


def _moves(quads: QuadMesh, gaps: np.ndarray, faces: np.ndarray, far: float) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) moves of vertices to the farthest point, beyond ``far``, that their faces cut off, and of rings around
    these; and (n,) bool: vertices with a move."""
    lengths = np.linalg.norm(gaps, axis=1)
    order = np.argsort(lengths, kind="stable")
    order = order[lengths[order] > far]
    farthest = np.zeros((len(quads.sizes), 4))
    farthest[faces[order]] = np.column_stack([gaps, lengths])[order]  # the last sample of a face stays, the farthest
    weights = farthest[quads.corner_faces, 3:]
    moves, sums = np.zeros_like(quads.vertices), np.zeros((len(quads.vertices), 1))
    np.add.at(moves, quads.corner_vertices, weights * farthest[quads.corner_faces, :3])
    np.add.at(sums, quads.corner_vertices, weights)
    goes = sums[:, 0] > 0
    moves[goes] /= sums[goes]
    edges, _ = quads.edges
    both = np.concatenate([edges, edges[:, ::-1]])
    for _ in range(RINGS):
        joined = both[goes[both[:, 0]] & ~goes[both[:, 1]]]
        numbers = np.bincount(joined[:, 1], minlength=len(goes))
        np.add.at(moves, joined[:, 1], FOLLOWING * moves[joined[:, 0]] / numbers[joined[:, 1], None])
        goes = goes | (numbers > 0)
    return moves, goes


def _judge(patches: Patches, samples: np.ndarray, faces: np.ndarray) -> Judge:
    """A function that tells which patches are better with moved vertices: nearer to the samples of their faces."""
    labels = np.full(len(patches.quads.sizes), -1)
    labels[patches.touched] = patches.of_faces
    own = labels[faces] >= 0
    below = samples[own], labels[faces[own]], faces_near(patches.quads, samples[own])
    ground, before = patches.ground, patches.quads.vertices
    limits = np.maximum(patches.norms(before)[1], np.radians(WORST))
    apart = ground.distances(patches, before, np.ones(len(limits), bool), below)

    def are_better(vertices: np.ndarray, waiting: np.ndarray) -> np.ndarray:
        better = waiting & (patches.norms(vertices)[1] <= limits)
        return better & (ground.distances(patches, vertices, better, below) < (1 - GAIN) * apart)

    return are_better
