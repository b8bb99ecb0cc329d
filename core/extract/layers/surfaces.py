# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers as surfaces: where the phase of a solid is a multiple of 2 pi, one triangle mesh for all of them.

Sheets end on the boundary of the solid and at dislocation curves, and are manifold otherwise: triangles are joined
along an edge only if exactly two meet there, and a vertex where sheets only touch is split.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...geometry import TriangleMesh
from ...geometry.tet_mesh import TetMesh
from ...graphs import components, label_rows
from ...interpolate import TURN, EdgePhases
from ...interpolate_solid import face_numbers, outward_numbers
from .crossings import LayerCrossings, crossings_of, polygons_in
from .punctured import sheets_in


@dataclass(frozen=True)
class LayerSurfaces:
    """Triangles of all layers.

    Attributes
    ----------
    vertices : (p, 3)
    triangles : (t, 3) vertices, with normals to larger phases
    layers : (t,) number of the connected piece, from 0 at the bottom, or of the level, of all pieces at one height;
        a screw dislocation along the normals joins the sheets around it into one ramp
    corners, weights : (p, 4) vertices of the solid between which each vertex lies, and their weights
    levels : (count,) number of the height at which each layer lies, from 0 in its body; several pieces may share one
    """

    vertices: np.ndarray
    triangles: np.ndarray
    layers: np.ndarray
    corners: np.ndarray
    weights: np.ndarray
    levels: np.ndarray

    @cached_property
    def mesh(self) -> TriangleMesh:
        """All layers as one mesh."""
        return TriangleMesh(self.vertices, self.triangles)

    @property
    def count(self) -> int:
        """Number of layers as :attr:`layers` numbers them."""
        return int(self.layers.max(initial=-1)) + 1

    @property
    def level_count(self) -> int:
        """Number of heights at which layers lie."""
        return int(self.levels.max(initial=-1)) + 1

    @property
    def areas(self) -> np.ndarray:
        """(count,) areas of the layers."""
        a, b, c = np.moveaxis(self.vertices[self.triangles], 1, 0)
        areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
        return np.bincount(self.layers, areas, self.count)


def layer_surfaces(edge_phases: EdgePhases[TetMesh], heights: np.ndarray, by_level: bool = False) -> LayerSurfaces:
    """Extract the layers where the phase is 2 pi k.

    Parameters
    ----------
    edge_phases : one phase a vertex
    heights : (n,) for the order of layers, such as :attr:`LayerPattern.heights`
    by_level : number levels instead of pieces, in each piece of the solid from its lowest layer; a piece of a layer
        whose level varies, around dislocations, has the level of its mean height
    """
    mesh, crossings = edge_phases.mesh, crossings_of(edge_phases)
    numbers = face_numbers(edge_phases)
    punctured = outward_numbers(mesh, numbers).any(axis=1)
    triangles, quads = polygons_in(crossings, np.flatnonzero(~punctured))
    sheets = sheets_in(crossings, numbers, np.flatnonzero(punctured))
    count = len(crossings.edges)
    # Crossings, vertices, centres of faces, centres of tetrahedra.
    node_of = np.append(crossings.nodes, np.arange(len(mesh.faces) + mesh.tet_count) + count + mesh.vertex_count)
    inner = node_of[np.concatenate([triangles, _halves(crossings, quads), sheets])]
    faces = count + crossings.faces
    inner = _without_doubles(inner[(inner != np.roll(inner, 1, axis=1)).all(axis=1)], faces)
    return _number_vertices(crossings, np.concatenate([inner, faces]), len(inner), heights, by_level)


def _halves(crossings: LayerCrossings, quads: np.ndarray) -> np.ndarray:
    """(2 q, 3) triangles of quads, cut along their shorter diagonals."""
    ends = crossings.mesh.vertices[crossings.mesh.edges[crossings.edges]]
    points = ends[:, 0] + crossings.shares[:, None] * (ends[:, 1] - ends[:, 0])
    a, b, c, d = (points[quads[:, k]] for k in range(4))
    turned = np.linalg.norm(b - d, axis=1) < np.linalg.norm(a - c, axis=1)
    quads = np.where(turned[:, None], np.roll(quads, -1, axis=1), quads)
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def _without_doubles(triangles: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Remove triangles that are boundary faces already, and opposite pairs, where a sheet touches itself."""
    both = np.sort(np.concatenate([triangles, faces]), axis=1)
    label = label_rows(both)
    a, b, c = triangles.T
    sign = np.where((b > a) ^ (c > b) ^ (c > a), 1, -1)
    label, covered = label[: len(triangles)], label[len(triangles) :]
    net = np.bincount(label, sign, minlength=len(both))
    net[covered] = 0
    return triangles[net[label] * sign > 0]


def _links(triangles: np.ndarray, inner_count: int) -> np.ndarray:
    """(k, 2) half-edges of neighbouring triangles that are joined.

    Two triangles of the same kind at an edge, both on the boundary or both inside, are joined first; then the two that
    are left, of different kinds.
    """
    tails, heads = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    low, high = np.minimum(tails, heads), np.maximum(tails, heads)
    edge = np.unique(low * (triangles.max(initial=0) + 1) + high, return_inverse=True)[1].reshape(-1)
    on_boundary = np.arange(len(edge)) >= 3 * inner_count
    same_kind = 2 * edge + on_boundary  # label of the edge and the kind of triangle
    sizes = np.bincount(same_kind)[same_kind]
    order = np.argsort(same_kind, kind="stable")
    alone = order[sizes[order] == 1]
    met = np.flatnonzero(np.diff(edge[alone]) == 0)
    mixed = np.column_stack([alone[met], alone[met + 1]])
    pairs = np.concatenate([order[sizes[order] == 2].reshape(-1, 2), mixed])
    return pairs[tails[pairs[:, 0]] == heads[pairs[:, 1]]]


def _number_vertices(
    crossings: LayerCrossings, triangles: np.ndarray, inner_count: int, heights: np.ndarray, by_level: bool
) -> LayerSurfaces:
    """The surfaces of triangles of nodes, with separate vertices for each sheet, numbered from bottom to top."""
    links = _links(triangles, inner_count)
    following = np.arange(triangles.size).reshape(-1, 3)[:, [1, 2, 0]].ravel()
    one, other = links.T
    ends = np.column_stack([np.append(one, following[one]), np.append(following[other], other)])
    vertex = components(triangles.size, ends)
    node = np.empty(vertex.max(initial=-1) + 1, int)
    node[vertex] = triangles.ravel()
    piece = components(len(triangles), links // 3)
    piece_count = piece.max(initial=-1) + 1
    corners, weights = _places(crossings, node)
    at_corner = np.einsum("pk,pk->p", weights, heights[corners])[vertex.reshape(-1, 3)].mean(axis=1)
    means = np.bincount(piece, at_corner, piece_count) / np.bincount(piece, minlength=piece_count)
    solid_piece = np.empty(piece_count, int)
    solid_piece[piece] = crossings.mesh.pieces[corners[vertex[::3], 0]]
    levels = rank = _levels(means, solid_piece)
    if not by_level:
        rank = np.empty(piece_count, int)
        rank[np.argsort(means, kind="stable")] = np.arange(piece_count)
    points = np.einsum("pk,pkx->px", weights, crossings.mesh.vertices[corners])
    order = np.argsort(rank[piece], kind="stable")
    corners_of, layers = vertex.reshape(-1, 3)[order].astype(int), rank[piece][order]
    of_layers = np.zeros(rank.max(initial=-1) + 1, int)
    of_layers[rank] = levels
    return LayerSurfaces(points, corners_of, layers, corners, weights, of_layers)


def _levels(means: np.ndarray, solid_pieces: np.ndarray) -> np.ndarray:
    """(k,) levels of pieces of layers: their mean heights above the lowest one in their body, in whole turns."""
    lowest = np.full(solid_pieces.max(initial=-1) + 1, np.inf)
    np.minimum.at(lowest, solid_pieces, means)
    turns = np.rint((means - lowest[solid_pieces]) / TURN)
    return np.unique(turns, return_inverse=True)[1].reshape(-1)


def _places(crossings: LayerCrossings, nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(p, 4) vertices of the solid between which nodes lie, and their weights."""
    mesh, count = crossings.mesh, len(crossings.edges)
    corners, weights = np.zeros((len(nodes), 4), int), np.zeros((len(nodes), 4))
    kind = np.digitize(nodes, np.cumsum([count, mesh.vertex_count, len(mesh.faces)]))
    on_edge, at_vertex, on_face, inside = (np.flatnonzero(kind == k) for k in range(4))
    crossing = nodes[on_edge]
    corners[on_edge, :2] = mesh.edges[crossings.edges[crossing]]
    weights[on_edge, :2] = np.column_stack([1 - crossings.shares[crossing], crossings.shares[crossing]])
    corners[at_vertex, 0], weights[at_vertex, 0] = nodes[at_vertex] - count, 1
    face = nodes[on_face] - count - mesh.vertex_count
    corners[on_face, :3], weights[on_face, :3] = mesh.faces[face], 1 / 3
    tet = nodes[inside] - count - mesh.vertex_count - len(mesh.faces)
    corners[inside], weights[inside] = mesh.tets[tet], 1 / 4
    return corners, weights
