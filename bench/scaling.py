# SPDX-License-Identifier: GPL-3.0-or-later
"""Time and memory against size, with the slope of log time against log nodes.

    python bench/scaling.py SHAPE=SIZES [SHAPE=SIZES ...] [--problem "n = 4"] [--repeat 1] [--long-proofs]

    MESH.obj=1,2,4,6     the mesh with every edge in so many parts
    sphere=10,32,100     spheres of 10 parts² + 2 vertices
    grid=32,64,128       a trefoil vortex on a grid of size x size x size / 2 nodes, relaxation alone

Every size is measured in a process of its own, which holds nothing else. "s relaxation": relaxation and
certificate to a gap of 1e-2, "× LY": its CPU time in products L Y; "s solve": the whole default solve. "MB problem",
"MB relaxation" and "MB solve": the most memory held until the matrices, the relaxation and the solve are there.
"""

from pathlib import Path
from statistics import median

import numpy as np

from synch_fields.bench import problems
from synch_fields.bench.command import arguments
from synch_fields.bench.grids import trefoil_problem
from synch_fields.bench.measure import peak_megabytes, relaxation_in_products, row_of_child, timed, timed_solve
from synch_fields.bench.meshes import read_obj
from synch_fields.bench.subdivide import sphere, subdivided
from synch_fields.bench.tables import Column, print_table
from synch_fields.core.algebra.workers import solving
from synch_fields.core.solve import Options

TARGET_GAP = 1e-2
# Where the slope is taken.
SLOPE_FROM = 10_000
COLUMNS = (
    Column("nodes", "nodes", "d"),
    Column("edges", "edges", "d"),
    Column("s matrices", "build s", ".2f"),
    Column("s relaxation", "relaxation s", ".2f"),
    Column("of it certificate", "proof s", ".2f"),
    Column("gap", "gap", ".1e"),
    Column("certificate", "certificate", ""),
    Column("rank", "rank", "d"),
    Column("× LY", "LY", ".0f"),
    Column("s solve", "solve s", ".2f"),
    Column("energy", "energy", ".2f"),
    Column("MB problem", "MB problem", ".0f"),
    Column("MB relaxation", "MB relaxation", ".0f"),
    Column("MB solve", "MB solve", ".0f"),
)


def main():
    """Print a table and the slopes for every shape."""
    options = _arguments()
    for argument in options.shapes:
        shape, sizes = argument.rsplit("=", 1)
        name = Path(shape).stem
        rows = [
            row_of_child(f"{name} {size}", measure, shape, size, options.problem, options.repeat, options.long_proofs)
            for size in map(int, sizes.split(","))
        ]
        print_table(f"{name}, trefoil" if shape == "grid" else f"{name}, {options.problem}", COLUMNS, rows)
        for what, key in (("relaxation and certificate", "relaxation s"), ("whole solve", "solve s")):
            _print_slope(what, [(row["nodes"], row[key]) for row in rows if key in row])


def _arguments():
    parser = arguments(__doc__)
    parser.add_argument("shapes", nargs="+", metavar="SHAPE=SIZES")
    parser.add_argument("--problem", choices=problems.NAMES, default="n = 4")
    parser.add_argument("--repeat", type=int, default=1, help="runs, of which medians are printed (1)")
    parser.add_argument("--long-proofs", action="store_true", help="relaxations alone, proved however long that takes")
    return parser.parse_args()


def measure(shape, size, problem_name, repeat, long_proofs):
    """A row of the table; runs in a process of its own."""
    with solving():
        problem = _problem(shape, size, problem_name)
        _, build = timed(list, problem.pieces)
        row = {"nodes": problem.connection.node_count, "edges": len(problem.connection.edges), "build s": build}
        row["MB problem"] = peak_megabytes()
        options = [Options(target_gap=TARGET_GAP, seed=seed, long_proofs=long_proofs) for seed in range(repeat)]
        relaxations = [relaxation_in_products(problem, each) for each in options]
        solution = relaxations[0][0]
        row |= {"gap": solution.sdp_gap, "certificate": solution.certificate, "MB relaxation": peak_megabytes()}
        row["relaxation s"] = median(seconds for _, seconds, _ in relaxations)
        row["proof s"] = median(found.times["certify"] for found, _, _ in relaxations)
        row |= {"LY": median(products for _, _, products in relaxations), "rank": solution.rank}
        if shape != "grid" and not long_proofs:
            solves = [timed_solve(problem, seed=seed) for seed in range(repeat)]
            row["solve s"] = median(seconds for _, seconds in solves)
            row |= {"energy": median(solution.energy for solution, _ in solves), "MB solve": peak_megabytes()}
    return row


def _problem(shape, size, problem_name):
    if shape == "grid":
        return trefoil_problem((size, size, size // 2))
    mesh = sphere(size) if shape == "sphere" else subdivided(read_obj(shape), size)
    return problems.make_problem(mesh, problem_name)


def _print_slope(what, points):
    points = np.log([(nodes, seconds) for nodes, seconds in points if nodes >= SLOPE_FROM])
    if len(points) >= 2:
        print(f"\nSlope of {what} from {SLOPE_FROM} nodes: {np.polyfit(*points.T, 1)[0]:.2f}", flush=True)


if __name__ == "__main__":
    main()
