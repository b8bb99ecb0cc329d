# SPDX-License-Identifier: GPL-3.0-or-later
"""A quad mesh from a quad pattern: vertices where grid lines cross, faces between them (paper, Section 3.5)."""

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np

from ....geometry import TriangleMesh
from ....graphs import components, take_loops
from ....interpolate import EdgePhases
from .boundary_graph import SHARP, add_farthest, turning_angles, vertex_places
from .grid_lines import GridLines, grid_lines
from .line_graph import LineGraph
from .relocate_disclinations import relocate_disclinations

# Edges shorter than this part of the median length of their component count as degenerate.
SHORTEST = 1e-4
# Corners of the face of a round component.
_CORNERS = 4
# Properties of a quad mesh that do not depend on where its vertices are.
_OF_FACES = (
    *("starts", "corner_faces", "next_corners", "previous_corners"),
    *("half_edges", "edges", "on_rim", "is_irregular"),
)


@dataclass(frozen=True)
class QuadMesh:
    """Faces between grid lines, most of them quads, on the surface that they were traced on.

    Attributes
    ----------
    vertices : (n, 3)
    triangles, weights : (n,) triangle of the surface that each vertex lies in, (n, 3) barycentric coordinates there
    corner_vertices : (c,) vertex of each corner, counterclockwise, face by face
    sizes : (f,) number of corners of each face
    """

    vertices: np.ndarray
    triangles: np.ndarray
    weights: np.ndarray
    corner_vertices: np.ndarray
    sizes: np.ndarray

    def __getstate__(self) -> dict[str, object]:
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @cached_property
    def starts(self) -> np.ndarray:
        """(f,) first corner of each face."""
        return np.cumsum(self.sizes) - self.sizes

    @cached_property
    def corner_faces(self) -> np.ndarray:
        """(c,) face of each corner."""
        return np.repeat(np.arange(len(self.sizes)), self.sizes)

    @cached_property
    def next_corners(self) -> np.ndarray:
        """(c,) next corner of the face."""
        following = np.arange(1, len(self.corner_vertices) + 1)
        following[self.starts + self.sizes - 1] = self.starts
        return following

    @cached_property
    def previous_corners(self) -> np.ndarray:
        """(c,) previous corner of the face."""
        before = np.empty_like(self.next_corners)
        before[self.next_corners] = np.arange(len(before))
        return before

    @cached_property
    def half_edges(self) -> np.ndarray:
        """(c, 2) vertices from each corner to the next."""
        return np.column_stack([self.corner_vertices, self.corner_vertices[self.next_corners]])

    @property
    def is_unsound(self) -> np.ndarray:
        """(f,) bool: faces without three different corners, or with the vertices or a half-edge of another one."""
        result = self.sizes < 3
        for size in np.unique(self.sizes):
            faces = np.flatnonzero(self.sizes == size)
            result[faces] |= repeats(np.sort(self.corner_vertices[self.starts[faces, None] + np.arange(size)], axis=1))
        corners = np.column_stack([self.corner_faces, self.corner_vertices])
        result[self.corner_faces[repeats(corners) | repeats(self.half_edges)]] = True
        return result

    @cached_property
    def edges(self) -> tuple[np.ndarray, np.ndarray]:
        """(e, 2) vertices, the lower first, and (e,) number of faces at each."""
        count = len(self.vertices)
        names, counts = np.unique(np.sort(self.half_edges, axis=1) @ [count, 1], return_counts=True)
        return np.column_stack(np.divmod(names, count)), counts

    @property
    def edge_lengths(self) -> np.ndarray:
        """(e,) in the order of :attr:`edges`."""
        edges, _ = self.edges
        return np.linalg.norm(self.vertices[edges[:, 1]] - self.vertices[edges[:, 0]], axis=1)

    @property
    def edges_without_length(self) -> np.ndarray:
        """(k, 2) vertices of edges that are far shorter than others of their component, the lower first."""
        ends = self.half_edges
        lengths = np.linalg.norm(self.vertices[ends[:, 1]] - self.vertices[ends[:, 0]], axis=1)
        if lengths.min(initial=np.inf) >= SHORTEST * lengths.max(initial=0):
            return np.empty((0, 2), int)
        labels = components(len(self.vertices), ends)[ends[:, 0]]
        ordered, counts = lengths[np.lexsort((lengths, labels))], np.bincount(labels)
        medians = ordered[(np.cumsum(counts) - counts + counts // 2).clip(max=len(lengths) - 1)]
        return np.unique(np.sort(ends[lengths < SHORTEST * medians[labels]], axis=1), axis=0)

    @cached_property
    def on_rim(self) -> np.ndarray:
        """(n,) bool: vertices of edges with one face."""
        edges, counts = self.edges
        result = np.zeros(len(self.vertices), bool)
        result[edges[counts == 1]] = True
        return result

    def middles(self, vertices: np.ndarray) -> np.ndarray:
        """(f, 3) mean of each face's corners, with the vertices at (n, 3) places."""
        return np.add.reduceat(vertices[self.corner_vertices], self.starts) / self.sizes[:, None]

    @cached_property
    def is_irregular(self) -> np.ndarray:
        """(n,) bool: interior vertices with other than four edges."""
        edges, counts = self.edges
        result = np.bincount(edges.ravel(), minlength=len(self.vertices)) != 4
        result[edges[counts == 1]] = False
        return result

    @property
    def euler_characteristic(self) -> int:
        """V - E + F of all components together."""
        return len(self.vertices) - len(self.edges[0]) + len(self.sizes)

    @property
    def places(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Where the vertices are: :attr:`vertices`, :attr:`triangles` and :attr:`weights`."""
        return self.vertices, self.triangles, self.weights

    def moved(
        self, which: np.ndarray | slice, places: np.ndarray, triangles: np.ndarray, weights: np.ndarray
    ) -> "QuadMesh":
        """The quad mesh with some vertices moved on the surface."""
        values = self.vertices.copy(), self.triangles.copy(), self.weights.copy()
        for array, new in zip(values, (places, triangles, weights), strict=True):
            array[which] = new
        result = QuadMesh(*values, self.corner_vertices, self.sizes)
        # What follows from the faces alone stays.
        result.__dict__.update({name: self.__dict__[name] for name in _OF_FACES if name in self.__dict__})
        return result

    def only(self, kept: np.ndarray) -> "QuadMesh":
        """The quad mesh with some of its faces, (f,) bool, and without vertices that none of them uses."""
        return self.with_faces(self.corner_vertices[kept[self.corner_faces]], self.sizes[kept])

    def with_faces(self, corner_vertices: np.ndarray, sizes: np.ndarray) -> "QuadMesh":
        """The quad mesh with other faces, and without vertices that no face uses."""
        used, corners = np.unique(corner_vertices, return_inverse=True)
        return QuadMesh(self.vertices[used], self.triangles[used], self.weights[used], corners.ravel(), sizes)


def repeats(rows: np.ndarray) -> np.ndarray:
    """(n,) bool: rows that occur more than once."""
    _, labels, counts = np.unique(rows, axis=0, return_inverse=True, return_counts=True)
    return counts[labels.ravel()] > 1


def quad_mesh(edge_phases: EdgePhases) -> QuadMesh:
    """The quad mesh of the grid lines of a pattern with two phases at each vertex."""
    lines = grid_lines(relocate_disclinations(edge_phases))
    mesh = edge_phases.mesh
    positions = np.einsum("nk,nkx->nx", lines.weights, mesh.vertices[mesh.triangles[lines.triangles]])
    graph = _unite_centres(lines, positions)
    inside = _inside_parallel_edges(graph, lines.graph, positions)
    if inside:
        kept = lines.graph.kept.copy()
        kept[inside] = True
        graph = _unite_centres(replace(lines, graph=replace(lines.graph, kept=kept)), positions)
    darts, sizes = graph.faces()
    quads = QuadMesh(positions, lines.triangles, lines.weights, graph.tails[darts], sizes)
    return _add_island_faces(_without_short_edges(quads), mesh)


def _inside_parallel_edges(graph: LineGraph, traced: LineGraph, positions: np.ndarray) -> list[int]:
    """A node in the middle of each edge but the shortest of those between the same two nodes, as around a thin tube."""
    ends = np.sort(graph.tails.reshape(-1, 2), axis=1) @ [len(graph.kept), 1]
    _, labels, counts = np.unique(ends, return_inverse=True, return_counts=True)
    inside: list[int] = []
    follow = _Paths(traced)
    darts, last = 2 * np.flatnonzero(counts[labels] > 1), graph.heads
    for label in np.flatnonzero(counts > 1):
        parallel = darts[labels[darts // 2] == label].tolist()
        paths = [follow(int(graph.tails[dart]), float(graph.keys[dart]), int(last[dart])) for dart in parallel]
        along = [np.append(0, np.linalg.norm(np.diff(positions[path], axis=0), axis=1).cumsum()) for path in paths]
        for number in np.argsort([places[-1] for places in along], kind="stable")[1:]:
            path, between = paths[number][1:-1], along[number][1:-1]
            inside += path[np.abs(between - along[number][-1] / 2).argsort(kind="stable")[:1]].tolist()
    return inside


class _Paths:
    """Nodes along the edges of a graph from before its cleaning."""

    def __init__(self, traced: LineGraph) -> None:
        self._heads, self._keys = traced.heads, traced.keys
        self._order = np.argsort(traced.tails, kind="stable")
        self._starts = np.searchsorted(traced.tails[self._order], np.arange(len(traced.kept) + 1))

    def __call__(self, first: int, key: float, last: int) -> np.ndarray:
        """The nodes along an edge that leaves the first node at a key and ends at the last one. Where it crosses
        removed lines, only the nodes up to there are known."""
        path = [first]
        found = self._leaving(first)
        found = found[self._keys[found] == key]
        while len(found) == 1:
            path.append(int(self._heads[found[0]]))
            found = np.setdiff1d(self._leaving(path[-1]), found ^ 1) if path[-1] != last else found[:0]
        return np.array(path if path[-1] == last else [*path, last])

    def _leaving(self, node: int) -> np.ndarray:
        return self._order[self._starts[node] : self._starts[node + 1]]


def _without_short_edges(quads: QuadMesh) -> QuadMesh:
    """The quad mesh with degenerate edges contracted, and without faces that have fewer than three corners left.

    Such edges arise where lines that meet at a vertex of the surface were moved aside from it.
    """
    labels = components(len(quads.vertices), quads.edges_without_length)
    first = np.unique(labels, return_index=True)[1]
    corners = first[labels[quads.corner_vertices]]
    stays = corners != corners[quads.next_corners]
    sizes = np.bincount(quads.corner_faces[stays], minlength=len(quads.sizes))
    stays &= (sizes > 2)[quads.corner_faces]
    return quads.with_faces(corners[stays], sizes[sizes > 2])


def _unite_centres(lines: GridLines, positions: np.ndarray) -> LineGraph:
    """The clean graph of the lines, with all lines of each disclination meeting at one node.

    The phases of a disclination's triangle may lie a fraction of a cell beside its centre. Then some of its lines meet
    at a crossing nearby and only the others at the centre: the latter are led to the crossing too.
    """
    kept = lines.graph.kept.copy()
    kept[lines.centres] = True
    graph = replace(lines.graph, kept=kept).cleaned()
    for centre in lines.centres[lines.valences[lines.centres] == 5]:
        degree = np.count_nonzero(graph.tails == centre)
        if degree == 1:
            graph = _attach_line_end(graph, centre, positions)
        elif degree in (3, 4):
            graph = _unite_centre(graph, centre, positions)
    return replace(graph, kept=lines.graph.kept).cleaned()


def _attach_line_end(graph: LineGraph, centre: int, positions: np.ndarray) -> LineGraph:
    """Lead a line that ends at a centre on to a node of the surrounding face.

    In a hexagon that is the opposite corner, which leaves two quads; otherwise it is the nearest one.
    """
    (loose,) = np.flatnonzero(graph.tails == centre).tolist()
    rim = _rim(graph, loose)
    opposite = rim[len(rim) // 2]
    others = rim[~np.isin(graph.tails[rim], [centre, graph.heads[loose]]) & ~graph.kept[graph.tails[rim]]]
    if len(others) == 0:
        return graph
    distances = np.linalg.norm(positions[graph.tails[others]] - positions[centre], axis=1)
    # The rim of a hexagon has eight darts, because it passes the loose line on both sides.
    place = opposite if len(rim) == 8 and opposite in others else others[distances.argmin()]
    return _start_darts_at(graph, np.array([loose]), place, None)


def _rim(graph: LineGraph, dart: int) -> np.ndarray:
    """The darts around a face in order, starting with ``dart``."""
    rim = [dart]
    while graph.next[rim[-1]] != dart:
        rim.append(graph.next[rim[-1]])
    return np.array(rim)


def _unite_centre(graph: LineGraph, centre: int, positions: np.ndarray) -> LineGraph:
    """Merge a centre with an adjacent crossing into a node of five edges, if possible one between pentagons."""
    leaving = np.flatnonzero(graph.tails == centre)
    heads = graph.heads[leaving]
    fitting = (graph.degrees[heads] + len(leaving) == 7) & (heads != centre)
    if not fitting.any():
        return graph
    sizes = np.bincount(graph.face_labels)
    between = (sizes[graph.face_labels[leaving]] == 5) & (sizes[graph.face_labels[leaving ^ 1]] == 5)
    near = np.linalg.norm(positions[heads] - positions[centre], axis=1)
    way = leaving[np.lexsort((near, ~between, ~fitting))[0]]
    others = np.setdiff1d(leaving, way)
    later = graph.keys[others] > graph.keys[way]
    others = others[np.lexsort((graph.keys[others], ~later))]
    return _start_darts_at(graph, others, way ^ 1, way // 2)


def _start_darts_at(graph: LineGraph, darts: np.ndarray, place: int, removed: int | None) -> LineGraph:
    """The graph with darts moved, in counterclockwise order, to the node of the dart ``place``, right after it."""
    tails, keys = graph.tails.copy(), graph.keys.copy()
    node = tails[place]
    later = keys[(tails == node) & (keys > keys[place])]
    gap = later.min(initial=keys[place] + 1) - keys[place]
    keys[darts] = keys[place] + gap * np.arange(1, len(darts) + 1) / (len(darts) + 1)
    tails[darts] = node
    moved = LineGraph(tails, keys, graph.outside, graph.kept)
    if removed is None:
        return moved
    keep = np.ones(len(tails) // 2, bool)
    keep[removed] = False
    return moved.with_edges(keep)


def _add_island_faces(quads: QuadMesh, mesh: TriangleMesh) -> QuadMesh:
    """The quad mesh with one face more for each component of its surface that is a disk and has no faces."""
    faces = [_corners_of(mesh, rim) for rim in _rims_of_empty_disks(quads, mesh)]
    if not faces:
        return quads
    corners = np.concatenate(faces)
    triangles, weights = vertex_places(mesh, corners)
    return QuadMesh(
        np.concatenate([quads.vertices, mesh.vertices[corners]]),
        np.concatenate([quads.triangles, triangles]),
        np.concatenate([quads.weights, weights]),
        np.append(quads.corner_vertices, len(quads.vertices) + np.arange(len(corners))),
        np.append(quads.sizes, [len(face) for face in faces]),
    )


def _rims_of_empty_disks(quads: QuadMesh, mesh: TriangleMesh) -> Iterator[np.ndarray]:
    """Vertices around each disk without faces, counterclockwise."""
    pieces = mesh.pieces
    is_empty_disk = mesh.piece_euler_characteristics == 1
    is_empty_disk[pieces[mesh.triangles[quads.triangles[quads.corner_vertices], 0]]] = False
    tails, heads = mesh.triangles.ravel(), np.roll(mesh.triangles, -1, axis=1).ravel()
    half = np.flatnonzero((mesh.twins < 0) & is_empty_disk[pieces[tails]])
    yield from map(np.array, take_loops(dict(zip(tails[half].tolist(), heads[half].tolist(), strict=True))))


def _corners_of(mesh: TriangleMesh, rim: np.ndarray) -> np.ndarray:
    """Vertices at which a closed line turns sharply; with fewer than three, others far apart are added."""
    points, places = mesh.vertices[rim], np.arange(len(rim))
    chosen = places[turning_angles(points, places) > SHARP].tolist()
    if len(chosen) < 3:
        chosen = chosen or [0]
        chosen += add_farthest(points, chosen, places, _CORNERS)
    return rim[np.sort(chosen)]
