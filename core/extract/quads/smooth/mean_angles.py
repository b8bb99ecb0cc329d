# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Moves all vertices of a quad mesh whose corners are far from right angles on average.

Fitting weighs faces by their size. Where lines leave little room for quads, small and large faces lie side by side, and
many corners stay bad. Here the vertices lower the mean deviation of the corners itself, in cells that are shifted in
each round; a cell moves only if it improves.
"""

from dataclasses import replace

import numpy as np

from ....geometry import TriangleMesh
from ..features.chains import Chains
from ..measure.quality import corner_angles
from ..trace.quad_mesh import QuadMesh
from .fitting import sliding_lines
from .patches import Ground, Judge, Patches, regular_degrees
from .worst_corners import moving_directions

# Mean deviation of corners from right angles, in degrees, beyond which the vertices of a quad mesh move.
BAD_MEAN = 10.0
# Most rounds, steps of descent in each, and the length of a cell in mean edges.
ROUNDS, STEPS, CELL = 32, 100, 8.0
# It ends when some rounds together lower the mean by less than this share.
LATEST, ENOUGH = 4, 0.005
# Samples of the surface for each face.
SAMPLES = 8
# Parts of its move that a cell tries, and the smallest share by which its mean must fall.
PARTS, GAIN = (1.0, 0.5, 0.2), 0.001
# Edges shorter than this part of the mean edge become no shorter.
SHORT = 0.15
# A cell may get this far from the surface, in mean edges, or stay as far as it is.
NEAR = 0.2
# Shifts of the cells in successive rounds along each axis: any few of them are spread evenly.
_SHIFTS = np.sqrt([2.0, 3.0, 5.0])


def lower_mean_angle(quads: QuadMesh, mesh: TriangleMesh, free: np.ndarray, chains: Chains | None = None) -> QuadMesh:
    """The quad mesh with vertices moved if the mean deviation of its corners is larger than :data:`BAD_MEAN`.

    Arguments as of :func:`.fitting.fit_quads`. In no cell more corners are turned over than before.
    """
    means = [mean_angle(quads)]
    if means[0] <= BAD_MEAN:
        return quads
    lines, ground, side = sliding_lines(free, chains), Ground.of(mesh, quads), float(quads.edge_lengths.mean())
    ground = replace(ground, samples=ground.samples[:: max(1, len(ground.samples) // (SAMPLES * len(quads.sizes)))])
    for number in range(ROUNDS):
        moving = np.flatnonzero(free & _are_inside(quads, number * _SHIFTS, CELL * side))
        if len(moving):
            patches = Patches.of(quads, ground, moving)
            moves = patches.descend(moving_directions(quads, mesh, moving, lines, chains), STEPS, patches.means)
            quads, _ = patches.move_better(moves, PARTS, lines, chains, _judge(patches, side))
        means.append(mean_angle(quads))
        if number + 1 >= LATEST and means[-1] > (1 - ENOUGH) * means[number + 1 - LATEST]:
            break
    return quads


def mean_angle(quads: QuadMesh) -> float:
    """Mean deviation of the corners from those of regular faces, in degrees."""
    return float(np.abs(corner_angles(quads) - regular_degrees(quads.sizes)[quads.corner_faces]).mean())


def _are_inside(quads: QuadMesh, shift: np.ndarray, size: float) -> np.ndarray:
    """(n,) bool: vertices all of whose faces lie in one cell of a grid."""
    cells = np.floor(quads.vertices / size + shift)
    labels = np.unique(cells, axis=0, return_inverse=True)[1].ravel()[quads.corner_vertices]
    lowest, highest = (part.reduceat(labels, quads.starts) for part in (np.minimum, np.maximum))
    inside = np.ones(len(quads.vertices), bool)
    inside[quads.corner_vertices[(lowest != highest)[quads.corner_faces]]] = False
    return inside


def _judge(patches: Patches, side: float) -> Judge:
    """A function that tells which patches are better with moved vertices."""
    before = patches.quads.vertices
    means, turned, shortest = patches.means(before)[0], patches.turned(before), patches.shortest(before)

    def are_better(vertices: np.ndarray, waiting: np.ndarray) -> np.ndarray:
        better = waiting & (patches.means(vertices)[0] < (1 - GAIN) * means) & (patches.turned(vertices) <= turned)
        better &= patches.shortest(vertices) >= np.minimum(shortest, SHORT * side)
        return patches.stay_near(vertices, better, NEAR)

    return are_better
