# SPDX-License-Identifier: GPL-3.0-or-later
"""Our quad meshes beside Blender's QuadriFlow and any other program, at the same number of faces.

    python bench/quads.py MESHES [--only NAME ...] [--rows FILE] [--again METHOD ...] [--set NAME=VALUE ...]
        [--peer NAME=COMMAND] [--keep FOLDER]

On each MESHES/*.obj that is not refused and on the surfaces of surface_shapes.py, at a period of the longest side over
25, but at least four median edges. The others are asked for as many faces as ours has, and again with a corrected
number where they miss it. The same functions measure all; below the table stands on how many meshes ours is no worse.
With --rows the rows go to a file of JSON lines as they come, and those in it are not made again. Needs Blender as a
module (bpy).
"""

import json
import sys
import tempfile
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from time import perf_counter

from synch_fields.bench.command import arguments
from synch_fields.bench.measure import in_child
from synch_fields.bench.meshes import write_obj
from synch_fields.bench.rows import KeptRows
from synch_fields.bench.surface_shapes import SHAPES
from synch_fields.bench.tables import Column, print_table

OURS = "ours"
# Options of its operator. The second keeps sharp edges and boundaries.
QUADRIFLOW = {"QuadriFlow": (), "QuadriFlow sharp": (("use_preserve_sharp", True), ("use_preserve_boundary", True))}
# Field files beside the meshes, which ours follows in a row of its own.
FIELD_FILES = {"cheburashka": "cheburashka-cf.rawfield"}
# Face counts are met when they are off by at most this share.
MET = 0.05

COLUMNS = (
    Column("asked", "asked", "d"),
    Column("faces", "faces", "d"),
    Column("quads", "quad_share", ".1%"),
    Column("irregular", "irregular_vertices", "d"),
    Column("on the boundary", "irregular_on_rim", "d"),
    Column("mean angle off", "angle_deviation", ".2f"),
    Column("worst", "worst_angle", ".0f"),
    Column("over 180°", "reflex_corners", "d"),
    Column("turned over", "turned_faces", "d"),
    Column("edge spread", "length_spread", ".3f"),
    Column("Hausdorff / side", "distance", ".2%"),
    Column("χ", "euler_characteristic", "d"),
    Column("χ given", "given_characteristic", "d"),
    Column("closed", "closed", ""),
    Column("manifold", "manifold", ""),
    Column("in short loops", "short_loop_share", ".0%"),
    Column("CPU s", "seconds", ".2f"),
)
# Ours is no worse in a column when its value is no larger.
COMPARED = {
    "share of other faces": "other_share",
    "irregular vertices": "all_irregular",
    "mean angle off": "angle_deviation",
    "worst corner": "worst_angle",
    "corners over 180°": "reflex_corners",
    "faces turned over": "turned_faces",
    "Hausdorff distance": "distance",
    "edge spread": "length_spread",
    "CPU seconds": "seconds",
}


def main():
    """Make the rows that are missing, and print the table and the summary."""
    parser = arguments(__doc__, "the meshes")
    parser.add_argument("--only", nargs="+", default=(), help="names of meshes, all by default")
    parser.add_argument("--rows", type=Path, help="file of JSON lines for the rows, which are read from it first")
    parser.add_argument("--again", nargs="+", default=(), help="methods whose rows are made anew")
    parser.add_argument("--methods", nargs="+", default=[OURS, *QUADRIFLOW], help="%(default)s")
    parser.add_argument("--set", nargs="+", default=[], help="settings of ours; {faces}: what the spacing asks for")
    parser.add_argument("--peer", action="append", default=[], help="a name and a command: {input} {output} {faces}")
    parser.add_argument("--keep", type=Path, help="folder for the quad meshes as .obj files")
    parser.add_argument("--limit", type=int, default=900, help="seconds for a mesh (%(default)s)")
    options = parser.parse_args()
    if options.keep:
        options.keep.mkdir(parents=True, exist_ok=True)
    table = Table(options)
    with tempfile.TemporaryDirectory() as folder:
        for name, path, field in subjects(options, Path(folder)):
            table.add(name, path, field)
    rows = table.rows()
    print_table("Quad meshes", COLUMNS, [labelled(row) for row in rows if "faces" in row])
    print()
    for row in rows:
        if "fails" in row:
            print(f"{row['mesh']}: {row['method']} fails: {row['fails']}")
    print_comparison(rows)


def subjects(options, folder):
    """Name, path and field file of each mesh; those that code makes are written to a folder first."""
    for path in sorted(options.meshes.glob("*.obj")):
        if not options.only or path.stem in options.only:
            yield path.stem, path, None
            if path.stem in FIELD_FILES:
                yield f"{path.stem}, field file", path, options.meshes / FIELD_FILES[path.stem]
    for shape in SHAPES:
        if not options.only or shape.name in options.only:
            path = folder / f"{shape.name}.obj"
            write_obj(shape.make(), path)
            yield shape.name, path, None


class Table:
    """Rows by mesh and method, in the order of the meshes, kept in a file where one is given."""

    def __init__(self, options):
        self._options = options
        self._rows, self._meshes = KeptRows(options.rows, "mesh", "method"), []
        self._commands = dict(peer.split("=", 1) for peer in options.peer)
        self._settings = [read_setting(setting) for setting in options.set]

    def add(self, name, path, field):
        """Make the rows of a mesh that are missing, or of another number of faces than ours."""
        self._meshes.append(name)
        ours = self._row(name, OURS, None, "our_row", path, field, self._settings)
        if ours is None or "faces" not in ours or field:
            return
        faces = ours["faces"]
        for method, settings in QUADRIFLOW.items():
            self._row(name, method, faces, "quadriflow_row", path, faces, settings)
        others = [method for mesh, method in self._rows if mesh == name and method not in (OURS, *QUADRIFLOW)]
        for method in dict.fromkeys([*others, *self._commands]):
            self._row(name, method, faces, "command_row", path, faces, self._commands.get(method))

    def rows(self):
        """Of the meshes that were added, as a list."""
        return [row for name in self._meshes for (mesh, _), row in self._rows.items() if mesh == name]

    def _row(self, name, method, asked, maker, path, *rest):
        row = self._rows.pop((name, method), None)
        is_wanted = method in self._options.methods or method in self._commands
        if row is not None and asked not in (None, row.get("asked", asked)):
            row = None
        if is_wanted and (row is None or method in self._options.again):
            row = {"mesh": name, "method": method} | self._made(name, method, maker, path, *rest)
            self._rows.keep(row)
        elif row is not None:
            self._rows[name, method] = row
        return row

    def _made(self, name, method, maker, path, *rest):
        print(f"{name}: {method}", file=sys.stderr, flush=True)
        kept = self._options.keep and str(self._options.keep / f"{name} {method}.obj")
        limit, start = self._options.limit, perf_counter()
        try:
            return in_child(made, maker, str(path), limit, *rest, kept)
        except BrokenProcessPool:
            seconds = perf_counter() - start
            return {"fails": f"no result in {limit} s" if seconds > limit else f"it crashed after {seconds:.0f} s"}


def made(maker, *arguments):
    """What a function of quad_makers.py gives."""
    # A process that has loaded Blender cannot hand its search path on to one that is to load it.
    from synch_fields.bench import quad_makers

    return getattr(quad_makers, maker)(*arguments)


def read_setting(text):
    """Name and value of NAME=VALUE, the value as JSON where it is."""
    name, value = text.split("=", 1)
    try:
        return name, json.loads(value)
    except json.JSONDecodeError:
        return name, value


def labelled(row):
    """A row as the table prints it."""
    return row | {"label": f"{row['mesh']}: {row['method']}", "closed": "yes" if row["closed"] else "no"}


def print_comparison(rows):
    """On how many meshes ours meets its face count and has only quads, and is no worse than each of the others."""
    rows = [
        row
        | {"other_share": 1 - row["quad_share"], "all_irregular": row["irregular_vertices"] + row["irregular_on_rim"]}
        for row in rows
        if "faces" in row
    ]
    ours = {row["mesh"]: row for row in rows if row["method"] == OURS}
    print("\n| ours | meshes |")
    print("|---|---|")
    print(f"| nothing but quads | {_share([row['other_faces'] == 0 for row in ours.values()])} |")
    print(f"| face count within {MET:.0%} of what was asked | {_share(map(meets, ours.values()))} |")
    print(f"| manifold, with the given Euler characteristic | {_share(map(keeps, ours.values()))} |")
    methods = [method for method in dict.fromkeys(row["method"] for row in rows) if method != OURS]
    pairs = {
        method: [(ours[row["mesh"]], row) for row in rows if row["method"] == method and row["mesh"] in ours]
        for method in methods
    }
    print("\n| ours is no worse in | " + " | ".join(f"than {method}" for method in methods) + " |")
    print("|---" * (len(methods) + 1) + "|")
    for heading, key in COMPARED.items():
        cells = [_share([own[key] <= other[key] for own, other in pairs[method]]) for method in methods]
        print(f"| {heading} | " + " | ".join(cells) + " |")
    for heading, holds in (("their face count as near to ours", meets), ("their mesh keeps what is given", keeps)):
        print(f"| {heading} | " + " | ".join(_share([holds(other) for _, other in pairs[m]]) for m in methods) + " |")


def meets(row):
    """Whether a row has about as many faces as were asked for."""
    return abs(row["faces"] - row["asked"]) <= MET * row["asked"]


def keeps(row):
    """Whether a row is a surface like the one given: its Euler characteristic, closed or open as it was."""
    return (
        row["manifold"] == "yes"
        and row["euler_characteristic"] == row["given_characteristic"]
        and row["closed"] == row["given_closed"]
    )


def _share(held):
    held = list(held)
    return f"{sum(held)} of {len(held)} ({sum(held) / max(len(held), 1):.0%})"


if __name__ == "__main__":
    main()
