# SPDX-License-Identifier: GPL-3.0-or-later
"""Periodic patterns: phases that follow a target one-form, found by synchronization (paper, Sections 3.3 and 3.5).

Stripes and quads differ only in the number of phases at a vertex (:class:`TargetOneForm`).
"""

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import ArrayLike

from ..defects import Defect, list_defects
from ..errors import ContradictionError, SettingError
from ..geometry import TriangleMesh
from ..geometry.polygons import Polygons
from ..interpolate import EdgePhases, FacePhases, face_phases
from ..monitor import Callback
from ..problem import SynchronizationProblem, join_targets
from ..solution import COARSE, FIRST
from ..solve import Options, Solution, solve
from ..solve.warm_start import Follower
from .animation import next_solution
from .constraints.features import add_grid_lines, link_to_themselves
from .constraints.groups import TOLERANCE, Links, join_links
from .constraints.phase_rows import phase_constraints
from .constraints.rows import GRID, Row
from .constraints.strips import strip_stretch
from .curl_removal import check_share
from .directions import DirectionField
from .evenness import Evenness, evenness
from .mirror import LEAN, Reflection, add_self_edges, snap_targets, snap_to_plane, split_links
from .target_one_form import TargetOneForm

# Spacings below this share of the object are too fine for phases in double precision.
_FINEST = 1e-9


@dataclass(frozen=True)
class Pattern:
    """Phases on a mesh, one a vertex for stripes and two for quads.

    Attributes
    ----------
    growth : the target
    problem : of the phases, or None for phases that were given
    solution : of the problem, or None
    phases : (k n,) complex, the solution's or others (:meth:`showing`)
    on_planes : links from phases on mirror planes to themselves
    """

    growth: TargetOneForm
    problem: SynchronizationProblem | None
    solution: Solution | None
    phases: np.ndarray
    on_planes: Links = dataclasses.field(default_factory=lambda: join_links([]))

    @property
    def mesh(self) -> TriangleMesh:
        return self.growth.mesh

    @property
    def energy(self) -> float | None:
        """The energy of the phases; None for given ones."""
        if self.problem is None:
            return None
        if self.solution is not None and self.phases is self.solution.phases:
            return self.solution.energy
        return self.problem.energy(self.phases)

    def showing(self, phases: np.ndarray) -> "Pattern":
        """The pattern with other phases of the same problem: a variation, or one with defects at chosen places."""
        return replace(self, phases=phases)

    @cached_property
    def edge_phases(self) -> EdgePhases:
        """The phase changes along every edge."""
        return self.growth.edge_phases(self.phases)

    @cached_property
    def evenness(self) -> Evenness:
        """Evenness of the lines, against the target spacing."""
        return evenness(self.edge_phases, self.growth.asked_rates)

    @property
    def vertex_phases(self) -> np.ndarray:
        """(n, k) radians."""
        return self.edge_phases.arguments

    @property
    def dislocations(self) -> list[Defect]:
        """Defects with integer index."""
        numbers, _ = self.edge_phases.dislocations
        return [
            defect
            for phase, column in enumerate(numbers.T)
            for defect in list_defects(self.mesh, "dislocation", column, phase=phase)
        ]

    def on_faces(self, polygons: Polygons) -> tuple[FacePhases, ...]:
        """The phases on the faces that the mesh's triangles make up, one item for each phase."""
        return face_phases(self.edge_phases, polygons)


def check_spacing(places: np.ndarray, spacing: ArrayLike, what: str = "stripe") -> None:
    """Refuse a spacing larger than the object, or too fine for double precision.

    Parameters
    ----------
    places : (n, 3) vertices that the pattern is on
    spacing : a length in their unit, or one at each vertex (and axis)
    what : the spaced thing, for messages
    """
    spacing = check_lengths(spacing)
    extent = np.linalg.norm(np.ptp(places, axis=0))
    if spacing.min() > extent:
        raise SettingError(
            f"the spacing {spacing.min():g} is larger than the object ({extent:g}): no {what} would fit, reduce it"
        )
    if spacing.min() < _FINEST * extent:
        raise SettingError(
            f"the spacing {spacing.min():g} is finer than numbers tell places on an object of {extent:g} apart: "
            f"give one from {1.1 * _FINEST * extent:.2g} on"
        )


def check_lengths(spacing: ArrayLike) -> np.ndarray:
    """Spacings, one or one at each vertex (and axis), as an array; refuses those that are not positive lengths."""
    spacing = np.asarray(spacing, float)
    bad = np.argwhere(~(np.isfinite(spacing) & (spacing > 0)))
    if len(bad):
        where = f" at vertex {bad[0][0]} ({len(bad)} in all)" if spacing.ndim else ""
        raise SettingError(f"the spacing is {spacing[tuple(bad[0])]:g}{where}: give a positive length")
    return spacing


def pattern_problem(
    mesh: TriangleMesh,
    field: DirectionField,
    spacing: ArrayLike,
    rows: Sequence[Row] = (),
    mirrors: Sequence[Reflection] = (),
    branching: float = 1.0,
) -> SynchronizationProblem:
    """The synchronization problem of a pattern.

    Parameters
    ----------
    field : direction of the lines of the first phase; a cross field gives two phases
    spacing : length of a period in the mesh's units, or one at each vertex (see :meth:`TargetOneForm.of`)
    rows : of the constraint list; those of the kinds "phase" and "constant" apply
    mirrors : symmetries of the pattern
    branching : share of the growth's curl that is kept, from 0 to 1: fewer dislocations below 1, for a spacing that
        varies more (see :mod:`.curl_removal`)
    """
    return _pose_pattern(mesh, field, spacing, rows, mirrors, branching)[1]


def _pose_pattern(
    mesh: TriangleMesh,
    field: DirectionField,
    spacing: ArrayLike,
    rows: Sequence[Row],
    mirrors: Sequence[Reflection],
    branching: float,
) -> tuple[TargetOneForm, SynchronizationProblem, Links]:
    """The growth, the problem, and the links of phases to themselves, on mirrors and grid lines."""
    check_spacing(mesh.vertices[np.unique(mesh.triangles)], spacing)
    check_share(branching, "branching")
    growth = _growth(mesh, field, spacing, rows)
    slack = LEAN if mirrors else TOLERANCE
    try:
        links, loops = _mirror_links(growth, mirrors)
        rows = [row for row in rows if row.is_of_phases]
        links, on_grid = add_grid_lines(growth, rows, links)
        fixed, merged, drawn = phase_constraints(growth, [row for row in rows if row.kind != GRID], [links], slack)
        fixed = snap_targets(fixed, loops, slack)
        loops = join_links([loops, link_to_themselves(np.setdiff1d(on_grid, np.append(fixed.nodes, loops.i)))])
    except ContradictionError as error:
        raise error.renumbered(np.repeat(np.arange(mesh.vertex_count), growth.phase_count)) from None
    growth = growth.remove_curl(1 - branching, fixed, merged)
    solved = growth.on_solver_edges
    connection = add_self_edges(solved.connection, loops)
    # At a branching of 0 there is no curl left to remove.
    calmer = partial(solved.curl_removing_turns, fixed, merged) if branching > 0 else None
    problem = SynchronizationProblem(connection, solved.masses, merged, fixed, join_targets(drawn), calmer)
    return growth, problem, loops


def solve_pattern(
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
    """Solve for a pattern; arguments as :func:`pattern_problem` and :func:`core.solve.solve`.

    Parameters
    ----------
    before : pattern on another shape of the mesh along a field in the same sheets, or anything else with its phases,
        optional: the pattern is then the one that descent reaches from there (see :mod:`.animation`)
    hold : weight that draws the phases to those before, per mass and in units of 1 / spacing^2
    follower : takes only some steps from the pattern before, optional
    start : (k n,) complex phases, optional: without a pattern before, the whole solve starts from these
    show : called with preliminary patterns where there is none before
    """
    growth, problem, loops = _pose_pattern(mesh, field, spacing, rows, mirrors, branching)

    def pattern(solution: Solution) -> Pattern:
        return _pattern_of(growth, problem, solution, loops)

    if before is None:
        shows = None if show is None else lambda solution: show(pattern(solution))
        solution = solve(problem, options, callback, start, shows)
    else:
        weights = hold * growth.masses * (growth.rates.ravel() / (2 * np.pi)) ** 2
        solution = next_solution(problem, before.phases, options, callback, weights, follower)
    return pattern(solution)


def change_pattern(
    pattern: Pattern, correction: np.ndarray, options: Options | None = None, callback: Callback | None = None
) -> Pattern:
    """The pattern solved again with an (e, k) correction, radians, added to the changes of its growth.

    The pattern has its problem, and its growth a correction already; options and callback as :func:`core.solve.solve`.
    """
    growth = pattern.growth
    assert pattern.problem is not None
    problem = pattern.problem.turned_by(growth.connection_turns(correction))
    growth = replace(growth, correction=growth.correction + correction)
    return _pattern_of(growth, problem, solve(problem, options, callback), pattern.on_planes)


def untangle(pattern: Pattern, options: Options | None = None, callback: Callback | None = None) -> Pattern:
    """A pattern with a branching of 0, solved again from phases in which its dislocations are taken out.

    The changes that it reached, without what dislocations add to them around triangles, are nearly those of phases.
    """
    growth, problem, options = pattern.growth, pattern.problem, options or Options()
    assert problem is not None
    reached = growth.reaching(pattern.edge_phases.changes)
    calm = reached.changes + reached.curl_removal(problem.fixed, problem.merged)
    near = problem.turned_by(growth.connection_turns(calm - growth.changes))
    start = solve(near, replace(options, method=FIRST), callback).phases
    solution = solve(problem, replace(options, method=COARSE), callback, start)
    return _pattern_of(growth, problem, solution, pattern.on_planes)


def _pattern_of(
    growth: TargetOneForm, problem: SynchronizationProblem, solution: Solution, on_planes: Links
) -> Pattern:
    solution = snap_to_plane(problem, solution, on_planes)
    return Pattern(growth, problem, solution, solution.phases, on_planes)


def known_pattern(
    mesh: TriangleMesh,
    field: DirectionField,
    spacing: ArrayLike,
    phases: np.ndarray,
    rows: Sequence[Row] = (),
    mirrors: Sequence[Reflection] = (),
    branching: float = 1.0,
) -> Pattern:
    """The pattern of (k n,) complex phases that are known, without problem and solution.

    Other parameters as :func:`pattern_problem`.
    """
    growth = _growth(mesh, field, spacing, rows)
    if branching < 1:
        growth, _, _ = _pose_pattern(mesh, field, spacing, rows, mirrors, branching)
    return Pattern(growth, None, None, phases)


def _growth(mesh: TriangleMesh, field: DirectionField, spacing: ArrayLike, rows: Sequence[Row]) -> TargetOneForm:
    """The target one-form before curl is removed."""
    growth = TargetOneForm.of(mesh, field, spacing)
    return replace(growth, stretch=strip_stretch(growth, rows))


def _mirror_links(growth: TargetOneForm, mirrors: Sequence[Reflection]) -> tuple[Links, Links]:
    count = growth.phase_count * growth.mesh.vertex_count
    return split_links(count, [mirror.phase_links(growth) for mirror in mirrors])
