# SPDX-License-Identifier: GPL-3.0-or-later
"""The intrinsic Delaunay triangulation: the same surface and vertices, triangulated without negative cotangents.

Its edges are straight on the unfolded surface, so that corners, sides and angles describe it (Bobenko and Springborn
2007, "A discrete Laplace-Beltrami operator for simplicial surfaces"). The angle sums at vertices do not change, and the
new edges lie at known angles in the tangent planes of the mesh (Sharp, Soliman and Crane 2019, "Navigating intrinsic
triangulations").
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .vertex_splitting import next_half_edges, previous_half_edges

# Cotangent weights are clipped to this range: Eq. (2) needs them positive, and slivers would
# otherwise outweigh the rest of the mesh by ten orders of magnitude.
WEIGHT_RANGE = (1e-4, 1e4)
# Share of the energy up to which negative weights are clipped: measured to do as well as other triangles.
MOST_CLIPPED = 0.1
# Edges are kept if their opposite angles sum to at most pi plus this, radians.
TOLERANCE = 1e-9
# Boundary edges cannot flip: their triangles are left out of weights if the angle opposite is larger than this.
FLAT = np.radians(165)
# Most rounds of simultaneous flips; rounding errors could prevent their end.
MOST_ROUNDS = 1000


def edge_weights(cotangents: np.ndarray, edges: np.ndarray, count: int) -> np.ndarray:
    """Compute (e,) weights (cot a + cot b) / 2, clipped to :data:`WEIGHT_RANGE`, of ``count`` edges, from (h,)
    cotangents opposite to half-edges and (h,) the edge of each."""
    return np.clip(np.bincount(edges, weights=0.5 * cotangents, minlength=count), *WEIGHT_RANGE)


def clipped_share(
    corner_angles: np.ndarray, triangle_edges: np.ndarray, edge_lengths: np.ndarray, areas: np.ndarray
) -> float:
    """Compute the share of negative weights in the energy, the sum of w_e l_e^2, which is twice the area."""
    sums = np.bincount(triangle_edges.ravel(), 0.5 * opposite_cotangents(corner_angles).ravel())
    with np.errstate(over="ignore"):
        return np.maximum(-sums, 0) @ edge_lengths**2 / (2 * areas.sum())


def opposite_cotangents(corner_angles: np.ndarray) -> np.ndarray:
    """Compute (m, 3) cotangents of the angle opposite the side from corner k to corner k + 1."""
    opposite = np.roll(corner_angles, 1, axis=1)
    return np.cos(opposite) / np.maximum(np.sin(opposite), np.finfo(float).tiny)


@dataclass(frozen=True)
class IntrinsicMesh:
    """Triangles with straight sides on a surface, with the attributes of a TriangleMesh.

    An edge may join a vertex to itself, or be one of several between two vertices, and runs in either direction.

    Attributes
    ----------
    triangles : (m, 3) vertices
    sides : (m, 3) length from corner k to corner k + 1, scene units
    directions : (m, 3) angle of that side in the tangent plane of corner k
    corner_angles : (m, 3) radians
    twins : (3 m,) the opposite half-edge, -1 on the boundary
    angle_scales : (n,) see TriangleMesh
    """

    triangles: np.ndarray
    sides: np.ndarray
    directions: np.ndarray
    corner_angles: np.ndarray
    twins: np.ndarray
    angle_scales: np.ndarray

    @property
    def vertex_count(self) -> int:
        return len(self.angle_scales)

    @property
    def triangle_count(self) -> int:
        return len(self.triangles)

    @cached_property
    def _first_halves(self) -> np.ndarray:
        """(e,) half-edge in whose direction each edge is stored."""
        return np.flatnonzero((self.twins < 0) | (self.twins > np.arange(len(self.twins))))

    @cached_property
    def triangle_edges(self) -> np.ndarray:
        """(m, 3) edge from corner k to corner k + 1."""
        halves = np.arange(len(self.twins))
        first = np.where(self.twins < 0, halves, np.minimum(halves, self.twins))
        return np.searchsorted(self._first_halves, first).reshape(-1, 3)

    @property
    def triangle_edge_signs(self) -> np.ndarray:
        """(m, 3) +1 where the triangle runs along the edge's stored direction, else -1."""
        is_first = np.zeros(len(self.twins), bool)
        is_first[self._first_halves] = True
        return np.where(is_first, 1, -1).reshape(-1, 3)

    @cached_property
    def edges(self) -> np.ndarray:
        """(e, 2) vertices."""
        ends = np.stack([self.triangles, np.roll(self.triangles, -1, axis=1)], axis=-1)
        return ends.reshape(-1, 2)[self._first_halves]

    @cached_property
    def edge_lengths(self) -> np.ndarray:
        """(e,) length of each edge."""
        return self.sides.ravel()[self._first_halves]

    @cached_property
    def edge_directions(self) -> np.ndarray:
        """(e, 2) angles of the edge in the tangent plane of its first vertex, and of the reversed edge at the other."""
        reverse = np.roll(self.directions + self.scaled_angles, -1, axis=1)
        return np.stack([self.directions, reverse], axis=-1).reshape(-1, 2)[self._first_halves]

    @property
    def scaled_angles(self) -> np.ndarray:
        """(m, 3) corner angles after rescaling."""
        return self.corner_angles * self.angle_scales[self.triangles]

    @property
    def face_curvatures(self) -> np.ndarray:
        """(m,) curvature that the rescaled tangent planes assign to each triangle."""
        return self.scaled_angles.sum(axis=1) - np.pi

    @cached_property
    def areas(self) -> np.ndarray:
        """(m,) area of each triangle."""
        return 0.5 * self.sides[:, 0] * self.sides[:, 2] * np.sin(self.corner_angles[:, 0])

    @cached_property
    def vertex_masses(self) -> np.ndarray:
        """(n,) a third of the area around each vertex, positive."""
        masses = np.bincount(self.triangles.ravel(), np.repeat(self.areas / 3, 3), self.vertex_count)
        return np.maximum(masses, 1e-9 * masses.mean())

    @cached_property
    def weights(self) -> np.ndarray:
        """(e,) see :func:`edge_weights`."""
        flat = _is_flat(np.roll(self.corner_angles, 1, axis=1).ravel(), self.twins)
        counted = ~flat.reshape(-1, 3).any(axis=1)
        cotangents = counted[:, None] * opposite_cotangents(self.corner_angles)
        return edge_weights(cotangents.ravel(), self.triangle_edges.ravel(), len(self.edges))


def flip_edges(mesh: IntrinsicMesh) -> IntrinsicMesh:
    """Flip edges of a manifold mesh until no two angles opposite an edge sum to more than pi.

    Returns the mesh itself if no edge has to flip and the boundary has no flat triangles.
    """
    angles, twins = mesh.corner_angles.ravel(), mesh.twins
    waiting = np.flatnonzero(twins > np.arange(len(twins)))
    waiting = waiting[_excess(angles, twins, waiting) > TOLERANCE]
    if len(waiting) == 0 and not _is_flat(angles[previous_half_edges(np.arange(len(twins)))], twins).any():
        return mesh
    surface = _Flipped(
        mesh.triangles.ravel().copy(),
        mesh.sides.ravel().copy(),
        mesh.directions.ravel().copy(),
        angles.copy(),
        twins.copy(),
        mesh.angle_scales,
    )
    random = np.random.default_rng(0)
    for _ in range(MOST_ROUNDS):
        chosen = surface.apart(random.permutation(waiting))
        if len(chosen) == 0:
            break
        surface.flip(chosen)
        waiting = surface.bad_among(np.concatenate([waiting, surface.around(chosen)]))
    of_corners = surface.tails, surface.lengths, surface.directions, surface.angles
    triangles, sides, directions, corner_angles = (values.reshape(-1, 3) for values in of_corners)
    return IntrinsicMesh(triangles, sides, directions, corner_angles, surface.twins, mesh.angle_scales)


def _excess(angles: np.ndarray, twins: np.ndarray, halves: np.ndarray) -> np.ndarray:
    """Compute (k,) excess over pi of the sum of the two angles opposite inner half-edges."""
    return angles[previous_half_edges(halves)] + angles[previous_half_edges(twins[halves])] - np.pi


def _is_flat(opposite: np.ndarray, twins: np.ndarray) -> np.ndarray:
    """Find the boundary half-edges opposite a nearly straight angle, (h,) bool."""
    return (twins < 0) & (opposite > FLAT)


@dataclass
class _Flipped:
    """Half-edges 3 t + k during the flips: (h,) tail, length, direction and angle at the tail, twin; (n,) scales."""

    tails: np.ndarray
    lengths: np.ndarray
    directions: np.ndarray
    angles: np.ndarray
    twins: np.ndarray
    scales: np.ndarray

    def around(self, halves: np.ndarray) -> np.ndarray:
        """List the half-edges of the triangles on both sides."""
        triangles = np.concatenate([halves, self.twins[halves]]) // 3
        return (3 * triangles[:, None] + np.arange(3)).ravel()

    def bad_among(self, halves: np.ndarray) -> np.ndarray:
        """Select one half-edge of each edge that has to flip."""
        halves = np.unique(np.minimum(halves, self.twins[halves]))
        halves = halves[halves >= 0]
        halves = halves[halves // 3 != self.twins[halves] // 3]
        return halves[_excess(self.angles, self.twins, halves) > TOLERANCE]

    def apart(self, halves: np.ndarray) -> np.ndarray:
        """Select the half-edges that come first in both their triangles, so that no two share a triangle."""
        sides = np.stack([halves, self.twins[halves]]) // 3
        places = np.tile(np.arange(len(halves)), 2)
        triangles, numbers = np.unique(sides.ravel(), return_inverse=True)
        first = np.full(len(triangles), len(halves))
        np.minimum.at(first, numbers.ravel(), places)
        return halves[(first[numbers.reshape(2, -1)] == np.arange(len(halves))).all(axis=0)]

    def flip(self, left: np.ndarray) -> None:
        """Flip edges, no two of one triangle: the triangles i j k and j i m become k m j and m k i."""
        right = self.twins[left]
        (jk, im), (ki, mj) = (of(np.stack([left, right])) for of in (next_half_edges, previous_half_edges))
        at_i, at_j = self.angles[im] + self.angles[left], self.angles[jk] + self.angles[right]
        length, at_k, at_m = self._across(jk, mj, at_j)
        _, above_m, above_k = self._across(im, ki, at_i)
        k, m = self.tails[ki], self.tails[mj]
        towards_m = self.directions[ki] + self.scales[k] * above_k
        towards_k = self.directions[mj] + self.scales[m] * at_m
        old = np.stack([mj, jk, ki, im])
        place = np.stack([jk, ki, im, mj])
        new_place = np.arange(len(self.twins))
        new_place[old] = place
        opposite = self.twins[old]
        opposite = np.where(opposite < 0, -1, new_place[opposite])
        for values in (self.tails, self.lengths, self.directions):
            values[place] = values[old]
        self.tails[left], self.tails[right] = k, m
        self.lengths[left] = self.lengths[right] = length
        self.directions[left], self.directions[right] = towards_m, towards_k
        self.angles[left], self.angles[right] = at_k, above_m
        self.angles[place] = np.stack([at_m, at_j, above_k, at_i])
        self.twins[place] = opposite
        inner = opposite >= 0
        self.twins[opposite[inner]] = place[inner]

    def _across(
        self, first: np.ndarray, second: np.ndarray, angle: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Compute the third side and the angles at its ends from two sides and the angle between them."""
        a, b = self.lengths[first], self.lengths[second]
        x, y = a - b + 2 * b * np.sin(angle / 2) ** 2, b * np.sin(angle)
        at_first = np.arctan2(y, x)
        return np.hypot(x, y), at_first, np.maximum(np.pi - angle - at_first, 0)
