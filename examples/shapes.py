# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes that the examples need no files for."""

import numpy as np

from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.filling.stuffing import fill_surface

LARGE, SMALL = 1.0, 0.4


def torus(across):
    """A torus around the z axis, ``across`` vertices around its tube and three times as many along it."""
    u, v = np.meshgrid(*(2 * np.pi * np.arange(count) / count for count in (3 * across, across)), indexing="ij")
    reach = LARGE + SMALL * np.cos(v)
    points = np.stack([reach * np.cos(u), reach * np.sin(u), SMALL * np.sin(v)], axis=-1).reshape(-1, 3)
    number = np.arange(3 * across * across).reshape(3 * across, across)
    a, b = number.ravel(), np.roll(number, -1, 0).ravel()
    c, d = np.roll(number, (-1, -1), (0, 1)).ravel(), np.roll(number, -1, 1).ravel()
    return TriangleMesh(points, np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])]))


def solid_torus(size):
    """The torus filled with tetrahedra, ``size`` long at most."""

    def distance(points):
        return np.hypot(np.hypot(points[:, 0], points[:, 1]) - LARGE, points[:, 2]) - SMALL

    reach = np.array([LARGE + SMALL, LARGE + SMALL, SMALL])
    return fill_surface(distance, np.array([-reach, reach]), size)
