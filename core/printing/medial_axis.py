# SPDX-License-Identifier: GPL-3.0-or-later
"""Beads where contours leave a gap: along the medial line of what they leave, and through what is then left.

The medial line is where the nearest places of the rim change from one side to another: edges of the mesh whose ends
belong to places of the rim that are far apart along it, cut where both are equally far.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from ..extract.layers.toolpaths import rim_vertices
from ..geometry import TriangleMesh
from ..geometry.polylines import close_polyline, places_at, polyline_length
from ..graphs import components

# Rounds in which vertices take over their neighbours' nearest place of the rim.
_ROUNDS = 4
# Of a step: nearer to beads than the first no bead begins or ends, and one that is farther nowhere than the second is
# left out.
_NEAR, _FAR = 0.5, 0.54
# Of a step: what is shorter is less than a bead is wide.
_SHORTEST = 0.5
# The medial line is level where it rises by less for its length; in corners it does not.
_STEEP = 0.5
# Passes of smoothing, and the share of the way to the middle of its neighbours that a point moves in each.
_PASSES, _SHARE = 12, 0.5
# Points of a bead are a step over this apart.
PARTS = 4


@dataclass(frozen=True)
class Polyline:
    """Places along a bead.

    Attributes
    ----------
    points : (n, 3); of a closed one the first does not come again
    """

    points: np.ndarray
    closed: bool
    layer: int

    @property
    def length(self) -> float:
        return polyline_length(close_polyline(self.points, self.closed))


def medial_beads(
    mesh: TriangleMesh,
    layers: np.ndarray,
    medial: tuple[np.ndarray, np.ndarray],
    away: Callable[[np.ndarray, np.ndarray], np.ndarray],
    step: float,
) -> list[Polyline]:
    """Beads along the medial lines of layers, where other beads are farther than half a step.

    Parameters
    ----------
    layers : (t,) of the mesh's triangles
    medial : as :func:`medial_points`
    away : callable((k, 3) points, (k,) layers) -> (k,) distances to the beads that there are
    step : between beads
    """
    edges, points, numbers = _placed(mesh, layers, medial)
    gaps = away(points, numbers[edges])
    node = np.full(len(mesh.edges), -1)
    kept = gaps > _NEAR * step
    node[edges[kept]] = np.arange(np.count_nonzero(kept))
    edges, points, gaps = edges[kept], points[kept], gaps[kept]
    at = node[mesh.triangle_edges]
    count = (at >= 0).sum(axis=1)
    two = np.sort(at[count == 2], axis=1)[:, 1:]
    # Three lines that meet in the middle of a triangle get three separate ends.
    centres = np.repeat(mesh.vertices[mesh.triangles[count == 3]].mean(axis=1), 3, axis=0)
    ends = at[count == 3].ravel()
    pairs = np.concatenate([two, np.column_stack([ends, len(points) + np.arange(len(ends))])])
    points, gaps = np.concatenate([points, centres]), np.append(gaps, gaps[ends])
    of = np.append(numbers[edges], numbers[edges][ends])
    beads = []
    for run, closed in chains(len(points), pairs):
        bead = Polyline(points[run], closed, int(of[run[0]]))
        if gaps[run].max() > _FAR * step and bead.length > step:
            beads.append(smooth(bead, step))
    return beads


def level_pieces(
    mesh: TriangleMesh,
    layers: np.ndarray,
    medial: tuple[np.ndarray, np.ndarray],
    rim: Callable[[np.ndarray, np.ndarray], np.ndarray],
    step: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """(k, 3) begins and ends of pieces of the medial line that do not run into a corner, (k,) their layers, and (k,)
    how far they are from the contours on both sides, in steps from 0 to 1. ``rim`` gives distances from the rim, like
    ``away`` above."""
    edges, points, numbers = _placed(mesh, layers, medial)
    depths = rim(points, numbers[edges])
    node = np.full(len(mesh.edges), -1)
    node[edges] = np.arange(len(edges))
    at = node[mesh.triangle_edges]
    pairs = np.sort(at[(at >= 0).sum(axis=1) == 2], axis=1)[:, 1:]
    ways = np.linalg.norm(np.diff(points[pairs], axis=1)[:, 0], axis=1)
    rises = np.abs(np.diff(depths[pairs])[:, 0])
    way, rise = (np.bincount(pairs.ravel(), np.repeat(of, 2), len(points)) for of in (ways, rises))
    # Places beside the line are less deep than it.
    middles = rim(points[pairs].mean(axis=1), numbers[edges[pairs[:, 0]]])
    deep = np.maximum(depths[pairs].max(axis=1), middles) / step - 0.5
    pairs, deep = (values[(rise <= _STEEP * way)[pairs].all(axis=1) & (deep > 0)] for values in (pairs, deep))
    begins, ends = points[pairs[:, 0]], points[pairs[:, 1]]
    return begins, ends, numbers[edges[pairs[:, 0]]], deep % 1


def _placed(
    mesh: TriangleMesh, layers: np.ndarray, medial: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(k,) edges that the medial line crosses, (k, 3) where, and the layer of each edge of the mesh."""
    edges, places = medial
    points = np.einsum("ke,kex->kx", np.column_stack([1 - places, places]), mesh.vertices[mesh.edges[edges]])
    numbers = np.zeros(len(mesh.edges), int)
    numbers[mesh.triangle_edges] = layers[:, None]
    return edges, points, numbers


def medial_points(mesh: TriangleMesh, distances: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Edges that the medial line crosses, and how far along each."""
    sources = _nearest_on_rim(mesh)
    loop, way, length = _along_rims(mesh)
    i, j = mesh.edges.T
    first, second = sources[i], sources[j]
    apart = np.abs(way[first] - way[second])
    apart = np.where(loop[first] == loop[second], np.minimum(apart, length[loop[first]] - apart), np.inf)
    # Along one side of the rim, the nearest places of an edge's ends are no farther apart than these themselves.
    crosses = (apart > 2 * mesh.edge_lengths + step) & (mesh.edge_face_counts == 2)
    edges = np.flatnonzero(crosses)
    lengths = mesh.edge_lengths[edges]
    places = (lengths + distances[j[edges]] - distances[i[edges]]) / (2 * lengths)
    return edges, np.clip(places, 0.02, 0.98)


def _nearest_on_rim(mesh: TriangleMesh) -> np.ndarray:
    """(n,) the vertex of the rim that is nearest to each vertex, searched along edges."""
    i, j = mesh.edges.T
    count = mesh.vertex_count
    graph = coo_matrix((mesh.edge_lengths, (i, j)), shape=(count, count)).tocsr()
    rim = np.flatnonzero(rim_vertices(mesh))
    sources = dijkstra(graph, directed=False, indices=rim, min_only=True, return_predecessors=True)[2]
    sources = np.where(sources < 0, np.arange(count), sources)
    tails, heads = np.concatenate([i, j]), np.concatenate([j, i])
    for _ in range(_ROUNDS):
        offered = sources[heads]
        ways = np.linalg.norm(mesh.vertices[tails] - mesh.vertices[offered], axis=1)
        own = np.linalg.norm(mesh.vertices - mesh.vertices[sources], axis=1)
        better = ways < own[tails]
        order = np.argsort(-ways[better], kind="stable")
        sources[tails[better][order]] = offered[better][order]
    return sources


def _along_rims(mesh: TriangleMesh) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(n,) the loop of the rim that a vertex is on, (n,) its way along it, and the length of each loop.

    Each vertex that is not on the rim counts as a loop without length.
    """
    halves = np.flatnonzero(mesh.twins < 0)
    tails, heads = mesh.triangles.ravel()[halves], np.roll(mesh.triangles, -1, axis=1).ravel()[halves]
    loop = components(mesh.vertex_count, np.column_stack([tails, heads]))
    after = dict(zip(tails.tolist(), heads.tolist(), strict=True))
    steps = dict(zip(tails.tolist(), np.linalg.norm(mesh.vertices[heads] - mesh.vertices[tails], axis=1).tolist(),
                     strict=True))  # fmt: skip
    way, length = np.zeros(mesh.vertex_count), np.zeros(loop.max(initial=-1) + 1)
    for first in np.unique(loop[tails], return_index=True)[1]:
        at = begin = int(tails[first])
        total = 0.0
        while True:
            way[at] = total
            total += steps[at]
            at = after[at]
            if at == begin:
                break
        length[loop[begin]] = total
    return loop, way, length


def chains(count: int, pairs: np.ndarray) -> Iterator[tuple[np.ndarray, bool]]:
    """Nodes in the order in which pairs join them, no node being in more than two: yields (k,) nodes and whether they
    close."""
    beside: list[list[int]] = [[] for _ in range(count)]
    for one, other in pairs.tolist():
        beside[one].append(other)
        beside[other].append(one)
    met = np.zeros(count, bool)
    ends = [node for node in range(count) if len(beside[node]) == 1]
    for first in [*ends, *(node for node in range(count) if len(beside[node]) == 2)]:
        if met[first]:
            continue
        run, node = [], first
        while node >= 0:
            met[node] = True
            run.append(node)
            node = next((other for other in beside[node] if not met[other]), -1)
        yield np.array(run), len(beside[first]) == 2


def smooth(bead: Polyline, step: float) -> Polyline:
    """A bead without the bends that come from the edges of the mesh, its points a share of a step apart."""
    points = close_polyline(bead.points, bead.closed)
    length = polyline_length(points)
    count = max(3 if bead.closed else 2, round(PARTS * length / step)) + (not bead.closed)
    points = places_at(points, np.linspace(0, length, count, endpoint=not bead.closed))
    for _ in range(_PASSES):
        middles = (np.roll(points, 1, axis=0) + np.roll(points, -1, axis=0)) / 2
        moved = points + _SHARE * (middles - points)
        if not bead.closed:
            moved[[0, -1]] = points[[0, -1]]
        points = moved
    return Polyline(points, bead.closed, bead.layer)


def beads_through(mesh: TriangleMesh, layers: np.ndarray, far: np.ndarray, step: float) -> list[Polyline]:
    """Beads through (n,) bool vertices that are far from others: along the longest way in each piece of them.

    ``layers`` are (t,) of the mesh's triangles; beads are a step apart.
    """
    chosen = np.flatnonzero(far)
    i, j = mesh.edges.T
    inside = far[i] & far[j]
    place = np.cumsum(far) - 1
    pairs = place[mesh.edges[inside]]
    graph = coo_matrix((mesh.edge_lengths[inside], pairs.T), shape=(len(chosen), len(chosen))).tocsr()
    piece = components(len(chosen), pairs)
    of = np.zeros(mesh.vertex_count, int)
    of[mesh.triangles] = layers[:, None]
    beads = []
    order = np.argsort(piece, kind="stable")
    for members in np.split(order, np.flatnonzero(np.diff(piece[order])) + 1):
        if len(members) < 3:
            continue
        part = graph[members][:, members]
        start = dijkstra(part, directed=False, indices=0).argmax()
        ways, before = dijkstra(part, directed=False, indices=start, return_predecessors=True)
        run = [int(ways.argmax())]
        while run[-1] != start:
            run.append(int(before[run[-1]]))
        if ways.max() < _SHORTEST * step:
            continue
        vertices = chosen[members[run]]
        beads.append(smooth(Polyline(mesh.vertices[vertices], False, int(of[vertices[0]])), step))
    return beads
