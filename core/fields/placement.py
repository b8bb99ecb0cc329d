# SPDX-License-Identifier: GPL-3.0-or-later
"""Line ends at chosen places, and other configurations of defects, from one solve (paper, Section 4.6)."""

from collections.abc import Collection
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from ..errors import SettingError, name_elements, quote_value
from ..interpolate import dislocation_numbers
from ..monitor import Callback, Monitor
from ..solution import COARSE, Options
from ..solve import solve
from .directions import SolvedField
from .local_defects import add_stripe, move_line_ends
from .patterns import Pattern

# Energy above the best, as a share of it, up to which a drawn variation counts as near.
NEAR = 0.05
_Field = TypeVar("_Field", Pattern, SolvedField)


def variation(pattern: _Field, number: int) -> _Field:
    """A pattern or direction field with other near-optimal phases of the same solve.

    The first numbers, from 0, are the local optima found by the solve, best first; higher numbers are the seeds of a
    search on a coarser problem, from which descent leads to a local optimum.
    """
    return pattern.with_phases(_varied_phases(pattern, number))


def _varied_phases(pattern: Pattern | SolvedField, number: int) -> np.ndarray:
    """The phases of :func:`variation`."""
    ready = pattern.solution.variations
    if number < len(ready):
        return ready[number]
    if pattern.solution.lifted is None:
        raise SettingError(
            "only the semidefinite method finds variations, in a solve that is not ended early: solve again"
        )
    return solve(pattern.problem, Options(method=COARSE, seed=number)).phases


def nearest_variation(
    pattern: Pattern | SolvedField, numbers: Collection[int], progress: Callback | None = None
) -> tuple[int, np.ndarray]:
    """Number and phases of the first of some variations that is near the best in energy, or of the nearest one."""
    monitor = Monitor(progress)
    found: list[tuple[float, int, np.ndarray]] = []
    for number in numbers:
        monitor.at("searching", len(found) / len(numbers))
        phases = _varied_phases(pattern, number)
        found.append((pattern.problem.energy(phases), number, phases))
        if found[-1][0] <= (1 + NEAR) * pattern.solution.energy:
            break
    return min(found, key=lambda one: one[0])[1:]


def with_line_ends(pattern: Pattern, vertices: ArrayLike) -> Pattern:
    """The pattern with a line end beside each of some vertices and their mirror images; farther away it stays as it is.

    Raises :class:`SettingError` where none fits.
    """
    vertices = check_vertices(vertices, pattern.mesh.vertex_count)
    for vertex in vertices:
        if not _has_defects(pattern, vertex):
            pattern = _with_line_end(pattern, vertex)
    return pattern


def move_defects(pattern: Pattern, triangles: np.ndarray, targets: np.ndarray) -> Pattern:
    """The pattern whose line ends in some triangles are in one of the targets; farther away it stays as it is.

    Errors as :func:`move_line_ends`.
    """
    numbers, torn = pattern.edge_phases.dislocations
    starts = triangles[numbers[triangles].any(axis=1)]
    if not len(starts) or not len(targets):
        raise SettingError("the line end or the face is not there any more: choose others")
    end = int(targets[torn[targets].argmin()])
    for start in starts.tolist():
        pattern = move_line_ends(pattern, start, end)
    return pattern


def _with_line_end(pattern: Pattern, vertex: int) -> Pattern:
    """The pattern with a line end in a triangle at a vertex, the first in which one fits; SettingError without one."""
    refused = f"no line end fits beside {name_elements('vertex', [vertex])}: choose others nearby"
    for triangle in np.flatnonzero((pattern.mesh.triangles == vertex).any(axis=1)).tolist():
        try:
            found = add_stripe(pattern, triangle)
        except SettingError as error:
            refused = str(error)
            continue
        if _has_defects(found, vertex):
            return found
    raise SettingError(refused)


def check_vertices(vertices: ArrayLike, count: int) -> np.ndarray:
    """(k,) vertices of a mesh with ``count`` of them, ascending, each once; refuses everything else."""
    try:
        found = np.unique(np.asarray(vertices).ravel())
    except ValueError:  # lists in lists of other lengths
        found = np.empty(0)
    if found.dtype.kind not in "iu" or not len(found):
        raise SettingError(f"the vertices are {quote_value(vertices)}: give the numbers of one or more")
    outside = found[(found < 0) | (found >= count)]
    if len(outside):
        raise SettingError(f"there is no vertex {outside[0]}: the mesh has {count}, from 0 on")
    return found


def _has_defects(pattern: Pattern, vertices: ArrayLike) -> bool:
    """Whether each vertex is a corner of a triangle with a dislocation, or around which the sheet changes."""
    triangles = pattern.mesh.triangles
    near = np.flatnonzero(np.isin(triangles, vertices).any(axis=1))
    numbers, torn = dislocation_numbers(pattern.edge_phases, triangles[near])
    return bool(np.isin(vertices, triangles[near][numbers.any(axis=1) | torn]).all())
