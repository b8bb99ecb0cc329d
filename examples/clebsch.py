# SPDX-License-Identifier: GPL-3.0-or-later
"""Vortex filaments of equal strength in the flow around a trefoil knot: the paper's Figure 5, small.

    minimize  sum over edges ij of  w_ij |phi_j - exp(i u_ij / hbar) phi_i|^2   over unit numbers phi       (Eq. 13)

with the integral u_ij of the velocity along an edge of a grid. Each curve where phi vanishes carries the circulation
h = 2 pi hbar. Here: the spectral relaxation, the semidefinite one rounded by its singular vector, by the best of random
projections, and by the default search.

    python examples/clebsch.py [NODES] [PARTS]
"""

import sys

import numpy as np

from synch_fields.core.extract.vortices.filaments import filaments
from synch_fields.core.fields.biot_savart import filament_velocity
from synch_fields.core.fields.clebsch import clebsch_map, edge_integrals
from synch_fields.core.geometry.grid import Grid
from synch_fields.core.solve import Options

WAYS = {
    "spectral": Options(method="spectral"),
    "singular vector": Options(rounding="svd"),
    "randomized": Options(rounding="random"),
    "default": Options(),
}


def main(nodes=24, parts=4):
    shape = np.array([nodes, nodes, nodes // 2])
    grid = Grid(shape, 1 / (nodes - 1), -0.5 * (shape - 1) / (nodes - 1))
    turn = 2 * np.pi * np.arange(121) / 120
    knot = np.column_stack(
        [np.sin(turn) + 2 * np.sin(2 * turn), np.cos(turn) - 2 * np.cos(2 * turn), -np.sin(3 * turn)]
    )
    integrals = edge_integrals(grid, filament_velocity(grid.places, [(0.107 * knot, 1.0)], 0.06))
    found = {name: clebsch_map(grid, integrals, 1 / parts, options) for name, options in WAYS.items()}
    for name, options in found.items():
        print(f"{name:>16}: energy {options.energy:.3f}")
    best = found["default"]
    print(f"at least {best.solution.lower_bound:.3f} ({best.solution.certificate}); {len(filaments(best))} filaments")
    return found


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
