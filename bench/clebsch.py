# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's Figure 5: relaxations of singular Clebsch maps of a trefoil knot, at several circulations of a filament.

    python bench/clebsch.py [NODES]

Energies of the spectral relaxation (EIG), of SVD rounding, of randomized rounding and of the default solve, with the
bound, on a grid of NODES x NODES x NODES / 2 (40 by default). The knot's circulation is the number of quanta times h.
"""

import sys

import numpy as np
from grids import QUANTA, trefoil_velocity
from tables import Column, print_table

from synch_fields.core.extract.filaments import filaments
from synch_fields.core.fields.clebsch import TURN, clebsch_map, edge_integrals
from synch_fields.core.geometry.grid import Grid
from synch_fields.core.solve import Options

FILAMENTS = (6, 4, 3, 2, 1)
WAYS = {
    "eig": Options(method="spectral"),
    "svd": Options(rounding="svd"),
    "random": Options(rounding="random"),
    "polished": Options(),
}
COLUMNS = (
    Column("EIG", "eig", ".2f"),
    Column("SDP-SVD", "svd", ".2f"),
    Column("SDP-RR", "random", ".2f"),
    Column("default", "polished", ".2f"),
    Column("bound", "bound", ".2f"),
    Column("filaments", "filaments", "d"),
    Column("their length", "length", ".2f"),
)


def main(nodes=40):
    shape = (nodes, nodes, nodes // 2)
    grid = Grid(shape, 1 / (nodes - 1), -0.5 * (np.array(shape) - 1) / (nodes - 1))
    integrals = edge_integrals(grid, trefoil_velocity(grid.places))
    rows = []
    for quanta in FILAMENTS:
        maps = {name: clebsch_map(grid, integrals, TURN * QUANTA / quanta, way) for name, way in WAYS.items()}
        lines = filaments(maps["polished"])
        lengths = [np.linalg.norm(np.diff(line.points, axis=0), axis=1).sum() for line in lines]
        row = {name: found.energy for name, found in maps.items()}
        bound = maps["polished"].solution.lower_bound
        rows.append(
            row | {"label": f"{quanta} quanta", "bound": bound, "filaments": len(lines), "length": sum(lengths)}
        )
    print_table(f"Trefoil on {shape[0]} x {shape[1]} x {shape[2]} nodes", COLUMNS, rows)
    for row in rows:
        ordered = [row[name] for name in ("bound", "polished", "random", "svd", "eig")]
        if (np.diff(ordered) < -1e-6 * ordered[0]).any():
            print(f"out of order at {row['label']}: {ordered}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
