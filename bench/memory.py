# SPDX-License-Identifier: GPL-3.0-or-later
"""Memory that solves take, beside what is estimated before (core/solve/methods/memory_estimate.py).

    python bench/memory.py [PROBLEM ...]

Every size is solved in a process of its own, which begins with the matrices' problem. "MB taken" and "MB address space"
are the most that it has beyond what it had then, looked at a hundred times a second.
"""

import threading
import time
from pathlib import Path

import numpy as np

from synch_fields.bench import problems
from synch_fields.bench.command import arguments
from synch_fields.bench.grids import trefoil_problem
from synch_fields.bench.measure import row_of_child, timed
from synch_fields.bench.subdivide import sphere
from synch_fields.bench.tables import Column, print_table
from synch_fields.core.algebra.workers import solving
from synch_fields.core.fields import direction_field
from synch_fields.core.fields.layers import SolidTargetOneForm, pose_layers
from synch_fields.core.fields.patterns import PatternWishes, pattern_problem
from synch_fields.core.geometry.filling.stuffing import fill_surface
from synch_fields.core.solve import Options, solve
from synch_fields.core.solve.methods.certificate import plan_proof
from synch_fields.core.solve.methods.memory_estimate import search_bytes

SIZES = {
    "stripes 40": (10, 32, 63, 100),
    "n = 4": (32, 100),
    "quads": (20, 40, 63),
    "layers": (8, 12, 18, 26),
    "flow": (16, 24, 32, 48),
}
COLUMNS = (
    Column("nodes", "nodes", "d"),
    Column("rows", "rows", "d"),
    Column("entries", "entries", "d"),
    Column("certificate", "certificate", ""),
    Column("rank", "rank", "d"),
    Column("s", "seconds", ".1f"),
    Column("MB taken", "taken", ".0f"),
    Column("MB address space", "space", ".0f"),
    Column("MB search", "search", ".0f"),
    Column("MB proof", "proof", ".0f"),
)


def main():
    """Print the table."""
    parser = arguments(__doc__)
    parser.add_argument("names", nargs="*", default=SIZES, metavar="PROBLEM", help=", ".join(SIZES))
    names = parser.parse_args().names
    rows = [row_of_child(f"{name}, {size}", measure, name, size) for name in names for size in SIZES[name]]
    print_table("memory of solves", COLUMNS, rows)


def measure(name, size):
    """A row of the table; runs in a process of its own."""
    problem = _problem(name, size)
    with _Watch() as watch:
        solution, seconds = timed(solve, problem, Options())
    piece = max(problem.pieces, key=lambda piece: piece.node_count)
    plan, (rows, entries) = plan_proof(piece), (piece.matrix.shape[0], piece.matrix.nnz)
    return {
        "nodes": piece.node_count,
        "rows": rows,
        "entries": entries,
        "certificate": solution.certificate,
        "rank": solution.rank,
        "seconds": seconds,
        "taken": watch.taken[1],
        "space": watch.taken[0],
        "search": search_bytes(rows, entries, piece.is_complex) / 2**20,
        "proof": None if plan is None else plan.bytes / 2**20,
    }


def _problem(name, size):
    with solving():
        if name == "flow":
            return trefoil_problem((size, size, size // 2))
        if name == "layers":
            ball = fill_surface(
                lambda places: np.linalg.norm(places, axis=1) - 1, np.array([[-1.3] * 3, [1.3] * 3]), 1 / size
            )
            one_form = SolidTargetOneForm.of(ball, np.tile([0.0, 0, 1], (ball.vertex_count, 1)), 0.2)
            return pose_layers(one_form, (), 1.0)[1]
        mesh = sphere(size)
        if name == "quads":
            return pattern_problem(mesh, direction_field(mesh, 4), PatternWishes(0.05))
        return problems.make_problem(mesh, name)


class _Watch:
    """The most address space and memory that this process has beyond what it had, in MB."""

    def __enter__(self):
        self._before, self.taken, self._ended = _sizes(), np.zeros(2), threading.Event()
        self._thread = threading.Thread(target=self._look)
        self._thread.start()
        return self

    def __exit__(self, *_error):
        self._ended.set()
        self._thread.join()

    def _look(self):
        while not self._ended.is_set():
            self.taken = np.maximum(self.taken, _sizes() - self._before)
            time.sleep(0.01)


def _sizes():
    pages = Path("/proc/self/statm").read_text().split()[:2]
    return np.array(pages, float) * 4096 / 2**20


if __name__ == "__main__":
    main()
