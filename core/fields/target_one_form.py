# SPDX-License-Identifier: GPL-3.0-or-later
"""The target one-form of a pattern's phases, and its connection (paper, Eq. 6 and Section 3.5).

Stripes have one phase at a vertex and quads two.
"""

from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ..connection import Connection, circle_transports
from ..errors import SettingError
from ..gauge import balance
from ..geometry import TriangleMesh
from ..interpolate import EdgePhases
from ..matchings import after_turns
from ..problem import Merged, Targets
from .curl_removal import known_turns, remove_holonomy, surface_circulation
from .directions import DirectionField

AXES = "XYZ"


@dataclass(frozen=True)
class TargetOneForm:
    """Directions and rates in which the k phases of a vertex grow.

    Attributes
    ----------
    angles : (n,) radians, direction in which the first phase grows; the next ones follow at pi / k
    rates : (n, k) phase per unit length
    matchings : (e,) see :mod:`core.matchings`
    has_signs : whether a phase and its negative differ, as for stripes along a vector field
    correction : (e, k) added to the changes to remove curl (see :mod:`.curl_removal`), optional
    scale : one, or (n,) factor on the size of quads that keeps them near square (see :class:`DirectionField`)
    stretch : one, or (e,) complex factor on edges, whose argument turns them counterclockwise (see
        :mod:`.constraints.strips`)
    solver_matchings : the matchings along the edges of problems, None for the mesh's own
    """

    mesh: TriangleMesh
    angles: np.ndarray
    rates: np.ndarray
    matchings: np.ndarray
    has_signs: bool
    correction: np.ndarray | None = None
    scale: float | np.ndarray = 1.0
    stretch: complex | np.ndarray = 1.0
    solver_matchings: np.ndarray | None = None

    @classmethod
    def of(cls, mesh: TriangleMesh, field: DirectionField, spacing: ArrayLike) -> "TargetOneForm":
        """The one-form across a direction field, so that the lines of the first phase run along it.

        Vectors and lines give one phase a vertex, crosses two. The spacing is the length of a period in the mesh's
        units, or (n,) one at each vertex; for crosses also (n, 2) or (1, 2), one along each of the field's two axes,
        of which the first is nearer to X.
        """
        count = max(1, field.symmetry // 2)
        angles = field.angles + np.pi / 2
        matched = field.matchings
        spacing = np.asarray(spacing, float)
        spacing = spacing if spacing.ndim == 2 else spacing.reshape(-1, 1)
        scale = 1.0 if count == 1 else field.scale
        if count == 1:
            spacing = np.broadcast_to(spacing, (mesh.vertex_count, 1))
        else:
            spacing = spacing * np.reshape(scale, (-1, 1))
            spacing = _on_axes(mesh, angles, matched, np.broadcast_to(spacing, (mesh.vertex_count, count)))
        rates, solver_matchings = 2 * np.pi / spacing, field.solver_matchings
        return cls(mesh, angles, rates, matched, field.symmetry == 1, scale=scale, solver_matchings=solver_matchings)

    def __getstate__(self) -> dict[str, object]:
        """A copy without what can be computed again, for a process that has the mesh."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @property
    def on_solver_edges(self) -> "TargetOneForm":
        """The one-form along the edges of its problem: those of :attr:`TriangleMesh.solver_mesh`, or the mesh's own if
        these have a correction or a stretch."""
        if self.solver_matchings is None or self.correction is not None or np.ndim(self.stretch) > 0:
            return self
        return self._on_other_edges

    @cached_property
    def _on_other_edges(self) -> "TargetOneForm":
        assert self.solver_matchings is not None
        return replace(self, mesh=self.mesh.solver_mesh, matchings=self.solver_matchings, solver_matchings=None)

    @property
    def asked_rates(self) -> np.ndarray:
        """(n, k) phase per unit length by the spacing alone."""
        return self.rates * np.reshape(self.scale, (-1, 1))

    @property
    def phase_count(self) -> int:
        """k, phases at a vertex; phase l of vertex v is node k v + l of the problem."""
        return int(self.rates.shape[1])

    @property
    def turn(self) -> float:
        """Angle between one direction and the next."""
        return np.pi / self.phase_count

    @cached_property
    def changes(self) -> np.ndarray:
        """(e, k) target phase change along each edge, for the phases of its lower vertex, corrected."""
        changes = self._uncorrected_changes
        return changes if self.correction is None else changes + self.correction

    def reaching(self, changes: np.ndarray) -> "TargetOneForm":
        """The one-form with (e, k) changes in place of its own."""
        return replace(self, correction=changes - self._uncorrected_changes)

    @cached_property
    def _uncorrected_changes(self) -> np.ndarray:
        """(e, k) changes without their correction.

        They are the integral of v / hbar by the trapezoidal rule (Eq. 6). An edge has known angles in the tangent
        planes of both ends, so that neighbouring faces agree by construction.
        """
        i, j = self.mesh.edges.T
        numbers = np.arange(self.phase_count) * self.turn
        directions = self.mesh.edge_directions + np.reshape(np.angle(self.stretch), (-1, 1))
        at_tail = self.rates[i] * np.cos(self.angles[i, None] + numbers - directions[:, :1])
        at_head = -self.rates[j] * np.cos(self.angles[j, None] + numbers - directions[:, 1:])
        lengths = self.mesh.edge_lengths * np.abs(self.stretch)
        return 0.5 * lengths[:, None] * (at_tail + after_turns(at_head, -self.matchings))

    @cached_property
    def connection(self) -> Connection:
        """The connection between the phases as nodes."""
        count, edges = self.phase_count, self.mesh.edges
        ends, phase = np.empty((len(edges), count, 2), int), np.arange(count)
        ends[..., 0] = count * edges[:, :1] + phase
        ends[..., 1] = count * edges[:, 1:] + (phase - self.matchings[:, None]) % count
        flips, changes = self._flips, self.changes.ravel()
        return Connection(
            count * self.mesh.vertex_count,
            ends.reshape(-1, 2),
            np.repeat(self.mesh.weights, count),
            circle_transports(np.where(flips, -changes, changes), flips),
        )

    @property
    def _flips(self) -> np.ndarray:
        """(k e,) whether the connection's edges conjugate."""
        count = self.phase_count
        # Directions from k to 2 k - 1 are reverse; k is 1 or 2, so that this is one bit of their number.
        return (((np.arange(count) - self.matchings[:, None]) & count) > 0).ravel()

    def remove_curl(self, share: float, fixed: Targets, merged: Merged) -> "TargetOneForm":
        """The one-form without a share of the curl of its changes, around triangles that keep their sheet.

        Constraints of the phases determine the changes along their edges.
        """
        if share == 0:
            return self
        return replace(self, correction=share * self.curl_removal(fixed, merged))

    def curl_removing_turns(self, fixed: Targets, merged: Merged) -> np.ndarray:
        """(k e,) radians, approximate turns of the problem's edges that remove the curl, for candidates."""
        solved = self.on_solver_edges
        return solved.connection_turns(solved.curl_removal(fixed, merged, rough=True))

    def connection_turns(self, changes: np.ndarray) -> np.ndarray:
        """(k e,) radians by which additional (e, k) changes turn the connection's edges."""
        turns = changes.ravel()
        return np.where(self._flips, -turns, turns)

    def curl_removal(self, fixed: Targets, merged: Merged, rough: bool = False) -> np.ndarray:
        """(e, k) correction of the changes that removes the curl, optionally a rough one."""
        count = self.phase_count
        circulation, _ = surface_circulation(self.mesh, self.matchings, count)
        known = known_turns(self.connection, fixed, merged)
        known = np.where(self._flips, -known, known)
        weights = np.repeat(self.mesh.weights, count)
        found = remove_holonomy(circulation, circulation.matrix @ self.changes.ravel(), weights, known, rough)
        return found.correction.reshape(-1, count)

    @property
    def masses(self) -> np.ndarray:
        """(k n,) mass of each node."""
        return np.repeat(self.mesh.vertex_masses, self.phase_count)

    def edge_phases(self, phases: np.ndarray) -> EdgePhases:
        """The edge phases of (k n,) complex phases."""
        return EdgePhases.of(self.mesh, phases.reshape(-1, self.phase_count), self.changes, self.matchings)

    @property
    def coarse_share(self) -> float:
        """Share of the edges along which a phase turns by more than half a period."""
        return float((np.abs(self.changes) > np.pi).any(axis=1).mean())

    @property
    def forced_dislocations(self) -> float:
        """Number of dislocations forced by directions and rates: the circulation of v / hbar, in turns.

        The absolute sums of the target changes around the triangles that keep their sheet are added up. A pattern that
        stretches and bends needs fewer. The errors of the trapezoidal rule in each triangle are included.
        """
        values, turns = self._around
        return float(np.abs(values[turns == 0, 3]).sum() / (2 * np.pi))

    @property
    def quad_count(self) -> float:
        """Approximate number of quads of two phases with the target changes: one for each half turn of both."""
        values, _ = self._around
        first, second = values[:, 1], values[:, 2]
        return float(np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]).sum() / (2 * np.pi**2))

    @property
    def _around(self) -> tuple[np.ndarray, np.ndarray]:
        """The target changes around the triangles, from 0; see :meth:`EdgePhases.around`."""
        zero = np.zeros((self.mesh.vertex_count, self.phase_count))
        return EdgePhases(self.mesh, zero, self.changes, self.matchings).around(self.mesh.triangles)


def _on_axes(mesh: TriangleMesh, angles: np.ndarray, matched: np.ndarray, spacing: np.ndarray) -> np.ndarray:
    """(n, 2) spacings of each vertex's two phases, for spacings given along the field's two axes."""
    if (spacing[:, 0] == spacing[:, 1]).all():
        return spacing
    swapped, apart = balance(mesh.vertex_count, mesh.edges, matched % 2 == 1)
    if not apart.all():
        raise SettingError(
            "two different spacings need a cross field whose two directions never change places, but here they do, "
            f"around disclinations on the piece of vertex {np.flatnonzero(~apart)[0]}: use the same for both "
            "(an aspect of 1)"
        )
    # The first axis of each piece of the mesh is the one nearer to X; Y and Z decide where X does not.
    x, y = mesh.tangent_frames
    first = angles + np.where(swapped, np.pi / 2, 0)
    turned = [np.cos(a)[:, None] * x + np.sin(a)[:, None] * y for a in (first, first + np.pi / 2)]
    nearer = np.abs(turned[0]) - np.abs(turned[1])
    sums = np.array([np.bincount(mesh.pieces, mesh.vertex_masses * part) for part in nearer.T])
    decided = np.abs(sums) > 1e-3 * np.bincount(mesh.pieces, mesh.vertex_masses)
    vote = np.take_along_axis(sums, decided.argmax(axis=0)[None], axis=0)[0]
    swapped ^= (vote < 0)[mesh.pieces]
    return np.where(swapped[:, None], spacing[:, ::-1], spacing)
