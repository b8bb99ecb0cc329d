# SPDX-License-Identifier: GPL-3.0-or-later
"""Singular Clebsch maps on a grid (Section 3.6.1): the velocity of a trefoil vortex as a connection."""

import numpy as np

from synch_fields.core.fields.biot_savart import filament_velocity
from synch_fields.core.fields.clebsch import clebsch_problem, edge_integrals
from synch_fields.core.geometry.grid import Grid
from synch_fields.core.interpolate import TURN

# Lengths are in units of the box's longest side.
SIZE = 0.32
CORE = 0.06
SEGMENTS = 120
# Filaments that the vortex is cut into: its circulation over 2 pi hbar.
QUANTA = 6


def trefoil_grid(shape):
    """A box grid of cubes around the origin with so many nodes along x, y and z, open boundary."""
    spacing = 1 / (max(shape) - 1)
    return Grid(shape, spacing, -0.5 * spacing * (np.array(shape) - 1))


def trefoil_problem(shape):
    """The problem of maps of the trefoil's flow, as many filaments as :data:`QUANTA`, on such a grid (Eq. 13)."""
    grid = trefoil_grid(shape)
    return clebsch_problem(grid, edge_integrals(grid, trefoil_velocity(grid.places)), TURN)


def trefoil_velocity(places):
    """(n, 3) velocity / hbar of a trefoil filament with a soft core, by Biot and Savart's law."""
    turn = TURN * np.arange(SEGMENTS + 1) / SEGMENTS
    curve = np.column_stack(
        [np.sin(turn) + 2 * np.sin(2 * turn), np.cos(turn) - 2 * np.cos(2 * turn), -np.sin(3 * turn)]
    )
    return filament_velocity(places, [(SIZE / 3 * curve, TURN * QUANTA)], CORE)
