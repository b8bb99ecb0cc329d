# SPDX-License-Identifier: GPL-3.0-or-later
"""Wall seconds of whole solves and quad meshes on several cores, and whether their bits are the same.

    python bench/walls.py MESH.obj [MESH.obj ...] [--problems "n = 4" ...] [--quads 3000] [--threads 1 2 4 8]

Prints a line of each number of threads as it comes: seconds, the least of some runs, and of the phases in that run.
Measure on a machine that nothing else uses. With ``--samples``, one more run on the most threads tells in which
functions the calling thread was, by samples.
"""

import argparse
import hashlib
import sys
from collections import Counter
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from threading import Event, Thread, get_ident
from time import perf_counter, process_time
from unittest.mock import patch

import numpy as np

from synch_fields.bench import problems
from synch_fields.bench.measure import with_matrices
from synch_fields.bench.meshes import read_obj
from synch_fields.core.algebra import workers
from synch_fields.core.geometry.mesh_input import MeshInput
from synch_fields.core.geometry.polygons import Polygons
from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.core.solve import Options, solve
from synch_fields.core.tasks import quad_meshes
from synch_fields.core.tasks.surface_source import SurfaceSource
from synch_fields.core.tasks.surfaces import SurfaceRequest

PHASES = ("relax", "certify", "round")
# Seconds between samples, and functions of the package that a sample names.
SAMPLE, NAMED, SHOWN = 2e-3, 3, 30


def main():
    """Print the lines."""
    options = _arguments()
    start = perf_counter()
    for path in options.meshes:
        mesh, stem = read_obj(path), Path(path).stem
        works = [(f"{stem} {name}", partial(run_solve, with_matrices(p))) for name, p in _problems(mesh, options)]
        if options.quads:
            works.append((f"{stem} quads", partial(run_quads, mesh, options.quads)))
        for label, work in works:
            if perf_counter() - start < options.limit:
                measure(label, work, options)
    print(f"{perf_counter() - start:.0f} s in all", flush=True)


def _problems(mesh, options):
    return problems.problems(mesh, options.problems) if options.problems else ()


def _arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("meshes", nargs="+", metavar="MESH.obj")
    parser.add_argument("--problems", nargs="*", choices=problems.NAMES, default=["n = 4", "stripes 40"])
    parser.add_argument("--quads", type=int, default=0, help="faces of a quad mesh (none)")
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2, 4, 8])
    parser.add_argument("--repeat", type=int, default=2, help="runs, of which the fastest counts (%(default)s)")
    parser.add_argument("--limit", type=float, default=np.inf, help="seconds after which nothing more is begun")
    parser.add_argument("--samples", action="store_true")
    return parser.parse_args()


def measure(label, work, options):
    """Print a line of each number of threads."""
    alone, bits = None, None
    for threads in options.threads:
        with patch.object(workers, "WORKERS", threads):
            runs = [_timed(work) for _ in range(options.repeat)]
        wall, cpu, phases, found = min(runs, key=lambda run: run[0])
        alone, bits = alone or wall, bits or found
        parts = "  ".join(f"{name} {seconds:.2f}" for name, seconds in phases.items())
        rest = wall - sum(phases.values())
        same = "same bits" if {run[-1] for run in runs} == {bits} else "OTHER BITS"
        print(
            f"{label:26} {threads:2} threads  {wall:6.2f} s  x {alone / wall:4.2f}  CPU {cpu:6.2f}  {parts}  "
            f"rest {rest:.2f}  {same}",
            flush=True,
        )
    if options.samples:
        with patch.object(workers, "WORKERS", max(options.threads)):
            _print_samples(work)


def _timed(work):
    wall, cpu = perf_counter(), process_time()
    phases, found = work()
    return perf_counter() - wall, process_time() - cpu, phases, found


def run_solve(problem):
    """Seconds of the phases of one solve, and a hash of its bits."""
    solution = solve(problem, Options())
    return {name: solution.times.get(name, 0.0) for name in PHASES}, _hash(solution.phases, solution.lower_bound)


def run_quads(mesh, faces):
    """Seconds of the phases of one quad mesh, and a hash of its bits."""
    given = MeshInput(mesh, Polygons.of_triangles(mesh), np.eye(3), mesh, np.arange(mesh.vertex_count))
    settings = SurfaceSettings(faces=faces).for_command("quad_mesh")
    request, phases = SurfaceRequest.of("quad_mesh", SurfaceSource(given), settings), Counter()

    def timed(name, work):
        def run(*arguments, **named):
            start = perf_counter()
            try:
                return work(*arguments, **named)
            finally:
                phases[name] += perf_counter() - start

        return run

    with ExitStack() as stack:
        for owner, name in (
            (SurfaceRequest, "directed"),
            (SurfaceRequest, "trace"),
            (SurfaceRequest, "finish"),
            (quad_meshes, "draw"),
        ):
            stack.enter_context(patch.object(owner, name, timed(name, getattr(owner, name))))
        quads = request.solve().quads
    return phases, _hash(quads.vertices, quads.corner_vertices)


def _hash(*arrays):
    return hashlib.sha256(b"".join(np.ascontiguousarray(array).tobytes() for array in arrays)).hexdigest()


def _print_samples(work):
    """Shares of the samples of the calling thread, by the innermost functions of the package."""
    counts, ended, caller = Counter(), Event(), get_ident()

    def sample():
        while not ended.wait(SAMPLE):
            frame, names = sys._current_frames()[caller], []
            while frame is not None and len(names) < NAMED:
                code = frame.f_code
                if "synch_fields" in code.co_filename and "<" not in code.co_name:
                    names.append(f"{Path(code.co_filename).stem}.{code.co_name}:{frame.f_lineno}")
                frame = frame.f_back
            counts[" < ".join(names)] += 1

    thread = Thread(target=sample)
    thread.start()
    work()
    ended.set()
    thread.join()
    for names, count in counts.most_common(SHOWN):
        print(f"    {count / counts.total():5.1%}  {names}", flush=True)


if __name__ == "__main__":
    main()
