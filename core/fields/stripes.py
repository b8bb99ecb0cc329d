# SPDX-License-Identifier: GPL-3.0-or-later
"""Stripe patterns: evenly spaced stripes along a direction field (paper, Section 3.3)."""

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


def stripe_problem(
    mesh: TriangleMesh,
    field: DirectionField,
    spacing: ArrayLike,
    rows: Sequence[Row] = (),
    mirrors: Sequence[Reflection] = (),
    branching: float = 1.0,
) -> SynchronizationProblem:
    """The synchronization problem of stripes along a vector or line field; arguments as :func:`pattern_problem`."""
    _check_symmetry(field)
    return pattern_problem(mesh, field, spacing, rows, mirrors, branching)


def stripe_pattern(
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
    """Stripes along a vector or line field; arguments as :func:`solve_pattern`."""
    _check_symmetry(field)
    return solve_pattern(
        mesh, field, spacing, rows, mirrors, options, callback, before, hold, branching, show, follower, start
    )


def _check_symmetry(field: DirectionField) -> None:
    if field.symmetry not in (1, 2):
        raise SettingError("stripes need a vector or line field: set the symmetry to vector or line")
