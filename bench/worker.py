# SPDX-License-Identifier: GPL-3.0-or-later
"""What it costs to solve in a process of its own: starting it, handing a job over, and the whole solve beside one here.

    python bench/worker.py [--vertices 2562,10242,40962,163842] [--repeat 3]

"cold ms": from starting the process until it has loaded all that it needs; it may be told meanwhile. "warm ms": from
asking a process that waits until it has begun to solve, less what loading is; "MB there", "MB back": bytes of request
and result; "own s", "here s": the whole solve of stripes on an icosphere, asked and read back, and in this process;
"/ here" their ratio within a run, by turns. "first s": until the first picture is read, of those that a child shows
and a script does not make; they are part of "own s".
"""

import argparse
import time
from statistics import median

import bpy

import synch_fields
from synch_fields.bench.tables import Column, print_table
from synch_fields.core.process.ipc import pack_parts
from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.synch_addon.jobs.worker import Worker
from synch_fields.synch_addon.patterns.job import FieldJob

_TICK = 0.01
COLUMNS = (
    Column("vertices", "nodes", "d"),
    Column("MB there", "there", ".1f"),
    Column("warm ms", "warm ms", ".0f"),
    Column("MB back", "back", ".1f"),
    Column("first s", "first s", ".2f"),
    Column("own s", "own s", ".2f"),
    Column("here s", "here s", ".2f"),
    Column("/ here", "ratio", ".3f"),
)


def main():
    """Print how long a process takes to start, and a row for each size."""
    parser = argparse.ArgumentParser(description="What it costs to solve in a process of its own.")
    parser.add_argument("--vertices", default="2562,10242,40962,163842", metavar="N,N...")
    parser.add_argument("--repeat", type=int, default=3, metavar="N")
    options = parser.parse_args()
    synch_fields.register()
    try:
        cold = [_cold() for _ in range(options.repeat)]
        print(f"cold ms: {1000 * median(cold):.0f} (of {len(cold)}, at most {1000 * max(cold):.0f})")
        rows = [_row(int(count), options.repeat) for count in options.vertices.split(",")]
        print_table("stripes on icospheres", COLUMNS, rows)
    finally:
        synch_fields.unregister()


def _cold():
    start = time.perf_counter()
    worker = _ready()
    seconds = time.perf_counter() - start
    worker.end()
    return seconds


def _ready():
    worker = Worker(2**40)
    while not worker.is_ready:
        worker.exchange()
        time.sleep(0.002)
    return worker


def _row(vertices, repeat):
    request = _request(vertices)
    worker = _ready()
    own, here, warm, first, back = [], [], [], [], 0
    _asked(worker, request)  # loads what only a solve loads
    for _ in range(repeat):
        seconds, begun, early, result = _asked(worker, request)
        own.append(seconds)
        first.append(early)
        warm.append(begun)
        back = _size(pack_parts(("done", result, 0.0), request.shared))
        fresh = _request(vertices)  # nothing computed of its mesh yet, as in the other process
        start = time.perf_counter()
        fresh.solve(lambda *_: True)
        here.append(time.perf_counter() - start)
    worker.end()
    ratios = [one / other for one, other in zip(own, here, strict=True)]
    there = _size(pack_parts(("solve", request)))
    figures = {"there": there, "back": back, "warm ms": 1000 * median(warm), "own s": median(own)}
    figures["first s"] = median(first)
    return {"label": f"{vertices}", "nodes": vertices, **figures, "here s": median(here), "ratio": median(ratios)}


def _asked(worker, request):
    """Seconds until the result is read, the solve has begun and a first picture is there; and the result."""
    start = time.perf_counter()
    worker.ask(request)
    begun, early = None, 0.0
    while True:
        for message in worker.exchange():
            begun = begun or time.perf_counter() - start
            if message[0] == "shown":
                early = early or time.perf_counter() - start
            if message[0] == "done":
                return time.perf_counter() - start, begun, early, message[1]
        time.sleep(_TICK if begun else 0.001)


def _request(vertices):
    bpy.ops.wm.read_homefile(use_empty=True)
    subdivisions = round((len(bin((vertices - 2) // 10)) - 3) / 2) + 1
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=subdivisions)
    return FieldJob("stripes", bpy.context.object, SurfaceSettings(spacing=0.1)).request


def _size(parts):
    return sum(memoryview(part).nbytes for part in parts) / 1e6


if __name__ == "__main__":
    main()
