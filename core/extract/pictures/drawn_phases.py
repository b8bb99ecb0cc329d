# SPDX-License-Identifier: GPL-3.0-or-later
"""Triangles on which the phases of a pattern are linear, so that graphics cards can interpolate them from corners."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...geometry.polygons import Polygons
from ...interpolate import TURN, FacePhases, evaluate

# Parts of each edge of the sixths into which the medians cut a singular triangle.
PARTS = 5
# Points are moved towards the middle of their triangle by this share: the formula jumps between some around a defect.
_INWARDS = 1e-4


@dataclass(frozen=True)
class DrawnTriangles:
    """Triangles to draw, for any places of their mesh's vertices.

    A triangle in a face with a defect is cut along its medians, which pass through the defect and on which the formula
    of :func:`core.interpolate.evaluate` changes, and the sixths into ``PARTS ** 2`` triangles each.

    Attributes
    ----------
    whole, cut : (w, 3) and (c, 3) vertices of the triangles that are drawn whole, and of those that are cut
    phases : (3 t, 2) float32 radians at the corners of the drawn triangles, the second 0 for a single phase
    """

    whole: np.ndarray
    cut: np.ndarray
    phases: np.ndarray

    @classmethod
    def of(cls, phases: Sequence[FacePhases], polygons: Polygons) -> "DrawnTriangles":
        """The triangles of one or two phases."""
        is_singular = np.zeros(len(polygons.starts), bool)
        for phase in phases:
            # Disclinations have nonzero values on their rims, dislocations nonzero numbers.
            rim = phase.disclination.any(axis=1) | (phase.closing != 0)
            is_singular |= (phase.index != 0) | (phase.index_2 != 0) | rim
        cut = is_singular[polygons.triangle_faces]
        regular, singular = np.flatnonzero(~cut), np.flatnonzero(cut)
        corners = polygons.triangle_corners[regular]
        whole, weights = np.zeros((len(regular), 3, 2)), _cut_triangle()
        pieces = np.zeros((len(singular), len(weights), 3, 2))
        inner = _inside(weights).reshape(-1, 3)
        for number, phase in enumerate(phases):
            whole[..., number] = phase.corner_phase[corners]
            triangles, inside = np.repeat(singular, len(inner)), np.tile(inner, (len(singular), 1))
            values = evaluate(phase, polygons, triangles, inside).reshape(len(singular), len(weights), 3)
            turns = np.rint((values - values[..., :1]) / TURN)
            pieces[..., number] = values - TURN * turns
        drawn = np.concatenate([whole.reshape(-1, 2), pieces.reshape(-1, 2)]).astype(np.float32)
        cut_corners = polygons.triangle_corners[singular]
        return cls(polygons.corner_vertices[corners], polygons.corner_vertices[cut_corners], drawn)

    def places(self, vertices: np.ndarray) -> np.ndarray:
        """(3 t, 3) float32 corners of the triangles, for (n, 3) places of the vertices."""
        small = np.einsum("pki,fix->fpkx", _cut_triangle(), vertices[self.cut])
        return np.concatenate([vertices[self.whole].reshape(-1, 3), small.reshape(-1, 3)]).astype(np.float32)


def drawn_phases(phases: Sequence[FacePhases], polygons: Polygons, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners of the :class:`DrawnTriangles` for (n, 3) places of the vertices, and the phases there."""
    triangles = DrawnTriangles.of(phases, polygons)
    return triangles.places(places), triangles.phases


def _inside(weights: np.ndarray) -> np.ndarray:
    """Weights of triangles' corners, moved a little towards the triangles' middles."""
    return weights + _INWARDS * (weights.mean(axis=1, keepdims=True) - weights)


def _cut_triangle() -> np.ndarray:
    """(p, 3, 3) barycentric weights of the corners of a cut triangle's parts."""
    corners, centre = np.eye(3), np.full(3, 1 / 3)
    parts = []
    for first in range(3):
        for second in ((first + 1) % 3, (first + 2) % 3):
            middle = (corners[first] + corners[second]) / 2
            parts.append(np.array([corners[first], middle, centre]))
    steps = []
    for i in range(PARTS):
        for j in range(PARTS - i):
            steps.append([(i, j), (i + 1, j), (i, j + 1)])
            if i + j < PARTS - 1:
                steps.append([(i + 1, j), (i + 1, j + 1), (i, j + 1)])
    grid = np.array(steps) / PARTS
    grid = np.concatenate([1 - grid.sum(axis=2, keepdims=True), grid], axis=2)
    return np.concatenate([grid @ part for part in parts])
