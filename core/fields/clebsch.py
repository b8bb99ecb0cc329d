# SPDX-License-Identifier: GPL-3.0-or-later
"""Clebsch maps of a flow: vortex filaments of equal strength, and tubes (paper, Sections 3.6 and 4.6).

A phase with d theta = velocity / hbar exists only up to vortex filaments, each of which carries the circulation
h = 2 pi hbar. Two complex numbers, a point of the sphere S^3, need no filaments: their Hopf map to S^2 shows vortex
tubes, and each of their projections is a map with filaments again.
"""

import time
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from ..connection import Connection, circle_transports
from ..defects import wrap
from ..errors import SettingError, name_elements
from ..geometry.grid import Grid
from ..geometry.surface import Surface
from ..geometry.triangle_mesh import TriangleMesh
from ..graphs import components
from ..interpolate import TURN
from ..monitor import Callback
from ..problem import Merged, SynchronizationProblem
from ..solve import Options, Solution, solve
from ..solve.lifted import lifted_of_rank

# The most filaments through a face on average: phases at two corners do not distinguish turns of more than a half.
MOST_QUANTA = 0.5
TINY = np.finfo(float).tiny


def edge_integrals(grid: Grid | Surface, velocity: ArrayLike) -> np.ndarray:
    """(e,) integrals of a velocity along the edges, by the trapezoidal rule.

    The velocity is (n, d) at the nodes; on a surface (n, 3), whose tangential part counts. Raises SettingError for
    another shape, or values that are not finite, naming the first node.
    """
    velocity = np.asarray(velocity, float)
    if isinstance(grid, Surface):
        return _surface_integrals(grid.mesh, velocity)
    if velocity.shape != (grid.node_count, grid.dimension):
        raise SettingError(
            f"velocities of the shape {velocity.shape} on a grid of {grid.node_count} nodes in {grid.dimension} "
            "dimensions: give one vector a node"
        )
    bad = ~np.isfinite(velocity).all(axis=1)
    if bad.any():
        place = np.unravel_index(np.flatnonzero(bad)[0], grid.shape)
        raise SettingError(
            f"the velocity at node {tuple(int(p) for p in place)} ({bad.sum()} in all) is not a number: "
            "fill or crop the grid"
        )
    axes = grid.edge_axes
    i, j = grid.edges.T
    return 0.5 * grid.spacing[axes] * (velocity[i, axes] + velocity[j, axes])


def _surface_integrals(mesh: TriangleMesh, velocity: np.ndarray) -> np.ndarray:
    """(e,) integrals of (n, 3) velocities along a surface's edges, from the tangent planes at both ends."""
    if velocity.shape != mesh.vertices.shape:
        raise SettingError(
            f"velocities of the shape {velocity.shape} on {mesh.vertex_count} vertices: give three numbers a vertex"
        )
    bad = np.flatnonzero(~np.isfinite(velocity).all(axis=1))
    if len(bad):
        raise SettingError(f"the velocity at {name_elements('vertex', bad)} is not a number: give finite vectors")
    numbers = mesh.tangent_numbers(velocity)
    i, j = mesh.edges.T
    at_tail, at_head = (numbers[[i, j]] * np.exp(-1j * mesh.edge_directions.T)).real
    return 0.5 * mesh.edge_lengths * (at_tail - at_head)


def circulations(grid: Grid | Surface, integrals: np.ndarray) -> np.ndarray:
    """(f,) circulation around each face: the flux of the vorticity through it."""
    return sum(sign * integrals[edge] for sign, edge in zip(grid.face_signs.T, grid.face_edges.T, strict=True))


def mean_circulation(grid: Grid | Surface, integrals: np.ndarray) -> float:
    """Mean of the absolute circulations around the faces that the flow reaches."""
    reached = grid.face_signs.any(axis=1)
    return float(np.abs(circulations(grid, integrals)[reached]).mean())


def faces_of_filament(grid: Grid | Surface, integrals: np.ndarray, quantum: float) -> float:
    """Number of faces over which the circulation of a filament is spread, a mean over the vorticity."""
    reached = grid.face_signs.any(axis=1)
    around = np.abs(circulations(grid, integrals)[reached])
    return float(quantum * around.sum() / (around**2).sum())


def quantum_for(grid: Grid | Surface, integrals: np.ndarray, count: float) -> float:
    """The circulation h of a filament for about ``count`` filaments through the plane with most vorticity, in the
    direction in which more pass; SettingError for a flow without vorticity."""
    largest = layer_sums(grid, circulations(grid, integrals))
    if largest <= 1e-9 * np.abs(integrals).sum():  # rounding errors
        raise SettingError("the flow has no vorticity: there are no vortices to show")
    return largest / count


def layer_sums(grid: Grid | Surface, fluxes: np.ndarray) -> float:
    """The largest sum of the (f,) numbers of one sign on a plane of the grid."""
    layers = grid.face_layers if isinstance(grid, Grid) and grid.dimension == 3 else np.zeros(len(fluxes), int)
    return max(np.bincount(layers, np.maximum(way, 0)).max(initial=0) for way in (fluxes, -fluxes))


def clebsch_problem(grid: Grid | Surface, integrals: np.ndarray, quantum: float) -> SynchronizationProblem:
    """The synchronization problem of maps whose filaments carry the circulation ``quantum`` (Eq. 13); SettingError for
    one that is not positive, or with more than ``MOST_QUANTA`` filaments through a face on average."""
    if not (np.isfinite(quantum) and quantum > 0):
        raise SettingError(f"the circulation of a filament is {quantum}: give a positive one")
    mean = mean_circulation(grid, integrals)
    if not mean <= MOST_QUANTA * quantum:
        raise SettingError(
            f"filaments of the circulation {quantum:.3g} are too many for the grid, {mean / quantum:.3g} for each of "
            f"its faces: give a circulation from {1.005 * mean / MOST_QUANTA:.3g} on, or a finer grid"
        )
    reached = grid.weights > 0
    transports = circle_transports(TURN / quantum * integrals[reached])
    connection = Connection(grid.node_count, grid.edges[reached], grid.weights[reached], transports)
    return SynchronizationProblem(connection, grid.masses, _merge_seam_sides(grid))


def _merge_seam_sides(grid: Grid | Surface) -> Merged | None:
    """Merge both sides of the seam of a one-sided surface: the phase of a velocity does not depend on the side."""
    if not isinstance(grid, Surface) or grid.seam is None:
        return None
    labels = components(grid.node_count, grid.seam)
    roots = np.unique(labels, return_index=True)[1][labels]
    nodes = np.flatnonzero(roots != np.arange(grid.node_count))
    return Merged(nodes, roots[nodes], np.ones(len(nodes), complex))


@dataclass(frozen=True)
class ClebschMap:
    """A map to the circle, with vortex filaments.

    Attributes
    ----------
    integrals : (e,) of the velocity along the edges
    quantum : circulation of one filament
    phases : (n,) complex, the solution's or others (:meth:`with_phases`)
    """

    grid: Grid | Surface
    integrals: np.ndarray
    quantum: float
    problem: SynchronizationProblem
    options: Options
    solution: Solution
    phases: np.ndarray

    @property
    def regular_grid(self) -> Grid:
        """The grid of a map that is not on a surface."""
        assert isinstance(self.grid, Grid)
        return self.grid

    @property
    def energy(self) -> float:
        """The energy of the phases."""
        return self.problem.energy(self.phases)

    def with_phases(self, phases: np.ndarray) -> "ClebschMap":
        """The map with other phases of the same problem."""
        return replace(self, phases=phases)

    @property
    def lean(self) -> "ClebschMap":
        """The map without data that only its solve needs."""
        solution = replace(self.solution, lifted=None, variations=self.solution.phases[None])
        problem = clebsch_problem(self.grid, self.integrals, self.quantum)
        return replace(self, problem=problem, solution=solution)

    @cached_property
    def vorticity(self) -> float:
        """Sum of the absolute circulations around all faces."""
        return float(np.abs(circulations(self.grid, self.integrals)).sum())

    @cached_property
    def changes(self) -> np.ndarray:
        """(e,) phase change along each edge, the one nearest to the flow's."""
        i, j = self.grid.edges.T
        asked = TURN / self.quantum * self.integrals
        arguments = np.angle(self.phases)
        return asked + wrap(arguments[j] - arguments[i] - asked)

    @cached_property
    def face_numbers(self) -> np.ndarray:
        """(f,) signed number of filaments through each face; the sum over a cell is zero."""
        return np.rint(circulations(self.grid, self.changes) / TURN).astype(int)

    @cached_property
    def face_shares(self) -> np.ndarray:
        """(f,) share of the vorticity that a filament along a face's normal carries there; negative against the
        flow."""
        return self.quantum * np.sign(circulations(self.grid, self.integrals)) / max(self.vorticity, TINY)

    @property
    def vorticity_share(self) -> float | None:
        """Share of the flow's vorticity that the filaments carry, less what they carry against it; None if there is
        none."""
        return float(self.face_numbers @ self.face_shares) if self.vorticity else None


@dataclass(frozen=True)
class SphericalMap:
    """A map to the sphere S^3 in two complex dimensions, without filaments, and with it a map to S^2.

    Attributes
    ----------
    found : the map whose relaxation it comes from
    lifted : (n, 2) complex, unit rows
    energy : of the lifted problem (Eq. 16 at epsilon 1), not below the relaxation's bound
    seconds : of the solve
    """

    found: ClebschMap
    lifted: np.ndarray
    energy: float
    seconds: float

    @cached_property
    def sphere(self) -> np.ndarray:
        """(n, 3) unit vectors, the Hopf map: vortex tubes surround the places where it meets a point."""
        first, second = self.lifted.T
        both = 2 * first.conj() * second
        return np.column_stack([both.real, both.imag, np.abs(first) ** 2 - np.abs(second) ** 2])

    def seen_from(self, point: ArrayLike) -> ClebschMap:
        """The map to the circle whose filaments are where the map to S^2 meets the antipode of a point."""
        x, y, z = np.asarray(point, float) / np.linalg.norm(point)
        # Project on a pair of complex numbers whose Hopf image is the point.
        theta, phi = np.arccos(np.clip(z, -1, 1)), np.arctan2(y, x)
        direction = np.array([np.cos(theta / 2), np.exp(1j * phi) * np.sin(theta / 2)])
        values = self.lifted @ direction.conj()
        lengths = np.abs(values)
        return self.found.with_phases(np.where(lengths > 0, values / np.where(lengths > 0, lengths, 1), 1))

    @cached_property
    def face_areas(self) -> np.ndarray:
        """(f,) signed area of S^2 that the map covers on each face, over 4 pi: its vorticity in quanta."""
        first, *others = np.moveaxis(self.sphere[self.found.grid.faces], 1, 0)
        return np.sum([_solid_angles(first, b, c) for b, c in pairwise(others)], axis=0) / (4 * np.pi)


def spherical_map(found: ClebschMap, callback: Callback | None = None, is_rough: bool = False) -> SphericalMap:
    """Solve the relaxation of a map at rank 2, within the rest of its time limit; roughly where only filaments are
    seen from its points."""
    begin = time.perf_counter()
    problem = found.problem
    coordinates = lifted_of_rank(problem, found.solution, 2, found.options, callback, is_rough=is_rough)
    lifted = np.column_stack([problem.expand(column) for column in coordinates.T])
    energy = sum(problem.connection.energy(column) for column in lifted.T)
    return SphericalMap(found, lifted, energy, time.perf_counter() - begin)


def _solid_angles(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """(k,) signed solid angles of spherical triangles of unit vectors (van Oosterom and Strackee 1983)."""
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    dots = [np.einsum("ij,ij->i", u, v) for u, v in ((a, b), (b, c), (c, a))]
    return 2 * np.arctan2(volume, 1 + sum(dots))


def clebsch_map(
    grid: Grid | Surface,
    integrals: np.ndarray,
    quantum: float,
    options: Options | None = None,
    callback: Callback | None = None,
    start: Solution | None = None,
) -> ClebschMap:
    """Solve for the map of a flow with (e,) integrals along the edges (:func:`edge_integrals`).

    The quantum is the circulation of one filament; options, callback and start are those of :func:`core.solve.solve`.
    """
    options = Options() if options is None else options
    problem = clebsch_problem(grid, integrals, quantum)
    solution = solve(problem, options, callback, start)
    return ClebschMap(grid, integrals, quantum, problem, options, solution, solution.phases)
