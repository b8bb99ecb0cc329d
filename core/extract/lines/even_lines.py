# SPDX-License-Identifier: GPL-3.0-or-later
"""Evenly spaced streamlines: many are traced, and the lines or parts of lines that keep their distance are kept."""

import numpy as np
from scipy.spatial import cKDTree

from ...geometry import TriangleMesh
from ...graphs import pairs_within
from ...unit_vectors import unit_vectors
from .streamlines import Streamlines, trace

# Distance between lines in mean edge lengths; on a coarse mesh less, so that this many lines fit across a square of
# the same area.
EDGES_APART, LINES_ACROSS = 3.0, 32
# Seeds per square of one distance.
SEEDS = 0.5
# Full length of a line in distances.
ASPECT = 16
# Lines nearer than this share of the distance are too near.
TOO_NEAR = 0.7
# Stretches of one line with numbers further apart than this count as different turns of the line.
SAME_TURN = 4
# Lines of at least this share of their full length are kept first, then shorter ones.
SHARES = (0.8, 0.4, 0.15)


def evenly_traced(mesh: TriangleMesh, vectors: np.ndarray, symmetry: int, limit: int) -> Streamlines:
    """Evenly spaced :class:`Streamlines`, at most about ``limit`` of full length; arguments as :func:`trace`."""
    area = mesh.areas.sum()
    # A line of full length, ASPECT times the distance to the next one, takes up ASPECT squares of that distance. The
    # distance is large enough that no more such lines than the limit fill the area.
    apart = min(EDGES_APART * mesh.edge_lengths.mean(), np.sqrt(area) / LINES_ACROSS)
    apart = max(apart, np.sqrt(area / (ASPECT * limit)))
    triangles, weights = even_seeds(mesh, int(np.ceil(SEEDS * area / apart**2)))
    traced = trace(mesh, vectors, symmetry, triangles, weights, ASPECT * apart)
    return traced[_keep_apart(mesh, traced, apart)]


def even_seeds(mesh: TriangleMesh, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Points that stand for equal areas: (count,) triangles and (count, 3) barycentric coordinates."""
    numbers = np.arange(count)
    sums = np.cumsum(mesh.areas)
    triangles = np.searchsorted(sums, (numbers + 0.5) / count * sums[-1])
    # Multiples of powers of the plastic number fill the unit square evenly; folded, the triangle.
    s, t = (np.outer([0.7548776662466927, 0.5698402909980532], numbers) + 0.5) % 1
    folded = s + t > 1
    s, t = np.where(folded, 1 - s, s), np.where(folded, 1 - t, t)
    return triangles, np.column_stack([1 - s - t, s, t])


def _keep_apart(mesh: TriangleMesh, traced: Streamlines, apart: float) -> np.ndarray:
    """(s,) bool: pieces that are not too near to other lines and are connected with their line's seed."""
    stretch, numbers = _stretches(mesh, traced, apart / 2)
    starts = np.flatnonzero(np.diff(stretch, prepend=-1))
    side_by_side = _SideBySide(mesh, traced[starts], TOO_NEAR * apart)
    first = np.searchsorted(traced.line[starts], np.arange(traced.line.max() + 2))
    blocked, kept = side_by_side.coming_back(numbers[starts]), np.zeros(len(starts), bool)
    waiting = list(range(len(first) - 1))
    for share in SHARES:
        left = []
        # A loop, because each line is blocked by the lines before it.
        for line in waiting:
            around = slice(first[line], first[line + 1])
            low, high = _free_run(blocked[around], int(np.searchsorted(numbers[starts[around]], 0)))
            if high - low < share * 2 * ASPECT:
                left.append(line)
                continue
            run = np.arange(first[line] + low, first[line] + high)
            kept[run] = True
            blocked[side_by_side.with_run(run)] = True
        waiting = left
    return kept[stretch]


def _free_run(blocked: np.ndarray, seed: int) -> tuple[int, int]:
    """First and one past the last stretch of the unblocked run that contains the seed's stretch."""
    if blocked[seed]:
        return 0, 0
    barriers = np.flatnonzero(blocked)
    place = np.searchsorted(barriers, seed)
    low = barriers[place - 1] + 1 if place else 0
    return low, barriers[place] if place < len(barriers) else len(blocked)


def _stretches(mesh: TriangleMesh, traced: Streamlines, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Cut lines into stretches of a length, counted from each line's seed.

    Returns (p,) the stretch of each piece, numbered over all lines, and (p,) its number on the line, 0 after the seed.
    """
    ends = traced.segments(mesh)
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    middles = np.cumsum(lengths) - lengths / 2
    at_seed = (np.cumsum(lengths) - lengths)[traced.step == 0]
    numbers = np.floor((middles - at_seed[traced.line]) / length).astype(int)
    new = (np.diff(traced.line, prepend=-1) != 0) | (np.diff(numbers, prepend=0) != 0)
    return np.cumsum(new) - 1, numbers


class _SideBySide:
    """Finds pieces that run side by side, within a radius and on the same side of a thin sheet."""

    def __init__(self, mesh: TriangleMesh, pieces: Streamlines, radius: float) -> None:
        ends = pieces.segments(mesh)
        self.along = unit_vectors(ends[:, 1] - ends[:, 0])
        self.normals = mesh.face_normals[pieces.triangle]
        self.centres, self.line = ends.mean(axis=1), pieces.line
        self.tree, self.radius = cKDTree(self.centres), radius

    def with_run(self, run: np.ndarray) -> np.ndarray:
        """Indices of the pieces beside any of a run of pieces, the run itself included."""
        return self._pairs(run)[1]

    def coming_back(self, numbers: np.ndarray) -> np.ndarray:
        """(p,) bool: pieces beside a piece of the same line that is nearer to its seed; ``numbers`` count from the
        seed."""
        i, j = self._pairs(np.arange(len(numbers)))
        back = (self.line[i] == self.line[j]) & (np.abs(numbers[i] - numbers[j]) > SAME_TURN)
        back &= 2 * np.abs(numbers[i]) + (numbers[i] < 0) > 2 * np.abs(numbers[j]) + (numbers[j] < 0)
        found = np.zeros(len(numbers), bool)
        found[i[back]] = True
        return found

    def _pairs(self, run: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Pairs of a piece of the run and a piece beside it, as two arrays of indices."""
        rows, j = pairs_within(self.tree, self.centres[run], self.radius)
        i = run[rows]
        beside = np.abs(np.einsum("ij,ij->i", self.along[i], self.along[j])) > 0.7
        beside &= np.einsum("ij,ij->i", self.normals[i], self.normals[j]) > 0.5
        return i[beside], j[beside]
