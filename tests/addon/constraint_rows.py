# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A sheet whose seams are marked, and rows as an artist adds them."""

import bpy
import numpy as np

from .scenes import attribute, make_active, mark_edges, panel

OPERATORS = ["directions", "stripes"]


def sheet():
    """A rectangle, 2 by 1.2, with seams on the column of vertices at x = 0."""
    obj = panel((2, 1.2), (8, 5), (-1, -0.6))
    mark_edges(obj, "seams", middle(obj))
    return obj


def middle(obj):
    return np.abs(attribute(obj, "position")[:, 0]) < 1e-6


def add_row(obj, **settings):
    make_active(obj)
    assert bpy.ops.synch.constraint_add() == {"FINISHED"}
    row = obj.synch.constraints[obj.synch.active_constraint]
    for name, value in settings.items():
        setattr(row, name, value)
    return row
