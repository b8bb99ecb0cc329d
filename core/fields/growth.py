# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the phases of a pattern should grow, and the connection that asks for it (paper, Eq. 6 and Section 3.5).

Stripes have one phase at a vertex and quads two; what is written here serves both.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..connection import Connection, circle_transports
from ..errors import SettingError
from ..gauge import balance
from ..geometry import TriangleMesh
from ..interpolate import EdgePhases
from ..sheets import after_turns, matchings

AXES = "XYZ"
# More than this share of the edges that turn the phase by more than half a period are too many.
COARSE_SHARE = 0.05


@dataclass(frozen=True)
class Growth:
    """Directions and rates in which the k phases of a vertex grow.

    Attributes
    ----------
    mesh : TriangleMesh
    angles : (n,) radians, direction in which the first phase grows; the next ones follow at pi / k
    rates : (n, k) phase per unit length
    matchings : (e,) see :mod:`core.sheets`
    has_signs : whether a phase and its negative are told apart, as for stripes along a vector field
    """

    mesh: TriangleMesh
    angles: np.ndarray
    rates: np.ndarray
    matchings: np.ndarray
    has_signs: bool

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
        matched = matchings(mesh, angles, field.symmetry)
        spacing = np.asarray(spacing, float)
        if spacing.ndim < 2:
            spacing = np.broadcast_to(spacing.reshape(-1, 1), (mesh.vertex_count, count))
        else:
            spacing = _on_axes(mesh, angles, matched, np.broadcast_to(spacing, (mesh.vertex_count, count)))
        return cls(mesh, angles, 2 * np.pi / spacing, matched, field.symmetry == 1)

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

        The integral of v / hbar by the trapezoidal rule over the two ends (Eq. 6); the edge lies at known angles in
        both tangent planes, so that neighbouring faces agree by construction.
        """
        i, j = self.mesh.edges.T
        numbers = np.arange(self.phase_count) * self.turn
        directions = self.mesh.edge_directions
        at_tail = self.rates[i] * np.cos(self.angles[i, None] + numbers - directions[:, :1])
        at_head = -self.rates[j] * np.cos(self.angles[j, None] + numbers - directions[:, 1:])
        return 0.5 * self.mesh.edge_lengths[:, None] * (at_tail + after_turns(at_head, -self.matchings))

    @cached_property
    def connection(self):
        """:class:`Connection` between the phases as nodes."""
        count = self.phase_count
        i, j = (np.repeat(ends, count) for ends in self.mesh.edges.T)
        phase = np.tile(np.arange(count), len(self.mesh.edges))
        direction = (phase - np.repeat(self.matchings, count)) % (2 * count)
        flips = direction >= count
        changes = self.changes.ravel()
        return Connection(
            count * self.mesh.vertex_count,
            np.column_stack([count * i + phase, count * j + direction % count]),
            np.repeat(self.mesh.weights, count),
            circle_transports(np.where(flips, -changes, changes), flips),
        )

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
        zero = np.zeros((self.mesh.vertex_count, self.phase_count))
        asked = EdgePhases(self.mesh, zero, self.changes, self.matchings)
        values, turns = asked.around(self.mesh.triangles)
        return float(np.abs(values[turns == 0, 3]).sum() / (2 * np.pi))


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
