# SPDX-License-Identifier: GPL-3.0-or-later
"""Seconds, products with L, and peak memory."""

import copy
import multiprocessing
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path
from statistics import median
from time import perf_counter

import numpy as np

from synch_fields.core.solve import Options, solve
from synch_fields.core.solve.stage import Workspace
from synch_fields.core.solve.threads import one_blas_thread


def timed(work, *arguments):
    """Result and wall seconds."""
    start = perf_counter()
    result = work(*arguments)
    return result, perf_counter() - start


def untouched(problem):
    """The problem with its matrices but without anything that an earlier solve left on them."""
    twin = copy.copy(problem)
    twin.pieces = [replace(piece) for piece in problem.pieces]
    return twin


def timed_solve(problem, **options):
    """Solution and wall seconds; the matrices are there already, as they are for the peers."""
    return timed(solve, untouched(problem), Options(**options))


def timed_relaxation(problem, target_gap, seed=0):
    """Solution and wall seconds of everything but the rounding: start, relaxation and certificate."""
    solution, seconds = timed_solve(problem, target_gap=target_gap, rounding="svd", seed=seed)
    return solution, seconds - solution.times.get("round", 0.0)


def energy_of(problem, method):
    """Energy of a peer's fields on all pieces."""
    with one_blas_thread():
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
        cycles += median(timed(metric.solve, columns)[1] for _ in range(9))
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
