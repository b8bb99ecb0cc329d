# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Flows with known vortices."""

import numpy as np


def ring_curve(radius=0.27, centre=(0.0, 0.0, 0.0), normal=2, segments=200):
    """(segments + 1, 3) a closed circle, counterclockwise about a coordinate axis."""
    turn = np.linspace(0, 2 * np.pi, segments + 1)
    points = np.zeros((len(turn), 3))
    points[:, (normal + 1) % 3], points[:, (normal + 2) % 3] = radius * np.cos(turn), radius * np.sin(turn)
    return points + centre


def line_integrals(grid, centre, circulation=1.0):
    """(e,) integrals of the flow around a straight line along z: the angle that each edge is seen under."""
    angles = np.arctan2(*(grid.places[:, :2] - centre).T[::-1])
    i, j = grid.edges.T
    return circulation / (2 * np.pi) * ((angles[j] - angles[i] + np.pi) % (2 * np.pi) - np.pi)


def rankine_velocity(places):
    """(n, 3) rigid rotation with curl 1 inside the unit disk about z, no curl outside (Figure 7)."""
    squares = (places[:, :2] ** 2).sum(axis=1)
    return 0.5 / np.maximum(squares, 1)[:, None] * np.cross([0, 0, 1], places)


def linking_number(first, second):
    """Gauss's integral over two closed polylines, pair of segments by pair (Klenin and Langowski 2000)."""
    a, c = first[:, None], second[None]
    b, d = np.roll(first, -1, axis=0)[:, None], np.roll(second, -1, axis=0)[None]
    corners = [c - a, d - a, d - b, c - b]
    normals = [np.cross(u, v) for u, v in zip(corners, [*corners[1:], corners[0]], strict=True)]
    normals = [n / np.maximum(np.linalg.norm(n, axis=-1, keepdims=True), 1e-300) for n in normals]
    pairs = zip(normals, [*normals[1:], normals[0]], strict=True)
    angles = sum(np.arcsin(np.clip((u * v).sum(axis=-1), -1, 1)) for u, v in pairs)
    sides = np.sign((np.cross(d - c, b - a) * (c - a)).sum(axis=-1))
    return (sides * angles).sum() / (4 * np.pi)
