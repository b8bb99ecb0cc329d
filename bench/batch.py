# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a batch costs: tiny rows by one process, and the rows of real meshes by one process and by a Dask cluster.

    python bench/batch.py tiny [--count 10000]
    python bench/batch.py meshes FOLDER [--workers 2]

The first prints times a row and the memory of all processes as the batch goes on, beside the time of the same
command in a loop without a batch. The second prints both times, their ratios, and whether all figures and files are
the same. Needs Blender as a module (bpy).
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from itertools import product
from pathlib import Path

import numpy as np

TETRAHEDRON = "v 1 1 1\nv -1 -1 1\nv -1 1 -1\nv 1 -1 -1\nf 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n"
# Meshes of the folder that one process does in some seconds, and what is done with each.
MESHES = "spot", "fandisk", "inspired_mesh", "teapot", "cheburashka"
KINDS = [("directions", {"symmetry": "line"}), ("directions", {"symmetry": "cross"})]
KINDS += [("stripes", {"guidance": "smooth"}), ("stripes", {"guidance": "curvature-min"})]
SEEDS = 0, 1
LOOP = """
import sys, time
import bpy, synch_fields
from synch_fields.synch_addon.command.main import main
synch_fields.register()
path, count = sys.argv[1], int(sys.argv[2])
main(["info", path])
start = time.perf_counter()
spent = time.process_time()
for _ in range(count):
    main(["info", path, "--report", "loop.json"])
print((time.perf_counter() - start) / count, (time.process_time() - spent) / count, file=sys.stderr)
"""


def main():
    parser = argparse.ArgumentParser(description="Measure what a batch costs.")
    parser.add_argument("what", choices=("tiny", "meshes"))
    parser.add_argument("meshes", nargs="?", type=Path, help="folder of meshes")
    parser.add_argument("--count", type=int, default=10000, help="tiny rows")
    parser.add_argument("--workers", type=int, default=2, help="of the cluster")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        if options.what == "tiny":
            tiny(Path(folder), options.count)
        else:
            compare(Path(folder), options.meshes.resolve(), options.workers)


def tiny(folder, count):
    """Print times a row, those of the processor too, which a busy machine does not change much."""
    path = folder / "tetrahedron.obj"
    path.write_text(TETRAHEDRON)
    loop = [sys.executable, "-c", LOOP, path, str(min(count, 500))]
    alone = subprocess.run(loop, check=True, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True, cwd=folder)
    alone = np.array(alone.stderr.split()[-2:], float)
    row = {"command": "info", "input": str(path)}
    write_rows(folder / "rows.jsonl", [row | {"report": f"reports/{number:05}.json"} for number in range(count)])
    start = times_now()
    batch = subprocess.Popen(command("--jobs", 1, "--quiet"), cwd=folder)
    while batch.poll() is None:
        done = sum(1 for _ in folder.glob("reports/*.json"))
        print(f"{done:6} rows, {memory_of(batch.pid):.0f} MB", flush=True)
        time.sleep(5)
    each = (times_now() - start) / count
    start = times_now()
    subprocess.run(command("--jobs", 1, "--quiet"), cwd=folder, check=True)
    again = times_now() - start
    for kind, place in (("time", 0), ("processor time", 1)):
        both = f"{each[place] * 1000:.1f} ms a row, in a loop without a batch {alone[place] * 1000:.1f} ms"
        print(f"{kind}: {both}; overhead {(each - alone)[place] * 1000:.1f} ms; once more: {again[place]:.1f} s")


def times_now():
    """Seconds on the clock, and of processors in processes that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return np.array([time.perf_counter(), used.ru_utime + used.ru_stime])


def memory_of(pid):
    """MB of a process and its children."""
    total = 0
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = status.read_text().rpartition(")")[2].split()
            if pid in (int(status.parent.name), int(fields[1])):
                total += int(fields[21]) * os.sysconf("SC_PAGE_SIZE")
        except (OSError, IndexError):
            pass
    return total / 2**20


def compare(folder, meshes, workers):
    from distributed import LocalCluster

    rows = []
    for number, ((name, settings), seed, mesh) in enumerate(product(KINDS, SEEDS, MESHES)):
        row = {"command": name, "input": str(meshes / f"{mesh}.obj"), "seed": seed, "report": f"out/{number}.json"}
        rows.append(row | settings | ({"export_field": f"out/{number}.rawfield"} if name == "directions" else {}))
    times, found = [], []
    for kind in ("serial", "dask"):
        here = folder / kind
        here.mkdir()
        write_rows(here / "rows.jsonl", rows)
        start = times_now()
        if kind == "serial":
            subprocess.run(command("--jobs", 1, "--quiet"), cwd=here, check=True)
            times.append(times_now() - start)
        else:
            with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster:
                start = times_now()
                subprocess.run(command("--scheduler", cluster.scheduler_address, "--quiet"), cwd=here, check=True)
                clock = times_now()
            times.append(np.array([clock[0] - start[0], times_now()[1] - start[1]]))
        found.append(results(here))
    for what, serial, cluster in zip(("time", "processor time"), *times, strict=True):
        print(f"{what}: {serial:.1f} s by one process, {cluster:.1f} s by {workers} workers: {cluster / serial:.3f}")
    print("all figures and files are the same" if found[0] == found[1] else "THEY DIFFER")


def command(*flags):
    return [sys.executable, "-m", "synch_fields", "batch", "rows.jsonl", "--folder", "batch", *map(str, flags)]


def results(folder):
    """All figures of the summary but times and memory, and all field files."""
    rows = json.loads((folder / "batch" / "summary.json").read_text())
    for row in rows:
        del row["seconds"], row["memory_mb"], row["files"], row["key"]
    return rows, {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*.rawfield")}


def write_rows(path, rows):
    path.write_text("".join(json.dumps(row) + "\n" for row in rows))


if __name__ == "__main__":
    main()
