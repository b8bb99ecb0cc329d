# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts chains of a quad mesh's edges onto boundaries and sharp edges of its surface, and vertices onto corners.

Where a grid line was held on a line, its vertices lie there already. At corners, which phases cannot follow exactly,
the nearest vertex with a suitable number of edges is used. Where the next vertex of a line lies across a face, the face
can be cut in two. Where no chain follows a line from end to end, because one of its corners has no vertex or lines are
crowded, chains follow the parts of the line on which edges lie.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from ....fields.constraints.features import quads_around
from ....geometry import TriangleMesh
from ....graphs import ragged_arange
from ..trace.boundary_graph import vertex_places
from ..trace.quad_mesh import SHORTEST, QuadMesh
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
    edges, counts = quads.edges
    on_rim = quads.on_rim
    at_corner = _prefer_neighbours(quads, features, side, _corner_vertices(quads, features, side, on_rim))
    taken = np.zeros(len(quads.vertices), bool)
    taken[list(at_corner.values())] = True
    lines, fixed = np.full(len(taken), -1), taken.copy()
    corners = np.array(list(at_corner), int)
    at = np.array(list(at_corner.values()), int)
    quads = move_vertices(quads, at, features.mesh.vertices[corners], *vertex_places(features.mesh, corners))
    tree, pieces = cKDTree(quads.vertices), _pieces(quads, features.mesh)
    followed, diagonals = features.lengths.copy(), _diagonals(quads) if cut else edges[:0]
    passages = [_Passages(part, len(taken)) for part in (edges[counts == 1], edges[counts != 1], diagonals)]
    for number in np.argsort(~features.on_boundary, kind="stable").tolist():
        line = features.lines[number]
        reach = LINE_REACH * side + features.lengths[number] / len(line)
        close = np.zeros(len(taken), bool)
        close[np.concatenate(tree.query_ball_point(features.mesh.vertices[line], reach)).astype(int)] = True
        near = np.flatnonzero(close & ~taken & (pieces == features.mesh.pieces[line[0]]))
        ends = [at_corner[int(corner)] for corner in line[[0, -1]] if int(corner) in at_corner]
        between = [part.between(np.union1d(near, ends).astype(int)) for part in passages]
        usable, made = (between[0], edges[:0]) if features.on_boundary[number] else between[1:]
        ways, apart = np.full(len(taken), np.nan), np.full(len(taken), np.inf)
        ways[near], apart[near] = features.nearest(number, quads.vertices[near])
        chain = _chain(quads, features, number, side, (usable, made), at_corner, (ways, apart), on_rim)
        with_cuts = None if chain is None else _cut_faces(quads, chain[2])
        if chain is None or with_cuts is None:
            followed[number] = 0
            for vertices, places, length in _parts(quads, features, number, side, usable, at_corner, ways, apart):
                lines[vertices], taken[vertices] = number, True
                quads = move_vertices(quads, vertices, *features.at(number, places))
                followed[number] = min(followed[number] + length, features.lengths[number])
            continue
        vertices, ways, cuts = chain
        lines[vertices], taken[vertices] = number, True
        if len(cuts):
            quads = with_cuts
            edges, counts = quads.edges
            passages = [
                _Passages(part, len(taken)) for part in (edges[counts == 1], edges[counts != 1], _diagonals(quads))
            ]
        quads = move_vertices(quads, vertices, *features.at(number, ways))
    gaps = features.lengths / (1 + np.bincount(lines[lines >= 0], minlength=len(features.lines)))
    return quads, Chains(features, lines, fixed, followed, gaps)


class _Passages:
    """(e, 2) edges or diagonals of a quad mesh with some number of vertices, found from their ends."""

    def __init__(self, ends: np.ndarray, count: int) -> None:
        self._ends, self._order = ends, np.argsort(ends, axis=None, kind="stable")
        self._starts = np.searchsorted(ends.ravel()[self._order], np.arange(count + 1))

    def between(self, vertices: np.ndarray) -> np.ndarray:
        """(k, 2) those with both ends among (v,) ascending vertices, in their order."""
        rows, places = ragged_arange(self._starts[vertices + 1] - self._starts[vertices])
        found, counts = np.unique(self._order[self._starts[vertices][rows] + places] // 2, return_counts=True)
        return self._ends[found[counts == 2]]


def move_vertices(
    quads: QuadMesh, which: np.ndarray, places: np.ndarray, triangles: np.ndarray, weights: np.ndarray
) -> QuadMesh:
    """The quad mesh with some vertices moved on the surface."""
    result = replace(quads, **{n: getattr(quads, n).copy() for n in ("vertices", "triangles", "weights")})
    result.vertices[which], result.triangles[which], result.weights[which] = places, triangles, weights
    return result


def _corner_vertices(quads: QuadMesh, features: FeatureLines, side: float, on_rim: np.ndarray) -> dict[int, int]:
    """The vertex of the quad mesh for each corner; the pairs with the least cost are chosen first."""
    mesh, corners = features.mesh, features.corners
    if len(corners) == 0:
        return {}
    valences = np.bincount(quads.edges[0].ravel(), minlength=len(quads.vertices))
    of_vertices, of_corners = _pieces(quads, mesh), mesh.pieces[corners]
    wanted = quads_around(mesh, features.edges, corners) + mesh.boundary_vertices[corners]
    pairs = cKDTree(mesh.vertices[corners]).query_ball_tree(cKDTree(quads.vertices), CORNER_REACH * side)
    costs = []
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


def _pieces(quads: QuadMesh, mesh: TriangleMesh) -> np.ndarray:
    """(n,) component of the surface that each vertex of the quad mesh is on."""
    return mesh.pieces[mesh.triangles[quads.triangles, 0]]


def _diagonals(quads: QuadMesh) -> np.ndarray:
    """(d, 2) vertices between which a face can be cut in two: not joined by an edge, nor corners of another face."""
    across = [np.empty((0, 2), int)]
    for size in np.unique(quads.sizes):
        corners = quads.corner_vertices[quads.starts[quads.sizes == size, None] + np.arange(size)]
        across += [corners[:, [i, j]] for i in range(size) for j in range(i + 2, size - (i == 0))]
    pairs, faces = np.unique(np.sort(np.concatenate(across), axis=1), axis=0, return_counts=True)
    pairs = pairs[faces == 1]
    count = len(quads.vertices)
    return pairs[~np.isin(pairs @ [count, 1], quads.edges[0] @ [count, 1])]


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
    quads: QuadMesh,
    features: FeatureLines,
    number: int,
    side: float,
    edges: tuple[np.ndarray, np.ndarray],
    at_corner: dict[int, int],
    nearest: tuple[np.ndarray, np.ndarray],
    on_rim: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Vertices along one line without its corners, their positions along it, and the pairs of vertices between which
    faces are cut; None without a chain.

    ``edges`` are (e, 2) usable edges, and (d, 2) diagonals along which faces may be cut; ``near`` are (k,) vertices
    that may lie on the line.
    """
    line, length = features.lines[number], features.lengths[number]
    ways, apart = nearest
    begin, closed = 0.0, features.closed[number]
    first, last = (at_corner.get(int(corner)) for corner in line[[0, -1]])
    if closed:
        first = last = int(np.where(on_rim == features.on_boundary[number], apart, np.inf).argmin())
        begin, ways = ways[first], (ways - ways[first]) % length
    if first is None or last is None or (closed and apart[first] > LINE_REACH * side):
        return None
    shortest = side if features.on_boundary[number] else 0.0
    found = _path(quads, edges, ways, apart, side, (first, last), length, shortest)
    if found is None:
        return None
    path, cuts = found
    steps = np.linalg.norm(np.diff(quads.vertices[path], axis=0), axis=1)
    if not length / LENGTH_RATIO < steps.sum() < length * LENGTH_RATIO or (closed and len(steps) < 3):
        return None
    inner = _spread_evenly(ways[path[1:-1]], length, steps)
    return (path[:-1], (begin + np.append(0, inner)) % length, cuts) if closed else (path[1:-1], inner, cuts)


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
    quads: QuadMesh,
    edges: tuple[np.ndarray, np.ndarray],
    ways: np.ndarray,
    apart: np.ndarray,
    side: float,
    ends: tuple[int, int],
    length: float,
    shortest: float,
) -> tuple[np.ndarray, np.ndarray] | None:
    """(k,) vertices from one end of a line to the other along edges near it, and (c, 2) steps along diagonals; or None.

    The ends may be the same vertex or neighbours, so they get nodes of their own. An edge is usable if it leads about
    as far along the line as it is long.

    Parameters
    ----------
    edges : (e, 2) usable edges, and (d, 2) diagonals
    ways, apart : (n,) positions of the vertices along the line, and distances from it
    side : length of a quad's side
    ends : the vertices at the line's ends
    length : of the line
    """
    count = len(quads.vertices)
    names = np.append(np.arange(count), ends)
    apart = apart / side
    apart[list(ends)] = np.inf
    ways, apart = np.append(ways, [0, length]), np.append(apart, [0, 0])
    close = np.isfinite(apart)
    close[list(ends)] = True
    parts, costs = [_with_ends(part[close[part].all(axis=1)], ends, count) for part in edges], []
    for part, more in zip(parts, (0.0, CUTTING * side), strict=True):
        steps = np.linalg.norm(np.diff(quads.vertices[names[part]], axis=1)[:, 0], axis=1)
        onwards = np.abs(np.diff(ways[part], axis=1)[:, 0]) < LENGTH_RATIO * np.maximum(steps, shortest)
        usable = onwards & (apart[part] < LINE_REACH).all(axis=1)
        away = np.where(usable, (apart[part] ** 2).mean(axis=1), 0)
        costs.append(np.where(usable, steps * (1 + DISTANCE_COST * away) + more + 1e-9 * side, np.inf))
    passages, lengths = np.concatenate(parts), np.concatenate(costs)
    taken = np.isfinite(lengths)
    nodes, ends_of = np.unique(np.append(passages[taken], [count, count + 1]), return_inverse=True)
    graph = coo_matrix((lengths[taken], ends_of[:-2].reshape(-1, 2).T), shape=(len(nodes), len(nodes)))
    _, before = dijkstra(graph, directed=False, indices=len(nodes) - 2, return_predecessors=True)
    path = names[nodes[_way_to(len(nodes) - 1, before)]]
    if path[0] != names[count]:
        return None
    steps = np.sort(np.column_stack([path[:-1], path[1:]]), axis=1)
    return path, steps[np.isin(steps @ [count, 1], edges[1] @ [count, 1])]


def _way_to(end: int, before: np.ndarray) -> list[int]:
    """The nodes of the path to a node; ``before`` are predecessors, negative at its start."""
    way = [end]
    while before[way[-1]] >= 0:
        way.append(int(before[way[-1]]))
    return way[::-1]


def _parts(
    quads: QuadMesh,
    features: FeatureLines,
    number: int,
    side: float,
    edges: np.ndarray,
    at_corner: dict[int, int],
    ways: np.ndarray,
    apart: np.ndarray,
) -> Iterator[tuple[np.ndarray, np.ndarray, float]]:
    """The parts of a line on which edges lie: vertices that are not at its corners, their positions along the line, and
    the length of the part.

    ``ways`` and ``apart`` are (n,) positions of the vertices along the line, and distances from it, infinite for those
    that may not lie on it; other arguments as of :func:`_chain`.
    """
    line, length = features.lines[number], features.lengths[number]
    is_loop = line[0] == line[-1]
    ways, apart = ways.copy(), apart.copy()
    at_ends = [] if features.closed[number] else [at_corner.get(int(corner), -1) for corner in line[[0, -1]]]
    for vertex, way in zip(at_ends, (0.0, length), strict=False):
        if vertex >= 0:
            apart[(np.abs(ways - way) < SMALLEST_GAP * side) & (np.arange(len(ways)) != vertex)] = np.inf
            ways[vertex], apart[vertex] = way, 0.0
    edges = edges[(apart[edges] < PART_REACH * side).all(axis=1)]
    steps = np.linalg.norm(np.diff(quads.vertices[edges], axis=1)[:, 0], axis=1)
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


def _with_ends(edges: np.ndarray, ends: tuple[int, int], count: int) -> np.ndarray:
    """Edges, and copies in which the nodes ``count`` and ``count + 1`` replace the ends of the line."""
    first = np.where(edges == ends[0], count, edges)
    last, both = (np.where(part == ends[1], count + 1, part) for part in (edges, first))
    at_first, at_last = ((part != edges).any(axis=1) for part in (first, last))
    at_both = at_first & at_last & (both != first).any(axis=1)
    return np.concatenate([edges, first[at_first], last[at_last], both[at_both]])
