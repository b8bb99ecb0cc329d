# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers in a solid: evenly spaced sheets across given directions, flush with chosen surfaces (paper, Section 3.4)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ..connection import Connection, circle_transports
from ..errors import SettingError
from ..geometry.tet_mesh import TetMesh
from ..graphs import components
from ..interpolate import TURN, EdgePhases
from ..interpolate_solid import TetPhases, face_numbers, tet_phases
from ..monitor import Callback
from ..problem import Merged, SynchronizationProblem, Targets
from ..refinement.spacing import check_spacing
from ..solve import Options, Solution, solve
from .constraints.groups import Links, contract_groups, fixed_phases, join_links
from .curl_removal import check_share, close_changes, known_turns
from .evenness import quantiles
from .guidance.potentials import potential

# Share of the volume at either end that does not count for the thinnest and thickest layers, as single extremes.
RARE = 0.01


@dataclass(frozen=True)
class LayerGroup:
    """Surfaces on which the phase of the layers is constant, so that layers follow them.

    Attributes
    ----------
    vertices : (k,) their vertices, ascending
    triangles : (f, 3) vertices of their triangles
    phase : radians, or (k,) of them; None for a free phase, one for each connected piece of the triangles
    name : for messages
    """

    vertices: np.ndarray
    triangles: np.ndarray
    phase: float | np.ndarray | None = None
    name: str = "the group"

    @property
    def sides(self) -> np.ndarray:
        """(3 f, 2) ends of the triangles' sides."""
        return self.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)

    @property
    def links(self) -> Links:
        """Links from the first vertex of each piece to the others."""
        count = len(self.vertices)
        pieces = components(count, np.searchsorted(self.vertices, self.sides))
        roots = self.vertices[np.unique(pieces, return_index=True)[1][pieces]]
        names = np.full(count, self.name, object)
        return Links(roots, self.vertices, np.zeros(count), np.zeros(count, bool), names)


@dataclass(frozen=True)
class SolidTargetOneForm:
    """The target for the phase of layers, and its connection (Eq. 6).

    Attributes
    ----------
    rates : (n, 3) phase per unit length: 2 pi / spacing, in the direction across the layers
    correction : (e,) added to the changes to remove curl (see :mod:`.curl_removal`), optional
    """

    mesh: TetMesh
    rates: np.ndarray
    correction: np.ndarray | None = None

    @classmethod
    def of(cls, mesh: TetMesh, directions: ArrayLike, spacing: ArrayLike) -> "SolidTargetOneForm":
        """From (n, 3) unit vectors, zero for no change, and a spacing in the solid's units or (n,) of them."""
        directions = np.asarray(directions, float)
        if directions.shape != mesh.vertices.shape or not np.isfinite(directions).all():
            raise SettingError(
                f"the directions of the solid have the shape {directions.shape}: "
                f"give {mesh.vertex_count} vectors of finite numbers"
            )
        return cls(mesh, directions * (TURN / _check_distances(mesh, spacing))[:, None])

    @cached_property
    def changes(self) -> np.ndarray:
        """(e,) target phase change from the lower to the higher vertex: the trapezoidal rule (Eq. 6), corrected."""
        i, j = self.mesh.edges.T
        changes = 0.5 * np.einsum("ex,ex->e", self.rates[i] + self.rates[j], self.mesh.edge_vectors)
        return changes if self.correction is None else changes + self.correction

    @property
    def connection(self) -> Connection:
        """The connection between the vertices."""
        mesh = self.mesh
        return Connection(mesh.vertex_count, mesh.edges, mesh.weights, circle_transports(self.changes))

    @property
    def coarse_share(self) -> float:
        """Share of the edges along which the phase should turn by more than half a period."""
        return float((np.abs(self.changes) > np.pi).mean())

    def divided(self, count: int) -> "SolidTargetOneForm":
        """The one-form with ``count`` layers in each period."""
        correction = None if self.correction is None else count * self.correction
        return replace(self, rates=count * self.rates, correction=correction)

    def remove_curl(self, share: float, fixed: Targets, merged: Merged) -> "SolidTargetOneForm":
        """The one-form without a share of the curl of its changes.

        At a share of 1 they add up to zero around every triangle. Constraints determine the changes along their edges.
        """
        if share == 0:
            return self
        known = known_turns(self.connection, fixed, merged)
        return replace(self, correction=share * (close_changes(self.mesh, self.changes, known) - self.changes))

    def edge_phases(self, phases: np.ndarray, groups: Sequence[LayerGroup] = ()) -> EdgePhases[TetMesh]:
        """The edge phases of (n,) complex phases, with no change along the triangles of groups."""
        asked = self.changes.copy()
        for group in groups:
            asked[self.mesh.edges_between(*group.sides.T)] = 0
        return EdgePhases[TetMesh].of(self.mesh, phases[:, None], asked[:, None], np.zeros(len(asked), int))


@dataclass(frozen=True)
class Spacings:
    """Distances between layers over the solid's volume: 2 pi / |grad theta|.

    Tetrahedra punctured by a dislocation curve do not count, nor those in which the distance would exceed the size of
    the solid.

    Attributes
    ----------
    mean, deviation : lengths
    thinnest, thickest : lengths; 1 % of the counted volume is thinner, and 1 % thicker
    counted : share of the volume; where layers end inside, of the rays that mean and extremes are measured along
    distances : (m,) in each tetrahedron, nan where it does not count
    """

    mean: float
    deviation: float
    thinnest: float
    thickest: float
    counted: float
    distances: np.ndarray


@dataclass(frozen=True)
class LayerPattern:
    """Phases at the vertices of a solid, with their changes along edges; layers lie at multiples of 2 pi."""

    mesh: TetMesh
    solution: Solution
    edge_phases: EdgePhases[TetMesh]

    @property
    def vertex_phases(self) -> np.ndarray:
        """(n,) radians."""
        return self.edge_phases.arguments[:, 0]

    @cached_property
    def face_numbers(self) -> np.ndarray:
        """(f,) dislocation numbers of the faces, along their vertices in increasing order."""
        return face_numbers(self.edge_phases)

    @cached_property
    def tet_phases(self) -> TetPhases:
        """The data with which the phase is evaluated anywhere."""
        return tet_phases(self.edge_phases)

    @cached_property
    def heights(self) -> np.ndarray:
        """(n,) radians, height of each vertex in the stack of layers, 0 at the lowest vertex of each piece.

        It is the function whose changes along edges are nearest to those of the phase; it has no dislocations.
        """
        return potential(self.mesh, self.edge_phases.changes[:, 0])

    def divided(self, count: int) -> "LayerPattern":
        """The pattern with ``count`` layers in each period: its phase times that number, dislocations too."""
        phases = self.edge_phases
        return replace(
            self, edge_phases=replace(phases, arguments=count * phases.arguments, changes=count * phases.changes)
        )

    def start_half_a_layer_up(self, groups: Sequence[LayerGroup]) -> "LayerPattern":
        """The pattern with the phase moved so that the first layer of each piece of the solid lies half a layer above
        its lowest vertex; pieces with a group of given phase stay as they are."""
        pieces, phases = self.mesh.pieces, self.edge_phases
        order = np.argsort(self.heights, kind="stable")
        _, first = np.unique(pieces[order], return_index=True)
        move = np.pi - phases.arguments[order[first]]
        for group in groups:
            if group.phase is not None:
                move[pieces[group.vertices]] = 0
        return replace(self, edge_phases=replace(phases, arguments=phases.arguments + move[pieces]))

    @property
    def spacings(self) -> Spacings:
        """Statistics of the distances between the layers."""
        steepness = np.linalg.norm(self.tet_phases.gradients(self.mesh), axis=1)
        extent = np.linalg.norm(np.ptp(_places(self.mesh), axis=0))
        counts = ~self.tet_phases.punctured & (steepness > TURN / extent)
        distances = np.full(self.mesh.tet_count, np.nan)
        distances[counts] = TURN / steepness[counts]
        if not counts.any():
            return Spacings(np.nan, np.nan, np.nan, np.nan, 0.0, distances)
        met, volumes = distances[counts], self.mesh.volumes[counts]
        mean = np.average(met, weights=volumes)
        deviation = np.sqrt(np.average((met - mean) ** 2, weights=volumes))
        thinnest, thickest = quantiles(met, volumes, [RARE, 1 - RARE])
        share = volumes.sum() / self.mesh.volumes.sum()
        return Spacings(float(mean), float(deviation), float(thinnest), float(thickest), float(share), distances)


def choose_levels(one_form: SolidTargetOneForm, groups: Sequence[LayerGroup], divisions: int) -> list[LayerGroup]:
    """Choose levels for groups of given phase among the ``divisions`` layers of a period of the one-form.

    The first connected piece of a group keeps its level; for each other piece the level that fits the one-form best is
    chosen, so that the top of a fin and that of the block beside it lie on layers of their own.
    """
    if divisions == 1:
        return list(groups)
    mesh, names, places = one_form.mesh, np.arange(one_form.mesh.vertex_count), {}
    sides = mesh.boundary_triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    for number, group in enumerate(groups):
        if group.phase is not None:
            is_member = np.isin(np.arange(mesh.vertex_count), group.vertices)
            labels = components(mesh.vertex_count, sides[is_member[sides].all(axis=1)])[group.vertices]
            _, first, piece = np.unique(labels, return_index=True, return_inverse=True)
            places[number] = group.vertices[first], piece.reshape(-1)
            names[group.vertices] = group.vertices[first][places[number][1]]
    if not places:
        return list(groups)
    # Each piece lies on one level, to which the one-form is fitted.
    names = np.unique(names, return_inverse=True)[1].reshape(-1)
    function, start = divisions * potential(mesh, one_form.changes, names), None
    chosen = list(groups)
    for number, (firsts, piece) in places.items():
        heights = function[firsts] - groups[number].phase
        start = heights[0] if start is None else start
        levels = np.rint((heights - start) / TURN)[piece]
        chosen[number] = replace(groups[number], phase=(groups[number].phase + TURN * levels) / divisions)
    return chosen


def solve_layers(
    mesh: TetMesh,
    directions: ArrayLike,
    spacing: ArrayLike,
    groups: Sequence[LayerGroup] = (),
    options: Options | None = None,
    callback: Callback | None = None,
    branching: float = 1.0,
) -> LayerPattern:
    """Solve for layers; errors as :func:`pose_layers`.

    Parameters
    ----------
    directions : (n, 3) unit vectors across the layers (:mod:`core.fields.guidance.solids`)
    spacing : distance between layers in the solid's units, or (n,) one at each vertex
    groups : surfaces that layers follow; the boundary is free elsewhere
    options, callback : see :func:`core.solve.solve`
    branching : share of the target one-form's curl that is kept, from 0 to 1: the less, the fewer and shorter the
        curves where layers branch, and the more the distances vary (see :mod:`.curl_removal`)
    """
    return solve_one_form(SolidTargetOneForm.of(mesh, directions, spacing), groups, options, callback, branching)


def solve_one_form(
    one_form: SolidTargetOneForm,
    groups: Sequence[LayerGroup] = (),
    options: Options | None = None,
    callback: Callback | None = None,
    branching: float = 1.0,
) -> LayerPattern:
    """Solve for layers that follow a target one-form."""
    one_form, problem = pose_layers(one_form, groups, branching)
    options = replace(Options() if options is None else options, integrate=True)
    solution = solve(problem, options, callback)
    return LayerPattern(one_form.mesh, solution, one_form.edge_phases(solution.phases, groups))


def pose_layers(
    one_form: SolidTargetOneForm, groups: Sequence[LayerGroup], branching: float
) -> tuple[SolidTargetOneForm, SynchronizationProblem]:
    """The one-form with a share of its curl, and its problem; arguments as :func:`solve_layers`.

    Raises SettingError for a share out of range, and ContradictionError where groups ask for different phases.
    """
    check_share(branching, "branching")
    mesh = one_form.mesh
    links = join_links([group.links for group in groups if group.phase is None])
    given = [
        (group.name, group.vertices, np.exp(1j * np.broadcast_to(group.phase, len(group.vertices))))
        for group in groups
        if group.phase is not None
    ]
    fixed = fixed_phases(given, "take them out of one of the groups")
    fixed, merged = contract_groups(mesh.vertex_count, links, fixed)
    one_form = one_form.remove_curl(1 - branching, fixed, merged)
    return one_form, SynchronizationProblem(one_form.connection, mesh.vertex_masses, merged, fixed)


def _places(mesh: TetMesh) -> np.ndarray:
    """Positions of the vertices that have a tetrahedron."""
    return mesh.vertices[np.unique(mesh.tets)]


def _check_distances(mesh: TetMesh, spacing: ArrayLike) -> np.ndarray:
    """(n,) distances; refuses those that no layer fits."""
    spacing = np.asarray(spacing, float)
    if spacing.shape not in ((), (mesh.vertex_count,)):
        raise SettingError(
            f"{spacing.size} spacings are given for {mesh.vertex_count} vertices: give one, or one for each vertex"
        )
    check_spacing(_places(mesh), spacing, "layer")
    return np.broadcast_to(spacing, mesh.vertex_count)
