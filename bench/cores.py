# SPDX-License-Identifier: GPL-3.0-or-later
"""Shares of a solve that several cores can compute at the same time, and its speed on them by a model.

    SYNCH_THREADS=1 python bench/cores.py MESH.obj [MESH.obj ...] [--problems "n = 4" ...]

Prints Markdown. One solve on one core gives the CPU seconds of the relaxation, of its proof, of what rounding needs
besides, and of each batch of columns of the rounding, split as eight cores share them; and how much of each is in
products whose rows cores can share. bench/README.md says what the model adds up.
"""

import argparse
from functools import partial
from heapq import heapify, heapreplace
from pathlib import Path
from time import thread_time
from typing import NamedTuple
from unittest.mock import patch

from synch_fields.bench import problems
from synch_fields.bench.measure import with_matrices
from synch_fields.bench.meshes import read_obj
from synch_fields.bench.tables import Column, print_table
from synch_fields.core.algebra.products import WORTH_SHARING, SharedRows
from synch_fields.core.algebra.workers import MOST_WORKERS, WORKERS
from synch_fields.core.solve import semidefinite, solve, solver
from synch_fields.core.solve.methods import rounding, staircase

CORES = (2, 4, 8, 16)
SHARES = ("relaxation", "proof", "besides", "batches", "rest")
# Seconds that sharing the rows of a product costs: handing parts to threads, and waiting for the last.
SHARING = 1e-4
COLUMNS = (
    Column("CPU s", "total", ".2f"),
    *(Column(name, name, ".0%") for name in SHARES),
    Column("rows", "rows", ".0%"),
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
    seconds, rows = dict.fromkeys(SHARES, Part()), {"now": Part()}
    calls, multiply = [], SharedRows.__matmul__

    def shared(matrix, columns):
        start = thread_time()
        result = multiply(matrix, columns)
        if matrix.matrix.nnz * (columns.size // matrix.shape[1]) >= WORTH_SHARING:
            rows["now"] += Part(0.0, thread_time() - start, 1)
        return result

    def timed(name, work):
        def run(*arguments):
            result, part = spent(partial(work, *arguments))
            seconds[name] += part
            return result

        return run

    def spent(work):
        before, start = rows["now"], thread_time()
        result = work()
        inside = rows["now"] - before
        return result, Part(thread_time() - start - inside.rows, inside.rows, inside.products)

    def run_batches(work, parts, monitor, at_once):
        results, batches = zip(*(spent(partial(work, part, monitor)) for part in parts), strict=True)
        calls.append((batches, at_once))
        return list(results)

    with (
        patch.object(SharedRows, "__matmul__", shared),
        patch.object(semidefinite, "relax", timed("relaxation", semidefinite.relax)),
        patch.object(staircase, "prove", timed("proof", staircase.prove)),
        patch.object(solver, "prepare_search", timed("besides", solver.prepare_search)),
        patch.object(rounding, "share_out", run_batches),
        patch.object(rounding, "idle_workers", lambda: MOST_WORKERS),
    ):
        _, whole = spent(partial(solve, problem))
    seconds["relaxation"] -= seconds["proof"]
    seconds["batches"] = sum((batch for batches, _ in calls for batch in batches), Part())
    seconds["rest"] = whole - sum(seconds.values(), Part())
    total = whole.on(1)
    speeds = {count: total / _model(seconds, calls, count) for count in CORES}
    shares = {name: seconds[name].on(1) / total for name in SHARES}
    return {"total": total, "rows": whole.rows / total} | shares | speeds


class Part(NamedTuple):
    """Seconds of work on one core; of these, in products whose rows cores can share; the number of such products."""

    alone: float = 0.0
    rows: float = 0.0
    products: int = 0

    def __add__(self, other):
        return Part(*(mine + its for mine, its in zip(self, other, strict=True)))

    def __sub__(self, other):
        return Part(*(mine - its for mine, its in zip(self, other, strict=True)))

    def on(self, cores):
        """Seconds on several cores."""
        return self.alone + self.rows / cores + (SHARING * self.products if cores > 1 else 0.0)


def _model(seconds, calls, cores):
    """Seconds on several cores: preparations run beside the relaxation, its proof beside the rounding."""
    first = max(seconds["relaxation"].on(cores), seconds["besides"].on(1))
    proof, rest = seconds["proof"].on(1), seconds["rest"].on(cores)
    rounding_alone = rest + sum(_last_end(batches, cores, at_once) for batches, at_once in calls)
    together = (proof + seconds["rest"].on(1) + seconds["batches"].on(1)) / cores
    return first + max(proof, rounding_alone, together)


def _last_end(batches, cores, at_once):
    """Seconds of batches that are begun in order, each by the first core that is free; free cores share rows."""
    threads = min(cores, len(batches), at_once)
    ends = [0.0] * threads
    heapify(ends)
    for number, batch in enumerate(batches):
        heapreplace(ends, ends[0] + batch.on(max(cores // min(len(batches) - number, threads), 1)))
    return max(ends)


if __name__ == "__main__":
    main()
