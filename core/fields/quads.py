# SPDX-License-Identifier: GPL-3.0-or-later
"""Quad patterns: two phases at a vertex, exchanged around the disclinations of a cross field (paper, Section 3.5).

The product of the phases' cosines does not depend on the sheet, and its grid lines are those of a quad mesh.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..errors import SettingError
from ..geometry.triangle_mesh import TriangleMesh
from ..monitor import Callback
from ..problem import SynchronizationProblem
from ..solution import Options
from ..solve.warm_start import Follower
from .constraints.rows import Row
from .directions import DirectionField
from .mirror import Reflection
from .patterns import Pattern, pattern_problem, solve_pattern


def quad_problem(
    mesh: TriangleMesh,
    field: DirectionField,
    spacing: ArrayLike,
    rows: Sequence[Row] = (),
    mirrors: Sequence[Reflection] = (),
    branching: float = 1.0,
) -> SynchronizationProblem:
    """The synchronization problem of quads along a cross field; arguments as :func:`pattern_problem`."""
    _check_symmetry(field)
    return pattern_problem(mesh, field, spacing, rows, mirrors, branching)


def quad_pattern(
    mesh: TriangleMesh,
    field: DirectionField,
    spacing: ArrayLike,
    rows: Sequence[Row] = (),
    mirrors: Sequence[Reflection] = (),
    options: Options | None = None,
    callback: Callback | None = None,
    before: Pattern | None = None,
    hold: float = 0.0,
    branching: float = 1.0,
    show: Callable[[Pattern], object] | None = None,
    follower: Follower | None = None,
    start: np.ndarray | None = None,
) -> Pattern:
    """Quads along a cross field; arguments as :func:`solve_pattern`."""
    _check_symmetry(field)
    return solve_pattern(
        mesh, field, spacing, rows, mirrors, options, callback, before, hold, branching, show, follower, start
    )


def _check_symmetry(field: DirectionField) -> None:
    if field.symmetry != 4:
        raise SettingError("quads need a cross field: set the symmetry to cross")
