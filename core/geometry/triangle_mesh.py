# SPDX-License-Identifier: GPL-3.0-or-later
"""An oriented triangle surface as arrays: any number of pieces, boundaries and handles.

Half-edge ``h = 3 t + k`` runs in triangle ``t`` from its corner ``k`` to corner ``k + 1``. An edge
``e = (i, j)`` is stored once with ``i < j``, and every quantity on edges (transport, flip, phase
change) is meant in that direction.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError
from ..graphs import components, sum_by
from ..unit_vectors import unit_vectors
from .intrinsic_delaunay import MOST_CLIPPED, IntrinsicMesh, clipped_share, edge_weights, flip_edges
from .nearest import NearestTriangles
from .vertex_splitting import next_half_edges, previous_half_edges

# Cotangents are clipped to a range in which sums do not overflow.
_LARGEST = 1e200


def rows_of(width: int, values: ArrayLike, dtype: type, remedy: str) -> np.ndarray:
    """Convert values to a contiguous (n, width) array; MeshError with a remedy for another shape."""
    array = np.asarray(values)
    if array.size and (array.ndim != 2 or array.shape[1] != width):
        raise MeshError(f"an array of shape {array.shape} where (n, {width}) is needed: {remedy}")
    return np.ascontiguousarray(array, dtype=dtype).reshape(-1, width)


@dataclass(frozen=True)
class _HalfEdges:
    """The edge of each half-edge.

    Attributes
    ----------
    edges : (e, 2) vertices, the lower one first, sorted
    numbers : (3 m,) edge of each half-edge
    forward : (3 m,) bool, from the lower vertex to the higher
    """

    edges: np.ndarray
    numbers: np.ndarray
    forward: np.ndarray


class TriangleMesh:
    """Vertices and triangles, and quantities derived from them, computed on first use.

    Raises MeshError for arrays of another shape, or a vertex index out of range.

    Parameters
    ----------
    vertices : (n, 3) float array, in scene units
    triangles : (m, 3) int array, oriented consistently; :func:`check_mesh` checks the other conditions
    """

    def __init__(self, vertices: ArrayLike, triangles: ArrayLike) -> None:
        self.vertices = rows_of(3, vertices, np.float64, "vertices are points in space")
        self.triangles = rows_of(3, triangles, np.int64, "split polygons into triangles")
        outside = ((self.triangles < 0) | (self.triangles >= len(self.vertices))).any(axis=1)
        if outside.any():
            face = np.flatnonzero(outside)[0]
            raise MeshError(
                f"triangle {face} has the vertices {self.triangles[face].tolist()} and there are {len(self.vertices)}: "
                "count them from 0"
            )

    @property
    def vertex_count(self) -> int:
        return len(self.vertices)

    @property
    def triangle_count(self) -> int:
        return len(self.triangles)

    # Connectivity

    @cached_property
    def used_vertices(self) -> np.ndarray:
        """(k,) vertices of triangles, ascending; ``numpy.unique`` would take many times as long."""
        return np.flatnonzero(np.bincount(self.triangles.ravel()))

    @cached_property
    def _half_edges(self) -> _HalfEdges:
        tails = self.triangles.ravel()
        heads = self.triangles[:, [1, 2, 0]].ravel()
        low, high = np.minimum(tails, heads), np.maximum(tails, heads)
        keys, inverse = np.unique(low * self.vertex_count + high, return_inverse=True)
        edges = np.column_stack(np.divmod(keys, max(self.vertex_count, 1)))
        return _HalfEdges(edges, inverse.reshape(-1), tails == low)

    @property
    def edges(self) -> np.ndarray:
        """(e, 2) vertex indices, the lower one first, sorted."""
        return self._half_edges.edges

    @property
    def triangle_edges(self) -> np.ndarray:
        """(m, 3) edge from corner k to corner k + 1."""
        return self._half_edges.numbers.reshape(-1, 3)

    @property
    def triangle_edge_signs(self) -> np.ndarray:
        """(m, 3) +1 where the triangle runs along the edge's stored direction, else -1."""
        return np.where(self._half_edges.forward, 1, -1).reshape(-1, 3)

    @cached_property
    def _edge_keys(self) -> np.ndarray:
        return self.edges[:, 0] * self.vertex_count + self.edges[:, 1]

    def edges_between(self, tails: np.ndarray, heads: np.ndarray) -> np.ndarray:
        """Find the edges that join pairs of vertices in either direction; the pairs must be edges."""
        return np.searchsorted(self._edge_keys, np.minimum(tails, heads) * self.vertex_count + np.maximum(tails, heads))

    @cached_property
    def edge_face_counts(self) -> np.ndarray:
        """(e,) number of triangles at each edge: 1 on the boundary, 2 inside."""
        return np.bincount(self._half_edges.numbers, minlength=len(self.edges))

    @cached_property
    def edge_triangles(self) -> np.ndarray:
        """(e, 2) triangles at each edge, twice the same at the boundary."""
        halves, last = np.argsort(self.triangle_edges.ravel(), kind="stable"), np.cumsum(self.edge_face_counts)
        return halves[np.column_stack([last - self.edge_face_counts, last - 1])] // 3

    @property
    def boundary_edges(self) -> np.ndarray:
        """Indices of the edges that have one triangle only."""
        return np.flatnonzero(self.edge_face_counts == 1)

    @cached_property
    def boundary_vertices(self) -> np.ndarray:
        """(n,) bool."""
        mask = np.zeros(self.vertex_count, bool)
        mask[self.edges[self.boundary_edges]] = True
        return mask

    @cached_property
    def twins(self) -> np.ndarray:
        """(3 m,) the opposite half-edge, -1 on the boundary; needs a manifold mesh."""
        halves = np.argsort(self._half_edges.numbers, kind="stable")
        twins = np.full(3 * self.triangle_count, -1)
        first = np.concatenate([[0], np.cumsum(self.edge_face_counts)[:-1]])[self.edge_face_counts == 2]
        twins[halves[first]], twins[halves[first + 1]] = halves[first + 1], halves[first]
        return twins

    def halves_off(self, edges: np.ndarray) -> np.ndarray:
        """Find the half-edges that have a twin and are not on (k,) edges."""
        is_open = np.ones(len(self.edges), bool)
        is_open[edges] = False
        return np.flatnonzero((self.twins >= 0) & is_open[self.triangle_edges.ravel()])

    def parts_between(self, edges: np.ndarray) -> np.ndarray:
        """Label the part of the surface between (k,) edges that each triangle is in, (m,)."""
        halves = self.halves_off(edges)
        return components(self.triangle_count, np.column_stack([halves, self.twins[halves]]) // 3)

    def line_corners(self, edges: np.ndarray, cosine: float) -> np.ndarray:
        """Find the vertices at which lines of (k,) edges end, branch, or turn by an angle of a smaller cosine."""
        ends, along = self.edges[edges], unit_vectors(self.edge_vectors[edges])
        degrees = np.bincount(ends.ravel(), minlength=self.vertex_count)
        leaving = np.zeros((self.vertex_count, 3))
        np.add.at(leaving, ends[:, 0], along)
        np.add.at(leaving, ends[:, 1], -along)
        # Two unit vectors that leave a vertex add up to 0 where they go straight on.
        bends = np.linalg.norm(leaving, axis=1) > np.sqrt(2 - 2 * cosine)
        return np.flatnonzero((degrees > 0) & ((degrees != 2) | bends))

    @cached_property
    def pieces(self) -> np.ndarray:
        """(n,) label of the connected piece of each vertex."""
        return components(self.vertex_count, self.edges)

    @cached_property
    def loose_vertices(self) -> np.ndarray:
        """Indices of the vertices without a face; they carry no field."""
        return np.flatnonzero(np.bincount(self.triangles.ravel(), minlength=self.vertex_count) == 0)

    @property
    def euler_characteristic(self) -> int:
        """V - E + F over all pieces, loose vertices left out."""
        return self.vertex_count - len(self.loose_vertices) - len(self.edges) + self.triangle_count

    @property
    def piece_euler_characteristics(self) -> np.ndarray:
        """(p,) V - E + F of each piece, 1 for a loose vertex."""
        count = self.pieces.max(initial=-1) + 1
        firsts = (np.arange(self.vertex_count), self.edges[:, 0], self.triangles[:, 0])
        vertices, edges, triangles = (np.bincount(self.pieces[first], minlength=count) for first in firsts)
        return vertices - edges + triangles

    # Lengths, angles and areas

    @cached_property
    def edge_vectors(self) -> np.ndarray:
        """(e, 3) from the lower to the higher vertex."""
        return self.vertices[self.edges[:, 1]] - self.vertices[self.edges[:, 0]]

    @cached_property
    def edge_lengths(self) -> np.ndarray:
        """(e,) length of each edge."""
        return np.linalg.norm(self.edge_vectors, axis=1)

    @cached_property
    def _corner_products(self) -> tuple[np.ndarray, np.ndarray]:
        """(m, 3) dot products of the two edge vectors at each corner, and (m, 1) twice the areas."""
        first, second, third = (self.vertices[corner] for corner in self.triangles.T)
        sides = second - first, third - second, first - third
        dots = np.stack([-np.einsum("tx,tx->t", sides[k], sides[k - 1]) for k in range(3)], axis=1)
        return dots, np.linalg.norm(np.cross(sides[2], sides[0]), axis=1)[:, None]

    @cached_property
    def corner_angles(self) -> np.ndarray:
        """(m, 3) interior angles, radians."""
        dots, double_areas = self._corner_products
        return np.arctan2(double_areas, dots)

    @property
    def half_edge_angles(self) -> np.ndarray:
        """(m, 3) radians, angles of half-edges in the planes of their triangles, counterclockwise from the first."""
        angles = self.corner_angles
        return np.column_stack([np.zeros(len(angles)), np.pi - angles[:, 1], np.pi + angles[:, 0]])

    @cached_property
    def plane_half_edges(self) -> np.ndarray:
        """(m, 3) complex, the half-edges as vectors in the planes of their triangles."""
        return self.edge_lengths[self.triangle_edges] * np.exp(1j * self.half_edge_angles)

    @cached_property
    def areas(self) -> np.ndarray:
        """(m,) area of each triangle."""
        return 0.5 * self._corner_products[1][:, 0]

    @cached_property
    def face_normals(self) -> np.ndarray:
        """(m, 3) unit normals; zero for a triangle without area."""
        a, b, c = np.moveaxis(self.vertices[self.triangles], 1, 0)
        return unit_vectors(np.cross(b - a, c - a))

    @cached_property
    def dihedral_angles(self) -> np.ndarray:
        """(e,) radians between the normals of the two triangles at each edge, positive at ridges; 0 on the boundary."""
        return self.angles_between(self.face_normals)

    def angles_between(self, normals: np.ndarray) -> np.ndarray:
        """Compute (e,) radians between (m, 3) unit vectors of the two triangles at each edge; signs as for normals."""
        half = np.flatnonzero((self.twins >= 0) & (self.triangle_edge_signs.ravel() > 0))
        left, right = normals[half // 3], normals[self.twins[half] // 3]
        edges = self.triangle_edges.ravel()[half]
        across = np.cross(left, right)
        sines = np.copysign(np.linalg.norm(across, axis=1), np.einsum("hx,hx->h", across, self.edge_vectors[edges]))
        angles = np.zeros(len(self.edges))
        angles[edges] = np.arctan2(sines, np.einsum("hx,hx->h", left, right))
        return angles

    @cached_property
    def vertex_normals(self) -> np.ndarray:
        """(n, 3) unit normals, averaged by corner angle."""
        weighted = (self.corner_angles[:, :, None] * self.face_normals[:, None]).reshape(-1, 3)
        return unit_vectors(self._sum_at_vertices(weighted))

    @cached_property
    def vertex_masses(self) -> np.ndarray:
        """(n,) a third of the area around each vertex, positive."""
        masses = self._sum_at_vertices(np.repeat(self.areas / 3, 3))
        return np.maximum(masses, 1e-9 * masses.mean())

    @cached_property
    def weights(self) -> np.ndarray:
        """(e,) see :func:`edge_weights`."""
        dots, double_areas = self._corner_products
        with np.errstate(over="ignore"):  # of triangles without area within a polygon that has one
            cotangents = np.clip(dots / np.maximum(double_areas, np.finfo(float).tiny), -_LARGEST, _LARGEST)
        return edge_weights(cotangents[:, [2, 0, 1]].ravel(), self._half_edges.numbers, len(self.edges))

    @cached_property
    def solver_mesh(self) -> "TriangleMesh":
        """The mesh on which problems are solved: this one, or its :func:`intrinsic_delaunay` triangulation, with all
        attributes that problems need, if negative weights are too large a share of the energy."""
        lost = clipped_share(self.corner_angles, self.triangle_edges, self.edge_lengths, self.areas)
        return self if lost <= MOST_CLIPPED else intrinsic_delaunay(self)  # type: ignore[return-value]

    # Rescaled tangent planes (Knöppel et al. 2013, Section 3.1)

    @cached_property
    def angle_scales(self) -> np.ndarray:
        """(n,) factor that makes the angles around an interior vertex sum to 2 pi.

        Boundary vertices keep their angles, so that a flat domain stays flat up to its rim.
        """
        sums = self._sum_at_vertices(self.corner_angles.ravel())
        return np.where(self.boundary_vertices, 1.0, 2 * np.pi / np.where(sums > 0, sums, 1))

    @cached_property
    def scaled_angles(self) -> np.ndarray:
        """(m, 3) corner angles after rescaling, which define the curvature of the discrete connection."""
        return self.corner_angles * self.angle_scales[self.triangles]

    @cached_property
    def _fans(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(3 m,) half-edge angles, (n,) first half-edges and (n,) numbers of corners, by a walk around all vertices."""
        tails = self.triangles.ravel()
        angles = self.scaled_angles.ravel()
        halves = np.arange(len(tails))
        previous = previous_half_edges(halves)
        starts = np.full(self.vertex_count, -1)
        starts[tails[::-1]] = halves[::-1]
        open_starts = halves[self.twins < 0]
        starts[tails[open_starts]] = open_starts

        directions = np.zeros(len(tails))
        met = np.zeros(self.vertex_count, int)
        current = starts[starts >= 0]
        total = np.zeros(len(current))
        first = current.copy()
        while len(current):
            met[tails[current]] += 1
            total = total + angles[current]
            following = self.twins[previous[current]]
            going = (following >= 0) & (following != first)
            current, total, first = following[going], total[going], first[going]
            directions[current] = total
        return directions, starts, met

    @property
    def half_edge_directions(self) -> np.ndarray:
        """(3 m,) angle of each half-edge in the tangent plane of its tail, counterclockwise from the reference edge."""
        return self._fans[0]

    @property
    def fan_corner_counts(self) -> np.ndarray:
        """(n,) corners met on one walk around each vertex; fewer than its corners at a bow-tie."""
        return self._fans[2]

    @cached_property
    def edge_directions(self) -> np.ndarray:
        """(e, 2) angle of the edge in the tangent plane of its lower vertex, and of the reversed edge in that of its
        higher vertex; counterclockwise from each vertex's reference edge."""
        at_tail = self.half_edge_directions
        following = next_half_edges(np.arange(len(at_tail)))
        at_head = at_tail[following] + self.scaled_angles.ravel()[following]
        directions = np.zeros((len(self.edges), 2))
        edge, forward = self._half_edges.numbers, self._half_edges.forward
        directions[edge[forward]] = np.column_stack([at_tail, at_head])[forward]
        backward = ~forward & (self.edge_face_counts[edge] == 1)
        directions[edge[backward]] = np.column_stack([at_head, at_tail])[backward]
        return directions

    @cached_property
    def tangent_frames(self) -> tuple[np.ndarray, np.ndarray]:
        """(n, 3) directions of angle 0 at each vertex, and (n, 3) a quarter turn counterclockwise from them.

        The former are the means of the edges turned back by their angles, so that they do not depend on the numbering.
        """
        normals = self.vertex_normals
        references = np.zeros((self.vertex_count, 3))
        for end, sign in ((0, 1), (1, -1)):
            at = self.edges[:, end]
            n = normals[at]
            towards = sign * self.edge_vectors
            towards = unit_vectors(towards - np.einsum("ij,ij->i", towards, n)[:, None] * n)
            angles = self.edge_directions[:, end, None]
            back = np.cos(angles) * towards - np.sin(angles) * np.cross(n, towards)
            np.add.at(references, at, back)
        x = unit_vectors(references)
        return x, np.cross(normals, x)

    @cached_property
    def finder(self) -> NearestTriangles:
        """Finds nearest points."""
        return NearestTriangles(self.vertices, self.triangles)

    def tangent_numbers(self, vectors: np.ndarray) -> np.ndarray:
        """Compute (n,) complex tangential parts of (n, 3) vectors in :attr:`tangent_frames`."""
        x, y = self.tangent_frames
        return np.einsum("ij,ij->i", vectors, x) + 1j * np.einsum("ij,ij->i", vectors, y)

    @cached_property
    def face_curvatures(self) -> np.ndarray:
        """(m,) curvature that the rescaled tangent planes give each triangle; on a closed mesh it sums to 2 pi chi."""
        return self.scaled_angles.sum(axis=1) - np.pi

    def _sum_at_vertices(self, corner_values: np.ndarray) -> np.ndarray:
        """Sum (3 m,) or (3 m, k) corner values at their vertices."""
        return sum_by(self.triangles.ravel(), corner_values, self.vertex_count)


def intrinsic_delaunay(mesh: TriangleMesh) -> TriangleMesh | IntrinsicMesh:
    """Triangulate the surface of a manifold mesh without edges whose opposite angles sum to more than pi: the mesh
    itself if it has neither such edges nor flat triangles at its boundary."""
    sides, directions = mesh.edge_lengths[mesh.triangle_edges], mesh.half_edge_directions.reshape(-1, 3)
    own = IntrinsicMesh(mesh.triangles, sides, directions, mesh.corner_angles, mesh.twins, mesh.angle_scales)
    flipped = flip_edges(own)
    return mesh if flipped is own else flipped
