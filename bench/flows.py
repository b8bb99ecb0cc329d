# SPDX-License-Identifier: GPL-3.0-or-later
"""Filaments of flows whose vortices are known: how many close, and how they wind.

    python bench/flows.py [NODES ...] [--defaults] [--data FILE ...]

ABC flow and Taylor-Green vortices in a periodic box; two linked rings, Borromean rings and a trefoil of circulation 1
each, whose linking numbers, writhe and helicity stand in the rows "truth". Each by the spectral relaxation (EIG) and by
the semidefinite one (SDP), the two solvers of the paper's Figure 5, on grids of so many nodes along the longest side
(24 and 32 by default).

With --defaults only the table of what the default settings show: which share of the vorticity is carried, beside the
truth, and how many warnings there are. With --data the same of files of one's own, alone or beside --defaults, in any
format that is read; the library that reads them has to be there.
"""

import tempfile
import time
from pathlib import Path

import numpy as np

from synch_fields.bench.command import arguments
from synch_fields.bench.tables import Column, print_table
from synch_fields.core.extract.vortices.filaments import Filament, filaments
from synch_fields.core.extract.vortices.linking_numbers import linking_numbers
from synch_fields.core.fields.biot_savart import FilamentCurves, filament_integrals
from synch_fields.core.fields.clebsch import clebsch_map, edge_integrals, quantum_for
from synch_fields.core.fields.loops import flow_helicity
from synch_fields.core.files.flows import flow_file
from synch_fields.core.geometry.grid import Grid, box_grid
from synch_fields.core.interpolate import TURN
from synch_fields.core.settings.flow import FlowSettings
from synch_fields.core.solve import Options
from synch_fields.core.tasks.flows import FlowRequest

SOLVERS = {"EIG": Options(method="spectral"), "SDP": Options()}
# Radius of the filaments' cores in cells, passes of smoothing, and room around curves, as a share of their size.
CORE, SMOOTHING, ROOM = 0.5, 5, 0.3
# Filaments that are asked for through the plane of a periodic flow with most vorticity.
COUNTS = {"ABC": 6, "Taylor-Green": 16}
COLUMNS = (
    Column("h", "quantum", ".3g"),
    Column("energy", "energy", ".1f"),
    Column("filaments", "filaments", "d"),
    Column("closed", "closed", "d"),
    Column("around the box", "around", "d"),
    Column("windings", "windings", ""),
    Column("links", "links", "d"),
    Column("writhe", "writhe", ".2f"),
    Column("helicity", "helicity", ".2f"),
)


def abc(x, y, z):
    """Arnold, Beltrami and Childress's flow."""
    return np.sin(z) + np.cos(y), np.sin(x) + np.cos(z), np.sin(y) + np.cos(x)


def taylor_green(x, y, z):
    """Taylor and Green's vortices."""
    return np.sin(x) * np.cos(y) * np.cos(z), -np.cos(x) * np.sin(y) * np.cos(z), 0 * x


def curves():
    """Closed polygons of each link."""
    turn = np.linspace(0, TURN, 120, endpoint=False)
    circle = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    flat = circle * [2, 1, 0]
    trefoil = [np.sin(turn) + 2 * np.sin(2 * turn), np.cos(turn) - 2 * np.cos(2 * turn), -np.sin(3 * turn)]
    return {
        "linked rings": [circle, circle[:, [0, 2, 1]] + [1, 0, 0]],
        "Borromean rings": [np.roll(flat, k, axis=1) for k in range(3)],
        "trefoil": [np.column_stack(trefoil)],
    }


def told(label, lines, box, **more):
    """The row of filaments."""
    found = linking_numbers(lines, box)
    windings = sorted({tuple(abs(turns) for turns in line.winding) for line in lines if any(line.winding)})
    return {
        "label": label,
        "filaments": len(lines),
        "closed": sum(line.is_closed for line in lines),
        "around": sum(any(line.winding) for line in lines),
        "windings": " ".join("(" + " ".join(map(str, one)) + ")" for one in windings) or "–",
        "links": None if found is None else int(np.abs(np.triu(found.numbers, 1)).sum()),
        "writhe": None if found is None else float(found.writhes.sum()),
        "helicity": None if found is None else found.helicity,
        **more,
    }


def solved(label, grid, integrals, quantum):
    """The rows of both solvers."""
    box = np.where(grid.periodic, grid.spacing * grid.shape, 0)
    for name, options in SOLVERS.items():
        found = clebsch_map(grid, integrals, quantum, options)
        lines = filaments(found, SMOOTHING)
        yield told(f"{label}, {max(grid.shape)}: {name}", lines, box, quantum=quantum, energy=found.energy)


# Defaults

DEFAULTS = (
    Column("nodes", "nodes", "d"),
    Column("h", "quantum", ".3g"),
    Column("carried", "share", ".0%"),
    Column("filaments", "filaments", "d"),
    Column("closed", "closed", "d"),
    Column("links", "links", "d"),
    Column("writhe", "writhe", ".2f"),
    Column("helicity", "helicity", ".1f"),
    Column("of the flow", "whole", ".1f"),
    Column("warnings", "warnings", "d"),
    Column("CPU s", "seconds", ".0f"),
)


def jet(nodes):
    """Vorticity of a round jet whose shear layer has rolled up to four rings, periodic along it, with its grid."""
    grid = Grid((nodes, nodes, nodes), 4 / nodes, (-2, -2, 0), (False, False, True))
    x, y, z = grid.places.T
    radius = np.hypot(x, y)
    layer = np.exp(-(((radius - 1) / 0.25) ** 2)) * (1 + np.cos(TURN * z))
    return grid, layer[:, None] / np.maximum(radius, 1e-9)[:, None] * np.column_stack([-y, x, 0 * x])


def default_sources(folder, nodes):
    """Test flows by name, with the polygons of their vortices if known."""
    for label, flow in (("ABC", abc), ("Taylor-Green", taylor_green)):
        grid = Grid((nodes,) * 3, TURN / nodes, 0.0, True)
        velocity = np.column_stack(flow(*grid.places.T)).reshape(*grid.shape, 3)
        np.savez(folder / f"{label}.npz", velocity=velocity, spacing=grid.spacing, periodic=True)
        yield label, flow_file(folder / f"{label}.npz"), None
    grid, vorticity = jet(nodes)
    more = {"spacing": grid.spacing, "origin": grid.origin, "periodic": grid.periodic}
    np.savez(folder / "jet.npz", vorticity=vorticity.reshape(*grid.shape, 3), **more)
    yield "jet", flow_file(folder / "jet.npz"), None
    links = curves()
    circle = links["linked rings"][0]
    links = {
        "leapfrogging rings": [circle, 0.8 * circle + [0, 0, 0.5]],
        "Hopf link": links.pop("linked rings"),
        **links,
    }
    for label, link in links.items():
        closed = tuple((np.vstack([curve, curve[:1]]), 1.0) for curve in link)
        yield label, FilamentCurves(label, closed, 0.5), link


def shown_by_default(label, source, nodes):
    """The row of a flow."""
    begin = time.process_time()
    result = FlowRequest(source, FlowSettings(resolution=nodes)).solve()
    seconds, grid = time.process_time() - begin, result.found.grid
    row = told(label, result.shown.lines, np.where(grid.periodic, grid.spacing * grid.shape, 0))
    row |= {"nodes": grid.node_count, "quantum": result.found.quantum, "share": result.shown.share, "seconds": seconds}
    row |= {"whole": flow_helicity(grid, result.found.integrals)}
    for line in result.warnings:
        print(f"{label}: {line}", flush=True)
    if result.shown.share < 0.6 and not result.warnings:
        raise SystemExit(f"{label}: {result.shown.share:.0%} are carried, and nothing is said")
    return row | {"warnings": len(result.warnings)}


def defaults(nodes, with_known, files):
    """Print what the default settings show of the known flows, if wanted, on grids of so many nodes along the longest
    side, and of files."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for label, source, link in default_sources(Path(folder), nodes) if with_known else ():
            if link is not None:
                rows.append(told(f"{label}: truth", [Filament(curve, 1.0, True) for curve in link], np.zeros(3)))
            rows.append(shown_by_default(label, source, nodes))
    rows += [shown_by_default(path.name, flow_file(path, attribute), nodes) for path, attribute in map(named, files)]
    print_table("What the default settings show", DEFAULTS, rows)


def named(text):
    """The path and the attribute of FILE or FILE:ATTRIBUTE."""
    path, _, attribute = text.partition(":")
    return Path(path), attribute or "velocity"


def main(sizes):
    """Print the table."""
    rows = []
    for label, flow in (("ABC", abc), ("Taylor-Green", taylor_green)):
        for nodes in sizes:
            grid = Grid((nodes,) * 3, TURN / nodes, 0.0, True)
            integrals = edge_integrals(grid, np.column_stack(flow(*grid.places.T)))
            rows += solved(label, grid, integrals, quantum_for(grid, integrals, COUNTS[label]))
    for label, link in curves().items():
        rows.append(told(f"{label}: truth", [Filament(curve, 1.0, True) for curve in link], np.zeros(3)))
        points = np.concatenate(link)
        low, high = points.min(axis=0), points.max(axis=0)
        room = ROOM * float((high - low).max())
        for nodes in sizes:
            grid = box_grid(low - room, high + room, nodes)
            closed = [(np.vstack([curve, curve[:1]]), 1.0) for curve in link]
            integrals = filament_integrals(grid, closed, CORE * float(grid.spacing.min()))
            rows += solved(label, grid, integrals, 1.0)
    print_table("Filaments of known flows", COLUMNS, rows)


if __name__ == "__main__":
    parser = arguments(__doc__)
    parser.add_argument("nodes", type=int, nargs="*", default=[24, 32])
    parser.add_argument("--defaults", action="store_true", help="only the table of the default settings")
    parser.add_argument("--data", nargs="*", default=[], metavar="FILE[:ATTRIBUTE]", help="flows to add to it")
    given = parser.parse_args()
    if given.defaults or given.data:
        defaults(given.nodes[-1], given.defaults, given.data)
    else:
        main(given.nodes)
