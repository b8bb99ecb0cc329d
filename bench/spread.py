# SPDX-License-Identifier: GPL-3.0-or-later
"""The relaxation on many processes (bench/mpi), beside that of one.

    mpirun -n 4 python bench/spread.py torus=1000000 sphere=998562 [--gap 1e-2]
    python bench/spread.py --alone torus=1000000

    torus=NODES     stripes around a torus, 50 of them inside and 150 outside; every process makes its own part
    sphere=NODES    crosses (n = 4) on a sphere, which process 0 makes whole and scatters

"energy": of the best of some random projections after descent. "CPU s": the most of a process, waiting included. "MB":
the most memory that a process has held, its mesh included.
"""

from time import perf_counter, process_time

import numpy as np

from synch_fields.bench import problems
from synch_fields.bench.command import arguments
from synch_fields.bench.measure import peak_megabytes
from synch_fields.bench.subdivide import sphere
from synch_fields.bench.tables import Column, print_table
from synch_fields.core.connection import Connection
from synch_fields.core.problem import SynchronizationProblem
from synch_fields.core.solve import Options, solve

# Of the torus: its radius over the tube's, the stripes around its middle, and columns of nodes over rows.
RADII, LINES, ASPECT = 2.0, 100, 2
COLUMNS = (
    Column("nodes", "nodes", "d"),
    Column("processes", "processes", "d"),
    Column("relaxation", "value", ".6g"),
    Column("bound", "bound", ".6g"),
    Column("certificate", "certificate", ""),
    Column("rank", "rank", "d"),
    Column("steps", "steps", "d"),
    Column("energy", "energy", ".6g"),
    Column("s", "seconds", ".1f"),
    Column("CPU s", "cpu", ".1f"),
    Column("s build", "build", ".1f"),
    Column("s relax", "relax", ".1f"),
    Column("s certify", "certify", ".1f"),
    Column("MB", "megabytes", ".0f"),
)


def main():
    """Print a table."""
    parser = arguments(__doc__)
    parser.add_argument("shapes", nargs="+", metavar="SHAPE=NODES")
    parser.add_argument("--gap", type=float, default=1e-2, help="target gap (1e-2)")
    parser.add_argument("--alone", action="store_true", help="without PETSc, by the solver of one process")
    options = parser.parse_args()
    shapes = [(shape, int(count)) for shape, _, count in (text.partition("=") for text in options.shapes)]
    rows = [(alone if options.alone else spread)(*shape, options.gap) for shape in shapes]
    if options.alone or rows[0]:
        print_table(f"to a gap of {options.gap:g}", COLUMNS, rows)


def torus(count, first=0.0, last=1.0):
    """A range of the nodes of a torus, its edges, and their transports: stripes around the axis, evenly spaced.

    Returns
    -------
    start : number of the first node in the range from one share of all to another
    connection : Connection with the edges that have an end in the range
    mass : of the nodes in the range
    """
    rows = round(np.sqrt(count / ASPECT))
    columns = round(count / rows)
    begin, end = round(first * columns), round(last * columns)
    around, along = 2 * np.pi / columns, 2 * np.pi / rows
    tails, heads, weights, angles = [], [], [], []
    radius = RADII + np.cos(np.arange(rows) * along)
    between = RADII + np.cos((np.arange(rows) + 0.5) * along)
    own = np.arange(begin, end)[:, None]
    before = np.unique(np.append(np.arange(begin, end), begin - 1) % columns)[:, None]
    row = np.arange(rows)
    links = (
        (before, row, (before + 1) % columns, row, along / (radius * around), LINES * radius / RADII * around),
        (own, row, own, (row + 1) % rows, between * around / along, np.zeros(rows)),
    )
    for column, at, next_column, next_at, weight, angle in links:
        tail, head = np.broadcast_arrays(column * rows + at, next_column * rows + next_at)
        tails, heads = [*tails, tail.ravel()], [*heads, head.ravel()]
        weights, angles = [*weights, np.tile(weight, len(column))], [*angles, np.tile(angle, len(column))]
    edges = np.column_stack([np.concatenate(tails), np.concatenate(heads)])
    connection = Connection(rows * columns, edges, np.concatenate(weights), np.exp(1j * np.concatenate(angles)))
    return begin * rows, connection, np.tile(radius * around * along, end - begin)


def problem_of(shape, count):
    """The SynchronizationProblem of a whole shape."""
    if shape == "torus":
        _, connection, mass = torus(count)
        return SynchronizationProblem(connection, mass)
    return problems.make_problem(sphere(round(np.sqrt((count - 2) / 10))), "n = 4")


def alone(shape, count, gap):
    """A row of the solver of one process."""
    problem = problem_of(shape, count)
    wall, cpu = perf_counter(), process_time()
    solution = solve(problem, Options(target_gap=gap, rounding="svd"))
    return {
        "label": shape,
        "nodes": problem.connection.node_count,
        "processes": 0,
        "value": solution.sdp_value,
        "bound": solution.lower_bound,
        "certificate": solution.certificate,
        "rank": solution.rank,
        "steps": solution.iterations,
        "seconds": perf_counter() - wall,
        "cpu": process_time() - cpu,
        "megabytes": peak_megabytes(),
    } | solution.times


def spread(shape, count, gap):
    """A row of all processes; empty but in the first."""
    from mpi4py import MPI

    from synch_fields.bench.mpi.parts import Part, parts_of
    from synch_fields.bench.mpi.relaxation import solve_parts

    comm = MPI.COMM_WORLD
    if shape == "torus":
        part = Part(*torus(count, comm.rank / comm.size, (comm.rank + 1) / comm.size))
    else:
        whole = None
        if comm.rank == 0:
            problem = problem_of(shape, count)
            whole, _ = parts_of(problem.connection, problem.mass, comm.size)
        part = comm.scatter(whole)
        whole = None
    comm.Barrier()
    wall, cpu = perf_counter(), process_time()
    solution = solve_parts(part, comm, gap)
    wall, cpu = perf_counter() - wall, process_time() - cpu
    found = solution.relaxation
    row = {
        "label": shape,
        "nodes": part.connection.node_count,
        "processes": comm.size,
        "value": found.value,
        "bound": found.lower_bound,
        "certificate": found.certificate,
        "rank": found.lifted.shape[1],
        "steps": found.steps,
        "energy": solution.energy,
        "seconds": wall,
        "cpu": comm.allreduce(cpu, MPI.MAX),
        "megabytes": comm.allreduce(peak_megabytes(), MPI.MAX),
    }
    return row | solution.seconds if comm.rank == 0 else {}


if __name__ == "__main__":
    main()
