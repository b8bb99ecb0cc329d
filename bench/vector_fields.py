# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's Figure 9: unit vector fields on many surfaces of unit area, ours beside two other methods.

    python bench/vector_fields.py MESHES [--rows FILE] [--only WORD ...]

On all MESHES/*.obj, on surface_shapes.py and surface_family.py. Where there is a boundary, the field runs along it,
exactly. All methods get the same matrices: *Knöppel* is the smallest eigenvector on closed pieces and the linear solve
on others, normalized; *MBO* is diffusion at the time 0.1 from there until stationary (see peers.py); *ours* the default
solve, *SVD* the relaxation with the paper's rounding by singular values. Seconds are of the processor. With --rows the
rows go to a file of JSON lines as they come, and those in it are not made again.
"""

import sys
from functools import partial
from pathlib import Path

import numpy as np

from synch_fields.bench.command import arguments
from synch_fields.bench.measure import energy_of, spent, with_matrices
from synch_fields.bench.meshes import read_carrier
from synch_fields.bench.peers import fixed_diffusion, linear_field, plain_spectral
from synch_fields.bench.rows import KeptRows
from synch_fields.bench.surface_family import family
from synch_fields.bench.surface_shapes import SHAPES
from synch_fields.bench.tables import Column, print_table
from synch_fields.core.algebra.workers import solving
from synch_fields.core.fields.constraints.lines import boundary_line
from synch_fields.core.fields.constraints.rows import Row
from synch_fields.core.fields.directions import DirectionWishes, direction_problem
from synch_fields.core.solve import Options, solve

TIME = 0.1
# Energies that agree this well are the same optimum.
SAME = 1e-6
# Of the text: seconds, and how many times as slow as MBO.
SOON, MUCH = 60, 10
COLUMNS = (
    Column("nodes", "nodes", "d"),
    Column("fixed", "fixed", "d"),
    Column("smallest triangle", "least area", ".0e"),
    Column("largest curvature", "greatest curvature", ".0e"),
    Column("bound", "bound", ".2f"),
    Column("relaxation", "relaxation", ".2f"),
    Column("ours", "energy", ".2f"),
    Column("SVD", "svd energy", ".2f"),
    Column("MBO", "mbo energy", ".2f"),
    Column("Knöppel", "knoeppel energy", ".2f"),
    Column("s ours", "seconds", ".2f"),
    Column("s SVD", "svd seconds", ".2f"),
    Column("s MBO", "mbo seconds", ".2f"),
    Column("s Knöppel", "knoeppel seconds", ".2f"),
)
CLAIMS = (Column("here", "here", ""), Column("in the paper", "paper", ""))
CORRELATIONS = (
    Column("all", "all", "+.2f"),
    Column("of surfaces as large", "left", "+.2f"),
    Column("in the paper", "paper", ""),
)
# What the seconds are held against: heading, key of a row, and what the paper says.
AGAINST = (
    ("nodes", "nodes", "not all of it"),
    ("smallest triangle", "least area", "negative"),
    ("largest curvature", "greatest curvature", "positive"),
    ("RMS curvature", "mean curvature", "positive"),
)


def main():
    """Make the rows that are missing, and print the table and the shares."""
    parser = arguments(__doc__, "the meshes")
    parser.add_argument("--rows", type=Path, help="file of JSON lines for the rows, which are read from it first")
    parser.add_argument("--only", nargs="+", help="words; surfaces whose names hold one of them")
    options = parser.parse_args()
    rows = measured(options.meshes, options.rows, options.only)
    print_table("Figure 9", COLUMNS, rows)
    print_table("Section 5", CLAIMS, claims(rows), "")
    print_table("Seconds", CORRELATIONS, correlations(rows), "correlation of seconds with")


def measured(meshes, path=None, only=None):
    """Rows of all surfaces, or those with words in their names; kept in a file of JSON lines where one is given."""
    kept = KeptRows(path, "label")
    rows = []
    with solving():
        for label, make in subjects(meshes):
            if only and not any(word in label for word in only):
                continue
            if (label,) not in kept:
                print(label, file=sys.stderr, flush=True)
                kept.keep({"label": label} | row(make()))
            rows.append(kept[label,])
    return rows


def subjects(meshes):
    """Name of each surface, and what makes it."""
    for path in sorted(meshes.glob("*.obj")):
        yield path.stem, partial(read_carrier, path)
    for shape in SHAPES:
        yield shape.name, partial(unit_area, shape)
    for shape in family():
        yield shape.name, shape.make


def unit_area(shape):
    """A shape's mesh, scaled."""
    mesh = shape.make()
    return type(mesh)(mesh.vertices / np.sqrt(mesh.areas.sum()), mesh.triangles)


def vector_problem(mesh):
    """The problem of a unit vector field, which runs along the boundary where there is one."""
    rows = (Row(boundary_line(mesh), "along"),) if len(mesh.boundary_edges) else ()
    return direction_problem(mesh, 1, DirectionWishes(rows=rows))


def row(mesh):
    """What is measured on a surface."""
    problem = with_matrices(vector_problem(mesh))
    default, seconds = spent(solve, problem)
    svd, svd_seconds = spent(solve, problem, Options(rounding="svd"))
    mbo, mbo_seconds = spent(energy_of, problem, partial(fixed_diffusion, time=TIME, polished=False))
    knoeppel, knoeppel_seconds = spent(energy_of, problem, knoeppel_field)
    curvatures = vertex_curvatures(mesh)
    fixed = problem.fixed
    return {
        "nodes": mesh.vertex_count - len(mesh.loose_vertices),
        "fixed": len(fixed.nodes),
        "least area": float(mesh.areas.min()),
        "greatest curvature": float(np.abs(curvatures).max()),
        "mean curvature": float(np.sqrt(np.mean(curvatures**2))),
        "bound": default.lower_bound,
        "relaxation": default.sdp_value,
        "certificate": default.certificate.value,
        "energy": default.energy,
        "svd energy": svd.energy,
        "mbo energy": mbo,
        "knoeppel energy": knoeppel,
        "seconds": seconds,
        "svd seconds": svd_seconds,
        "mbo seconds": mbo_seconds,
        "knoeppel seconds": knoeppel_seconds,
        "boundary off": float(np.abs(default.phases[fixed.nodes] - fixed.values).max(initial=0)),
    }


def knoeppel_field(piece):
    """Spectral on a closed piece, a linear solve on one with fixed nodes."""
    return plain_spectral(piece) if piece.ground is None else linear_field(piece)


def vertex_curvatures(mesh):
    """(k,) Gaussian curvature of the inner vertices: what their angles lack of a full turn, over their area."""
    inner = ~mesh.boundary_vertices
    inner[mesh.loose_vertices] = False
    sums = np.bincount(mesh.triangles.ravel(), mesh.corner_angles.ravel(), mesh.vertex_count)
    return (2 * np.pi - sums[inner]) / mesh.vertex_masses[inner]


def claims(rows):
    """Rows of what Section 5 says: what it is, here, and in the paper."""
    ours, svd, mbo, knoeppel, bounds = (
        column(rows, key) for key in ("energy", "svd energy", "mbo energy", "knoeppel energy", "bound")
    )
    seconds, svd_seconds, mbo_seconds = (column(rows, key) for key in ("seconds", "svd seconds", "mbo seconds"))
    slowest = rows[int(np.argmax(seconds))]
    fixed = [row for row in rows if row["fixed"]]
    off = max((row["boundary off"] for row in fixed), default=0.0)
    proved = np.array([row["certificate"] == "proved" for row in rows])
    lines = [
        ("surfaces", f"{len(rows)}, {len(fixed)} of them with boundaries", "116"),
        ("energy no more than Knöppel's", share(ours <= knoeppel * (1 + SAME)), "lower"),
        (
            "... by SVD rounding alone, no more than Knöppel's",
            share(svd <= knoeppel * (1 + SAME)),
            "that is the paper's",
        ),
        ("energy no more than MBO's", share(ours <= mbo * (1 + SAME)), "comparable"),
        ("... by SVD rounding alone, no more than MBO's", share(svd <= mbo * (1 + SAME)), "that is the paper's"),
        ("energy over Knöppel's, median and largest", spread(ours / knoeppel), None),
        ("energy over MBO's, median and largest", spread(ours / mbo), None),
        ("share of the energy that could be saved at most, median", f"{np.median(1 - bounds / ours):.0%}", None),
        ("bound proved", share(proved), None),
        ("boundary values off by at most", f"{off:.0e}", "exact"),
        ("under 60 s", share(seconds < SOON), "67 %"),
        ("slowest", f"{slowest['seconds']:.1f} s ({slowest['label']})", "over 7800 s"),
        ("faster than MBO", share(seconds < mbo_seconds), "39 %"),
        ("... by SVD rounding alone, faster than MBO", share(svd_seconds < mbo_seconds), "that is the paper's"),
        ("at least ten times as slow as MBO", share(seconds >= MUCH * mbo_seconds), "22 %"),
        ("seconds over MBO's, median and largest", spread(seconds / mbo_seconds), "largest: two orders of magnitude"),
    ]
    return [{"label": label, "here": here, "paper": paper} for label, here, paper in lines]


def correlations(rows):
    """Rows of how the logarithm of the seconds goes with other logarithms: as it is, and what is left when a linear
    function of the number of nodes is taken off both."""
    seconds, nodes = (np.log(column(rows, key)) for key in ("seconds", "nodes"))
    lines = []
    for label, key, paper in AGAINST:
        # A flat surface is curved by no more than rounding.
        values = np.log(np.maximum(column(rows, key), np.finfo(float).eps))
        left = None if key == "nodes" else partial_correlation(seconds, values, nodes)
        lines.append({"label": label, "all": float(np.corrcoef(seconds, values)[0, 1]), "left": left, "paper": paper})
    return lines


def partial_correlation(first, second, given):
    """Correlation of what is left of two columns when a linear function of a third is taken off each."""
    table = np.column_stack([np.ones(len(given)), given])
    left = [values - table @ np.linalg.lstsq(table, values, rcond=None)[0] for values in (first, second)]
    return float(np.corrcoef(*left)[0, 1])


def column(rows, key):
    return np.array([row[key] for row in rows], float)


def spread(ratios):
    return f"{np.median(ratios):.3f}, {np.max(ratios):.3f}"


def share(held):
    return f"{held.sum()} of {len(held)} ({held.mean():.0%})"


if __name__ == "__main__":
    main()
