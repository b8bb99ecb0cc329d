# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A sheet with a line of every kind, and what its pattern should be."""

import numpy as np

from .scenes import add_curve, add_drawing, add_group, add_wire, attribute, make_active, mark_edges, panel, places

MARKS = ("seams", "sharp", "creases")


SOURCES = {"curve": add_curve, "drawing": add_drawing, "wire": add_wire}


SPACING = 0.35


def sheet():
    """A rectangle, 2 by 1.2, around the origin, with a column of vertices at x = 0."""
    return panel((2, 1.2), (16, 10), (-1, -0.6))


def line_upright(obj, place):
    """A line in the direction of y: the row's place, its x, and whether it runs up (1) or down (-1)."""
    x = places(obj)[:, 0]
    if place in MARKS:
        mark_edges(obj, place, np.abs(x) < 1e-6)
        return {"where": place}, 0.0, 1
    if place == "group":
        add_group(obj, "middle", np.flatnonzero(np.abs(x) < 1e-6))
        return {"where": "group", "name": "middle"}, 0.0, 1
    if place == "boundary":  # runs with the mesh on its left
        add_group(obj, "left", np.flatnonzero(x < -0.99))
        return {"where": "boundary", "name": "left"}, -1.0, -1
    source = SOURCES[place]([(0.04, -0.6, 0.2), (0.04, 0.6, 0.2)])  # above the sheet: it is projected
    make_active(obj)
    return {"where": "curve", "name": source.name}, 0.04, 1


EVERY_PLACE = (*MARKS, "group", "boundary", *SOURCES)


def pattern(obj):
    return attribute(obj, "synch_pattern").astype(float)


def cosines(obj):
    """The pattern at face corners, and their places."""
    vertices = np.array([loop.vertex_index for loop in obj.data.loops])
    return np.cos(attribute(obj, "synch_phase").astype(float)), places(obj)[vertices]


def wave(distance, spacing=SPACING, phase=0.0):
    return np.cos(2 * np.pi * np.asarray(distance) / spacing + phase)
