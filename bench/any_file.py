# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Stripes and quad meshes of any files: what becomes of each, and what is wrong with it.

    python bench/any_file.py FOLDER [--faces 1500] [--limit 600] [--rows FILE]

One row a file that Blender's importers read, in a process of its own, of its object with the most faces. "given": its
vertices; "joined" and "vertices": those that were joined, and those of the surface that the quad mesh was solved on.
"zero": edges without length; "lost": length of boundaries and sharp edges that no edges follow, in their own share;
"away": Hausdorff distance in edges. "stripes": dislocations, and "s" the CPU seconds of both. Needs Blender as a module
(bpy).
"""

import re
import sys
from collections import Counter
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from statistics import median

from synch_fields.bench.command import arguments
from synch_fields.bench.measure import in_child
from synch_fields.bench.rows import KeptRows
from synch_fields.bench.tables import Column, print_table

SUFFIXES = (".stl", ".obj", ".ply", ".glb", ".blend")
# What mean angles and seconds should be, in the median and at worst.
ANGLES, SECONDS = (6, 12), 10

COLUMNS = (
    Column("given", "given", "d"),
    Column("joined", "joined", "d"),
    Column("vertices", "vertices", "d"),
    Column("faces", "faces", "d"),
    Column("irregular", "irregular_vertices", "d"),
    Column("mean angle off", "angle_deviation", ".1f"),
    Column("folds", "folds", "d"),
    Column("zero", "zero", "d"),
    Column("lost", "lost", ".0%"),
    Column("away", "away", ".2f"),
    Column("closed", "closed_too", ""),
    Column("warnings", "warnings", "d"),
    Column("s", "quad_seconds", ".1f"),
    Column("stripes", "dislocations", "d"),
    Column("warnings ", "stripe_warnings", "d"),
    Column("s ", "stripe_seconds", ".1f"),
    Column("MB", "megabytes", ".0f"),
    Column("fails", "fails", ""),
)


def main():
    """Make the rows that are missing, and print the table and the summary."""
    parser = arguments(__doc__, "the files")
    parser.add_argument("--faces", type=int, default=1500, help="of each quad mesh (%(default)s)")
    parser.add_argument("--limit", type=int, default=600, help="CPU seconds for a file (%(default)s)")
    parser.add_argument("--rows", type=Path, help="file of JSON lines for the rows, which are read from it first")
    options = parser.parse_args()
    rows = KeptRows(options.rows, "label")
    for path in sorted(options.meshes.iterdir(), key=lambda path: path.stat().st_size):
        if path.suffix.lower() in SUFFIXES and (path.name,) not in rows:
            print(path.name, file=sys.stderr, flush=True)
            rows.keep({"label": path.name, **_row(path, options)})
    print_table(f"Quad meshes of {options.faces} faces, and stripes", COLUMNS, rows.values(), "file")
    _print_summary(list(rows.values()))


def _row(path, options):
    try:
        return in_child(made_row, path, options.faces, options.limit)
    except BrokenProcessPool:
        return {"crash": f"ended, or not done in {options.limit} CPU seconds"}
    except Exception as error:  # whatever it is, it is what the bench looks for
        return {"crash": f"{type(error).__name__}: {error}"}


def made_row(*arguments):
    """What :func:`any_file_rows.file_row` gives, in a process that imports Blender before anything else of it."""
    from synch_fields.bench import any_file_rows

    return any_file_rows.file_row(*arguments)


def _print_summary(rows):
    made = [row for row in rows if "faces" in row]
    print(f"\n{len(rows)} files, {sum('crash' in row for row in rows)} crashes, {len(made)} quad meshes")
    for name, limits in (("angle_deviation", ANGLES), ("quad_seconds", (SECONDS,)), ("stripe_seconds", (SECONDS,))):
        values = [row[name] for row in rows if name in row]
        if values:
            print(f"{name}: {median(values):.1f} in the median, {max(values):.1f} at worst; wanted: {limits}")
    print(f"edges without length: {sum(row['zero'] for row in made)}")
    print(f"closed and opened: {sum(row['closed_too'] == 'no' for row in made)}")
    for line, count in Counter(re.sub(r"[\d.]+", "N", row["fails"]) for row in rows if "fails" in row).items():
        print(f"refused {count}: {line}")
    for row in rows:
        if "crash" in row:
            print(f"{row['label']}: {row['crash']}")


if __name__ == "__main__":
    main()
