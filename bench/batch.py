# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a batch costs: tiny rows by one process, and the rows of real meshes by one process and by a Dask cluster.

    python bench/batch.py tiny [--count 10000]
    python bench/batch.py meshes FOLDER [--workers 2]

The first prints the time a row and the memory of all processes as the batch goes on, beside the time of the same
command in a loop without a batch. The second prints both times, their ratio, and whether all figures and files are the
same. Needs Blender as a module (bpy).
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from itertools import product
from pathlib import Path

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
for _ in range(count):
    main(["info", path])
print((time.perf_counter() - start) / count, file=sys.stderr)
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
    path = folder / "tetrahedron.obj"
    path.write_text(TETRAHEDRON)
    loop = [sys.executable, "-c", LOOP, path, str(min(count, 500))]
    alone = subprocess.run(loop, check=True, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
    alone = float(alone.stderr.split()[-1])
    write_rows(
        folder / "rows.jsonl",
        [{"command": "info", "input": str(path), "report": f"reports/{n:05}.json"} for n in range(count)],
    )
    start = time.perf_counter()
    batch = subprocess.Popen(command("--jobs", 1, "--quiet"), cwd=folder)
    seen = []
    while batch.poll() is None:
        time.sleep(5)
        done = sum(1 for _ in (folder / "reports").glob("*.json"))
        seen.append((done, memory_of(batch.pid)))
        print(f"{done:6} rows, {seen[-1][1]:.0f} MB", flush=True)
    each = (time.perf_counter() - start) / count
    again = time.perf_counter()
    subprocess.run(command("--jobs", 1, "--quiet"), cwd=folder, check=True)
    again = time.perf_counter() - again
    print(f"{count} rows: {each * 1000:.1f} ms each, {alone * 1000:.1f} ms each in a loop without a batch")
    print(f"overhead {(each - alone) * 1000:.1f} ms a row, start and summary included; again, all done: {again:.1f} s")


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
        if kind == "serial":
            times.append(timed(command("--jobs", 1, "--quiet"), here))
        else:
            with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster:
                times.append(timed(command("--scheduler", cluster.scheduler_address, "--quiet"), here))
        found.append(results(here))
    print(
        f"{len(rows)} rows: {times[0]:.1f} s by one process, {times[1]:.1f} s by {workers}: ratio {times[1] / times[0]:.3f}"
    )
    print("all figures and files are the same" if found[0] == found[1] else "THEY DIFFER")


def command(*flags):
    return [sys.executable, "-m", "synch_fields", "batch", "rows.jsonl", "--folder", "batch", *map(str, flags)]


def timed(line, folder):
    start = time.perf_counter()
    subprocess.run(line, cwd=folder, check=True)
    return time.perf_counter() - start


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
