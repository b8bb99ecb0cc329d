# SPDX-License-Identifier: GPL-3.0-or-later
"""Direction fields: unit tangent vectors up to a turn by 2 pi / symmetry (paper, Sections 3.1 and 3.2).

A field of symmetry n (1 vectors, 2 lines, 4 crosses) is solved as its n-th power: the unit
phase exp(i n a) for a direction at angle a in the vertex's tangent plane.
"""

from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from ..connection import Connection, circle_transports, levi_civita
from ..defects import Defect, disclination_numbers, list_defects
from ..errors import SettingError
from ..geometry import TriangleMesh
from ..graphs import sum_by
from ..matchings import matchings
from ..monitor import Callback
from ..problem import Merged, SynchronizationProblem, Targets, join_targets
from ..settings.surface import SYMMETRY_ORDERS
from ..solve import Options, Solution, solve
from ..solve.warm_start import Follower
from .animation import carry_angles, nearest_representatives, next_solution
from .constraints.groups import contract_groups, drop_contradictions, join_links
from .constraints.rows import Row, direction_targets
from .curl_removal import CurlRemoval, check_share, known_turns, remove_holonomy, remove_varying, surface_circulation
from .evenness import quantiles
from .guidance.curvature import principal_directions
from .guidance.guides import Guide, blend_guides
from .mirror import LEAN, Reflection, add_self_edges, snap_targets, snap_to_plane, split_links

# The largest ratio of the sizes of quads due to flattening, since exact square quads vary tenfold and more on animals'
# legs; and the share of the area at either end that does not count for it.
LARGEST_RATIO, _RARE = 2.5, 0.01


@dataclass(frozen=True)
class DirectionWishes:
    """Guides and constraints of a direction field.

    Attributes
    ----------
    guides : guides and their strengths against the field's own smoothness
    rows : of the constraint list
    mirrors : symmetries of the field
    singularities : share of the curvature's unevenness that is kept, from 0 to 1: fewer disclinations below 1, down to
        the fewest that the surface's topology allows (see :mod:`.curl_removal`)
    pins : triangles and the indices of their disclinations, multiples of 1 / symmetry; 0 for no disclination
    detail : length over which curvature has to vary to turn the directions, 0 for all
    """

    guides: tuple[tuple[Guide, float], ...] = ()
    rows: tuple[Row, ...] = ()
    mirrors: tuple[Reflection, ...] = ()
    singularities: float = 1.0
    pins: tuple[tuple[int, float], ...] = ()
    detail: float = 0.0

    @property
    def corrects(self) -> bool:
        """Whether they change the connection's turns around faces."""
        return self.singularities < 1 or bool(self.pins) or self.detail > 0


@dataclass(frozen=True)
class DirectionField:
    """A direction at every vertex.

    Attributes
    ----------
    symmetry : 1, 2 or 4
    angles : (n,) one representative, radians in the vertices' tangent planes
    solution : None for directions that were given
    problem : solved for, or None
    turn : radians, one or (n,), by which the directions were turned after the solve
    correction : (e,) added to the turns of the powers along edges (see :mod:`.curl_removal`), optional
    scale : one, or (n,) factor on the spacing of quads that keeps them near square
    """

    mesh: TriangleMesh
    symmetry: int
    angles: np.ndarray
    solution: Solution | None = None
    problem: SynchronizationProblem | None = None
    turn: float | np.ndarray = 0.0
    correction: np.ndarray | None = None
    scale: float | np.ndarray = 1.0

    @property
    def vectors(self) -> np.ndarray:
        """(n, 3) unit representatives in space."""
        x, y = self.mesh.tangent_frames
        return np.cos(self.angles)[:, None] * x + np.sin(self.angles)[:, None] * y

    def turned(self, angle: float | np.ndarray) -> Self:
        """The field with every direction turned counterclockwise by an angle in radians."""
        return replace(self, angles=self.angles + angle, turn=self.turn + angle)

    @property
    def without_solution(self) -> "DirectionField":
        """The directions without their problem and solution, which are large."""
        turn, correction, scale = self.turn, self.correction, self.scale
        return DirectionField(self.mesh, self.symmetry, self.angles, turn=turn, correction=correction, scale=scale)

    def flattened(self, share: float, known: np.ndarray | None = None) -> Self:
        """The field with the scale of a metric in which it is parallel except at its disclinations, or a share of it.

        The Levi-Civita connections of conformal metrics differ by the change, across the edges, of the factor's
        logarithm: these changes are the multipliers that remove the curvature, over the symmetry. Sizes vary
        ``LARGEST_RATIO``-fold at most; each piece keeps its number of quads. ``known`` are (e,) turns of the powers
        known from constraints (see :func:`known_turns`).
        """
        mesh = self.mesh
        if share == 0:
            return self
        removal = _remove_curvature(mesh, self.symmetry, self._numbers, known)
        at_faces = mesh.areas * removal.multipliers / self.symmetry
        logarithm = np.bincount(mesh.triangles.ravel(), np.repeat(at_faces, 3), mesh.vertex_count)
        logarithm *= share / (3 * mesh.vertex_masses)
        scale = np.ones(mesh.vertex_count)
        order = np.argsort(mesh.pieces, kind="stable")
        for own in np.split(order, np.flatnonzero(np.diff(mesh.pieces[order])) + 1):  # a free constant for each
            masses = mesh.vertex_masses[own]
            low, high = quantiles(logarithm[own], masses, [_RARE, 1 - _RARE])
            shrunk = min(1.0, np.log(LARGEST_RATIO) / max(high - low, np.finfo(float).tiny))
            factors = np.exp(shrunk * np.clip(logarithm[own] - low, 0, high - low))
            scale[own] = factors * np.sqrt(np.average(factors**-2.0, weights=masses))
        return replace(self, scale=scale)

    @property
    def energy(self) -> float | None:
        """The energy of the directions before they were turned; None for given ones."""
        if self.problem is None:
            return None
        return self.problem.energy(np.exp(1j * self.symmetry * (self.angles - self.turn)))

    @property
    def bending(self) -> float:
        """The energy that the field would have without its correction: what pins and fewer singularities cost."""
        mesh, turns = self.mesh, levi_civita(self.mesh, self.symmetry)
        own = Connection(mesh.vertex_count, mesh.edges, mesh.weights, circle_transports(turns))
        return own.energy(np.exp(1j * self.symmetry * (self.angles - self.turn)))

    def with_phases(self, phases: np.ndarray) -> Self:
        """The field with other phases of the same problem: a variation."""
        return replace(self, angles=np.angle(phases) / self.symmetry + self.turn)

    @property
    def disclinations(self) -> list[Defect]:
        """Defects with index k / symmetry."""
        return list_defects(self.mesh, "disclination", self._numbers, self.symmetry)

    @cached_property
    def _numbers(self) -> np.ndarray:
        """(m,) turns of the field around each triangle, times the symmetry."""
        powers = np.exp(1j * self.symmetry * self.angles)
        return disclination_numbers(self.mesh, powers, self.symmetry, self.correction)

    @property
    def matchings(self) -> np.ndarray:
        """(e,) see :func:`core.matchings.matchings`."""
        return matchings(self.mesh, self.angles, self.symmetry, self.correction)

    @property
    def solver_matchings(self) -> np.ndarray | None:
        """The matchings along :attr:`TriangleMesh.solver_mesh`'s edges; None if problems use the mesh's own edges."""
        solver_mesh = self.mesh.solver_mesh
        own = self.correction is not None or solver_mesh is self.mesh
        return None if own else matchings(solver_mesh, self.angles, self.symmetry)


@dataclass(frozen=True)
class SolvedField(DirectionField):
    """A direction field with the problem that it solves."""

    solution: Solution
    problem: SynchronizationProblem


def direction_problem(
    mesh: TriangleMesh, symmetry: int, wishes: DirectionWishes | None = None
) -> SynchronizationProblem:
    """The synchronization problem of a direction field; arguments as :func:`direction_field`."""
    return _pose_directions(mesh, symmetry, DirectionWishes() if wishes is None else wishes)[0]


def _pose_directions(
    mesh: TriangleMesh, symmetry: int, wishes: DirectionWishes
) -> tuple[SynchronizationProblem, np.ndarray | None, np.ndarray | None]:
    """The problem, the turns known from constraints, and the correction of the connection; both None without one."""
    if symmetry not in SYMMETRY_ORDERS.values():
        raise SettingError(f"symmetry {symmetry!r} is unknown: use 1 (vector), 2 (line) or 4 (cross)")
    check_share(wishes.singularities, "singularities")
    solver_mesh = _solver_mesh(mesh, wishes)
    turns = levi_civita(solver_mesh, symmetry)
    connection = Connection(mesh.vertex_count, solver_mesh.edges, solver_mesh.weights, circle_transports(turns))
    fixed, soft, gives_way = direction_targets(mesh, symmetry, wishes.rows)
    links, loops = split_links(mesh.vertex_count, [mirror.direction_links(symmetry) for mirror in wishes.mirrors])
    fixed = drop_contradictions(fixed, gives_way, join_links([links, loops]), LEAN * symmetry)
    fixed = snap_targets(fixed, loops, LEAN * symmetry)
    fixed, merged = contract_groups(mesh.vertex_count, links, fixed, LEAN * symmetry)
    if wishes.guides:
        guides, strengths = zip(*wishes.guides, strict=True)
        values, weights = blend_guides(guides, strengths, symmetry)
        weights[fixed.nodes] = 0
        nodes = np.flatnonzero(weights > 0)
        soft.append(Targets(nodes, values[nodes], weights[nodes]))
    known = correction = None
    if wishes.corrects:
        known = known_turns(connection, fixed, merged)
        correction = _correction(mesh, symmetry, wishes, known)
        connection = replace(connection, transports=circle_transports(turns + correction))
    turns_of = partial(_curl_removing_turns, mesh, wishes, symmetry, connection, fixed, merged)
    calmer = turns_of if wishes.singularities > 0 else None
    connection = add_self_edges(connection, loops)
    problem = SynchronizationProblem(connection, solver_mesh.vertex_masses, merged, fixed, join_targets(soft), calmer)
    return problem, known, correction


def _solver_mesh(mesh: TriangleMesh, wishes: DirectionWishes) -> TriangleMesh:
    """The mesh of the problem; corrections are given along the mesh's own edges."""
    return mesh if wishes.corrects else mesh.solver_mesh


def _curl_removing_turns(
    mesh: TriangleMesh, wishes: DirectionWishes, symmetry: int, connection: Connection, fixed: Targets, merged: Merged
) -> np.ndarray:
    """(e,) radians, approximate turns that remove the curvature, of which the connection has a share."""
    mesh = _solver_mesh(mesh, wishes)
    known = known_turns(connection, fixed, merged)
    circulation, _ = surface_circulation(mesh, np.zeros(len(mesh.edges), int))
    holonomy = wishes.singularities * symmetry * mesh.face_curvatures
    return remove_holonomy(circulation, holonomy, mesh.weights, known, rough=True).correction


def _correction(mesh: TriangleMesh, symmetry: int, wishes: DirectionWishes, known: np.ndarray | None) -> np.ndarray:
    """(e,) radians, turns of the powers along the edges that remove a share of the singularities and impose the pins.

    Around a pinned triangle the connection turns as much as the disclination, which then costs nothing there; on a
    closed piece, the difference is spread over the whole piece.

    Raises :class:`SettingError` for an unknown triangle, an impossible index, or pins on one side of a mirror.
    """
    correction = np.zeros(len(mesh.edges))
    if wishes.singularities < 1:
        correction += (1 - wishes.singularities) * _remove_curvature(mesh, symmetry, 0, known).correction
    circulation, _ = surface_circulation(mesh, np.zeros(len(mesh.edges), int))
    if wishes.detail > 0:
        if known is not None:
            correction = np.where(np.isnan(known), correction, known)
        curvature = symmetry * mesh.face_curvatures + circulation.matrix @ correction
        correction += remove_varying(circulation, curvature, mesh.weights, wishes.detail, known)
    if not wishes.pins:
        return correction
    if not all(mirror.has_image_of_each(mesh, wishes.pins) for mirror in wishes.mirrors):
        raise SettingError("pins hold one side of a mirror alone: pin both sides, or remove the mirror")
    curvature = symmetry * mesh.face_curvatures + circulation.matrix @ correction
    asked = np.zeros(mesh.triangle_count)
    for triangle, index in wishes.pins:
        if not 0 <= triangle < mesh.triangle_count:
            raise SettingError(f"there is no triangle {triangle}: the mesh has {mesh.triangle_count}, from 0 on")
        if not np.isclose(symmetry * index, np.rint(symmetry * index)):
            raise SettingError(f"the index {index} of a pin is impossible: use a multiple of {1 / symmetry:g}")
        asked[triangle] = curvature[triangle] - 2 * np.pi * np.rint(symmetry * index)
    known = None if known is None else known - correction
    correction += remove_holonomy(circulation, asked, mesh.weights, known).correction
    return correction


def _remove_curvature(
    mesh: TriangleMesh, symmetry: int, numbers: np.ndarray | int, known: np.ndarray | None
) -> CurlRemoval:
    """The correction that makes powers of directions parallel up to turns by 2 pi numbers (m,) around triangles."""
    circulation, _ = surface_circulation(mesh, np.zeros(len(mesh.edges), int))
    holonomy = symmetry * mesh.face_curvatures - 2 * np.pi * numbers
    return remove_holonomy(circulation, holonomy, mesh.weights, known)


def direction_field(
    mesh: TriangleMesh,
    symmetry: int,
    wishes: DirectionWishes | None = None,
    options: Options | None = None,
    callback: Callback | None = None,
    before: DirectionField | None = None,
    follower: Follower | None = None,
    start: np.ndarray | None = None,
) -> SolvedField:
    """The smoothest direction field that follows the wishes.

    Parameters
    ----------
    mesh : checked
    symmetry : 1, 2 or 4
    options, callback : see :func:`core.solve.solve`
    before : field on another shape of the mesh, optional: the result is then the field that descent reaches from
        there, with the nearest representatives (see :mod:`.animation`)
    follower : takes only some steps from there, optional
    start : (n,) radians, optional: without a field before, the whole solve starts from these directions
    """
    wishes = DirectionWishes() if wishes is None else wishes
    problem, known, correction = _pose_directions(mesh, symmetry, wishes)
    carried = start
    if before is None:
        solution = solve(problem, options, callback, None if start is None else np.exp(1j * symmetry * start))
    else:
        carried = carry_angles(before.angles - before.turn, before.mesh, mesh)
        solution = next_solution(problem, np.exp(1j * symmetry * carried), options, callback, follower=follower)
    _, loops = split_links(mesh.vertex_count, [mirror.direction_links(symmetry) for mirror in wishes.mirrors])
    solution = snap_to_plane(problem, solution, loops)
    angles = np.angle(solution.phases) / symmetry
    if carried is not None:
        angles = nearest_representatives(angles, carried, symmetry)
    field = SolvedField(mesh, symmetry, angles, solution, problem, correction=correction)
    return field.flattened(1 - wishes.singularities, known)


def known_directions(mesh: TriangleMesh, symmetry: int, vectors: ArrayLike, wishes: DirectionWishes) -> DirectionField:
    """The field of (n, 3) vectors, solved before with the same wishes, without problem and solution.

    Errors as :func:`given_directions`.
    """
    field = given_directions(mesh, symmetry, vectors)
    if not wishes.corrects:
        return field
    _, known, correction = _pose_directions(mesh, symmetry, wishes)
    return replace(field, correction=correction).flattened(1 - wishes.singularities, known)


def given_directions(mesh: TriangleMesh, symmetry: int, vectors: ArrayLike) -> DirectionField:
    """A field from (n, 3) vectors, projected to the tangent planes.

    Raises :class:`SettingError` naming the first vertex whose vector has no tangential part.
    """
    vectors = np.asarray(vectors, float)
    tangent = mesh.tangent_numbers(vectors)
    lengths = np.linalg.norm(vectors, axis=1)
    bad = ~(np.abs(tangent) > 1e-6 * lengths) | ~np.isfinite(lengths)
    bad[mesh.loose_vertices] = False
    if bad.any():
        raise SettingError(
            f"the guidance vector of vertex {np.flatnonzero(bad)[0]} ({bad.sum()} in all) is zero or "
            "points straight out of the surface: give it a tangential direction"
        )
    return DirectionField(mesh, symmetry, np.angle(tangent))


def along_curvature(field: DirectionField) -> DirectionField:
    """The field with its free pieces turned to agree best with the principal directions.

    Without constraints a turn of all phases by the same angle costs no energy. Edges along the principal directions
    bend least, and so do faces between them.
    """
    assert field.problem is not None
    mesh, problem = field.mesh, field.problem
    is_free = np.ones(mesh.pieces.max() + 1, bool)
    for nodes in (problem.fixed.nodes, problem.drawn.nodes, problem.merged.nodes):
        is_free[mesh.pieces[nodes]] = False
    values, weights = principal_directions(mesh, field.symmetry)
    wanted = weights * values * np.exp(-1j * field.symmetry * field.angles)
    totals = sum_by(mesh.pieces, wanted)
    turns = np.where(is_free, np.angle(totals), 0.0) / field.symmetry
    return field.turned(turns[mesh.pieces])
