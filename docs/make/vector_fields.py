# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's Figure 9 again: energies and seconds of unit vector fields on many surfaces, as scatter plots."""

import numpy as np

from synch_fields.bench import vector_fields
from synch_fields.bench.vector_fields import column
from synch_fields.docs.make.diagrams import BLUE, GREEN, ROSE, Diagram, draw
from synch_fields.docs.make.sheets import beside

METHODS = (("Knöppel et al.", "knoeppel", ROSE), ("MBO, time 0.1", "mbo", BLUE))
SECONDS, ENERGY = "CPU seconds of this program", "energy of this program"


def figure9(place):
    """The rows of all surfaces, made where they are missing, and the plots."""
    rows = vector_fields.measured(place.meshes, place.rows.with_name("surfaces.jsonl"))
    sheets = []
    for name, line in (("above", diagrams(rows)[:2]), ("below", diagrams(rows)[2:])):
        pictures = [draw(diagram, place.folder / f"{name} {k}.png") for k, diagram in enumerate(line)]
        sheets.append(place.folder / f"{name}.png")
        beside(pictures, sheets[-1])
    beside(sheets, place.picture, vertical=True)
    return {
        "claims": vector_fields.claims(rows),
        "correlations": vector_fields.correlations(rows),
        "surfaces": rows,
    }


def diagrams(rows):
    """Energies, seconds, and seconds for each node against the smallest triangle and the curvature."""
    ours, seconds = column(rows, "energy"), column(rows, "seconds")
    for_each = 1000 * seconds / column(rows, "nodes")

    def others(what):
        return tuple((name, color, x, column(rows, f"{key} {what}")) for name, key, color in METHODS)

    x = ours
    energies = Diagram("energy", ENERGY, "energy of the others", others("energy"), True)
    x = seconds
    times = Diagram("seconds", SECONDS, "CPU seconds of the others", others("seconds"), True)
    curvatures = column(rows, "mean curvature")
    curved = curvatures > np.sqrt(np.finfo(float).eps)  # the others are flat
    against = (
        ("smallest triangle", "area over all area", column(rows, "least area"), for_each),
        ("curvature", "RMS curvature of vertices times area", curvatures[curved], for_each[curved]),
    )
    return (
        energies,
        times,
        *(
            Diagram(title, across, "milliseconds for each node", (("", GREEN, values, taken),))
            for title, across, values, taken in against
        ),
    )
