# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts chains of a quad mesh's edges onto boundaries and sharp edges of its surface, and vertices onto corners.

Where a grid line was held on a line, its vertices lie there already. At corners, which phases cannot follow exactly,
the nearest vertex with a suitable number of edges is used. Where the next vertex of a line lies across a face, the face
can be cut in two. Where no chain follows a line from end to end, because one of its corners has no vertex or lines are
crowded, chains follow the parts of the line on which edges lie.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from heapq import heappop, heappush
from itertools import pairwise

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from ....fields.constraints.features import quads_around
from ..trace.boundary_graph import vertex_places
from ..trace.quad_mesh import SHORTEST, QuadMesh
from .edge_net import EdgeNet, pieces_of
from .feature_lines import FeatureLines

# Largest distances, in sides of a quad, by which a vertex is moved onto a corner or a line.
CORNER_REACH, LINE_REACH = 1.0, 0.8
# Cost of an edge too many or too few at a corner's vertex, in sides.
VALENCE_COST = 0.35
# Cost of an edge as a multiple of its length and of its squared distance from the line, in sides.
DISTANCE_COST = 50.0
# Cost of cutting a face in two, in sides.
CUTTING = 3.0
# Largest distance, in sides, of the edges of a part from the line.
PART_REACH = 0.25
# Chains longer or shorter than the line by more than this factor are rejected.
LENGTH_RATIO = 2.0
# Share of a line's length up to which nothing of it is lost.
ROUNDING = 1e-9
# Vertices of a chain nearer to each other than this part of their mean distance are spread evenly.
SMALLEST_GAP = 0.25


@dataclass(frozen=True)
class Chains:
    """Vertices of a quad mesh on feature lines.

    Attributes
    ----------
    lines : (n,) line on which each vertex slides, -1 for none
    fixed : (n,) bool, vertices on corners
    followed : (l,) length of each line that chains follow
    gaps : (l,) mean distance of the vertices on each line
    groups : (n,) group of each vertex, or one for all: sliding vertices keep their order within a group
    """

    features: FeatureLines
    lines: np.ndarray
    fixed: np.ndarray
    followed: np.ndarray
    gaps: np.ndarray
    groups: int | np.ndarray = 0

    @property
    def lost(self) -> np.ndarray:
        """(k,) the length that no chain follows of each line that is not followed from end to end."""
        lengths = self.features.lengths
        lost = lengths - self.followed
        return lost[lost > ROUNDING * lengths]

    def of_vertices(self, which: np.ndarray, groups: int | np.ndarray = 0) -> "Chains":
        """The chains of a quad mesh with (k,) of the vertices, in groups."""
        return replace(self, lines=self.lines[which], fixed=self.fixed[which], groups=groups)

    def edges(self, quads: QuadMesh) -> np.ndarray:
        """(e, 2) vertices of the quad mesh's edges that may lie on a line."""
        ends = quads.edges[0]
        on_line = self.fixed | (self.lines >= 0)
        lines = self.lines[ends]
        return ends[on_line[ends].all(axis=1) & ((lines[:, 0] == lines[:, 1]) | self.fixed[ends].any(axis=1))]


def follow_features(quads: QuadMesh, features: FeatureLines, cut: bool = False) -> tuple[QuadMesh, Chains]:
    """The quad mesh with chains of its edges on feature lines of its surface, and the :class:`Chains`.

    With ``cut``, faces are cut in two where a line leads through them.
    """
    side = float(quads.edge_lengths.mean())
    at_corner = _prefer_neighbours(quads, features, side, _corner_vertices(quads, features, side))
    taken = np.zeros(len(quads.vertices), bool)
    taken[list(at_corner.values())] = True
    lines, fixed = np.full(len(taken), -1), taken.copy()
    corners = np.array(list(at_corner), int)
    at = np.array(list(at_corner.values()), int)
    quads = quads.moved(at, features.mesh.vertices[corners], *vertex_places(features.mesh, corners))
    followed, net = features.lengths.copy(), EdgeNet.of(quads, features, LINE_REACH * side, taken, cut)
    for number in np.argsort(~features.on_boundary, kind="stable").tolist():
        chain = _chain(net, features, number, side, at_corner)
        with_cuts = None if chain is None else _cut_faces(quads, chain[2])
        if chain is None or with_cuts is None:
            followed[number] = 0
            for vertices, places, length in _parts(net, features, number, side, at_corner):
                lines[vertices] = number
                net.take(vertices)
                quads = quads.moved(vertices, *features.at(number, places))
                followed[number] = min(followed[number] + length, features.lengths[number])
            continue
        vertices, ways, cuts = chain
        lines[vertices] = number
        net.take(vertices)
        if len(cuts):
            quads, net = with_cuts, net.of_faces(with_cuts)
        quads = quads.moved(vertices, *features.at(number, ways))
    gaps = features.lengths / (1 + np.bincount(lines[lines >= 0], minlength=len(features.lines)))
    return quads, Chains(features, lines, fixed, followed, gaps)


def _corner_vertices(quads: QuadMesh, features: FeatureLines, side: float) -> dict[int, int]:
    """The vertex of the quad mesh for each corner; the pairs with the least cost are chosen first."""
    mesh, corners = features.mesh, features.corners
    if len(corners) == 0:
        return {}
    valences = np.bincount(quads.edges[0].ravel(), minlength=len(quads.vertices))
    of_vertices, of_corners = pieces_of(quads, mesh), mesh.pieces[corners]
    wanted = quads_around(mesh, features.edges, corners) + mesh.boundary_vertices[corners]
    pairs = cKDTree(mesh.vertices[corners]).query_ball_tree(cKDTree(quads.vertices), CORNER_REACH * side)
    on_rim, costs = quads.on_rim, []
    for place, near in enumerate(pairs):
        for vertex in near:
            same_piece = of_vertices[vertex] == of_corners[place]
            if same_piece and on_rim[vertex] == mesh.boundary_vertices[corners[place]]:
                apart = np.linalg.norm(quads.vertices[vertex] - mesh.vertices[corners[place]]) / side
                costs.append((apart + VALENCE_COST * abs(valences[vertex] - wanted[place]), place, vertex))
    found: dict[int, int] = {}
    used = set()
    for _, place, vertex in sorted(costs):
        if corners[place] not in found and vertex not in used:
            found[int(corners[place])] = vertex
            used.add(vertex)
    return found


def _prefer_neighbours(
    quads: QuadMesh, features: FeatureLines, side: float, at_corner: dict[int, int]
) -> dict[int, int]:
    """The vertices at corners. One that does not lie at its corner yet is replaced by a neighbour that does.

    Otherwise the edge between the two would lose its length.
    """
    corner_of = np.full(len(quads.vertices), -1)
    corner_of[list(at_corner.values())] = list(at_corner)
    ends = quads.edges[0]
    ends = np.concatenate([ends, ends[:, ::-1]])
    ends = ends[(corner_of[ends[:, 0]] >= 0) & (corner_of[ends[:, 1]] < 0)]
    apart = quads.vertices[ends] - features.mesh.vertices[corner_of[ends[:, 0]], None]
    stands = ((np.linalg.norm(apart, axis=2) < SHORTEST * side) == [False, True]).all(axis=1)
    return at_corner | dict(zip(corner_of[ends[stands, 0]].tolist(), ends[stands, 1].tolist(), strict=True))


def _cut_faces(quads: QuadMesh, pairs: np.ndarray) -> QuadMesh | None:
    """The quad mesh with a face cut in two between each of (k, 2) vertices; None where a cut separates other pairs."""
    faces = [corners.tolist() for corners in np.split(quads.corner_vertices, quads.starts[1:])] if len(pairs) else []
    for pair in pairs.tolist():
        number = next((k for k, corners in enumerate(faces) if set(pair) <= set(corners)), None)
        if number is None:
            return None
        corners = faces[number]
        i, j = sorted(corners.index(vertex) for vertex in pair)
        faces[number] = corners[i : j + 1]
        faces.append([*corners[: i + 1], *corners[j:]])
    if not faces:
        return quads
    return replace(quads, corner_vertices=np.concatenate(faces), sizes=np.array([len(corners) for corners in faces]))


def _chain(
    net: EdgeNet, features: FeatureLines, number: int, side: float, at_corner: dict[int, int]
) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Vertices along one line without its corners, their positions along it, and the pairs of vertices between which
    faces are cut; None without a chain."""
    line, length, near = features.lines[number], float(features.lengths[number]), net.free_near(number)
    begin, closed, on_boundary = 0.0, features.closed[number], features.on_boundary[number]
    first, last = (at_corner.get(corner) for corner in line[[0, -1]].tolist())
    if closed:
        fitting = [vertex for vertex in near if net.on_rim[vertex] == on_boundary]
        first = last = min(fitting, key=lambda vertex: near[vertex][1], default=None)
        if first is None or near[first][1] > LINE_REACH * side:
            return None
        begin = near[first][0]
        near = {vertex: ((way - begin) % length, apart) for vertex, (way, apart) in near.items()}
    if first is None or last is None:
        return None
    found = _path(net, near, (first, last), length, side, on_boundary)
    if found is None:
        return None
    path, cuts = found
    steps = np.array([net.step(*ends) for ends in pairwise(path)])
    if not length / LENGTH_RATIO < steps.sum() < length * LENGTH_RATIO or (closed and len(steps) < 3):
        return None
    inner = _spread_evenly(np.array([near[vertex][0] for vertex in path[1:-1]]), length, steps)
    if closed:
        return np.array(path[:-1]), (begin + np.append(0, inner)) % length, cuts
    return np.array(path[1:-1], int), inner, cuts


def _spread_evenly(ways: np.ndarray, span: float, steps: np.ndarray) -> np.ndarray:
    """Positions between 0 and a span, replaced by the sums of the steps if they are not in order or too close.

    Steps that are much smaller than their mean are enlarged.
    """
    gaps = np.diff(np.concatenate([[0], ways, [span]]))
    if (gaps > SMALLEST_GAP * span / len(gaps)).all():
        return ways
    steps = np.maximum(steps, SMALLEST_GAP * steps.mean())
    return span * np.cumsum(steps)[:-1] / steps.sum()


def _path(
    net: EdgeNet,
    near: dict[int, tuple[float, float]],
    ends: tuple[int, int],
    length: float,
    side: float,
    on_boundary: bool,
) -> tuple[list[int], np.ndarray] | None:
    """The vertices from one end of a line to the other along edges near it, and (c, 2) steps along diagonals; or None.

    The shortest path by Dijkstra's algorithm. The ends may be the same vertex or neighbours, so they get numbers of
    their own. An edge is usable if it leads about as far along the line as it is long.

    Parameters
    ----------
    near : positions along the line, and distances from it, of the vertices that may be on it
    ends : the vertices at the line's ends
    length : of the line
    side : length of a quad's side
    """
    begin, end = -1, -2
    names = {begin: ends[0], end: ends[1]}
    positions = {vertex: (way, apart / side) for vertex, (way, apart) in near.items() if apart < LINE_REACH * side}
    for vertex in ends:
        positions.pop(vertex, None)
    positions |= {begin: (0.0, 0.0), end: (length, 0.0)}
    kinds = [(net.passages[0], 0.0)] if on_boundary else [(net.passages[1], 0.0), (net.passages[2], CUTTING * side)]
    shortest = side if on_boundary else 0.0
    costs, before, waiting, done = {begin: 0.0}, dict[int, tuple[int, bool]](), [(0.0, begin)], set[int]()
    while waiting:
        cost, node = heappop(waiting)
        if node == end:
            break
        if node in done:
            continue
        done.add(node)
        vertex, (way, apart) = names.get(node, node), positions[node]
        for passages, more in kinds:
            for name in passages.get(vertex, ()):
                other = end if name == ends[1] else name
                if other not in positions:
                    continue
                onwards, away = positions[other]
                step = net.step(vertex, name)
                if abs(onwards - way) >= LENGTH_RATIO * max(step, shortest):
                    continue
                total = cost + step * (1 + DISTANCE_COST * (apart**2 + away**2) / 2) + more + 1e-9 * side
                if total < costs.get(other, np.inf):
                    costs[other], before[other] = total, (node, more > 0)
                    heappush(waiting, (total, other))
    if end not in before:
        return None
    path, cuts = [ends[1]], list[tuple[int, int]]()
    node = end
    while node != begin:
        node, is_cut = before[node]
        path.append(names.get(node, node))
        cuts += [(path[-1], path[-2])] if is_cut else []
    return path[::-1], np.array(cuts[::-1], int).reshape(-1, 2)


def _way_to(end: int, before: np.ndarray) -> list[int]:
    """The nodes of the path to a node; ``before`` are predecessors, negative at its start."""
    way = [end]
    while before[way[-1]] >= 0:
        way.append(int(before[way[-1]]))
    return way[::-1]


def _parts(
    net: EdgeNet, features: FeatureLines, number: int, side: float, at_corner: dict[int, int]
) -> Iterator[tuple[np.ndarray, np.ndarray, float]]:
    """The parts of a line on which edges lie: vertices that are not at its corners, their positions along the line, and
    the length of the part."""
    line, length = features.lines[number], float(features.lengths[number])
    is_loop = line[0] == line[-1]
    close = {vertex: way for vertex, (way, apart) in net.free_near(number).items() if apart < PART_REACH * side}
    at_ends = [] if features.closed[number] else [at_corner.get(corner, -1) for corner in line[[0, -1]].tolist()]
    for vertex, end in zip(at_ends, (0.0, length), strict=False):
        if vertex >= 0:
            close = {other: way for other, way in close.items() if abs(way - end) >= SMALLEST_GAP * side} | {
                vertex: end
            }
    passages = net.passages[0 if features.on_boundary[number] else 1]
    pairs = [(i, j) for i in close for j in passages.get(i, ()) if i < j and j in close]
    if not pairs:
        return
    edges, ways, places = np.array(sorted(pairs)), np.full(len(net.places), np.nan), np.array(net.places)
    ways[list(close)] = list(close.values())
    steps = np.linalg.norm(places[edges[:, 1]] - places[edges[:, 0]], axis=1)
    onwards = np.diff(ways[edges], axis=1)[:, 0]
    if is_loop:
        onwards = (onwards + length / 2) % length - length / 2
    usable = (np.abs(onwards) * LENGTH_RATIO > steps) & (np.abs(onwards) < LENGTH_RATIO * steps)
    edges = np.where(onwards[:, None] > 0, edges, edges[:, ::-1])[usable]
    nodes, ends = np.unique(edges, return_inverse=True)
    ends = ends.reshape(-1, 2)
    graph = coo_matrix((np.abs(onwards[usable]), ends.T), shape=(len(nodes), len(nodes))).tocsr()
    begins = np.setdiff1d(ends[:, 0], ends[:, 1])
    begins = begins if len(begins) else ends[:1, 0]  # edges all around a loop
    reached, before = dijkstra(graph, indices=begins, return_predecessors=True)
    reached[~np.isfinite(reached)] = 0
    free = np.ones(len(nodes), bool)
    for row in np.argsort(-reached.max(axis=1, initial=0), kind="stable"):
        path = np.array(_way_to(int(reached[row].argmax()), before[row]))
        if free[path].all():
            free[path] = False
            inner = nodes[path[~np.isin(nodes[path], at_ends)]]
            yield inner, ways[inner], float(reached[row].max())
