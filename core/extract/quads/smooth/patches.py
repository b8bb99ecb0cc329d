# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches of a quad mesh whose vertices move: the deviations of their corners, and their distance from the surface."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree

from ....geometry import TriangleMesh
from ....geometry.nearest import nearest_in_triangles
from ....graphs import components
from ....unit_vectors import cross
from ..features.chains import Chains
from ..measure.quality import STRAIGHT
from ..trace.quad_mesh import QuadMesh
from .fitting import project_vertices

# Exponent of the norm of the corners' deviations, and weight of their root mean square that is added.
POWER, SHARE = 8, 0.5
# Deviation in radians below which the mean deviation is smooth.
SMOOTH = 0.1
# Largest move of a vertex in a round in each direction, in mean edges of its patch.
REACH = 0.4
# The first step, as a part of the largest move.
FIRST = 0.1
# Edges and triangles of the surface longer than this part of a quad's side are sampled at their middles, too.
LONG = 0.6
# The face nearest to a point is looked for among this many faces with the nearest middles.
CANDIDATES = 3
_TINY = np.finfo(float).tiny
# A patch may be farther from the surface than before by this share.
FARTHER = 0.01
# Values of patches for (n, 3) places of the vertices first, and the gradient of their sum last.
Measure = Callable[[np.ndarray], tuple[np.ndarray, ...]]
# Tells for (n, 3) places of the vertices and (p,) bool which of these patches are better, as a (p,) bool.
Judge = Callable[[np.ndarray, np.ndarray], np.ndarray]
# (s, 3) points, (s,) their patches, (s, CANDIDATES) faces near them.
Below = tuple[np.ndarray, np.ndarray, np.ndarray]


def regular_degrees(sizes: np.ndarray) -> np.ndarray:
    """Corner angles of regular polygons in degrees: right angles in quads."""
    return 180 * (1 - 2 / sizes)


def faces_near(quads: QuadMesh, points: np.ndarray) -> np.ndarray:
    """(s, :data:`CANDIDATES`) faces whose middles are nearest to points; the last again where there are fewer."""
    tree = cKDTree(quads.middles(quads.vertices))
    return tree.query(points, k=np.minimum(1 + np.arange(CANDIDATES), len(quads.sizes)))[1]


@dataclass(frozen=True)
class Ground:
    """The surface, and (s, 3) sample points on it that quads should be near to.

    ``quads`` is the mesh before smoothing. The faces near each sample are found once, on it, since smoothing moves
    vertices by little. They are given as ``near_faces`` where only some faces count for a sample.
    """

    mesh: TriangleMesh
    samples: np.ndarray
    quads: QuadMesh
    near_faces: np.ndarray | None = None

    @classmethod
    def of(cls, mesh: TriangleMesh, quads: QuadMesh) -> "Ground":
        """Sample the surface at its vertices and at the middles of edges and triangles that are long beside a quad's
        side."""
        side = np.linalg.norm(np.diff(quads.vertices[quads.half_edges], axis=1), axis=2).mean()
        long = mesh.edge_lengths > LONG * side
        wide = long[mesh.triangle_edges].any(axis=1)
        parts = [
            mesh.vertices[np.unique(mesh.triangles)],
            mesh.vertices[mesh.edges[long]].mean(axis=1),
            mesh.vertices[mesh.triangles[wide]].mean(axis=1),
        ]
        return cls(mesh, np.concatenate(parts), quads)

    @cached_property
    def near(self) -> np.ndarray:
        """(s, :data:`CANDIDATES`) faces near each sample."""
        return faces_near(self.quads, self.samples) if self.near_faces is None else self.near_faces

    def normals(self, quads: QuadMesh, which: np.ndarray) -> np.ndarray:
        """(k, 3) vectors along the surface's interpolated normals at vertices."""
        corners = self.mesh.triangles[quads.triangles[which]]
        return np.einsum("nk,nkx->nx", quads.weights[which], self.mesh.vertex_normals[corners])

    def distances(
        self, patches: "Patches", vertices: np.ndarray, wanted: np.ndarray, below: Below, enough: float = 0.0
    ) -> np.ndarray:
        """(p,) Hausdorff distances between patches, with the vertices at (n, 3) places, and the points below them.

        0 for patches that are not wanted; ``below`` as :attr:`Patches.below`. Distances up to ``enough`` sides of the
        patch may be found too large, up to that.
        """
        quads = patches.quads
        middles = quads.middles(vertices)
        faces = wanted[patches.of_faces]
        edges = wanted[patches.labels] & (patches.corners[:, 1] < patches.corners[:, 2])
        here = np.concatenate([middles[patches.touched[faces]], vertices[patches.corners[edges, 1:]].mean(axis=1)])
        labels = np.concatenate([patches.of_faces[faces], patches.labels[edges]])
        result = np.zeros(len(patches.sides))
        np.maximum.at(result, labels, np.linalg.norm(self.mesh.finder.nearby(here)[0] - here, axis=1))
        points, labels, near = below
        wanted = wanted[labels]
        limits = (enough * patches.sides[labels[wanted]]) ** 2
        squares = squares_to_faces(quads, vertices, middles, points[wanted], near[wanted], limits)
        np.maximum.at(result, labels[wanted], np.sqrt(squares))
        return result


def squares_to_faces(
    quads: QuadMesh,
    vertices: np.ndarray,
    middles: np.ndarray,
    points: np.ndarray,
    faces: np.ndarray,
    enough: ArrayLike = 0.0,
) -> np.ndarray:
    """(s,) squared distances of points to the nearest of (s, k) faces each, divided into triangles at their middles.

    Up to (s,) squares ``enough`` the distance to the first face will do.
    """
    squares = _squares_to_all(quads, vertices, middles, points, faces[:, :1])
    far = np.flatnonzero(squares > enough)
    squares[far] = np.minimum(squares[far], _squares_to_all(quads, vertices, middles, points[far], faces[far, 1:]))
    return squares


def _squares_to_all(
    quads: QuadMesh, vertices: np.ndarray, middles: np.ndarray, points: np.ndarray, faces: np.ndarray
) -> np.ndarray:
    """As :func:`squares_to_faces`, without ``enough``."""
    flat = faces.ravel()
    sizes = quads.sizes[flat]
    starts = np.cumsum(sizes) - sizes
    corners = np.repeat(quads.starts[flat] - starts, sizes) + np.arange(sizes.sum())
    tails, heads = quads.half_edges[corners].T
    triangles = np.stack([vertices[tails], vertices[heads], np.repeat(middles[flat], sizes, axis=0)])
    points = np.repeat(np.repeat(points, faces.shape[1], axis=0), sizes, axis=0)
    offsets = points - np.einsum("sk,ksx->sx", nearest_in_triangles(points, triangles), triangles)
    squares = np.einsum("sx,sx->s", offsets, offsets)
    return np.minimum.reduceat(squares, starts).reshape(faces.shape).min(axis=1) if len(flat) else np.empty(0)


@dataclass(frozen=True)
class Patches:
    """Moving vertices and their faces, divided into connected patches.

    Attributes
    ----------
    moving : (k,) vertices
    touched : (f,) faces with moving vertices
    corners, faces : (c, 3) vertices before, at and after each corner of these faces, and (c,) its place in ``touched``
    regular : (c,) corner angle of a regular face, radians
    up : (f, 3) vectors along the surface's normal
    of_moving, of_faces : (k,), (f,) the patch of each vertex and face
    sides : (p,) mean edge length of each patch
    """

    quads: QuadMesh
    ground: Ground
    moving: np.ndarray
    touched: np.ndarray
    corners: np.ndarray
    faces: np.ndarray
    regular: np.ndarray
    up: np.ndarray
    of_moving: np.ndarray
    of_faces: np.ndarray
    sides: np.ndarray

    @classmethod
    def of(cls, quads: QuadMesh, ground: Ground, moving: np.ndarray) -> "Patches":
        """Divide (k,) moving vertices, in ascending order, and their faces into patches."""
        moves = np.zeros(len(quads.vertices), bool)
        moves[moving] = True
        touched = np.unique(quads.corner_faces[moves[quads.corner_vertices]])
        which = np.flatnonzero(np.isin(quads.corner_faces, touched))
        around = quads.previous_corners[which], which, quads.next_corners[which]
        corners = quads.corner_vertices[np.column_stack(around)]
        faces = np.searchsorted(touched, quads.corner_faces[which])
        regular = np.radians(regular_degrees(quads.sizes[touched[faces]]))
        inside = moves[corners[:, 1]]
        pairs = np.column_stack([np.searchsorted(moving, corners[inside, 1]), len(moving) + faces[inside]])
        of_moving, of_faces = np.split(components(len(moving) + len(touched), pairs), [len(moving)])
        up = np.zeros((len(touched), 3))
        np.add.at(up, faces, ground.normals(quads, corners[:, 1]))
        lengths = np.linalg.norm(quads.vertices[corners[:, 2]] - quads.vertices[corners[:, 1]], axis=1)
        sides = np.bincount(of_faces[faces], lengths) / np.bincount(of_faces[faces])
        return cls(quads, ground, moving, touched, corners, faces, regular, up, of_moving, of_faces, sides)

    @cached_property
    def labels(self) -> np.ndarray:
        """(c,) the patch of each corner."""
        return self.of_faces[self.faces]

    @cached_property
    def below(self) -> Below:
        """Samples of the surface below the patches, their patches, and the faces near them."""
        samples, near = self.ground.samples, self.ground.near
        labels = np.full(len(self.quads.sizes), -1)
        labels[self.touched] = self.of_faces
        labels = labels[near[:, 0]]
        return samples[labels >= 0], labels[labels >= 0], near[labels >= 0]

    def descend(self, directions: np.ndarray, number: int, measure: Measure | None = None) -> np.ndarray:
        """(k, 3) moves of the vertices, along (k, 2, 3) directions, that lower :meth:`norms`, or another measure: a
        number of steps of Barzilai-Borwein descent."""
        measure = self.norms if measure is None else measure
        start, scales = self.quads.vertices, (REACH * self.sides)[self.of_moving, None]

        def at(shares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            vertices = start.copy()
            vertices[self.moving] += scales * np.einsum("kd,kdx->kx", shares, directions)
            norms, *_, gradient = measure(vertices)
            return norms, scales * np.einsum("kx,kdx->kd", gradient[self.moving], directions)

        def sums(u: np.ndarray, v: np.ndarray) -> np.ndarray:
            return np.bincount(self.of_moving, np.einsum("kd,kd->k", u, v), minlength=len(self.sides))

        shares = np.zeros((len(self.moving), 2))
        norms, slopes = at(shares)
        steps = FIRST / np.sqrt(np.maximum(sums(slopes, slopes), _TINY))
        for _ in range(number):
            # Steps that increase the norm are shortened and tried again.
            tried = np.clip(shares - steps[self.of_moving, None] * slopes, -1, 1)
            new_norms, new_slopes = at(tried)
            lower = new_norms < norms
            moved, turned = tried - shares, new_slopes - slopes
            bent = sums(moved, turned)
            good = lower & (bent > 0)
            steps = np.where(good, sums(moved, moved) / np.where(good, bent, 1), np.where(lower, 2, 0.25) * steps)
            taken = lower[self.of_moving, None]
            shares, slopes = np.where(taken, tried, shares), np.where(taken, new_slopes, slopes)
            norms = np.where(lower, new_norms, norms)
        return scales * np.einsum("kd,kdx->kx", shares, directions)

    def move_better(
        self, moves: np.ndarray, parts: Sequence[float], lines: np.ndarray, chains: Chains | None, are_better: Judge
    ) -> tuple[QuadMesh, np.ndarray]:
        """The quad mesh with the patches moved that improve, and (p,) bool: these patches.

        Each patch takes the first of the ``parts`` of the (k, 3) moves that is better; lines and chains as of
        :func:`project_vertices`.
        """
        quads, waiting = self.quads, np.ones(len(self.sides), bool)
        for part in parts:
            places = quads.vertices[self.moving] + part * moves
            tried = project_vertices(quads, self.ground.mesh, lines, chains, self.moving, places)
            better = are_better(tried.vertices, waiting)
            which = self.moving[better[self.of_moving]]
            quads = quads.moved(which, tried.vertices[which], tried.triangles[which], tried.weights[which])
            waiting &= ~better
            if not waiting.any():
                break
        return quads, ~waiting

    def norms(self, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(p,) norms of the corners' deviations, (p,) largest deviations, and (n, 3) gradient of the sum of norms."""
        off, to_before, to_after = self._deviations(vertices)
        labels, count = self.labels, len(self.sides)
        worst = np.full(count, _TINY)
        np.maximum.at(worst, labels, np.abs(off))
        powers = (np.abs(off) / worst[labels]) ** (POWER - 1)
        totals = np.maximum(np.bincount(labels, powers * np.abs(off) / worst[labels], minlength=count), _TINY)
        numbers = np.bincount(labels, minlength=count)
        means = np.maximum(np.sqrt(np.bincount(labels, off**2, minlength=count) / numbers), _TINY)
        slopes = (totals ** (1 / POWER - 1))[labels] * powers * np.sign(off) + SHARE * off / (means * numbers)[labels]
        gradient = self._sums_at_vertices @ (np.tile(slopes, 2)[:, None] * np.concatenate([to_before, to_after]))
        return worst * totals ** (1 / POWER) + SHARE * means, worst, gradient

    def means(self, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(p,) mean deviations of the patches' corners in radians, made smooth, and (n, 3) gradient of their sum."""
        off, to_before, to_after = self._deviations(vertices)
        labels, count = self.labels, len(self.sides)
        smooth, numbers = np.sqrt(off**2 + SMOOTH**2), np.bincount(labels, minlength=count)
        slopes = off / smooth / numbers[labels]
        gradient = self._sums_at_vertices @ (np.tile(slopes, 2)[:, None] * np.concatenate([to_before, to_after]))
        return np.bincount(labels, smooth, minlength=count) / numbers, gradient

    def turned(self, vertices: np.ndarray) -> np.ndarray:
        """(p,) number of corners beyond 180 degrees."""
        off = self._deviations(vertices)[0]
        return np.bincount(self.labels[np.abs(off) > np.pi / 2 + np.radians(STRAIGHT)], minlength=len(self.sides))

    def shortest(self, vertices: np.ndarray) -> np.ndarray:
        """(p,) length of the shortest edge."""
        shortest = np.full(len(self.sides), np.inf)
        lengths = np.linalg.norm(vertices[self.corners[:, 2]] - vertices[self.corners[:, 1]], axis=1)
        np.minimum.at(shortest, self.labels, lengths)
        return shortest

    def stay_near(self, vertices: np.ndarray, wanted: np.ndarray, near: float) -> np.ndarray:
        """(p,) bool: the wanted patches that stay as near to the surface, or nearer than a part of their mean edge."""
        if not wanted.any():
            return wanted
        away = self.ground.distances(self, vertices, wanted, self.below, near)
        far = wanted & (away > near * self.sides)
        if not far.any():
            return wanted
        before = self.ground.distances(self, self.quads.vertices, far, self.below)
        return wanted & (~far | (away <= (1 + FARTHER) * before))

    @cached_property
    def _sums_at_vertices(self) -> csr_matrix:
        """(n, 2 c) sums of the corners' gradients: of those by the vertices before them, then by those after."""
        count, (before, at, after) = len(self.corners), self.corners.T
        rows, columns = np.concatenate([before, after, at, at]), np.tile(np.arange(2 * count), 2)
        signs = np.repeat([1.0, -1.0], 2 * count)
        return csr_matrix((signs, (rows, columns)), shape=(len(self.quads.vertices), 2 * count))

    def _deviations(self, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(c,) differences to regular corners in radians, -pi to pi, and (c, 3) gradients by the two neighbours."""
        before, at, after = self.corners.T
        ahead, behind = vertices[after] - vertices[at], vertices[before] - vertices[at]
        across = cross(ahead, behind)
        normals = np.add.reduceat(across, np.flatnonzero(np.diff(self.faces, prepend=-1)))
        looks_up = np.einsum("fx,fx->f", normals, self.up) > 0
        normals = np.where(looks_up[:, None], normals, self.up)[self.faces]
        signs = np.where(np.einsum("cx,cx->c", across, normals) < 0, -1.0, 1.0)
        lengths = np.linalg.norm(across, axis=1)
        angles = np.arctan2(signs * lengths, np.einsum("cx,cx->c", ahead, behind))
        axes = (signs / np.maximum(lengths, _TINY))[:, None] * across
        to_before = cross(axes, behind) / np.maximum(np.einsum("cx,cx->c", behind, behind), _TINY)[:, None]
        to_after = -cross(axes, ahead) / np.maximum(np.einsum("cx,cx->c", ahead, ahead), _TINY)[:, None]
        return (angles - self.regular + np.pi) % (2 * np.pi) - np.pi, to_before, to_after
