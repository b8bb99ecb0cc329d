# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the phases of a pattern should grow, and the connection that asks for it (paper, Eq. 6 and Section 3.5).

Stripes have one phase at a vertex and quads two; what is written here serves both.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..connection import Connection, circle_transports
from ..errors import SettingError
from ..gauge import balance
from ..geometry import TriangleMesh
from ..interpolate import EdgePhases
from ..matchings import after_turns
from .curl_removal import PRECISION, ROUGH, calming, known_turns, surface_circulation

AXES = "XYZ"
# More than this share of the edges that turn the phase by more than half a period are too many.
COARSE_SHARE = 0.05


@dataclass(frozen=True)
class TargetOneForm:
    """Directions and rates in which the k phases of a vertex grow.

    Attributes
    ----------
    mesh : TriangleMesh
    angles : (n,) radians, direction in which the first phase grows; the next ones follow at pi / k
    rates : (n, k) phase per unit length
    matchings : (e,) see :mod:`core.matchings`
    has_signs : whether a phase and its negative are told apart, as for stripes along a vector field
    correction : (e, k) what is added to the changes to calm them (see :mod:`.curl_removal`); None for nothing
    scale : one, or (n,) times that quads are larger than asked, to be near square (see :class:`DirectionField`)
    stretch : one, or (e,) complex, what edges count as, as multiples of themselves, turned counterclockwise
        (see :mod:`.constraints.strips`)
    posed_matchings : the matchings along the edges that problems are posed on, None for the mesh's own
    """

    mesh: TriangleMesh
    angles: np.ndarray
    rates: np.ndarray
    matchings: np.ndarray
    has_signs: bool
    correction: np.ndarray | None = None
    scale: float | np.ndarray = 1.0
    stretch: complex | np.ndarray = 1.0
    posed_matchings: np.ndarray | None = None

    @classmethod
    def of(cls, mesh, field, spacing):
        """Growth across a direction field, so that the lines of the first phase run along it.

        Parameters
        ----------
        mesh : TriangleMesh
        field : DirectionField; vectors and lines give one phase a vertex, crosses two
        spacing : length of a period in the mesh's units, or (n,) one at each vertex; for crosses also (n, 2) or
            (1, 2), one along each of the field's two axes, the first of which is the one nearer to X
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
        rates, posed = 2 * np.pi / spacing, field.posed_matchings
        return cls(mesh, angles, rates, matched, field.symmetry == 1, scale=scale, posed_matchings=posed)

    @property
    def posed(self):
        """The growth along the edges that its problem is posed on (see :attr:`TriangleMesh.posed`): the mesh's own
        where something is known of these alone."""
        if self.posed_matchings is None or self.correction is not None or np.ndim(self.stretch) > 0:
            return self
        return replace(self, mesh=self.mesh.posed, matchings=self.posed_matchings, posed_matchings=None)

    @property
    def asked_rates(self):
        """(n, k) phase per unit length that the spacing alone asks for."""
        return self.rates * np.reshape(self.scale, (-1, 1))

    @property
    def phase_count(self):
        """k, phases at a vertex; the one numbered l at vertex v is node k v + l of the problem."""
        return self.rates.shape[1]

    @property
    def turn(self):
        """Angle between one direction and the next."""
        return np.pi / self.phase_count

    @cached_property
    def changes(self):
        """(e, k) phase change asked for along each edge, for the phases of its lower vertex.

        Before they are calmed, the integral of v / hbar by the trapezoidal rule over the two ends (Eq. 6); an edge lies
        at known angles in both tangent planes, so that neighbouring faces agree by construction.
        """
        i, j = self.mesh.edges.T
        numbers = np.arange(self.phase_count) * self.turn
        directions = self.mesh.edge_directions + np.reshape(np.angle(self.stretch), (-1, 1))
        at_tail = self.rates[i] * np.cos(self.angles[i, None] + numbers - directions[:, :1])
        at_head = -self.rates[j] * np.cos(self.angles[j, None] + numbers - directions[:, 1:])
        lengths = self.mesh.edge_lengths * np.abs(self.stretch)
        changes = 0.5 * lengths[:, None] * (at_tail + after_turns(at_head, -self.matchings))
        return changes if self.correction is None else changes + self.correction

    @cached_property
    def connection(self):
        """:class:`Connection` between the phases as nodes."""
        count = self.phase_count
        i, j = (np.repeat(ends, count) for ends in self.mesh.edges.T)
        phase = np.tile(np.arange(count), len(self.mesh.edges))
        direction = (phase - np.repeat(self.matchings, count)) % (2 * count)
        flips = self._flips
        changes = self.changes.ravel()
        return Connection(
            count * self.mesh.vertex_count,
            np.column_stack([count * i + phase, count * j + direction % count]),
            np.repeat(self.mesh.weights, count),
            circle_transports(np.where(flips, -changes, changes), flips),
        )

    @property
    def _flips(self):
        """(k e,) whether the connection's edges conjugate."""
        count = self.phase_count
        return ((np.arange(count) - self.matchings[:, None]) % (2 * count) >= count).ravel()

    def calmed(self, share, fixed, merged):
        """The growth without a share of the curl of its changes, around whole sheets.

        Parameters
        ----------
        share : from 0, as asked, to 1, nothing but disclinations left to go around
        fixed, merged : constraints (Targets, Merged) of the phases, which say what changes along their edges have to be
        """
        if share == 0:
            return self
        return replace(self, correction=share * self._calming(fixed, merged, PRECISION))

    def turns_to_calm(self, fixed, merged):
        """(k e,) radians, about what turns the connection's edges further for a growth without curl.

        Constraints as for :meth:`calmed`; to a low precision, which does for candidates.
        """
        return self.connection_turns(self._calming(fixed, merged, ROUGH))

    def connection_turns(self, changes):
        """(k e,) radians by which (e, k) changes more turn the connection's edges further."""
        turns = changes.ravel()
        return np.where(self._flips, -turns, turns)

    def _calming(self, fixed, merged, precision):
        """(e, k) what is to be added to the changes for a growth without curl."""
        count = self.phase_count
        circulation, _ = surface_circulation(self.mesh, self.matchings, count)
        known = known_turns(self.connection, fixed, merged)
        known = np.where(self._flips, -known, known)
        weights = np.repeat(self.mesh.weights, count)
        found = calming(circulation, circulation.matrix @ self.changes.ravel(), weights, known, precision)
        return found.correction.reshape(-1, count)

    @property
    def masses(self):
        """(k n,) mass of each node."""
        return np.repeat(self.mesh.vertex_masses, self.phase_count)

    def edge_phases(self, phases):
        """:class:`EdgePhases` of (k n,) complex phases."""
        return EdgePhases.of(self.mesh, phases.reshape(-1, self.phase_count), self.changes, self.matchings)

    @property
    def coarse_share(self):
        """Share of the edges along which a phase should turn by more than half a period."""
        return float((np.abs(self.changes) > np.pi).any(axis=1).mean())

    @property
    def forced_dislocations(self):
        """How many dislocations the directions and rates force: the circulation of v / hbar, in turns.

        The asked phase changes around a triangle add up to turns that no phase can make; their sizes are summed over
        all triangles around which the sheet is kept. A pattern that stretches and bends needs fewer, and what the
        trapezoidal rule is off by in each triangle counts too.
        """
        values, turns = self._around
        return float(np.abs(values[turns == 0, 3]).sum() / (2 * np.pi))

    @property
    def quad_count(self):
        """About how many quads two phases draw that change as asked: one for each half turn of both."""
        values, _ = self._around
        first, second = values[:, 1], values[:, 2]
        return float(np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]).sum() / (2 * np.pi**2))

    @property
    def _around(self):
        """The asked changes around the triangles, from 0 on; see :meth:`EdgePhases.around`."""
        zero = np.zeros((self.mesh.vertex_count, self.phase_count))
        return EdgePhases(self.mesh, zero, self.changes, self.matchings).around(self.mesh.triangles)


def _on_axes(mesh, angles, matched, spacing):
    """(n, 2) spacings of each vertex's own two phases, for spacings given along the field's two axes."""
    if (spacing[:, 0] == spacing[:, 1]).all():
        return spacing
    swapped, apart = balance(mesh.vertex_count, mesh.edges, matched % 2 == 1)
    if not apart.all():
        raise SettingError(
            "two different spacings need a cross field whose two directions never change places, but here they do, "
            f"around disclinations on the piece of vertex {np.flatnonzero(~apart)[0]}: use the same for both "
            "(an aspect of 1)"
        )
    # Each piece of the mesh chooses the axis that runs nearer to X as its first; Y and Z decide where X does not.
    x, y = mesh.tangent_frames
    first = angles + np.where(swapped, np.pi / 2, 0)
    turned = [np.cos(a)[:, None] * x + np.sin(a)[:, None] * y for a in (first, first + np.pi / 2)]
    nearer = np.abs(turned[0]) - np.abs(turned[1])
    sums = np.array([np.bincount(mesh.pieces, mesh.vertex_masses * part) for part in nearer.T])
    decided = np.abs(sums) > 1e-3 * np.bincount(mesh.pieces, mesh.vertex_masses)
    vote = np.take_along_axis(sums, decided.argmax(axis=0)[None], axis=0)[0]
    swapped ^= (vote < 0)[mesh.pieces]
    return np.where(swapped[:, None], spacing[:, ::-1], spacing)
