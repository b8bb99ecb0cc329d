# SPDX-License-Identifier: GPL-3.0-or-later
"""A quad mesh from a quad pattern: vertices where grid lines cross, faces between them (paper, Section 3.5)."""

from dataclasses import dataclass, replace

import numpy as np

from ....graphs import components
from ....interpolate import EdgePhases
from .grid_lines import grid_lines
from .islands import with_whole_islands
from .line_graph import LineGraph
from .relocate_disclinations import relocate_disclinations

# Edges shorter than this part of the middle length are none.
SHORTEST = 1e-4


@dataclass(frozen=True)
class QuadMesh:
    """Faces between grid lines, most of them quads, on the surface that they were traced on.

    Attributes
    ----------
    vertices : (n, 3)
    triangles, weights : (n,) triangle of the surface that each vertex lies in, (n, 3) barycentric coordinates there
    corner_vertices : (c,) vertex of each corner, counterclockwise; the corners of a face follow one another
    sizes : (f,) corners of each face
    """

    vertices: np.ndarray
    triangles: np.ndarray
    weights: np.ndarray
    corner_vertices: np.ndarray
    sizes: np.ndarray

    @property
    def starts(self):
        """(f,) first corner of each face."""
        return np.cumsum(self.sizes) - self.sizes

    @property
    def corner_faces(self):
        """(c,) face of each corner."""
        return np.repeat(np.arange(len(self.sizes)), self.sizes)

    @property
    def next_corners(self):
        """(c,) the corner that follows on the face's rim."""
        following = np.arange(1, len(self.corner_vertices) + 1)
        following[self.starts + self.sizes - 1] = self.starts
        return following

    @property
    def half_edges(self):
        """(c, 2) vertices from each corner to the next."""
        return np.column_stack([self.corner_vertices, self.corner_vertices[self.next_corners]])

    @property
    def is_simple(self):
        """Whether all faces have three corners or more and pass no vertex twice, no two of them have the same vertices,
        and no two edges join the same two."""
        if self.sizes.min(initial=3) < 3:
            return False
        for size in np.unique(self.sizes):
            of_size = np.sort(self.corner_vertices[self.starts[self.sizes == size, None] + np.arange(size)], axis=1)
            if len(np.unique(of_size, axis=0)) < len(of_size):
                return False
        corners = np.column_stack([self.corner_faces, self.corner_vertices])
        ways = np.unique(self.half_edges, axis=0)
        return len(np.unique(corners, axis=0)) == len(corners) and len(ways) == len(corners)

    @property
    def edges(self):
        """(e, 2) vertices, the lower first, and (e,) faces at each."""
        return np.unique(np.sort(self.half_edges, axis=1), axis=0, return_counts=True)

    @property
    def is_irregular(self):
        """(n,) bool: vertices inside with other than four edges."""
        edges, counts = self.edges
        result = np.bincount(edges.ravel(), minlength=len(self.vertices)) != 4
        result[edges[counts == 1]] = False
        return result

    @property
    def euler_characteristic(self):
        """V - E + F over all pieces."""
        return len(self.vertices) - len(self.edges[0]) + len(self.sizes)

    def with_faces(self, corner_vertices, sizes):
        """The quad mesh with other faces on its vertices, those that no face has left out."""
        used, corner_vertices = np.unique(corner_vertices, return_inverse=True)
        own = {name: getattr(self, name)[used] for name in ("vertices", "triangles", "weights")}
        return QuadMesh(**own, corner_vertices=corner_vertices.ravel(), sizes=sizes)


def quad_mesh(edge_phases: EdgePhases) -> QuadMesh:
    """The :class:`QuadMesh` of the grid lines of :class:`EdgePhases` with two phases a vertex."""
    lines = grid_lines(relocate_disclinations(edge_phases))
    mesh = edge_phases.mesh
    positions = np.einsum("nk,nkx->nx", lines.weights, mesh.vertices[mesh.triangles[lines.triangles]])
    graph = _with_whole_centres(lines, positions)
    darts, sizes = graph.faces()
    quads = QuadMesh(positions, lines.triangles, lines.weights, graph.tails[darts], sizes)
    return with_whole_islands(_without_short_edges(quads), mesh)


def _without_short_edges(quads):
    """The quad mesh with the ends of each edge of no length as one vertex, and without faces of fewer than three
    corners: lines that meet at a vertex of the surface were moved aside from it."""
    edges, _ = quads.edges
    lengths = np.linalg.norm(quads.vertices[edges[:, 1]] - quads.vertices[edges[:, 0]], axis=1)
    short = edges[lengths < SHORTEST * np.median(lengths)] if len(edges) else edges
    labels = components(len(quads.vertices), short)
    first = np.unique(labels, return_index=True)[1]
    corners = first[labels[quads.corner_vertices]]
    stays = corners != corners[quads.next_corners]
    sizes = np.bincount(quads.corner_faces[stays], minlength=len(quads.sizes))
    stays &= (sizes > 2)[quads.corner_faces]
    return quads.with_faces(corners[stays], sizes[sizes > 2])


def _with_whole_centres(lines, positions):
    """The clean graph of the lines, where those that belong to a disclination meet at one node.

    The phases of a disclination's triangle may lie a part of a cell beside its centre. Then lines of its vertex meet
    at a crossing nearby, and only the others at the centre: those go to the crossing too.
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


def _attach_line_end(graph, centre, positions):
    """A line that ends at a centre leads to a node of the face around it instead.

    In a hexagon that is the opposite corner, which leaves two quads; otherwise the nearest one.
    """
    (loose,) = np.flatnonzero(graph.tails == centre)
    rim = _rim(graph, loose)
    opposite = rim[len(rim) // 2]
    others = rim[~np.isin(graph.tails[rim], [centre, graph.heads[loose]]) & ~graph.kept[graph.tails[rim]]]
    if len(others) == 0:
        return graph
    distances = np.linalg.norm(positions[graph.tails[others]] - positions[centre], axis=1)
    # The rim of a hexagon passes the loose line on both sides.
    place = opposite if len(rim) == 8 and opposite in others else others[distances.argmin()]
    return _start_darts_at(graph, np.array([loose]), place, None)


def _rim(graph, dart):
    """The darts of a face in order, from one of them on."""
    rim = [dart]
    while graph.next[rim[-1]] != dart:
        rim.append(graph.next[rim[-1]])
    return np.array(rim)


def _unite_centre(graph, centre, positions):
    """A centre and a crossing beside it become one node of five edges: the nearest, better one between pentagons."""
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


def _start_darts_at(graph, darts, place, removed):
    """The graph with darts, in counterclockwise order, leaving the node of the dart ``place`` right after it."""
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
