# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad patterns: two phases at a vertex, exchanged around the disclinations of a cross field (paper, Section 3.5).

The product of the phases' cosines does not depend on the sheet, and its grid lines are those of a quad mesh.
"""

from ..errors import SettingError
from .patterns import pattern_problem, solve_pattern


def quad_problem(mesh, field, spacing, rows=(), mirrors=(), branching=1.0):
    """The synchronization problem of quads along a cross field; arguments as :func:`pattern_problem`."""
    _check_symmetry(field)
    return pattern_problem(mesh, field, spacing, rows, mirrors, branching)


def quad_pattern(
    mesh,
    field,
    spacing,
    rows=(),
    mirrors=(),
    options=None,
    callback=None,
    before=None,
    hold=0.0,
    branching=1.0,
    show=None,
):
    """Quads along a cross field; arguments as :func:`solve_pattern`."""
    _check_symmetry(field)
    return solve_pattern(mesh, field, spacing, rows, mirrors, options, callback, before, hold, branching, show)


def _check_symmetry(field):
    if field.symmetry != 4:
        raise SettingError("quads need a cross field: set the symmetry to cross")
