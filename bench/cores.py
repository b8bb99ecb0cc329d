# SPDX-License-Identifier: GPL-3.0-or-later
"""Shares of a solve that several cores can compute at the same time, and its speed on them by a model.

    SYNCH_THREADS=1 python bench/cores.py MESH.obj [MESH.obj ...] [--problems "n = 4" ...]

Prints Markdown. One solve on one core gives the CPU seconds of the relaxation, of its proof, of what rounding needs
besides, and of every batch of columns of the rounding. bench/README.md says what the model adds up.
"""

import argparse
from heapq import heapify, heapreplace
from pathlib import Path
from time import thread_time
from unittest.mock import patch

from synch_fields.bench import problems
from synch_fields.bench.measure import with_matrices
from synch_fields.bench.meshes import read_obj
from synch_fields.bench.tables import Column, print_table
from synch_fields.core.algebra.workers import WORKERS
from synch_fields.core.solve import semidefinite, solve, solver
from synch_fields.core.solve.methods import rounding, staircase

CORES = (2, 4, 8, 16)
SHARES = ("relaxation", "proof", "besides", "batches", "rest")
COLUMNS = (
    Column("CPU s", "total", ".2f"),
    *(Column(name, name, ".0%") for name in SHARES),
    *(Column(f"{count} cores", count, ".2f") for count in CORES),
)


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("meshes", nargs="+", metavar="MESH.obj")
    parser.add_argument("--problems", nargs="+", choices=problems.NAMES, default=["n = 4", "stripes 40"])
    options = parser.parse_args()
    if WORKERS > 1:
        parser.error("set SYNCH_THREADS=1: the shares are measured on one core")
    rows = []
    for path in options.meshes:
        for name, problem in problems.problems(read_obj(path), options.problems):
            rows.append({"label": f"{Path(path).stem} {name}"} | measure(with_matrices(problem)))
    print_table("Shares of the CPU time, and how many times as fast by the model", COLUMNS, rows)


def measure(problem):
    """The shares of one problem, and its speed on several cores over that on one."""
    seconds = dict.fromkeys(SHARES, 0.0)
    calls = []

    def timed(name, work):
        def run(*arguments):
            start = thread_time()
            try:
                return work(*arguments)
            finally:
                seconds[name] += thread_time() - start

        return run

    def run_batches(work, parts, monitor, at_once):
        results, spent = [], []
        for part in parts:
            start = thread_time()
            results.append(work(part, monitor))
            spent.append(thread_time() - start)
        calls.append((spent, at_once))
        return results

    with (
        patch.object(semidefinite, "relax", timed("relaxation", semidefinite.relax)),
        patch.object(staircase, "prove", timed("proof", staircase.prove)),
        patch.object(solver, "prepare_search", timed("besides", solver.prepare_search)),
        patch.object(rounding, "share_out", run_batches),
    ):
        start = thread_time()
        solve(problem)
        total = thread_time() - start
    seconds["relaxation"] -= seconds["proof"]
    seconds["batches"] = sum(sum(spent) for spent, _ in calls)
    seconds["rest"] = total - sum(seconds.values())
    speeds = {count: total / _model(seconds, calls, count) for count in CORES}
    return {"total": total} | {name: seconds[name] / total for name in SHARES} | speeds


def _model(seconds, calls, cores):
    """Seconds on several cores: preparations run beside the relaxation, its proof beside the rounding."""
    first = max(seconds["relaxation"], seconds["besides"])
    rounding_alone = seconds["rest"] + sum(_last_end(spent, min(cores, at_once)) for spent, at_once in calls)
    together = (seconds["proof"] + seconds["rest"] + seconds["batches"]) / cores
    return first + max(seconds["proof"], rounding_alone, together)


def _last_end(spent, cores):
    """Seconds of parts that are begun in order, each by the first core that is free."""
    ends = [0.0] * cores
    heapify(ends)
    for part in spent:
        heapreplace(ends, ends[0] + part)
    return max(ends)


if __name__ == "__main__":
    main()
