# SPDX-License-Identifier: GPL-3.0-or-later
"""How soon there is something to see, and how fast a pattern follows its settings.

    python bench/live.py MESH.obj[=PARTS] [MESH.obj ...] [--repeat 3] [--steps 20] [--wall]

PARTS divides every edge of a mesh. Seconds are of the processor, or with --wall those that pass: then nothing else may
run. SYNCH_THREADS says how many cores a solve uses.

First: "first s" and "/ eigsh", seconds of a first field and over those of eigsh on the same matrix (as in
bench/solver.py), medians; "whole", those of the default solve over those of eigsh; "energy", that of the first field
over that of the default solve; "bound", when it is there, in times of the first field, which are what the progress bar
tells; "showing", seconds of the default solve that shows fields over those of one that does not.

Live: stripes, forty along the longest side, whose spacing grows by 1 % a step: milliseconds of a step and steps a
second; "change", of cos theta in a step, the mean and the largest mean; "defects", how many more or fewer there are
after a step at most, and in all; "energy", after the last step over that of a full solve from there; then, after a
rest, the pattern that fades in: its seconds, "anew s", and its energy over that of a full solve, "anew"; and the whole
solve that starts from it and takes its place: "near s" and "near".
"""

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from statistics import mean, median
from time import perf_counter, process_time

import numpy as np

from synch_fields.bench import peers, problems
from synch_fields.bench.measure import with_matrices
from synch_fields.bench.meshes import read_obj
from synch_fields.bench.subdivide import subdivided
from synch_fields.bench.tables import Column, print_table
from synch_fields.core.algebra.workers import solving
from synch_fields.core.geometry.mesh_input import MeshInput
from synch_fields.core.geometry.polygons import Polygons
from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.core.solution import FIRST
from synch_fields.core.solve import Options, solve
from synch_fields.core.solve.warm_start import Follower
from synch_fields.core.tasks.live import ANEW, NEAR, LiveRequest
from synch_fields.core.tasks.surface_source import SurfaceSource
from synch_fields.core.tasks.surfaces import SurfaceRequest

NAMES = ("n = 1", "n = 4", "stripes 40")
COLUMNS = (
    Column("nodes", "nodes", "d"),
    Column("eigsh s", "eigsh", ".3f"),
    Column("first s", "first", ".3f"),
    Column("/ eigsh", "ratio", ".2f"),
    Column("whole", "whole", ".2f"),
    Column("energy", "energy", ".3f"),
    Column("bound", "bound", ".1f"),
    Column("showing", "showing", ".2f"),
)
LIVE = (
    Column("vertices", "vertices", "d"),
    Column("ms a step", "ms", ".0f"),
    Column("steps a second", "rate", ".1f"),
    Column("change", "change", ".3f"),
    Column("largest", "largest", ".3f"),
    Column("defects a step", "defects", "d"),
    Column("in all", "all", "d"),
    Column("energy", "energy", ".3f"),
    Column("anew s", "anew_seconds", ".2f"),
    Column("anew", "anew", ".3f"),
    Column("near s", "near_seconds", ".2f"),
    Column("near", "near", ".3f"),
)


def main():
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meshes", nargs="+")
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--steps", type=int, default=20)
    parser.add_argument("--wall", action="store_true")
    options = parser.parse_args()
    clock = perf_counter if options.wall else process_time
    firsts, lives = [], []
    for argument in options.meshes:
        path, _, parts = argument.partition("=")
        mesh, stem = read_obj(path), Path(path).stem
        if parts:
            mesh, stem = subdivided(mesh, int(parts)), f"{stem} {parts}"
        for name, problem in problems.problems(mesh, NAMES):
            print(f"{stem} {name}", file=sys.stderr, flush=True)
            firsts.append({"label": f"{stem} {name}"} | first_row(problem, options.repeat, clock))
        print(f"{stem} live", file=sys.stderr, flush=True)
        lives.append({"label": stem} | live_row(mesh, options.steps, clock))
    print_table("First fields", COLUMNS, firsts)
    print_table("Live spacing", LIVE, lives)


def timed(clock, work, *arguments, **named):
    """Result and seconds of a clock."""
    start = clock()
    result = work(*arguments, **named)
    return result, clock() - start


def first_row(problem, repeat, clock):
    """One problem's figures."""
    piece = max(with_matrices(problem).pieces, key=lambda piece: piece.node_count)
    rows = []
    for _ in range(repeat):
        with solving():
            _, eigsh = timed(clock, peers.plain_spectral, piece)
        found, first = timed(clock, solve, problem, Options(method=FIRST))
        whole, alone = timed(clock, solve, problem)
        times, start = [], clock()
        _, showing = timed(
            clock, solve, problem, show=lambda _, start=start, times=times: times.append(clock() - start)
        )
        rows.append((eigsh, first, first / eigsh, alone / eigsh, (times[1] - times[0]) / first, showing / alone))
    names = "eigsh", "first", "ratio", "whole", "bound", "showing"
    figures = dict(zip(names, map(median, zip(*rows, strict=True)), strict=True))
    return {"nodes": piece.node_count, "energy": found.energy / whole.energy} | figures


def live_row(mesh, steps, clock):
    """Figures of stripes on a mesh whose spacing grows."""
    size = np.ptp(mesh.vertices[np.unique(mesh.triangles)], axis=0).max()
    given = MeshInput(mesh, Polygons.of_triangles(mesh), np.eye(3), mesh, np.arange(mesh.vertex_count))
    spacing = size / problems.STRIPES["stripes 40"]
    asked = SurfaceRequest.of("stripes", SurfaceSource(given), SurfaceSettings(spacing=spacing).for_command("stripes"))
    shown, followers = asked.solve(), (Follower(), Follower())
    seconds, changes, counts = [], [], [len(shown.pattern.dislocations)]
    for _ in range(steps):
        spacing *= 1.01
        asked = replace(asked, spacing=spacing, spacings=spacing)
        slim = shown.field.without_solution
        found, spent = timed(clock, LiveRequest(asked, slim, shown.pattern.phases, True, followers).solve)
        seconds.append(spent)
        changes.append(np.abs(found.pattern.phases.real - shown.pattern.phases.real).mean())
        counts.append(len(found.pattern.dislocations))
        shown = found
    whole, shown_last, settled = asked.along(found.field).pattern.energy, found.pattern.energy, {}
    for settles in (ANEW, NEAR):
        slim = found.field.without_solution
        request = LiveRequest(asked, slim, found.pattern.phases, True, followers, settles)
        found, settled[f"{settles}_seconds"] = timed(clock, request.solve)
        settled[settles] = found.pattern.energy / whole
    return {
        "vertices": mesh.vertex_count,
        "ms": 1000 * median(seconds),
        "rate": 1 / median(seconds),
        "change": mean(changes),
        "largest": max(changes),
        "defects": int(np.abs(np.diff(counts)).max()),
        "all": abs(counts[-1] - counts[0]),
        "energy": shown_last / whole,
        **settled,
    }


if __name__ == "__main__":
    main()
