# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's Figures 1 to 9 again: pictures, and the tables of their pages.

    python docs/make/paper.py MESHES [--folder docs/paper] [--only 5 9] [--again] [--kept out/paper]

MESHES holds stanford-bunny.obj and the others of the public collections. What is measured is kept in files of JSON
lines: a figure whose picture and rows are there is not made again, and Figure 9 goes on with the surface at which it
was stopped. --again makes figures anew. The tables are written into the pages, between the marks that name them. Needs
Blender as a module (bpy).
"""

import re
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import synch_fields
from synch_fields.bench import clebsch, solids
from synch_fields.bench import vector_fields as many
from synch_fields.bench.command import arguments
from synch_fields.bench.rows import KeptRows
from synch_fields.bench.tables import table_lines
from synch_fields.docs.make import dislocations, figures, layers, quads, vector_fields, vortices


@dataclass(frozen=True)
class Figure:
    """How a figure is made.

    Attributes
    ----------
    make : function of a :class:`Place` that renders the picture and returns the rows of each table by its name
    tables : columns of each table, and what stands over its labels, by its name
    """

    make: object
    tables: dict


@dataclass(frozen=True)
class Place:
    """Folder of the meshes, one for files that nobody needs later, the picture, and the file of rows."""

    meshes: Path
    folder: Path
    picture: Path
    rows: Path


FIGURES = {
    1: Figure(layers.figure1, {"solids": (solids.COLUMNS, "solid")}),
    2: Figure(dislocations.figure2, {"dislocations": (dislocations.COLUMNS, "pattern")}),
    3: Figure(layers.figure3, {"solids": (solids.COLUMNS, "solid")}),
    4: Figure(quads.figure4, {"energies": (figures.COLUMNS, "mesh")}),
    5: Figure(
        vortices.figure5,
        {"energies": (clebsch.ENERGIES, "the knot as"), "finer": (clebsch.COUNTS, "the knot as")},
    ),
    6: Figure(figures.figure6, {"energies": (figures.COLUMNS, "problem")}),
    7: Figure(vortices.figure7, {"maps": (vortices.MAPS, "map")}),
    8: Figure(figures.figure8, {"energies": (figures.COLUMNS, "problem")}),
    9: Figure(
        vector_fields.figure9,
        {
            "claims": (many.CLAIMS, ""),
            "correlations": (many.CORRELATIONS, "correlation of seconds with"),
            "surfaces": (many.COLUMNS, "surface"),
        },
    ),
}


def main():
    """Make the figures that are asked for and not there."""
    parser = arguments(__doc__, "the meshes")
    parser.add_argument("--folder", type=Path, default=Path("docs/paper"), help="of pages and pictures (%(default)s)")
    parser.add_argument("--kept", type=Path, default=Path("out/paper"), help="folder of the rows (%(default)s)")
    parser.add_argument("--only", nargs="+", type=int, choices=FIGURES, default=tuple(FIGURES), help="their numbers")
    parser.add_argument("--again", action="store_true", help="make them anew")
    options = parser.parse_args()
    synch_fields.register()
    try:
        for number in options.only:
            write_page(number, options)
    finally:
        synch_fields.unregister()


def write_page(number, options):
    """Make a figure where its picture or its rows are missing, and write its tables into its page."""
    figure, page = FIGURES[number], options.folder / f"figure{number}.md"
    picture, path = page.with_suffix(".png"), options.kept / f"figure{number}.jsonl"
    if options.again or not (picture.exists() and path.exists()):
        print(f"Figure {number}", file=sys.stderr, flush=True)
        path.unlink(missing_ok=True)
        with tempfile.TemporaryDirectory() as folder:
            made = figure.make(Place(options.meshes, Path(folder), picture, path))
        kept = KeptRows(path, "table", "label")
        for table, (columns, _) in figure.tables.items():
            for row in made[table]:
                told = {column.key: row.get(column.key) for column in columns}
                kept.keep({"table": table, "label": row["label"]} | told)
    kept, text = KeptRows(path, "table", "label"), page.read_text(encoding="utf-8")
    for table, (columns, first) in figure.tables.items():
        rows = [row for row in kept.values() if row["table"] == table]
        text = filled(text, table, table_lines(columns, rows, first))
    page.write_text(text, encoding="utf-8")


def filled(text, name, lines):
    """A page's text with other lines between the marks of a table.

    Raises
    ------
    SystemExit
        where there are none
    """
    marks = f"<!-- table {name} -->", "<!-- end -->"
    pattern = re.compile(f"{marks[0]}\n.*?{marks[1]}", re.DOTALL)
    if not pattern.search(text):
        raise SystemExit(f"the page has no place for the table {name!r}: write {marks[0]} and below it {marks[1]}")
    whole = "\n".join([marks[0], *lines, marks[1]])
    return pattern.sub(lambda _: whole, text)


if __name__ == "__main__":
    main()
