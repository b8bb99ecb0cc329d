# SPDX-License-Identifier: GPL-3.0-or-later
"""Crossings of lines with edges, and the chords that join them: straight pieces of lines inside triangles.

A triangle's rim is its three sides, walked counterclockwise; a place on it has a rank, its number on that walk.
"""

from dataclasses import dataclass

import numpy as np

from ...errors import SettingError
from ...geometry import TriangleMesh
from ...graphs import ragged_arange
from ...interpolate import EdgePhases
from ...matchings import after_turns
from .levels import GRID, Levels
from .prepared_pattern import ASIDE, PreparedPattern, in_radians

# Most crossings of lines with edges or with one another: each takes about 100 bytes, and as much again in Blender.
MOST = 10_000_000


class TooManyLines(SettingError):
    """More crossings than can be drawn."""


def refuse_more(count: int, what: str, power: int) -> None:
    """Raise :class:`TooManyLines` for more than :data:`MOST`; the number grows with a power of the lines' density."""
    if count > MOST:
        factor = 1.05 * (count / MOST) ** (1 / power)
        raise TooManyLines(
            f"{what} {count:.2g} times, and more than {MOST:.2g} are not drawn: make the spacing {factor:.3g} times as "
            "large"
        )


@dataclass(frozen=True)
class Crossings:
    """Crossings of lines with edges, sorted along each edge from its lower vertex.

    Attributes
    ----------
    edges, phases, levels : (c,) edge, phase of the edge's lower vertex, and label of the level (:class:`Levels`)
    shares : (c,) position along the edge, 0 to 1
    starts, counts : (e,) first crossing of each edge, and number of its crossings
    """

    edges: np.ndarray
    phases: np.ndarray
    levels: np.ndarray
    shares: np.ndarray
    starts: np.ndarray
    counts: np.ndarray

    @property
    def stride(self) -> int:
        """Number of ranks of a triangle's side: one for the corner at its start, the others for its crossings."""
        return int(self.counts.max(initial=0)) + 1


def crossings_of(phases: EdgePhases, levels: Levels = GRID) -> Crossings:
    """All :class:`Crossings`; at most :data:`MOST`. Only centres of disclinations lie on lines: they do not count."""
    mesh, count = phases.mesh, phases.phase_count
    begin = phases.arguments[mesh.edges[:, 0]]
    end = begin + phases.changes
    end = np.where(np.abs(end - np.rint(end)) < ASIDE / 4, np.rint(end), end)  # a centre, but for rounding
    first = levels.above(np.minimum(begin, end))
    counts = np.maximum(levels.not_below(np.maximum(begin, end)) - first, 0).ravel()
    refuse_more(counts.sum(), "the lines cross the mesh's edges", 1)
    which, place = ragged_arange(counts)
    numbers = first.ravel()[which] + place
    edges, phase = which // count, which % count
    shares = (levels.value(numbers) - begin.ravel()[which]) / phases.changes.ravel()[which]
    # Two lines at the same place are put into an order that is the same for both triangles of the edge.
    order = np.lexsort((phase, shares, edges))
    per_edge = np.bincount(edges, minlength=len(mesh.edges))
    starts = np.cumsum(per_edge) - per_edge
    return Crossings(edges[order], phase[order], levels.label(numbers)[order], shares[order], starts, per_edge)


@dataclass(frozen=True)
class Chords:
    """Pieces of lines inside triangles, between two places on the rim.

    Attributes
    ----------
    triangles, phases : (h,) triangle, and index of the phase as its first corner numbers them
    ends : (h, 2) index of the crossing at either end; the number of crossings plus that of the centre at a centre
    ranks : (h, 2) order of the ends on the rim, increasing counterclockwise and within each chord
    """

    triangles: np.ndarray
    phases: np.ndarray
    ends: np.ndarray
    ranks: np.ndarray

    def __getitem__(self, which: np.ndarray) -> "Chords":
        return Chords(self.triangles[which], self.phases[which], self.ends[which], self.ranks[which])


@dataclass(frozen=True)
class Rims:
    """Crossings around the triangles, each listed once for every triangle at its edge.

    Attributes
    ----------
    triangles, sides, crossings : (r,)
    ranks : (r,) order on the rim, increasing counterclockwise
    phases, levels : (r,) phase and label of its level, both as the triangle's first corner has them
    values : (m, 4, k) phases at the corners, continued from the first one, and again at the first after a walk around,
        in units of pi
    numbers : (m, k) dislocation numbers
    """

    triangles: np.ndarray
    sides: np.ndarray
    crossings: np.ndarray
    ranks: np.ndarray
    phases: np.ndarray
    levels: np.ndarray
    values: np.ndarray
    numbers: np.ndarray


def rims_of(prepared: PreparedPattern, crossings: Crossings) -> Rims:
    """:class:`Rims` of the triangles of a :class:`PreparedPattern`."""
    triangle, side, crossing, rank = _places_on_rims(prepared.mesh, crossings)
    phase, level, values, numbers = _in_first_corners_phases(prepared, crossings, triangle, side, crossing)
    return Rims(triangle, side, crossing, rank, phase, level, values, numbers)


def chords_of(prepared: PreparedPattern, crossings: Crossings, rims: Rims) -> Chords:
    """Join the crossings on each triangle's rim that belong to one line, except in phases with a dislocation.

    A line crosses a triangle's rim twice, or in a third of a split triangle once if it ends at the centre.
    """
    order = np.lexsort((rims.ranks, rims.levels, rims.phases, rims.triangles))
    order = order[rims.numbers[rims.triangles, rims.phases][order] == 0]
    columns = (rims.triangles, rims.phases, rims.levels, rims.ranks, rims.crossings)
    triangle, phase, level, rank, crossing = (column[order] for column in columns)
    # Sorted as they are, the two crossings of one line follow each other.
    first = np.flatnonzero((np.diff(triangle) == 0) & (np.diff(phase) == 0) & (np.diff(level) == 0))
    alone = np.ones(len(order), bool)  # crossings whose line ends at a centre
    alone[first] = alone[first + 1] = False
    alone &= (prepared.fans[triangle] >= 0) & (np.rint(rims.values[triangle, 2, phase]) == level)
    centre = len(crossings.edges) + prepared.mesh.triangles[triangle[alone], 2] - prepared.first_centre
    pairs = np.column_stack([crossing[first], crossing[first + 1]]), np.column_stack([crossing[alone], centre])
    # The centre is the last corner, so its rank follows those of the first two sides.
    at_centre = np.full(alone.sum(), 2 * crossings.stride)
    ranks = np.column_stack([rank[first], rank[first + 1]]), np.column_stack([rank[alone], at_centre])
    return Chords(
        np.concatenate([triangle[first], triangle[alone]]),
        np.concatenate([phase[first], phase[alone]]),
        np.concatenate(pairs),
        np.concatenate(ranks),
    )


def on_rim(mesh: TriangleMesh, triangles: np.ndarray, sides: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """(k, 3) barycentric coordinates of places on sides; shares are counted from the edge's lower vertex."""
    along = np.where(mesh.triangle_edge_signs[triangles, sides] > 0, shares, 1 - shares)
    return (1 - along)[:, None] * np.eye(3)[sides] + along[:, None] * np.eye(3)[(sides + 1) % 3]


def chord_ends(prepared: PreparedPattern, crossings: Crossings, chords: Chords) -> np.ndarray:
    """(h, 2, 3) barycentric coordinates of the chords' ends in their triangles."""
    ends = np.zeros((len(chords.ends), 2, 3))
    for k in range(2):
        at_centre = chords.ends[:, k] >= len(crossings.edges)
        crossing = np.where(at_centre, 0, chords.ends[:, k])
        sides = np.minimum(chords.ranks[:, k] // crossings.stride, 2)
        rim = on_rim(prepared.mesh, chords.triangles, sides, crossings.shares[crossing])
        ends[:, k] = np.where(at_centre[:, None], [0.0, 0.0, 1.0], rim)
    return ends


def _places_on_rims(mesh: TriangleMesh, crossings: Crossings) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """(r,) triangle, side, crossing and rank of each place on a rim."""
    edges = mesh.triangle_edges.ravel()
    counts = crossings.counts[edges]
    half, place = ragged_arange(counts)
    forward = mesh.triangle_edge_signs.ravel()[half] > 0
    crossing = crossings.starts[edges[half]] + np.where(forward, place, counts[half] - 1 - place)
    return half // 3, half % 3, crossing, crossings.stride * (half % 3) + 1 + place


def _in_first_corners_phases(
    prepared: PreparedPattern, crossings: Crossings, triangle: np.ndarray, side: np.ndarray, crossing: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Phases, levels, values and numbers of :class:`Rims`: what each edge's lower vertex has, for the first corner.

    The phases of the first corner are carried along the sides; each matching on the way exchanges or reverses them.
    """
    mesh, phases = prepared.mesh, prepared.phases
    radians = in_radians(phases)
    values = radians.around(mesh.triangles)[0].copy()
    in_fan = prepared.fans >= 0
    # The walk around a third of a triangle does not close at its centre: the first corner keeps its own values.
    values[in_fan, 3] = values[in_fan, 0]
    turns = np.zeros((mesh.triangle_count, 4), int)  # sum of the matchings from the first corner on
    for k in range(3):
        _, matched = phases.between(mesh.triangles[:, k], mesh.triangles[:, (k + 1) % 3])
        turns[:, k + 1] = turns[:, k] + matched
    turns[in_fan, 3] = 0
    numbers = np.rint((values[:, 3] - values[:, 0]) / (2 * np.pi)).astype(int)
    # An edge's phases are those of its lower vertex.
    corner = side + (mesh.triangle_edge_signs[triangle, side] < 0)
    vertex = mesh.triangles[triangle, corner % 3]
    turned = turns[triangle, corner]
    offsets = values[triangle, corner] / np.pi - after_turns(phases.arguments[vertex], -turned)
    # Directions k and more are the negatives of the k phases.
    direction = (crossings.phases[crossing] + turned) % (2 * phases.phase_count)
    phase = direction % phases.phase_count
    offset = np.rint(offsets[np.arange(len(phase)), phase])
    level = np.where(direction < phases.phase_count, 1, -1) * crossings.levels[crossing] + offset
    return phase, level, values / np.pi, numbers
