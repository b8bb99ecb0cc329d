# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad patterns by three methods with the bound on all of them.

    python bench/quad_patterns.py MESHES [--only NAME ...] [--record]

Along the cross field of each MESHES/*.obj, at periods of the longest side over 15 and over 30. Every violated
inequality of Eq. (23) is printed below the table.
"""

import sys
from itertools import pairwise

from synch_fields.bench.best_known import BestKnown
from synch_fields.bench.command import arguments
from synch_fields.bench.measure import timed
from synch_fields.bench.meshes import read_obj
from synch_fields.bench.quad_measures import longest_side
from synch_fields.bench.tables import Column, print_table
from synch_fields.core.errors import MeshError
from synch_fields.core.fields import direction_field, quad_pattern
from synch_fields.core.fields.target_one_form import TargetOneForm
from synch_fields.core.solve import Options

# Periods along the longest side.
PERIODS = (15, 30)
METHODS = ("spectral", "diffusion", "sdp")

COLUMNS = (
    Column("nodes", "nodes", "d"),
    Column("coarse", "coarse", ".0%"),
    Column("lower bound", "lower_bound", ".1f"),
    Column("SDP", "sdp_value", ".1f"),
    Column("SDP gap", "sdp_gap", ".1e"),
    Column("proof", "certificate", ""),
    Column("polished", "sdp", ".1f"),
    Column("above best known", "above", ".2%"),
    Column("MBO falling", "diffusion", ".1f"),
    Column("spectral", "spectral", ".1f"),
    Column("disclinations", "disclinations", "d"),
    Column("dislocations SDP", "sdp dislocations", "d"),
    Column("dislocations MBO", "diffusion dislocations", "d"),
    Column("dislocations spectral", "spectral dislocations", "d"),
    Column("s field", "field seconds", ".1f"),
    Column("s SDP", "sdp seconds", ".1f"),
    Column("s MBO", "diffusion seconds", ".1f"),
    Column("s spectral", "spectral seconds", ".1f"),
)


def main():
    """Print the table; returns the number of violated inequalities."""
    parser = arguments(__doc__, "the meshes")
    parser.add_argument("--only", nargs="+", default=(), help="names of meshes, all by default")
    parser.add_argument("--record", action="store_true", help="keep energies below the best known ones")
    options = parser.parse_args()
    rows, refused, known = [], [], BestKnown()
    for path in sorted(options.meshes.glob("*.obj")):
        if not options.only or path.stem in options.only:
            try:
                rows += patterns(path, known)
            except MeshError as error:
                refused.append(f"{path.stem} is refused: {error}")
    print_table("Quad patterns", COLUMNS, rows)
    if options.record:
        known.save()
    violations = [line for row in rows for line in violated(row)]
    print("\n" + "\n".join(refused + (violations or ["All inequalities hold."])))
    return len(violations)


def patterns(path, known):
    """Rows of the table for one mesh; a :class:`BestKnown` sees their energies."""
    mesh = read_obj(path)
    field, field_seconds = timed(direction_field, mesh, 4)
    for count in PERIODS:
        spacing = longest_side(mesh) / count
        row = {
            "label": f"{path.stem} {count}",
            "nodes": 2 * (mesh.vertex_count - len(mesh.loose_vertices)),
            "coarse": TargetOneForm.of(mesh, field, spacing).coarse_share,
            "disclinations": len(field.disclinations),
            "field seconds": field_seconds,
        }
        for method in METHODS:
            pattern, seconds = timed(quad_pattern, mesh, field, spacing, (), (), Options(method=method))
            row |= {
                method: pattern.solution.energy,
                f"{method} dislocations": len(pattern.dislocations),
                f"{method} seconds": seconds,
            }
        for name in ("lower_bound", "sdp_value", "sdp_gap", "certificate"):
            row[name] = getattr(pattern.solution, name)
        name = f"{path.stem} quads {count}"
        row["above"] = known.distance(name, pattern.problem, row["sdp"])
        known.see(name, pattern.problem, min(row[method] for method in METHODS))
        print(row["label"], "is solved", file=sys.stderr, flush=True)
        yield row


def violated(row):
    """Lines for the inequalities of Eq. (23) that a row does not hold, and for a method better than ours."""
    pairs = (*pairwise(("lower_bound", "sdp_value", "sdp", "spectral")), ("sdp", "diffusion"))
    return [
        f"violated: {row['label']}: {smaller} {row[smaller]:.6g} > {larger} {row[larger]:.6g}"
        for smaller, larger in pairs
        if row[smaller] > row[larger] * (1 + 1e-9)
    ]


if __name__ == "__main__":
    sys.exit(min(main(), 1))
