# SPDX-License-Identifier: GPL-3.0-or-later
"""Grid lines of a quad pattern: where one of its phases is a multiple of pi, traced through all triangles.

The topology is decided by counting: which lines cross an edge, their order around a triangle, which two of these
crossings a line joins, and that two lines of different phases cross where their ends alternate. Coordinates only follow
from it, so that rounding cannot make the lines inconsistent.

A triangle with a disclination is split at its centre, through which lines of both phases pass. In a triangle with a
dislocation the lines of its phase end.
"""

from dataclasses import dataclass

import numpy as np

from ....graphs import ragged_arange
from ....interpolate import EdgePhases
from ...lines.edge_crossings import Chords, Crossings, chord_ends, chords_of, crossings_of, on_rim, refuse_more, rims_of
from ...lines.prepared_pattern import ASIDE, PreparedPattern, move_off_lines, prepare_pattern
from .boundary_graph import boundary_segments, vertex_places
from .line_graph import LineGraph


@dataclass(frozen=True)
class GridLines:
    """Lines as a graph on the surface.

    Attributes
    ----------
    triangles, weights : (n,), (n, 3) triangle of the mesh that each node lies in, and barycentric coordinates there
    valences : (n,) edges that should meet at a node of the quad mesh: 4, or 3 and 5 at disclinations of +-1/4
    """

    graph: LineGraph
    triangles: np.ndarray
    weights: np.ndarray
    valences: np.ndarray

    @property
    def centres(self) -> np.ndarray:
        """Nodes that are disclinations."""
        return np.flatnonzero(self.valences != 4)


def grid_lines(edge_phases: EdgePhases) -> GridLines:
    """:class:`GridLines` of a pattern with two phases at each vertex."""
    prepared = prepare_pattern(move_off_lines(edge_phases))
    crossings = crossings_of(prepared.phases)
    chords = chords_of(prepared, crossings, rims_of(prepared, crossings))
    return _graph(prepared, crossings, chords)


def _graph(prepared: PreparedPattern, crossings: Crossings, chords: Chords) -> GridLines:
    """:class:`GridLines` of chords and of the boundary."""
    mesh = prepared.mesh
    rim_count, centre_count = len(crossings.edges), mesh.vertex_count - prepared.first_centre
    first, second = _meeting_chords(chords)
    met = rim_count + centre_count + np.arange(len(first))
    node_count = rim_count + centre_count + len(first)
    # The nodes along each chord are sorted by the rank, between the chord's own, of the other chord's end.
    low, high = chords.ranks[first], chords.ranks[second]
    every = np.arange(len(chords.ends))
    passes = np.concatenate([first, second, every, every])
    ends = np.full(len(every), -1), np.full(len(every), np.inf)
    place = np.concatenate([_between(low, high), _between(high, low), *ends])
    node = np.concatenate([met, met, chords.ends[:, 0], chords.ends[:, 1]])
    order = np.lexsort((place, passes))
    passes, node = passes[order], node[order]
    step = np.flatnonzero(np.diff(passes) == 0)
    tails = np.column_stack([node[step], node[step + 1]])
    # Darts around a node are sorted by the rank they lead to: forwards to the chord's higher, backwards to its lower.
    keys = chords.ranks[passes[step]][:, ::-1].astype(float)
    fan = prepared.fans[chords.triangles[passes[step]]]
    at_centre = (tails >= rim_count) & (tails < rim_count + centre_count)
    keys = np.where(at_centre, keys + 4.0 * crossings.stride * fan[:, None], keys)
    at_rim = tails < rim_count
    keys = np.where(at_rim, 1.0, keys)
    reached = np.zeros(rim_count, bool)
    reached[tails[at_rim]] = True
    values = prepared.phases.arguments
    on_grid = (np.abs(values - np.rint(values)) < 2 * ASIDE).all(axis=1)
    border, corners, corner_vertices = boundary_segments(mesh, crossings, reached, node_count, on_grid)
    # Along the boundary the surface is to the left: the forward dart comes first, the backward one last.
    graph = LineGraph(
        np.concatenate([tails, border]).ravel(),
        np.concatenate([keys, np.tile([0.0, 2.0], (len(border), 1))]).ravel(),
        np.concatenate([np.zeros(tails.shape, bool), np.tile([False, True], (len(border), 1))]).ravel(),
        np.concatenate([np.zeros(node_count, bool), corners]),
    )
    triangles, weights = _places(prepared, crossings, chords, first, second, corner_vertices)
    valences = np.full(len(triangles), 4)
    # Once around the centre, A^g falls short by a quarter turn for g = 3, and goes too far by one for g = 1.
    valences[rim_count : rim_count + centre_count] = np.array([4, 5, 2, 3])[prepared.turns]
    return GridLines(graph, triangles, weights, valences)


def _meeting_chords(chords: Chords) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of chords of different phases whose ends alternate around their triangle."""
    order = np.lexsort((chords.phases, chords.triangles))
    triangles = chords.triangles[order]
    start = np.searchsorted(triangles, triangles, side="left")
    stop = np.searchsorted(triangles, triangles, side="right")
    is_y = chords.phases[order] == 1
    sums = np.append(0, np.cumsum(~is_y))
    x_counts = sums[stop] - sums[start]
    rows = np.flatnonzero(is_y)
    refuse_more(x_counts[rows].sum(), "grid lines may cross one another", 2)
    row, place = ragged_arange(x_counts[rows])
    y = rows[row]
    x, y = order[start[y] + place], order[y]
    inside = (chords.ranks[x][:, :1] < chords.ranks[y]) & (chords.ranks[y] < chords.ranks[x][:, 1:])
    share_end = chords.ranks[x][:, 1] == chords.ranks[y][:, 1]
    crossing = (inside.sum(axis=1) == 1) & ~share_end
    return x[crossing], y[crossing]


def _between(own: np.ndarray, other: np.ndarray) -> np.ndarray:
    """(k,) the one of two other ranks that lies between a chord's own."""
    first = other[:, 0]
    inside = (own[:, 0] < first) & (first < own[:, 1])
    return np.where(inside, first, other[:, 1])


def _places(
    prepared: PreparedPattern,
    crossings: Crossings,
    chords: Chords,
    first: np.ndarray,
    second: np.ndarray,
    corner_vertices: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Triangles and barycentric coordinates of all nodes in the given mesh."""
    mesh = prepared.mesh
    half_of = np.zeros(len(mesh.edges), int)
    half_of[mesh.triangle_edges.ravel()] = np.arange(3 * mesh.triangle_count)
    half = half_of[crossings.edges]
    rims = on_rim(mesh, half // 3, half % 3, crossings.shares)
    thirds = np.flatnonzero(prepared.fans == 0)  # in the order of the centres
    centres = np.tile([0.0, 0.0, 1.0], (len(thirds), 1))
    ends = [chord_ends(prepared, crossings, chords[which]) for which in (first, second)]
    corners, at_corners = vertex_places(mesh, corner_vertices)
    triangles = np.concatenate([half // 3, thirds, chords.triangles[first], corners])
    weights = np.concatenate([rims, centres, _meetings(*ends), at_corners])
    return prepared.parents[triangles], np.einsum("nk,nkx->nx", weights, prepared.places[triangles])


def _meetings(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """(k, 3) intersections of straight chords, given by their ends (k, 2, 3)."""
    along, across = first[:, 1] - first[:, 0], second[:, 1] - second[:, 0]
    between = second[:, 0] - first[:, 0]
    # Barycentric differences have two independent components.
    area = along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0]
    share = (between[:, 0] * across[:, 1] - between[:, 1] * across[:, 0]) / np.where(area == 0, 1, area)
    share = np.where(area == 0, 0.5, np.clip(share, 0, 1))  # in the middle of parallel chords
    return first[:, 0] + share[:, None] * along
