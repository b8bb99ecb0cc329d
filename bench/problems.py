# SPDX-License-Identifier: GPL-3.0-or-later
"""The problems of the benchmarks on one mesh: direction fields n = 1, 2, 4 and stripes at two spacings."""

import numpy as np

from synch_fields.core.fields import direction_field
from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.fields.patterns import PatternWishes, pattern_problem
from synch_fields.core.solve import Options

SYMMETRIES = {"n = 1": 1, "n = 2": 2, "n = 4": 4}
# Stripes along the mesh's longest side.
STRIPES = {"stripes 20": 20, "stripes 40": 40}
NAMES = (*SYMMETRIES, *STRIPES)


def make_problem(mesh, name, lines=None):
    """The problem of one name; stripes run along ``lines``, by default the spectral line field."""
    if name in SYMMETRIES:
        return direction_problem(mesh, SYMMETRIES[name])
    size = np.ptp(mesh.vertices[np.unique(mesh.triangles)], axis=0).max()
    return pattern_problem(mesh, spectral_lines(mesh) if lines is None else lines, PatternWishes(size / STRIPES[name]))


def spectral_lines(mesh):
    """The line field that stripes follow."""
    return direction_field(mesh, 2, options=Options(method="spectral"))


def problems(mesh, names=NAMES):
    """Names and problems on one mesh."""
    lines = spectral_lines(mesh) if set(names) & set(STRIPES) else None
    for name in names:
        yield name, make_problem(mesh, name, lines)
