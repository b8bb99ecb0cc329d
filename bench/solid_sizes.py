# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers in solids against size: the Stanford bunny, stuffed with finer and finer tetrahedra.

    python bench/solid_sizes.py MESHES [SIZE ...]

Sizes are those of the lattice, in units in which the surface has the area 1. Every size is measured in a process of its
own, in seconds of processor time of all its threads, so that the load of the machine counts for little. "× LY" is the
time in products of L with all columns of the lifted field, timed before and after in the same process; "s relaxation"
is all but the rounding.
"""

from statistics import median
from time import process_time

import numpy as np

from synch_fields.bench.command import arguments
from synch_fields.bench.measure import peak_megabytes, row_of_child, with_matrices
from synch_fields.bench.solid_shapes import stuffed_bunny
from synch_fields.bench.tables import Column, print_table
from synch_fields.core.algebra.workers import solving
from synch_fields.core.fields.guidance.solids import harmonic_directions
from synch_fields.core.fields.layers import layer_problem
from synch_fields.core.solve import Options, solve

SIZES = (0.03, 0.02, 0.015, 0.0108, 0.0062)
# Layers between the base and the tips of the ears, or so.
COUNT = 16
TARGET_GAP = 1e-2
PRODUCTS = 9
COLUMNS = (
    Column("vertices", "nodes", "d"),
    Column("tetrahedra", "tets", "d"),
    Column("edges", "edges", "d"),
    Column("s mesh", "mesh s", ".1f"),
    Column("s guidance", "guidance s", ".1f"),
    Column("s relaxation", "relaxation s", ".1f"),
    Column("gap", "gap", ".1e"),
    Column("certificate", "certificate", ""),
    Column("rank", "rank", "d"),
    Column("× LY", "LY", ".0f"),
    Column("s solve", "solve s", ".1f"),
    Column("solve × LY", "solve LY", ".0f"),
    Column("energy", "energy", ".3f"),
    Column("bound", "bound", ".3f"),
    Column("MB relaxation", "MB relaxation", ".0f"),
    Column("MB solve", "MB solve", ".0f"),
)


def main():
    """Print the table."""
    parser = arguments(__doc__, "stanford-bunny.obj")
    parser.add_argument("sizes", type=float, nargs="*", default=SIZES, help="%(default)s")
    options = parser.parse_args()
    rows = [row_of_child(f"bunny {size}", measure, options.meshes, size) for size in options.sizes]
    print_table(f"Layers in the stuffed bunny, {COUNT} along its height", COLUMNS, rows)


def measure(folder, size):
    """A row of the table; runs in a process of its own."""
    with solving():
        shape, mesh_seconds = processed(stuffed_bunny, folder, size)
        mesh = shape.mesh
        directions, guidance_seconds = processed(harmonic_directions, mesh, shape.low, shape.high)
        problem = layer_problem(mesh, directions, np.ptp(mesh.vertices[:, 2]) / COUNT)
        nodes = sum(piece.node_count for piece in problem.pieces)
        row = {"nodes": nodes, "tets": mesh.tet_count, "edges": len(mesh.edges)}
        row |= {"mesh s": mesh_seconds, "guidance s": guidance_seconds}
        relaxation, row["relaxation s"] = processed(
            solve, with_matrices(problem), Options(target_gap=TARGET_GAP, rounding="svd")
        )
        row |= {"gap": relaxation.sdp_gap, "certificate": relaxation.certificate, "rank": relaxation.rank}
        row |= {"MB relaxation": peak_megabytes()}
        products = product_times(problem, relaxation.rank)
        solution, row["solve s"] = processed(solve, with_matrices(problem), Options(target_gap=TARGET_GAP))
        products += product_times(problem, relaxation.rank)
        product = median(products)
        row |= {"LY": row["relaxation s"] / product, "solve LY": row["solve s"] / product}
        return row | {
            "energy": solution.energy,
            "bound": solution.lower_bound,
            "MB solve": peak_megabytes(),
            "t2": solution.times,
        }


def processed(work, *arguments):
    """Result and seconds of processor time of all threads."""
    start = process_time()
    result = work(*arguments)
    return result, process_time() - start


def product_times(problem, rank):
    """Seconds of some products L Y with all columns at once."""
    random, times = np.random.default_rng(0), []
    work = [(p.matrix, random.standard_normal((len(p.rows), 2 * rank)).view(p.matrix.dtype)) for p in problem.pieces]
    for _ in range(PRODUCTS):
        times.append(sum(processed(matrix.__matmul__, columns)[1] for matrix, columns in work))
    return times


if __name__ == "__main__":
    main()
