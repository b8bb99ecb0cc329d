# SPDX-License-Identifier: GPL-3.0-or-later
"""Seconds, products with L, and peak memory."""

import multiprocessing
import sys
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace
from pathlib import Path
from statistics import median
from time import perf_counter, process_time

import numpy as np

from synch_fields.core.algebra.workers import solving
from synch_fields.core.solve import Options, solve
from synch_fields.core.solve.methods.certificate import plan_proof
from synch_fields.core.solve.methods.stage import Workspace
from synch_fields.core.solve.methods.staircase import start_rank

# The clock of :func:`timed`.
_clocks = [perf_counter]
# CPU seconds from one product to the next where they are timed in between.
BETWEEN = 0.5


def time_the_processor():
    """From now on :func:`timed` measures CPU seconds."""
    _clocks[0] = process_time


def timed(work, *arguments):
    """Result and wall seconds, or CPU seconds after :func:`time_the_processor`."""
    start = _clocks[0]()
    result = work(*arguments)
    return result, _clocks[0]() - start


def spent(work, *arguments):
    """Result and CPU seconds, which do not count what else the machine does."""
    start = process_time()
    result = work(*arguments)
    return result, process_time() - start


def with_matrices(problem):
    """The problem, its matrices made."""
    list(problem.pieces)
    return problem


def timed_solve(problem, **options):
    """Solution and seconds as of :func:`timed`; the matrices are there already, as they are for the peers."""
    return timed(solve, with_matrices(problem), Options(**options))


def timed_relaxation(problem, target_gap, seed=0):
    """Solution and seconds of everything but the rounding: start, relaxation and certificate."""
    solution, seconds = timed_solve(problem, target_gap=target_gap, rounding="svd", seed=seed)
    # This rounding takes a thousandth of the time, and its seconds are of the wall.
    return solution, seconds if _clocks[0] is process_time else seconds - solution.times.get("round", 0.0)


def relaxation_in_products(problem, options):
    """Solution, wall seconds of everything but the rounding, and its CPU seconds in products L Y; the rounding of the
    options is not made.

    Products are timed again and again in between, on one core and in double precision, with as many columns as the
    lifted field begins with: so both meet the machine's load. Their time is left out.
    """
    problem = with_matrices(problem)
    piece = max(problem.pieces, key=lambda piece: piece.node_count)
    rank = start_rank(piece, plan_proof(piece, options.long_proofs) is not None, options.target_gap)
    columns = np.ones((piece.matrix.shape[0], rank), piece.matrix.dtype)
    spent = {"wall": 0.0, "cpu": 0.0}
    products = []

    def between(_stage, _fraction):
        if process_time() - last[0] > BETWEEN:
            wall, cpu = perf_counter(), process_time()
            piece.matrix @ columns
            products.append(process_time() - cpu)
            spent["wall"] += perf_counter() - wall
            spent["cpu"] += products[-1]
            last[0] = process_time()

    wall, last = perf_counter(), [-np.inf]
    cpu = process_time()
    solution = solve(problem, replace(options, rounding="svd"), between)
    wall, cpu = perf_counter() - wall - spent["wall"], process_time() - cpu - spent["cpu"]
    return solution, wall - solution.times.get("round", 0.0), cpu / median(products)


def energy_of(problem, method):
    """Energy of a peer's fields on all pieces."""
    with solving():
        return sum(float(piece.energy(method(piece))[0]) for piece in problem.pieces)


def product_seconds(problem, rank, repeats=9):
    """Seconds of L Y with all columns at once: the median of some."""
    random = np.random.default_rng(0)
    total = 0.0
    for piece in problem.pieces:
        matrix = piece.matrix
        columns = random.standard_normal((matrix.shape[0], max(rank, 1))).astype(matrix.dtype)
        total += median(timed(matrix.__matmul__, columns)[1] for _ in range(repeats))
    return total


def cycle_products(problem, rank):
    """What one application of the preconditioner to all columns costs, in products L Y."""
    random = np.random.default_rng(0)
    cycles = 0.0
    for piece in problem.pieces:
        metric = Workspace(piece).stages[0].metric(piece.stiffness * 1e-3)
        columns = random.standard_normal((piece.matrix.shape[0], max(rank, 1))).astype(metric.dtype)
        cycles += median(timed(metric.precondition, columns)[1] for _ in range(9))
    return cycles / product_seconds(problem, rank)


def peak_megabytes():
    """Most memory that this process has held."""
    status = Path("/proc/self/status")
    if status.exists():  # Linux: getrusage would start from what the parent held
        line = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM"))
        return int(line.split()[1]) / 1024
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20


def in_child(work, *arguments):
    """Result of a function of a module, run in a process of its own."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        return pool.submit(work, *arguments).result()


def row_of_child(label, work, *arguments):
    """A row of a table from a function that :func:`in_child` runs, or that it was killed."""
    print(label, file=sys.stderr, flush=True)
    try:
        return {"label": label} | in_child(work, *arguments)
    except BrokenProcessPool:
        return {"label": label, "certificate": "no result: the process was killed"}
