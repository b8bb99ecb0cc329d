# SPDX-License-Identifier: GPL-3.0-or-later
"""Periodic patterns: phases that grow as directions ask for, found by synchronization (paper, Sections 3.3 and 3.5).

Stripes and quads are the same but for the number of phases at a vertex (:class:`TargetOneForm`).
"""

import dataclasses
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from ..defects import Defect, list_defects
from ..errors import ContradictionError, SettingError
from ..geometry import TriangleMesh
from ..interpolate import EdgePhases, face_phases
from ..problem import SynchronizationProblem, join_targets
from ..solve import Solution, solve
from .animation import next_solution
from .constraints.features import loops_at, with_grid_lines
from .constraints.groups import TOLERANCE, Links, join_links
from .constraints.phase_rows import phase_constraints
from .constraints.rows import GRID
from .constraints.strips import widen_strips
from .curl_removal import check_share
from .evenness import Evenness, evenness
from .mirror import LEAN, on_mirror, snap_to_plane, split_links, with_loops
from .target_one_form import TargetOneForm

# Spacings that are a smaller share of the object than this are finer than double precision tells phases apart.
_FINEST = 1e-9


@dataclass(frozen=True)
class Pattern:
    """Phases on a mesh, one a vertex for stripes and two for quads.

    Attributes
    ----------
    growth : Growth that was asked for
    problem : SynchronizationProblem of the phases, or None for phases that were given
    solution : Solution of it, or None
    phases : (k n,) complex, the solution's or others (:meth:`showing`)
    on_planes : Links from phases on mirror planes to themselves
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
        """Of the phases that are shown; None for given ones."""
        if self.problem is None:
            return None
        if self.solution is not None and self.phases is self.solution.phases:
            return self.solution.energy
        return self.problem.energy(self.phases)

    def showing(self, phases: np.ndarray) -> "Pattern":
        """The pattern with other phases of the same problem: a variation, or with a defect at a chosen place."""
        return replace(self, phases=phases)

    @cached_property
    def edge_phases(self) -> EdgePhases:
        """:class:`EdgePhases`, the phase changes along every edge."""
        return self.growth.edge_phases(self.phases)

    @cached_property
    def evenness(self) -> Evenness:
        """:class:`Evenness` of the lines, against the spacing that was asked for."""
        return evenness(self.edge_phases, self.growth.asked_rates)

    @property
    def vertex_phases(self) -> np.ndarray:
        """(n, k) radians."""
        return self.edge_phases.arguments

    @property
    def dislocations(self) -> list[Defect]:
        """List of :class:`Defect` with integer index."""
        numbers, _ = self.edge_phases.dislocations
        return [
            defect
            for phase, column in enumerate(numbers.T)
            for defect in list_defects(self.mesh, "dislocation", column, phase=phase)
        ]

    def on_faces(self, polygons):
        """A :class:`FacePhases` for each phase, for the faces that the mesh's triangles draw."""
        return face_phases(self.edge_phases, polygons)


def check_spacing(places, spacing, what="stripe"):
    """Refuse a spacing that nothing fits in, and one that is too fine for double precision.

    Parameters
    ----------
    places : (n, 3) vertices of what the pattern is on
    spacing : a length in their unit, or one at each vertex (and axis)
    what : has this distance
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


def check_lengths(spacing):
    """Spacings, one or one at each vertex (and axis), as an array; refuses those that are no positive lengths."""
    spacing = np.asarray(spacing, float)
    bad = np.argwhere(~(np.isfinite(spacing) & (spacing > 0)))
    if len(bad):
        where = f" at vertex {bad[0][0]} ({len(bad)} in all)" if spacing.ndim else ""
        raise SettingError(f"the spacing is {spacing[tuple(bad[0])]:g}{where}: give a positive length")
    return spacing


def pattern_problem(mesh, field, spacing, rows=(), mirrors=(), branching=1.0):
    """The synchronization problem of a pattern.

    Parameters
    ----------
    mesh : TriangleMesh
    field : DirectionField, along which the lines of the first phase run; a cross field gives two phases
    spacing : length of a period in the mesh's units, or one at each vertex (see :meth:`Growth.of`)
    rows : Rows of the constraint list; those of the kinds "phase" and "constant" count
    mirrors : Mirrors that leave the pattern as it is
    branching : share of the growth's curl that is asked for, from 0 to 1: fewer dislocations below 1, for a spacing
        that varies more (see :mod:`.curl_removal`)
    """
    return _pose_pattern(mesh, field, spacing, rows, mirrors, branching)[1]


def _pose_pattern(mesh, field, spacing, rows, mirrors, branching):
    """The growth, the problem, and the mirrors' links from a phase to itself."""
    check_spacing(mesh.vertices[np.unique(mesh.triangles)], spacing)
    check_share(branching, "branching")
    growth = _growth(mesh, field, spacing, rows)
    slack = LEAN if mirrors else TOLERANCE
    try:
        links, loops = _mirror_links(growth, mirrors)
        rows = [row for row in rows if row.is_of_phases]
        links, on_grid = with_grid_lines(growth, rows, links)
        fixed, merged, drawn = phase_constraints(growth, [row for row in rows if row.kind != GRID], [links], slack)
        fixed = on_mirror(fixed, loops, slack)
        loops = join_links([loops, loops_at(np.setdiff1d(on_grid, np.append(fixed.nodes, loops.i)))])
    except ContradictionError as error:
        raise error.renumbered(np.repeat(np.arange(mesh.vertex_count), growth.phase_count)) from None
    growth = growth.calmed(1 - branching, fixed, merged)
    posed = growth.posed
    connection = with_loops(posed.connection, loops)
    # What is calmed as far as it can be leads to nothing calmer.
    calmer = partial(posed.turns_to_calm, fixed, merged) if branching > 0 else None
    problem = SynchronizationProblem(connection, posed.masses, merged, fixed, join_targets(drawn), calmer)
    return growth, problem, loops


def solve_pattern(
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
    follower=None,
    start=None,
):
    """Solve for a :class:`Pattern`; arguments as :func:`pattern_problem` and :func:`core.solve.solve`.

    Parameters
    ----------
    before : Pattern on another shape of the mesh along a field in the same sheets, or anything else with its phases,
        optional: the pattern is then the one that descent reaches from there (see :mod:`.animation`)
    hold : how strongly the phases are drawn to those before, per mass and in units of 1 / spacing^2
    follower : Follower that goes some steps from the pattern before only, optional
    start : (k n,) complex phases, optional: without a pattern before, the whole solve starts from these
    show : callable(Pattern), called with what there is before the end, for a pattern without one before
    """
    growth, problem, loops = _pose_pattern(mesh, field, spacing, rows, mirrors, branching)

    def pattern(solution):
        return _pattern_of(growth, problem, solution, loops)

    if before is None:
        shows = None if show is None else lambda solution: show(pattern(solution))
        solution = solve(problem, options, callback, start, shows)
    else:
        weights = hold * growth.masses * (growth.rates.ravel() / (2 * np.pi)) ** 2
        solution = next_solution(problem, before.phases, options, callback, weights, follower)
    return pattern(solution)


def change_pattern(pattern, correction, options=None, callback=None):
    """The :class:`Pattern` where (e, k) more is added to the changes that are asked for.

    Parameters
    ----------
    pattern : Pattern with its problem, whose growth is corrected already
    correction : (e, k) radians
    options, callback : as :func:`core.solve.solve` has them
    """
    growth = pattern.growth
    problem = pattern.problem.turned_by(growth.connection_turns(correction))
    growth = replace(growth, correction=growth.correction + correction)
    return _pattern_of(growth, problem, solve(problem, options, callback), pattern.on_planes)


def _pattern_of(growth, problem, solution, on_planes):
    solution = snap_to_plane(problem, solution, on_planes)
    return Pattern(growth, problem, solution, solution.phases, on_planes)


def known_pattern(mesh, field, spacing, phases, rows=(), mirrors=(), branching=1.0):
    """The :class:`Pattern` of (k n,) complex phases that were solved for, without problem and solution.

    Other parameters as :func:`pattern_problem`.
    """
    growth = _growth(mesh, field, spacing, rows)
    if branching < 1:
        growth, _, _ = _pose_pattern(mesh, field, spacing, rows, mirrors, branching)
    return Pattern(growth, None, None, phases)


def _growth(mesh, field, spacing, rows):
    """The :class:`TargetOneForm` that is asked for before it is calmed."""
    return widen_strips(TargetOneForm.of(mesh, field, spacing), rows)


def _mirror_links(growth, mirrors):
    count = growth.phase_count * growth.mesh.vertex_count
    return split_links(count, [mirror.phase_links(growth) for mirror in mirrors])
