# SPDX-License-Identifier: GPL-3.0-or-later
"""Triangles over which the phases of a pattern are linear, for graphics cards, which know of corners alone."""

import numpy as np

from ..interpolate import TURN, evaluate

# Parts of an edge of the sixths that the medians cut a singular triangle into.
PARTS = 5
# Points are taken this share nearer to the middle of their triangle: around a defect the formula jumps between some.
_INWARDS = 1e-4


def drawn_phases(phases, polygons, places):
    """Corners of triangles to draw, and the phases there.

    A triangle without a defect is one of them. One in a face with a defect is cut along its medians, which pass through
    the defect and on which the formula of :func:`core.interpolate.evaluate` changes, and the sixths into
    ``PARTS ** 2`` each.

    Parameters
    ----------
    phases : tuple of one or two :class:`FacePhases`
    polygons : Polygons
    places : (n, 3) vertices

    Returns
    -------
    (3 t, 3) float32 corners of the triangles one after the other, and (3 t, 2) float32 radians there, the second 0
    where there is one phase
    """
    is_singular = np.zeros(len(polygons.starts), bool)
    for phase in phases:
        # A fan's first values may be zero, but not all; dislocations have numbers.
        rim = phase.disclination.any(axis=1) | (phase.closing != 0)
        is_singular |= (phase.index != 0) | (phase.index_2 != 0) | rim
    cut = is_singular[polygons.triangle_faces]
    regular, singular = np.flatnonzero(~cut), np.flatnonzero(cut)
    corners = polygons.triangle_corners[regular]
    whole = np.zeros((len(regular), 3, 2))
    weights = _cut_triangle()
    pieces = np.zeros((len(singular), len(weights), 3, 2))
    inner = (weights + _INWARDS * (weights.mean(axis=1, keepdims=True) - weights)).reshape(-1, 3)
    for number, phase in enumerate(phases):
        whole[..., number] = phase.corner_phase[corners]
        triangles, inside = np.repeat(singular, len(inner)), np.tile(inner, (len(singular), 1))
        values = evaluate(phase, polygons, triangles, inside).reshape(len(singular), len(weights), 3)
        turns = np.rint((values - values[..., :1]) / TURN)
        pieces[..., number] = values - TURN * turns
    at = places[polygons.corner_vertices]
    small = np.einsum("pki,fix->fpkx", weights, at[polygons.triangle_corners[singular]])
    return (
        np.concatenate([at[corners].reshape(-1, 3), small.reshape(-1, 3)]).astype(np.float32),
        np.concatenate([whole.reshape(-1, 2), pieces.reshape(-1, 2)]).astype(np.float32),
    )


def _cut_triangle():
    """(p, 3, 3) barycentric weights of the corners of the parts of a triangle."""
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
