# SPDX-License-Identifier: GPL-3.0-or-later
"""Moves vertices around the worst corners of a quad mesh until the corners are nearer to right angles.

Fitting makes faces near to rectangles on average, and one bad corner counts little among many good ones. Here the
vertices of each patch of faces with bad corners lower a norm of the deviations that the largest ones dominate, as long
as the patch stays as near to the surface as before.
"""

import numpy as np

from ....geometry import TriangleMesh
from ....unit_vectors import cross, unit_vectors
from ..features.chains import Chains
from ..measure.quality import corner_angles
from ..trace.quad_mesh import QuadMesh
from .fitting import sliding_lines
from .patches import Ground, Judge, Patches, regular_degrees

# Corners that deviate from a right angle by more degrees than this are bad.
BAD = 25.0
# Rings of faces around the bad ones that move too, in each round.
RINGS = (0, 2)
# Parts of its move that a patch tries; it takes the first that is better.
PARTS = (1.0, 0.4)
# Number of descent steps.
STEPS = 25
# Smallest share by which a norm must fall.
GAIN = 0.01
# A patch may get as far from the surface as this part of its mean edge.
NEAR = 0.08
# Directions of a line are measured between points this part of the line before and behind.
_PIECE = 1e-3


def move_worst_corners(
    quads: QuadMesh,
    mesh: TriangleMesh,
    free: np.ndarray,
    chains: Chains | None = None,
    ground: Ground | None = None,
    steps: int = STEPS,
) -> QuadMesh:
    """The quad mesh with vertices moved where corners are bad; arguments as of :func:`fit_quads`.

    No patch's worst corner gets worse; corners that are turned over count as the worst. ``ground``: the part of the
    surface below, all of it by default; ``steps``: of descent.
    """
    lines = sliding_lines(free, chains)
    moving = _moving(quads, free, RINGS[0])
    if len(moving) == 0:
        return quads
    ground = Ground.of(mesh, quads) if ground is None else ground
    for rings in RINGS:
        moving = _moving(quads, free, rings)
        if len(moving) == 0:
            break
        patches = Patches.of(quads, ground, moving)
        moves = patches.descend(moving_directions(quads, mesh, moving, lines, chains), steps)
        quads, _ = patches.move_better(moves, PARTS, lines, chains, _judge(patches))
    return quads


def _moving(quads: QuadMesh, free: np.ndarray, rings: int) -> np.ndarray:
    """(k,) vertices that may move, of faces with bad corners and of rings around them."""
    faces = quads.corner_faces
    bad = np.zeros(len(quads.sizes), bool)
    bad[faces[np.abs(corner_angles(quads) - regular_degrees(quads.sizes)[faces]) > BAD]] = True
    near = np.zeros(len(quads.vertices), bool)
    for _ in range(1 + rings):
        near[quads.corner_vertices[bad[faces]]] = True
        bad[faces[near[quads.corner_vertices]]] = True
    return np.flatnonzero(near & free)


def _judge(patches: Patches) -> Judge:
    """A function that tells which patches are better with moved vertices."""
    norms, worst, _ = patches.norms(patches.quads.vertices)

    def are_better(vertices: np.ndarray, waiting: np.ndarray) -> np.ndarray:
        new_norms, new_worst, _ = patches.norms(vertices)
        better = waiting & (new_norms < (1 - GAIN) * norms) & (new_worst <= worst)
        return patches.stay_near(vertices, better, NEAR)

    return are_better


def moving_directions(
    quads: QuadMesh, mesh: TriangleMesh, moving: np.ndarray, lines: np.ndarray, chains: Chains | None
) -> np.ndarray:
    """(k, 2, 3) orthogonal unit directions in which vertices may move, 0 where there are fewer."""
    up = mesh.face_normals[quads.triangles[moving]]
    first = unit_vectors(cross(up, np.eye(3)[np.abs(up).argmin(axis=1)]))
    result = np.stack([first, cross(up, first)], axis=1)
    if chains is None or (lines[moving] < 0).all():
        return result
    sliding = lines[moving] >= 0
    numbers, features = lines[moving[sliding]], chains.features
    ways, _ = features.nearest(numbers, quads.vertices[moving[sliding]])
    lengths = features.lengths[numbers]
    behind, ahead = (features.at(numbers, np.clip(ways + part * lengths, 0, lengths))[0] for part in (-_PIECE, _PIECE))
    result[sliding, 0], result[sliding, 1] = unit_vectors(ahead - behind), 0
    return result
