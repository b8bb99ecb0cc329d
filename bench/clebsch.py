# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's Figure 5: relaxations of singular Clebsch maps of a trefoil knot, at several circulations of a filament.

    python bench/clebsch.py [NODES]

First table: energies of the spectral relaxation (EIG), of SVD rounding, of randomized rounding and of the default
solve, with the bound, on a grid of NODES x NODES x NODES / 2 (40 by default). The knot's circulation is the number of
quanta times h. Second table: filaments found, for a wanted number of them through the plane with most vorticity.
Third table: more quanta. All say which share of all vorticity the filaments carry, and how far, in quanta and root mean
square, the number of filaments through a square loop is from the flow's circulation along it, for all loops of a tenth
and of a quarter of the longest side.
"""

import numpy as np

from synch_fields.bench.command import arguments
from synch_fields.bench.grids import QUANTA, trefoil_grid, trefoil_velocity
from synch_fields.bench.tables import Column, print_table
from synch_fields.core.extract.vortices.filaments import filaments
from synch_fields.core.fields.clebsch import circulations, clebsch_map, edge_integrals, quantum_for
from synch_fields.core.fields.loops import loop_error
from synch_fields.core.interpolate import TURN
from synch_fields.core.solve import Options

CUTS = (6, 4, 3, 2, 1)
# Cuts of the same knot that carry up to 95 % of its vorticity.
FINER = (12, 24, 48)
WISHED = (1, 2, 4, 8, 16)
WAYS = {
    "eig": Options(method="spectral"),
    "svd": Options(rounding="svd"),
    "random": Options(rounding="random"),
    "polished": Options(),
}
FOUND = (
    Column("filaments", "filaments", "d"),
    Column("their length", "length", ".2f"),
    Column("share of vorticity", "share", ".0%"),
    Column("off, small loops", "small loops", ".2f"),
    Column("off, large loops", "large loops", ".2f"),
)
ENERGIES = (
    Column("EIG", "eig", ".2f"),
    Column("SDP-SVD", "svd", ".2f"),
    Column("SDP-RR", "random", ".2f"),
    Column("default", "polished", ".2f"),
    Column("bound", "bound", ".2f"),
    *FOUND,
)
COUNTS = (Column("h / 2π", "h", ".3f"), Column("energy", "energy", ".2f"), Column("bound", "bound", ".2f"), *FOUND)


def main(nodes):
    """Print both tables."""
    rows = cut_rows(nodes)
    shape, grid, integrals = _flow(nodes)
    print_table(f"Trefoil on {shape[0]} x {shape[1]} x {shape[2]} nodes", ENERGIES, rows)
    rows = []
    for count in WISHED:
        found = clebsch_map(grid, integrals, quantum_for(grid, integrals, count))
        rows.append({"label": f"{count} wished", "h": found.quantum / TURN, "energy": found.energy} | row(found))
    print_table("Filaments wished through the plane with most vorticity", COUNTS, rows)
    print_table("More quanta", COUNTS, finer_rows(nodes))


def cut_rows(nodes):
    """Rows of the first table, whose energies have to be in order.

    Raises
    ------
    SystemExit
        where they are not
    """
    _, grid, integrals = _flow(nodes)
    rows = []
    for cut in CUTS:
        maps = {name: clebsch_map(grid, integrals, TURN * QUANTA / cut, way) for name, way in WAYS.items()}
        energies = {name: found.energy for name, found in maps.items()}
        rows.append({"label": f"{cut} quanta"} | energies | row(maps["polished"]))
        ordered = [rows[-1][name] for name in ("bound", "polished", "random", "svd", "eig")]
        if (np.diff(ordered) < -1e-6 * ordered[0]).any():
            raise SystemExit(f"out of order at {cut} quanta: {ordered}")
    return rows


def finer_rows(nodes):
    """Rows of the third table."""
    _, grid, integrals = _flow(nodes)
    maps = {cut: clebsch_map(grid, integrals, TURN * QUANTA / cut) for cut in FINER}
    return [
        {"label": f"{cut} quanta", "h": found.quantum / TURN, "energy": found.energy} | row(found)
        for cut, found in maps.items()
    ]


def _flow(nodes):
    """Shape and grid of the box, and the flow's integrals along its edges."""
    shape = (nodes, nodes, nodes // 2)
    grid = trefoil_grid(shape)
    return shape, grid, edge_integrals(grid, trefoil_velocity(grid.places))


def row(found):
    """What is said about a map."""
    lines = filaments(found)
    vorticity = np.abs(circulations(found.grid, found.integrals)).sum()
    longest = max(found.grid.shape)
    return {
        "bound": found.solution.lower_bound,
        "filaments": len(lines),
        "length": sum(line.length for line in lines),
        "share": found.quantum * np.abs(found.face_numbers).sum() / vorticity,
        "small loops": loop_error(found, longest // 10),
        "large loops": loop_error(found, longest // 4),
    }


if __name__ == "__main__":
    parser = arguments(__doc__)
    parser.add_argument("nodes", type=int, nargs="?", default=40)
    main(parser.parse_args().nodes)
