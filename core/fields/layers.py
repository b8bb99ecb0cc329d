# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers in a solid: evenly spaced sheets across given directions, flush with chosen surfaces (paper, Section 3.4)."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..connection import Connection, circle_transports
from ..errors import SettingError
from ..geometry.tet_mesh import TetMesh
from ..graphs import components
from ..interpolate import TURN, EdgePhases
from ..interpolate_solid import TetPhases, face_numbers, tet_phases
from ..problem import SynchronizationProblem
from ..solve import Solution, solve
from .constraints.groups import Links, contract_groups, fixed_phases, join_links
from .curl_removal import check_share, close_changes, known_turns
from .evenness import quantiles
from .guidance.potentials import potential
from .patterns import check_spacing

# Share of the volume on either side that does not tell how thin or thick layers are: single tetrahedra are extreme.
_RARE = 0.01


@dataclass(frozen=True)
class LayerGroup:
    """Surfaces that a layer follows.

    Attributes
    ----------
    vertices : (k,) indices of those that share a phase, ascending
    triangles : (f, 3) faces among them, over which the phase does not change
    phase : radians; None for a phase that is left to the solver, one for each connected piece of the triangles
    name : what messages call the group
    """

    vertices: np.ndarray
    triangles: np.ndarray
    phase: float | None = None
    name: str = "the group"

    @classmethod
    def of_vertices(cls, mesh, chosen, phase=None, name="the group"):
        """Triangles with three chosen corners: of the boundary, and inner ones not all of whose corners lie on it.

        Parameters
        ----------
        mesh : TetMesh
        chosen : (n,) bool
        """
        chosen = np.asarray(chosen, bool)
        if chosen.shape != (mesh.vertex_count,):
            raise SettingError(
                f"{name} has {chosen.size} values and the solid {mesh.vertex_count} vertices: give each a truth value"
            )
        is_surface = ~mesh.boundary_vertices[mesh.faces].all(axis=1)
        is_surface[mesh.boundary_faces] = True
        return cls(np.flatnonzero(chosen), mesh.faces[is_surface & chosen[mesh.faces].all(axis=1)], phase, name)

    @property
    def sides(self):
        """(3 f, 2) ends of the triangles' sides."""
        return self.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)

    @property
    def links(self):
        """Every vertex follows the first one of its piece."""
        count = len(self.vertices)
        pieces = components(count, np.searchsorted(self.vertices, self.sides))
        roots = self.vertices[np.unique(pieces, return_index=True)[1][pieces]]
        names = np.full(count, self.name, object)
        return Links(roots, self.vertices, np.zeros(count), np.zeros(count, bool), names)


@dataclass(frozen=True)
class SolidTargetOneForm:
    """Where the phase of layers should grow, and the connection that asks for it (Eq. 6).

    Attributes
    ----------
    mesh : TetMesh
    rates : (n, 3) phase per unit length: 2 pi / spacing, in the direction in which the layers follow one another
    correction : (e,) what is added to the changes to calm them (see :mod:`.curl_removal`); None for nothing
    """

    mesh: TetMesh
    rates: np.ndarray
    correction: np.ndarray | None = None

    @classmethod
    def of(cls, mesh, directions, spacing):
        """From (n, 3) unit vectors, and a spacing in the solid's units or (n,) of them.

        A vector of zero asks for no change there.
        """
        directions = np.asarray(directions, float)
        if directions.shape != mesh.vertices.shape or not np.isfinite(directions).all():
            raise SettingError(
                f"the directions of the solid have the shape {directions.shape}: "
                f"give {mesh.vertex_count} vectors of finite numbers"
            )
        return cls(mesh, directions * (TURN / _check_distances(mesh, spacing))[:, None])

    @cached_property
    def changes(self):
        """(e,) phase change asked for from the lower to the higher vertex: the trapezoidal rule over its ends, before
        it is calmed."""
        i, j = self.mesh.edges.T
        changes = 0.5 * np.einsum("ex,ex->e", self.rates[i] + self.rates[j], self.mesh.edge_vectors)
        return changes if self.correction is None else changes + self.correction

    @property
    def connection(self):
        """:class:`Connection` between the vertices."""
        mesh = self.mesh
        return Connection(mesh.vertex_count, mesh.edges, mesh.weights, circle_transports(self.changes))

    def divided(self, count):
        """The growth with ``count`` layers in each period."""
        correction = None if self.correction is None else count * self.correction
        return replace(self, rates=count * self.rates, correction=correction)

    def calmed(self, share, fixed, merged):
        """The growth without a share of the curl of its changes.

        Parameters
        ----------
        share : from 0, as asked, to 1, changes that add up to nothing around every triangle
        fixed, merged : constraints (Targets, Merged) of the phases, which say what changes along their edges have to be
        """
        if share == 0:
            return self
        known = known_turns(self.connection, fixed, merged)
        return replace(self, correction=share * (close_changes(self.mesh, self.changes, known) - self.changes))

    def edge_phases(self, phases, groups=()):
        """:class:`EdgePhases` of (n,) complex phases; along the triangles of groups nothing changes."""
        asked = self.changes.copy()
        for group in groups:
            asked[self.mesh.edges_between(*group.sides.T)] = 0
        return EdgePhases.of(self.mesh, phases[:, None], asked[:, None], np.zeros(len(asked), int))


@dataclass(frozen=True)
class Spacings:
    """Distances between layers over the solid's volume: 2 pi / |grad theta|.

    Tetrahedra that a dislocation curve punctures do not count, nor those in which the phase changes so little that no
    second layer would fit into the solid.

    Attributes
    ----------
    mean, deviation : lengths
    thinnest, thickest : lengths, where 1 % of the counted volume is thinner, and 1 % thicker
    counted : share of the volume
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
    """Phases at the vertices of a solid; layers are where they are multiples of 2 pi.

    Attributes
    ----------
    mesh : TetMesh
    solution : Solution
    edge_phases : EdgePhases, the phase changes along every edge
    """

    mesh: TetMesh
    solution: Solution
    edge_phases: EdgePhases

    @property
    def vertex_phases(self):
        """(n,) radians."""
        return self.edge_phases.arguments[:, 0]

    @cached_property
    def face_numbers(self):
        """(f,) dislocation numbers of the faces, along their vertices in increasing order."""
        return face_numbers(self.edge_phases)

    @cached_property
    def tet_phases(self) -> TetPhases:
        """What it takes to evaluate the phase anywhere."""
        return tet_phases(self.edge_phases)

    @cached_property
    def heights(self):
        """(n,) position along the growth, in radians, 0 at the lowest place of each piece: the function without
        dislocations whose changes are nearest to the phase's."""
        return potential(self.mesh, self.edge_phases.changes[:, 0])

    def divided(self, count):
        """The pattern with ``count`` layers in each period: its phase times that number, dislocations too."""
        phases = self.edge_phases
        return replace(
            self, edge_phases=replace(phases, arguments=count * phases.arguments, changes=count * phases.changes)
        )

    def rested(self, groups):
        """The pattern with the phase moved so that the first layer of each piece of the solid lies half a layer above
        its lowest place; pieces with groups that hold a phase stay."""
        pieces, phases = self.mesh.pieces, self.edge_phases
        order = np.argsort(self.heights, kind="stable")
        _, first = np.unique(pieces[order], return_index=True)
        move = np.pi - phases.arguments[order[first]]
        for group in groups:
            if group.phase is not None:
                move[pieces[group.vertices]] = 0
        return replace(self, edge_phases=replace(phases, arguments=phases.arguments + move[pieces]))

    @property
    def spacings(self):
        """:class:`Spacings` of the layers."""
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
        thinnest, thickest = quantiles(met, volumes, [_RARE, 1 - _RARE])
        share = volumes.sum() / self.mesh.volumes.sum()
        return Spacings(float(mean), float(deviation), float(thinnest), float(thickest), float(share), distances)


def choose_levels(growth, groups, divisions):
    """Groups that hold phases, on those levels of a divided period that fit the growth best; the first one stays.

    Parameters
    ----------
    growth : SolidTargetOneForm of the whole period
    groups : LayerGroups, with phases of a layer
    divisions : layers in a period
    """
    held = [group for group in groups if group.phase is not None]
    levels = {}
    if divisions > 1 and len(held) > 1:
        function = potential(growth.mesh, growth.changes)
        heights = [divisions * function[group.vertices].mean() - group.phase for group in held]
        levels = {id(group): np.rint((height - heights[0]) / TURN) for group, height in zip(held, heights, strict=True)}
    return [
        group
        if group.phase is None
        else replace(group, phase=(group.phase + TURN * levels.get(id(group), 0)) / divisions)
        for group in groups
    ]


def layer_problem(mesh, directions, spacing, groups=(), branching=1.0):
    """The synchronization problem of layers.

    Parameters
    ----------
    mesh : TetMesh
    directions : (n, 3) unit vectors in which layers follow one another (:mod:`core.fields.guidance.solids`)
    spacing : distance between layers in the solid's units, or (n,) one at each vertex
    groups : LayerGroups; the boundary is free elsewhere
    branching : share of the growth's curl that is asked for, from 0 to 1: fewer and shorter curves where layers branch
        below 1, for distances that vary more (see :mod:`.curl_removal`)

    Raises
    ------
    SettingError
        for directions or spacings that do not fit
    ContradictionError
        where groups ask for different phases
    """
    return pose_layers(SolidTargetOneForm.of(mesh, directions, spacing), groups, branching)[1]


def solve_layers(mesh, directions, spacing, groups=(), options=None, callback=None, branching=1.0):
    """Solve for a :class:`LayerPattern`; arguments as :func:`layer_problem` and :func:`core.solve.solve`."""
    return solve_growth(SolidTargetOneForm.of(mesh, directions, spacing), groups, options, callback, branching)


def solve_growth(growth, groups=(), options=None, callback=None, branching=1.0):
    """The same for a :class:`SolidTargetOneForm`."""
    growth, problem = pose_layers(growth, groups, branching)
    solution = solve(problem, options, callback)
    return LayerPattern(growth.mesh, solution, growth.edge_phases(solution.phases, groups))


def pose_layers(growth, groups, branching):
    """A :class:`SolidTargetOneForm`, calmed, and its problem; arguments and errors as :func:`layer_problem`."""
    check_share(branching, "branching")
    mesh = growth.mesh
    links = join_links([group.links for group in groups if group.phase is None])
    held = [group for group in groups if group.phase is not None]
    fixed = fixed_phases(
        [(group.name, group.vertices, np.full(len(group.vertices), np.exp(1j * group.phase))) for group in held],
        "take them out of one of the groups",
    )
    fixed, merged = contract_groups(mesh.vertex_count, links, fixed)
    growth = growth.calmed(1 - branching, fixed, merged)
    return growth, SynchronizationProblem(growth.connection, mesh.vertex_masses, merged, fixed)


def _places(mesh):
    """Positions of the vertices that have a tetrahedron."""
    return mesh.vertices[np.unique(mesh.tets)]


def _check_distances(mesh, spacing):
    """(n,) distances; refuses those between which no layer fits."""
    spacing = np.asarray(spacing, float)
    if spacing.shape not in ((), (mesh.vertex_count,)):
        raise SettingError(f"{spacing.size} spacings are given for {mesh.vertex_count} vertices: give each one, or one")
    check_spacing(_places(mesh), spacing, "layer")
    return np.broadcast_to(spacing, mesh.vertex_count)
