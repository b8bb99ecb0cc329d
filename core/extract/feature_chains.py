# SPDX-License-Identifier: GPL-3.0-or-later
"""Chains of a quad mesh's edges put onto boundaries and sharp edges of its surface, and vertices onto their corners.

Where a grid line was held on a line, its vertices lie there already; at corners, where phases cannot be had in full,
the nearest vertex of the right number of edges is taken. Where the next vertex of a line is across a face, the face can
be cut in two. A line that no chain follows is left alone.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from ..fields.constraints.features import quads_around
from .feature_lines import FeatureLines
from .quad_mesh import SHORTEST

# Distances, in sides of a quad, up to which a vertex may be put onto a corner, and onto a line.
CORNER_REACH, LINE_REACH = 1.0, 0.8
# What an edge too many or too few at a corner's vertex counts for, in sides.
VALENCE_COST = 0.35
# How much more than its length an edge at the farthest distance costs.
DISTANCE_COST = 50.0
# What cutting a face in two costs, in sides.
CUTTING = 3.0
# Chains that are longer or shorter than the line by more than this factor are none.
LENGTH_RATIO = 2.0
# Vertices of a chain nearer to each other than this part of their mean distance are spread evenly.
SMALLEST_GAP = 0.25


@dataclass(frozen=True)
class Chains:
    """Vertices of a quad mesh that belong to lines.

    Attributes
    ----------
    features : FeatureLines
    lines : (n,) line on which each vertex slides, -1 for none
    fixed : (n,) bool, those on corners
    missed : numbers of the lines that no chain follows
    """

    features: FeatureLines
    lines: np.ndarray
    fixed: np.ndarray
    missed: tuple[int, ...]

    def of_vertices(self, which):
        """The chains of a quad mesh that has (k,) of the vertices alone."""
        return replace(self, lines=self.lines[which], fixed=self.fixed[which])

    def edges(self, quads):
        """(e, 2) vertices of the quad mesh's edges that may be of a line."""
        ends = quads.edges[0]
        on_line = self.fixed | (self.lines >= 0)
        lines = self.lines[ends]
        return ends[on_line[ends].all(axis=1) & ((lines[:, 0] == lines[:, 1]) | self.fixed[ends].any(axis=1))]


def on_features(quads, features, side, cut=False):
    """The quad mesh with chains of its edges on feature lines, and the :class:`Chains`.

    Parameters
    ----------
    quads : QuadMesh
    features : FeatureLines of the surface that it was traced on
    side : length of a quad's side
    cut : whether faces are cut in two where a line leads through them
    """
    edges, counts = quads.edges
    on_rim = np.zeros(len(quads.vertices), bool)
    on_rim[edges[counts == 1]] = True
    at_corner = _left_to_neighbours(quads, features, side, _corner_vertices(quads, features, side, on_rim))
    taken = np.zeros(len(quads.vertices), bool)
    taken[list(at_corner.values())] = True
    lines, fixed = np.full(len(taken), -1), taken.copy()
    quads = placed(quads, *_corner_places(features, at_corner))
    missed, diagonals = [], _diagonals(quads) if cut else edges[:0]
    for number in np.argsort(~features.on_boundary, kind="stable").tolist():
        usable = edges[(counts == 1) == features.on_boundary[number]]
        made = diagonals[: 0 if features.on_boundary[number] else None]
        chain = _chain(quads, features, number, side, (usable, made), at_corner, taken, on_rim)
        with_cuts = None if chain is None else _cut(quads, chain[2])
        if with_cuts is None:
            missed.append(number)
            continue
        vertices, ways, cuts = chain
        lines[vertices], taken[vertices] = number, True
        if len(cuts):
            quads = with_cuts
            edges, counts = quads.edges
            diagonals = _diagonals(quads)
        quads = placed(quads, vertices, *features.at(number, ways))
    return quads, Chains(features, lines, fixed, tuple(missed))


def placed(quads, which, places, triangles, weights):
    """The quad mesh with some vertices at other places of the surface."""
    result = replace(quads, **{n: getattr(quads, n).copy() for n in ("vertices", "triangles", "weights")})
    result.vertices[which], result.triangles[which], result.weights[which] = places, triangles, weights
    return result


def _corner_vertices(quads, features, side, on_rim):
    """Which vertex of the quad mesh goes to each corner: a dict, nearest pairs first."""
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


def _left_to_neighbours(quads, features, side, at_corner):
    """The same, but a corner at which a neighbour of its vertex stands is the neighbour's: the edge between them would
    have no length."""
    corner_of = np.full(len(quads.vertices), -1)
    corner_of[list(at_corner.values())] = list(at_corner)
    ends = quads.edges[0]
    ends = np.concatenate([ends, ends[:, ::-1]])
    ends = ends[(corner_of[ends[:, 0]] >= 0) & (corner_of[ends[:, 1]] < 0)]
    apart = quads.vertices[ends[:, 1]] - features.mesh.vertices[corner_of[ends[:, 0]]]
    stands = np.linalg.norm(apart, axis=1) < SHORTEST * side
    return at_corner | dict(zip(corner_of[ends[stands, 0]].tolist(), ends[stands, 1].tolist(), strict=True))


def _pieces(quads, mesh):
    """(n,) label of the surface's piece that each vertex of the quad mesh is on."""
    return mesh.pieces[mesh.triangles[quads.triangles, 0]]


def _corner_places(features, at_corner):
    """Vertices of the quad mesh with their places, triangles and barycentric coordinates at the corners."""
    mesh = features.mesh
    corners = np.array(list(at_corner), int)
    corner_of = np.zeros(mesh.vertex_count, int)
    corner_of[mesh.triangles.ravel()] = np.arange(3 * mesh.triangle_count)
    at = corner_of[corners]
    return np.array(list(at_corner.values()), int), mesh.vertices[corners], at // 3, np.eye(3)[at % 3]


def _diagonals(quads):
    """(d, 2) vertices between which faces can be cut in two: corners of one that no edge and no other face joins."""
    across = [np.empty((0, 2), int)]
    for size in np.unique(quads.sizes):
        corners = quads.corner_vertices[quads.starts[quads.sizes == size, None] + np.arange(size)]
        across += [corners[:, [i, j]] for i in range(size) for j in range(i + 2, size - (i == 0))]
    pairs, faces = np.unique(np.sort(np.concatenate(across), axis=1), axis=0, return_counts=True)
    pairs = pairs[faces == 1]
    count = len(quads.vertices)
    return pairs[~np.isin(pairs @ [count, 1], quads.edges[0] @ [count, 1])]


def _cut(quads, pairs):
    """The quad mesh with the face that holds both vertices cut in two between them, for each of (k, 2) pairs; None
    where one cut takes another's face apart."""
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


def _chain(quads, features, number, side, edges, at_corner, taken, on_rim):
    """Vertices along one line, without those at its corners, how far along it they go, and the pairs of vertices
    between which faces are to be cut; or None.

    ``edges`` are (e, 2) those that may be taken, and (d, 2) those that may be made.
    """
    line, length = features.lines[number], features.lengths[number][-1]
    near = np.unique(np.concatenate(edges))
    near = near[_pieces(quads, features.mesh)[near] == features.mesh.pieces[line[0]]]
    near = near[_within(quads.vertices[near], features.mesh.vertices[line], LINE_REACH * side + length / len(line))]
    ways, apart = np.full(len(quads.vertices), np.nan), np.full(len(quads.vertices), np.inf)
    ways[near], apart[near] = features.nearest(number, quads.vertices[near])
    apart[taken] = np.inf
    begin, closed = 0.0, line[0] == line[-1] and line[0] not in features.corners
    first, last = (at_corner.get(int(corner)) for corner in line[[0, -1]])
    if closed:
        first = last = int(np.where(on_rim == features.on_boundary[number], apart, np.inf).argmin())
        begin, ways = ways[first], (ways - ways[first]) % length
    if first is None or last is None or (closed and apart[first] > LINE_REACH * side):
        return None
    path, cuts = _path(quads, edges, ways, apart, side, (first, last), length)
    if path is None:
        return None
    steps = np.linalg.norm(np.diff(quads.vertices[path], axis=0), axis=1)
    inner = _spread(ways[path[1:-1]], length, steps)
    if not length / LENGTH_RATIO < steps.sum() < length * LENGTH_RATIO or (closed and len(steps) < 3):
        return None
    return (path[:-1], (begin + np.append(0, inner)) % length, cuts) if closed else (path[1:-1], inner, cuts)


def _within(points, line, reach):
    return cKDTree(line).query(points, distance_upper_bound=reach)[0] <= reach


def _spread(ways, span, steps):
    """Ways from 0 to a span, evenly as the steps where they are not in order or too near to each other."""
    gaps = np.diff(np.concatenate([[0], ways, [span]]))
    if (gaps > SMALLEST_GAP * span / len(gaps)).all():
        return ways
    return span * np.cumsum(steps)[:-1] / steps.sum()


def _path(quads, edges, ways, apart, side, ends, length):
    """(k,) vertices from one end of a line to the other along edges near it, and (c, 2) those of its steps that are
    made; or None, None.

    The ends may be the same vertex, or neighbours: they are two nodes of their own, and an edge counts where it leads
    about as far along the line as it is long.

    Parameters
    ----------
    quads : QuadMesh
    edges : (e, 2) vertices of those that may be taken, and (d, 2) of those that may be made
    ways, apart : (n,) how far along the line each vertex is, and how far from it
    side : length of a quad's side
    ends : the vertices at the line's begin and end
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
        onwards = np.abs(np.diff(ways[part], axis=1)[:, 0]) < LENGTH_RATIO * steps
        usable = onwards & (apart[part] < LINE_REACH).all(axis=1)
        away = np.where(usable, (apart[part] ** 2).mean(axis=1), 0)
        costs.append(np.where(usable, steps * (1 + DISTANCE_COST * away) + more + 1e-9 * side, np.inf))
    passages, lengths = np.concatenate(parts), np.concatenate(costs)
    taken = np.isfinite(lengths)
    graph = coo_matrix((lengths[taken], passages[taken].T), shape=(count + 2, count + 2))
    _, before = dijkstra(graph, directed=False, indices=count, return_predecessors=True)
    nodes = [count + 1]
    while nodes[-1] != count:
        if before[nodes[-1]] < 0:
            return None, None
        nodes.append(before[nodes[-1]])
    path = names[nodes[::-1]]
    steps = np.sort(np.column_stack([path[:-1], path[1:]]), axis=1)
    return path, steps[np.isin(steps @ [count, 1], edges[1] @ [count, 1])]


def _with_ends(edges, ends, count):
    """Edges, and those at the ends of a line with the nodes ``count`` and ``count + 1`` in place of these."""
    begins = np.where(edges == ends[0], count, edges)
    stops, both = (np.where(part == ends[1], count + 1, part) for part in (edges, begins))
    begun, stopped = ((part != edges).any(axis=1) for part in (begins, stops))
    return np.concatenate([edges, begins[begun], stops[stopped], both[begun & stopped & (both != begins).any(axis=1)]])
