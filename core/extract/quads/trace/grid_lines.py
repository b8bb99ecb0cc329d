# SPDX-License-Identifier: GPL-3.0-or-later
"""Grid lines of a quad pattern: where one of its phases is a multiple of pi, traced through all triangles.

Everything is decided by counting: which lines cross an edge, in which order they stand around a triangle, which
two of these crossings the same line joins, and that two lines of different phases cross where their ends
alternate. Coordinates enter only as places, so that the lines fit together whatever rounding does.

Around a disclination the triangle is split at its centre, through which lines of both phases pass. In a triangle with a
dislocation the lines of its phase end.
"""

from dataclasses import dataclass

import numpy as np

from ....graphs import ragged_arange
from ...lines.edge_crossings import chord_ends, chords_of, crossings_of, on_rim, refuse_more, rims_of, stride
from ...lines.prepared_pattern import ASIDE, move_off_lines, prepare_pattern
from .boundary_graph import border_of
from .line_graph import LineGraph


@dataclass(frozen=True)
class GridLines:
    """Lines as a graph on the surface.

    Attributes
    ----------
    graph : LineGraph
    triangles : (n,) triangle of the mesh that each node lies in
    weights : (n, 3) its barycentric coordinates there
    valences : (n,) edges that should meet at a node in the end: 4, and 3 or 5 at a disclination of +-1/4
    """

    graph: LineGraph
    triangles: np.ndarray
    weights: np.ndarray
    valences: np.ndarray

    @property
    def centres(self):
        """Nodes that are disclinations."""
        return np.flatnonzero(self.valences != 4)


def grid_lines(edge_phases):
    """:class:`GridLines` of :class:`EdgePhases` with two phases a vertex."""
    fans = prepare_pattern(move_off_lines(edge_phases))
    crossings = crossings_of(fans.phases)
    chords = chords_of(fans, crossings, rims_of(fans, crossings))
    return _graph(fans, crossings, chords)


def _graph(fans, crossings, chords):
    """:class:`GridLines` of chords and of the boundary."""
    mesh = fans.mesh
    rim_count, centre_count = len(crossings.edges), mesh.vertex_count - fans.first_centre
    first, second = _meeting_chords(chords)
    met = rim_count + centre_count + np.arange(len(first))
    node_count = rim_count + centre_count + len(first)
    # Pieces of chords: what each passes, in order of the ranks of the other chord's end between its own.
    low, high = chords.ranks[first], chords.ranks[second]
    passes = np.concatenate([first, second, np.arange(len(chords.ends)), np.arange(len(chords.ends))])
    place = np.concatenate(
        [_between(low, high), _between(high, low), np.full(len(chords.ends), -1), np.full(len(chords.ends), np.inf)]
    )
    node = np.concatenate([met, met, chords.ends[:, 0], chords.ends[:, 1]])
    order = np.lexsort((place, passes))
    passes, node = passes[order], node[order]
    step = np.flatnonzero(np.diff(passes) == 0)
    tails = np.column_stack([node[step], node[step + 1]])
    # Around a node the ways go by where they lead: to the higher rank forwards, to the lower backwards.
    keys = chords.ranks[passes[step]][:, ::-1].astype(float)
    fan = fans.fans[chords.triangles[passes[step]]]
    at_centre = (tails >= rim_count) & (tails < rim_count + centre_count)
    keys = np.where(at_centre, keys + 4.0 * stride(crossings) * fan[:, None], keys)
    at_rim = tails < rim_count
    keys = np.where(at_rim, 1.0, keys)
    reached = np.zeros(rim_count, bool)
    reached[tails[at_rim]] = True
    values = fans.phases.arguments
    on_grid = (np.abs(values - np.rint(values)) < 2 * ASIDE).all(axis=1)
    border, corners, corner_vertices = border_of(mesh, crossings, reached, node_count, on_grid)
    # Along the boundary the surface is to the left: its own way comes first, the way back last.
    graph = LineGraph(
        np.concatenate([tails, border]).ravel(),
        np.concatenate([keys, np.tile([0.0, 2.0], (len(border), 1))]).ravel(),
        np.concatenate([np.zeros(tails.shape, bool), np.tile([False, True], (len(border), 1))]).ravel(),
        np.concatenate([np.zeros(node_count, bool), corners]),
    )
    triangles, weights = _places(fans, crossings, chords, first, second, corner_vertices)
    valences = np.full(len(triangles), 4)
    # Turning once around, A^g is a quarter turn short for g = 3, and one too much for g = 1.
    valences[rim_count : rim_count + centre_count] = np.array([4, 5, 2, 3])[fans.turns]
    return GridLines(graph, triangles, weights, valences)


def _meeting_chords(chords):
    """Pairs of chords of the two phases whose ends alternate around their triangle."""
    order = np.lexsort((chords.phases, chords.triangles))
    triangles = chords.triangles[order]
    start = np.searchsorted(triangles, triangles, side="left")
    stop = np.searchsorted(triangles, triangles, side="right")
    x_counts = np.zeros(len(order), int)
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


def _between(own, other):
    """(k,) of two other ranks the one that lies between a chord's own."""
    first = other[:, 0]
    inside = (own[:, 0] < first) & (first < own[:, 1])
    return np.where(inside, first, other[:, 1])


def _places(fans, crossings, chords, first, second, corner_vertices):
    """Triangle of the given mesh and barycentric coordinates there of all nodes."""
    mesh = fans.mesh
    half_of = np.zeros(len(mesh.edges), int)
    half_of[mesh.triangle_edges.ravel()] = np.arange(3 * mesh.triangle_count)
    half = half_of[crossings.edges]
    rims = on_rim(mesh, half // 3, half % 3, crossings.shares)
    thirds = np.flatnonzero(fans.fans == 0)  # in the order of the centres
    centres = np.tile([0.0, 0.0, 1.0], (len(thirds), 1))
    ends = [chord_ends(fans, crossings, chords[which]) for which in (first, second)]
    meetings = _meetings(*ends)
    corner_of = np.zeros(mesh.vertex_count, int)
    corner_of[mesh.triangles.ravel()] = np.arange(3 * mesh.triangle_count)
    corner = corner_of[corner_vertices]
    triangles = np.concatenate([half // 3, thirds, chords.triangles[first], corner // 3])
    weights = np.concatenate([rims, centres, meetings, np.eye(3)[corner % 3]])
    return fans.parents[triangles], np.einsum("nk,nkx->nx", weights, fans.places[triangles])


def _meetings(first, second):
    """(k, 3) where straight chords meet, each from its ends (k, 2, 3)."""
    along, across = first[:, 1] - first[:, 0], second[:, 1] - second[:, 0]
    between = second[:, 0] - first[:, 0]
    # Barycentric differences have two independent components.
    area = along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0]
    share = (between[:, 0] * across[:, 1] - between[:, 1] * across[:, 0]) / np.where(area == 0, 1, area)
    share = np.where(area == 0, 0.5, np.clip(share, 0, 1))
    return first[:, 0] + share[:, None] * along
