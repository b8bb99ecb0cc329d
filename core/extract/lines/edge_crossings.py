# SPDX-License-Identifier: GPL-3.0-or-later
"""Where lines cross edges, and the pieces of lines inside triangles that join these crossings."""

from dataclasses import dataclass

import numpy as np

from ...errors import SettingError
from ...graphs import ragged_arange
from ...matchings import after_turns
from .levels import GRID
from .prepared_pattern import ASIDE, in_radians

# Crossings of lines with edges, and with one another: about 100 bytes each, and again as much in Blender.
MOST = 10_000_000


class TooManyLines(SettingError):
    """More lines than are drawn."""


def refuse_more(count, what, power):
    """Refuse more than :data:`MOST`, whose number goes by a power of the lines' density; the error says what fits."""
    if count > MOST:
        factor = 1.05 * (count / MOST) ** (1 / power)
        raise TooManyLines(
            f"{what} {count:.2g} times, and more than {MOST:.2g} are not drawn: make the spacing {factor:.3g} times as "
            "large"
        )


@dataclass(frozen=True)
class Crossings:
    """Where lines cross edges, along each edge from its lower vertex.

    Attributes
    ----------
    edges, phases, levels : (c,) edge, phase of the edge's lower vertex, and label of the level (:class:`Levels`)
    shares : (c,) how far along the edge
    starts, counts : (e,) the crossings of each edge follow one another
    """

    edges: np.ndarray
    phases: np.ndarray
    levels: np.ndarray
    shares: np.ndarray
    starts: np.ndarray
    counts: np.ndarray


def crossings_of(phases, levels=GRID):
    """All :class:`Crossings`; ends of an edge are never on a line but at a centre, which does not count.

    Raises
    ------
    SettingError
        for more than :data:`MOST`
    """
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
    # Two lines at the same place: an order, no matter which, that both triangles of the edge see.
    order = np.lexsort((phase, shares, edges))
    per_edge = np.bincount(edges, minlength=len(mesh.edges))
    return Crossings(
        edges[order],
        phase[order],
        levels.label(numbers)[order],
        shares[order],
        np.cumsum(per_edge) - per_edge,
        per_edge,
    )


@dataclass(frozen=True)
class Chords:
    """Pieces of lines inside triangles, from one rim place to another.

    Attributes
    ----------
    triangles, phases : (h,) triangle, and phase of its first corner
    ends : (h, 2) crossing, or crossings + centre, at either end
    ranks : (h, 2) where on the rim, increasing counterclockwise and within each chord
    """

    triangles: np.ndarray
    phases: np.ndarray
    ends: np.ndarray
    ranks: np.ndarray

    def __getitem__(self, which):
        return Chords(self.triangles[which], self.phases[which], self.ends[which], self.ranks[which])


@dataclass(frozen=True)
class Rims:
    """Crossings as they stand around the triangles, each once for every triangle at its edge.

    Attributes
    ----------
    triangles, sides, crossings : (r,)
    ranks : (r,) where on the rim, increasing counterclockwise
    phases, levels : (r,) phase and label of the level for the triangle's first corner
    values : (m, 4, k) phases at the triangles' corners and back at the first one, for it, in units of pi
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


def rims_of(fans, crossings):
    """:class:`Rims` of the triangles of :class:`Fans`."""
    triangle, side, crossing, rank = _places_on_rims(fans.mesh, crossings)
    phase, level, values, numbers = _seen_from_first_corners(fans, crossings, triangle, side, crossing)
    return Rims(triangle, side, crossing, rank, phase, level, values, numbers)


def chords_of(fans, crossings, rims):
    """Join the crossings on each triangle's rim that are of the same line, but for dislocations."""
    order = np.lexsort((rims.ranks, rims.levels, rims.phases, rims.triangles))
    order = order[rims.numbers[rims.triangles, rims.phases][order] == 0]
    columns = (rims.triangles, rims.phases, rims.levels, rims.ranks, rims.crossings)
    triangle, phase, level, rank, crossing = (column[order] for column in columns)
    first = np.flatnonzero((np.diff(triangle) == 0) & (np.diff(phase) == 0) & (np.diff(level) == 0))
    alone = np.ones(len(order), bool)
    alone[first] = alone[first + 1] = False
    alone &= (fans.fans[triangle] >= 0) & (np.rint(rims.values[triangle, 2, phase]) == level)
    centre = len(crossings.edges) + fans.mesh.triangles[triangle[alone], 2] - fans.first_centre
    pairs = np.column_stack([crossing[first], crossing[first + 1]]), np.column_stack([crossing[alone], centre])
    # The centre is the last corner: it comes after the first two sides.
    at_centre = np.full(alone.sum(), 2 * stride(crossings))
    ranks = np.column_stack([rank[first], rank[first + 1]]), np.column_stack([rank[alone], at_centre])
    return Chords(
        np.concatenate([triangle[first], triangle[alone]]),
        np.concatenate([phase[first], phase[alone]]),
        np.concatenate(pairs),
        np.concatenate(ranks),
    )


def stride(crossings):
    """Ranks that a side has to itself: that of the corner that it starts at, then those of its crossings."""
    return int(crossings.counts.max(initial=0)) + 1


def on_rim(mesh, triangles, sides, shares):
    """(k, 3) barycentric coordinates of places on sides, shares of the way from the edge's lower vertex."""
    along = np.where(mesh.triangle_edge_signs[triangles, sides] > 0, shares, 1 - shares)
    return (1 - along)[:, None] * np.eye(3)[sides] + along[:, None] * np.eye(3)[(sides + 1) % 3]


def chord_ends(fans, crossings, chords):
    """(h, 2, 3) barycentric coordinates of the chords' ends in their triangles."""
    ends = np.zeros((len(chords.ends), 2, 3))
    for k in range(2):
        at_centre = chords.ends[:, k] >= len(crossings.edges)
        crossing = np.where(at_centre, 0, chords.ends[:, k])
        sides = np.minimum(chords.ranks[:, k] // stride(crossings), 2)
        rim = on_rim(fans.mesh, chords.triangles, sides, crossings.shares[crossing])
        ends[:, k] = np.where(at_centre[:, None], [0.0, 0.0, 1.0], rim)
    return ends


def _places_on_rims(mesh, crossings):
    """(r,) triangle, side, crossing and rank of the places on the triangles' rims."""
    edges = mesh.triangle_edges.ravel()
    counts = crossings.counts[edges]
    half, place = ragged_arange(counts)
    forward = mesh.triangle_edge_signs.ravel()[half] > 0
    crossing = crossings.starts[edges[half]] + np.where(forward, place, counts[half] - 1 - place)
    return half // 3, half % 3, crossing, stride(crossings) * (half % 3) + 1 + place


def _seen_from_first_corners(fans, crossings, triangle, side, crossing):
    """Phase and level of crossings for the first corner of their triangle, the values at the triangles' corners and
    the dislocation numbers."""
    mesh, phases = fans.mesh, fans.phases
    radians = in_radians(phases)
    values, _ = radians.around(mesh.triangles)
    in_fan = fans.fans >= 0
    # The way around a third does not close beyond its centre: its first corner is seen as it was.
    values[in_fan, 3] = values[in_fan, 0]
    turns = np.zeros((mesh.triangle_count, 4), int)
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
    direction = (crossings.phases[crossing] + turned) % (2 * phases.phase_count)
    phase = direction % phases.phase_count
    offset = np.rint(offsets[np.arange(len(phase)), phase])
    level = np.where(direction < phases.phase_count, 1, -1) * crossings.levels[crossing] + offset
    return phase, level, values / np.pi, numbers
