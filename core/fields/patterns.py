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
from ..refinement.spacing import check_spacing
from ..solution import FIRST
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


@dataclass(frozen=True)
class PatternWishes:
    """What is asked of a pattern besides its directions.

    Attributes
    ----------
    spacing : length of a period in the mesh's units, or one at each vertex (see :meth:`TargetOneForm.of`)
    rows : of the constraint list; those of the kinds "phase" and "constant" apply
    mirrors : symmetries of the pattern
    branching : share of the target one-form's curl that is kept, from 0 to 1: the less, the fewer the dislocations,
        and the more the spacing varies (see :mod:`.curl_removal`)
    one_form : of directions and spacing, before anything else is applied, where it has been made already
    """

    spacing: ArrayLike
    rows: Sequence[Row] = ()
    mirrors: Sequence[Reflection] = ()
    branching: float = 1.0
    one_form: TargetOneForm | None = None


@dataclass(frozen=True)
class KnownPattern:
    """Phases on a mesh, one a vertex for stripes and two for quads, solved or read from an object's attributes.

    Attributes
    ----------
    one_form : the target one-form, which the phases follow as far as possible
    problem, solution : None for phases that were read
    phases : (k n,) complex
    on_planes : links of phases on mirror planes with themselves, which fix them up to a sign
    """

    one_form: TargetOneForm
    problem: SynchronizationProblem | None
    solution: Solution | None
    phases: np.ndarray
    on_planes: Links = dataclasses.field(default_factory=lambda: join_links([]))

    @property
    def mesh(self) -> TriangleMesh:
        return self.one_form.mesh

    @property
    def energy(self) -> float | None:
        """The energy of the phases; None for those that were read."""
        return None

    @cached_property
    def edge_phases(self) -> EdgePhases:
        """The phase changes along every edge."""
        return self.one_form.edge_phases(self.phases)

    @cached_property
    def evenness(self) -> Evenness:
        """Evenness of the lines, against the target spacing."""
        return evenness(self.edge_phases, self.one_form.asked_rates)

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


@dataclass(frozen=True)
class Pattern(KnownPattern):
    """A pattern with the problem that it solves; its phases are the solution's or others (:meth:`with_phases`)."""

    problem: SynchronizationProblem
    solution: Solution

    @property
    def energy(self) -> float:
        """The energy of the phases."""
        return self.solution.energy if self.phases is self.solution.phases else self.problem.energy(self.phases)

    def with_phases(self, phases: np.ndarray) -> "Pattern":
        """The pattern with other phases of the same problem: a variation, or one with defects at chosen places."""
        return replace(self, phases=phases)


def pattern_problem(mesh: TriangleMesh, field: DirectionField, wishes: PatternWishes) -> SynchronizationProblem:
    """The synchronization problem of a pattern."""
    return _pose_pattern(mesh, field, wishes)[1]


def _pose_pattern(
    mesh: TriangleMesh, field: DirectionField, wishes: PatternWishes
) -> tuple[TargetOneForm, SynchronizationProblem, Links]:
    """The one-form, the problem, and the links of phases to themselves, on mirrors and grid lines."""
    check_spacing(mesh.vertices[mesh.used_vertices], wishes.spacing)
    check_share(wishes.branching, "branching")
    one_form = _target_one_form(mesh, field, wishes)
    slack = LEAN if wishes.mirrors else TOLERANCE
    try:
        count = one_form.phase_count * mesh.vertex_count
        links, loops = split_links(count, [mirror.phase_links(one_form) for mirror in wishes.mirrors])
        rows = [row for row in wishes.rows if row.is_of_phases]
        links, on_grid = add_grid_lines(one_form, rows, links)
        fixed, merged, soft = phase_constraints(one_form, [row for row in rows if row.kind != GRID], [links], slack)
        fixed = snap_targets(fixed, loops, slack)
        loops = join_links([loops, link_to_themselves(np.setdiff1d(on_grid, np.append(fixed.nodes, loops.i)))])
    except ContradictionError as error:
        raise error.renumbered(np.repeat(np.arange(mesh.vertex_count), one_form.phase_count)) from None
    one_form = one_form.remove_curl(1 - wishes.branching, fixed, merged)
    solved = one_form.on_solver_edges
    connection = add_self_edges(solved.connection, loops)
    # At a branching of 0 there is no curl left to remove.
    calmer = partial(one_form.curl_removing_turns, fixed, merged) if wishes.branching > 0 else None
    problem = SynchronizationProblem(connection, solved.masses, merged, fixed, join_targets(soft), calmer)
    return one_form, problem, loops


def stripe_pattern(
    mesh: TriangleMesh,
    field: DirectionField,
    spacing: ArrayLike,
    rows: Sequence[Row] = (),
    mirrors: Sequence[Reflection] = (),
    options: Options | None = None,
    callback: Callback | None = None,
    branching: float = 1.0,
) -> Pattern:
    """Stripes along a vector or line field (Section 3.3); arguments as :class:`PatternWishes` and :func:`solve`."""
    if field.symmetry not in (1, 2):
        raise SettingError("stripes need a vector or line field: set the symmetry to vector or line")
    return solve_pattern(mesh, field, PatternWishes(spacing, rows, mirrors, branching), options, callback)


def quad_pattern(
    mesh: TriangleMesh,
    field: DirectionField,
    spacing: ArrayLike,
    rows: Sequence[Row] = (),
    mirrors: Sequence[Reflection] = (),
    options: Options | None = None,
    callback: Callback | None = None,
    branching: float = 1.0,
) -> Pattern:
    """Quads along a cross field (Section 3.5); arguments as :func:`stripe_pattern`.

    Two phases at a vertex are exchanged around the disclinations of the field. The product of their cosines does not
    depend on the sheet, and its grid lines are those of a quad mesh.
    """
    if field.symmetry != 4:
        raise SettingError("quads need a cross field: set the symmetry to cross")
    return solve_pattern(mesh, field, PatternWishes(spacing, rows, mirrors, branching), options, callback)


def solve_pattern(
    mesh: TriangleMesh,
    field: DirectionField,
    wishes: PatternWishes,
    options: Options | None = None,
    callback: Callback | None = None,
    start: np.ndarray | None = None,
    show: Callable[[Pattern], object] | None = None,
) -> Pattern:
    """Solve for a pattern; options and callback as :func:`core.solve.solve`.

    Parameters
    ----------
    field : direction of the lines of the first phase; a cross field gives two phases
    start : (k n,) complex phases from which the solve starts, optional
    show : called with preliminary patterns
    """
    one_form, problem, loops = _pose_pattern(mesh, field, wishes)
    shows = None if show is None else lambda solution: show(_pattern_of(one_form, problem, solution, loops))
    return _pattern_of(one_form, problem, solve(problem, options, callback, start, shows), loops)


def next_pattern(
    mesh: TriangleMesh,
    field: DirectionField,
    wishes: PatternWishes,
    before: np.ndarray,
    options: Options | None = None,
    callback: Callback | None = None,
    hold: float = 0.0,
    follower: Follower | None = None,
) -> Pattern:
    """The pattern that descent reaches from the phases of another one (see :mod:`.animation`).

    Parameters
    ----------
    before : (k n,) complex phases on another shape of the mesh, along a field in the same sheets
    hold : weight that draws the phases to those before, per mass and in units of 1 / spacing^2
    follower : takes only some steps, optional
    """
    one_form, problem, loops = _pose_pattern(mesh, field, wishes)
    weights = hold * one_form.masses * (one_form.rates.ravel() / (2 * np.pi)) ** 2
    return _pattern_of(one_form, problem, next_solution(problem, before, options, callback, weights, follower), loops)


def change_pattern(
    pattern: Pattern, correction: np.ndarray, options: Options | None = None, callback: Callback | None = None
) -> Pattern:
    """Solve a pattern again with an (e, k) correction, radians, added to the changes of its one-form along the edges.

    The one-form must have a correction already. Options and callback as :func:`core.solve.solve`.
    """
    one_form = pattern.one_form
    problem = pattern.problem.turned_by(one_form.connection_turns(correction))
    one_form = replace(one_form, correction=one_form.correction + correction)
    return _pattern_of(one_form, problem, solve(problem, options, callback), pattern.on_planes)


def untangle(pattern: Pattern, options: Options) -> Pattern:
    """A pattern with a branching of 0, solved again for other target changes, with fewer dislocations.

    The new targets are the changes that the pattern reached, less what its dislocations add to them around triangles;
    there are phases whose changes are nearly these. The energy is measured from the new targets.
    """
    one_form, problem = pattern.one_form, pattern.problem
    reached = one_form.reaching(pattern.edge_phases.changes)
    correction = reached.changes - one_form.changes + reached.curl_removal(problem.fixed, problem.merged)
    return change_pattern(pattern, correction, replace(options, method=FIRST))


def _pattern_of(
    one_form: TargetOneForm, problem: SynchronizationProblem, solution: Solution, on_planes: Links
) -> Pattern:
    solution = snap_to_plane(problem, solution, on_planes)
    return Pattern(one_form, problem, solution, solution.phases, on_planes)


def known_pattern(mesh: TriangleMesh, field: DirectionField, wishes: PatternWishes, phases: np.ndarray) -> KnownPattern:
    """The pattern of (k n,) complex phases that are known, without problem and solution."""
    one_form = _target_one_form(mesh, field, wishes) if wishes.branching == 1 else _pose_pattern(mesh, field, wishes)[0]
    return KnownPattern(one_form, None, None, phases)


def _target_one_form(mesh: TriangleMesh, field: DirectionField, wishes: PatternWishes) -> TargetOneForm:
    """The target one-form before curl is removed."""
    one_form = TargetOneForm.of(mesh, field, wishes.spacing) if wishes.one_form is None else wishes.one_form
    stretch = strip_stretch(one_form, wishes.rows)
    return one_form if np.ndim(stretch) == 0 else replace(one_form, stretch=stretch)
