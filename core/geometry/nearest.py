# SPDX-License-Identifier: GPL-3.0-or-later
"""Nearest points of triangles, in double precision, with NumPy and SciPy.

The triangle whose centre is nearest gives a first distance. A hierarchy of boxes around groups of triangles excludes
groups that are farther away, down to single triangles, of which the nearest is chosen.
"""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from ..errors import MeshError
from ..unit_vectors import cross

# Number of boxes in a larger one.
BRANCHES = 4
# Triangles share boxes if their sizes differ by less than this power of two, as larger ones would widen the boxes.
SIZE_POWER = 3
# Triangles among which :meth:`NearestTriangles.nearby` looks.
NEARBY = 12
# Pairs of a point and a box per batch, which take about a kilobyte each.
BATCH = 16384
# Squared sine of the angle at the first corner up to which a triangle is thin.
THIN = 1e-4
# Generous bound of the rounding error of distances, as a share of the largest coordinate.
ROUNDING = 1e-14


class NearestTriangles:
    """A search structure for nearest points on triangles; pickled as its two arrays.

    Raises MeshError without triangles.

    Parameters
    ----------
    vertices : (n, 3)
    triangles : (m, 3) of any shape and size, also without area
    """

    def __init__(self, vertices: ArrayLike, triangles: ArrayLike) -> None:
        self.vertices, self.triangles = np.array(vertices, float), np.array(triangles, int)
        if len(self.triangles) == 0:
            raise MeshError("there are no faces to find the nearest points on: add some")

    def __getstate__(self) -> dict[str, np.ndarray]:
        return {"vertices": self.vertices, "triangles": self.triangles}

    def nearest(self, points: ArrayLike, enough: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """Find the (k, 3) nearest places to (k, 3) points, and their (k,) triangles, the first of several as near.

        Up to a distance of ``enough`` the place on the triangle with the nearest centre will do.
        """
        points = np.asarray(points, float).reshape(-1, 3)
        found = self._centres.query(points)[1]
        places, squares = np.empty_like(points), np.empty(len(points))
        for part in _split(np.arange(len(points))):
            places[part], squares[part] = self._nearest_on(points[part], found[part])
        slack = ROUNDING * max(self._largest, np.abs(points).max(initial=0))
        top = len(self._boxes) - 1
        parts = _split(np.flatnonzero(squares > enough**2) if enough else np.arange(len(points)))
        # The last part is on top, so that few parts wait at any time.
        waiting = [(top, part, np.zeros(len(part), int)) for part in parts[::-1]]
        while waiting:
            level, at, nodes = waiting.pop()
            # Coordinates come first, so that NumPy's inner loops run along the pairs.
            low, high = (np.take(corner, nodes, axis=2) for corner in self._boxes[level])
            here = points.T[:, None, at]
            gaps = np.maximum(low - here, here - high)
            gaps = np.maximum(gaps, 0, out=gaps)
            gaps *= gaps
            near = gaps[0] + gaps[1] + gaps[2] <= (np.sqrt(squares[at]) + slack) ** 2
            rows, branches = np.nonzero(np.ascontiguousarray(near.T))
            at, nodes = at[rows], BRANCHES * nodes[rows] + branches
            if level:
                pairs = zip(_split(at), _split(nodes), strict=True)
                waiting.extend([(level - 1, *pair) for pair in pairs][::-1])
            else:
                self._improve(points, at, self._order[nodes], found, places, squares)
        return places, found

    def nearest_facing(
        self, points: np.ndarray, normals: np.ndarray, nearby: bool = False
    ) -> tuple[np.ndarray, np.ndarray]:
        """Find as :meth:`nearest`, or as :meth:`nearby` if asked, on the sheet of a thin surface whose triangles look
        along (k, 3) normals."""
        places, found = self.nearby(points) if nearby else self.nearest(points)
        behind = np.flatnonzero(np.einsum("px,px->p", self._normals[found], normals) < 0)
        axes = np.abs(normals[behind]).argmax(axis=1)
        sides = 2 * axes + (np.take_along_axis(normals[behind], axes[:, None], 1)[:, 0] < 0)
        for side in np.unique(sides):
            which = behind[sides == side]
            triangles, sheet = self._facing(side)
            if sheet is not None:
                places[which], rows = sheet.nearest(points[which])
                found[which] = triangles[rows]
        return places, found

    def _facing(self, side: int) -> tuple[np.ndarray, "NearestTriangles | None"]:
        """The triangles that look along an axis, 2 k, or against it, 2 k + 1, and their search structure."""
        if side not in self._sheets:
            sign = 1 - 2 * (side % 2)
            triangles = np.flatnonzero(sign * self._normals[:, side // 2] > 0)
            sheet = NearestTriangles(self.vertices, self.triangles[triangles]) if len(triangles) else None
            self._sheets[side] = triangles, sheet
        return self._sheets[side]

    @cached_property
    def _sheets(self) -> dict[int, tuple[np.ndarray, "NearestTriangles | None"]]:
        return {}

    @cached_property
    def _normals(self) -> np.ndarray:
        """(m, 3) vectors along the normals of triangles."""
        a, b, c = self._corners
        return cross(b - a, c - a)

    def nearby(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """As :meth:`nearest` in a third of the time, on the nearest of :data:`NEARBY` triangles: seldom another."""
        away, candidates = self._centres.query(points, k=range(1, 1 + min(NEARBY, len(self.triangles))))
        found = candidates[:, 0].copy()
        places, squares = self._nearest_on(points, found)
        at, others = np.nonzero(away - self._sizes[candidates] < np.sqrt(squares)[:, None])
        self._improve(points, at, candidates[at, others], found, places, squares)
        return places, found

    def _improve(
        self,
        points: np.ndarray,
        at: np.ndarray,
        triangles: np.ndarray,
        found: np.ndarray,
        places: np.ndarray,
        squares: np.ndarray,
    ) -> None:
        """Replace what was found for (c,) ascending points where (c,) triangles are nearer."""
        other = triangles != found[at]
        at, triangles = at[other], triangles[other]
        if len(at) == 0:
            return
        new_places, new_squares = self._nearest_on(points[at], triangles)
        begins = np.append(True, at[1:] != at[:-1])
        starts, owners = np.flatnonzero(begins), np.cumsum(begins) - 1
        least = np.minimum.reduceat(new_squares, starts)[owners]
        first = np.minimum.reduceat(np.where(new_squares == least, triangles, len(self.triangles)), starts)[owners]
        is_better = (new_squares < squares[at]) | ((new_squares == squares[at]) & (triangles < found[at]))
        better = np.flatnonzero((triangles == first) & is_better)
        at = at[better]
        found[at], places[at], squares[at] = triangles[better], new_places[better], new_squares[better]

    def _nearest_on(self, points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Compute the (c, 3) places of (c,) triangles nearest to (c, 3) points, and the (c,) squared distances."""
        corners = self._corners[:, triangles]
        shares = nearest_in_triangles(points, corners)
        places = np.einsum("pc,cpx->px", shares, corners)
        return places, np.einsum("px,px->p", points - places, points - places)

    @cached_property
    def _corners(self) -> np.ndarray:
        """(3, m, 3) coordinates."""
        return self.vertices[self.triangles.T]

    @cached_property
    def _largest(self) -> float:
        """The largest coordinate of the triangles; other vertices may be anywhere, even not finite."""
        return float(np.abs(self._corners).max())

    @cached_property
    def _centres(self) -> cKDTree:
        return cKDTree(self._corners.mean(axis=0))

    @cached_property
    def _sizes(self) -> np.ndarray:
        """(m,) largest distance of a corner from the centre."""
        return np.linalg.norm(self._corners - self._centres.data, axis=2).max(axis=0)

    @cached_property
    def _order(self) -> np.ndarray:
        """(m,) triangles in an order that groups those of similar size and place."""
        powers = np.frexp(np.maximum(self._sizes, np.finfo(float).tiny))[1] // SIZE_POWER
        order = self._centres.tree.indices
        return order[np.argsort(powers[order], kind="stable")]

    @cached_property
    def _boxes(self) -> list[tuple[np.ndarray, ...]]:
        """Lowest and highest corners, (3, BRANCHES, g) each, of the boxes in g larger ones: level by level from single
        triangles to one group."""
        low, high = self._corners[:, self._order].min(axis=0).T, self._corners[:, self._order].max(axis=0).T
        levels: list[tuple[np.ndarray, ...]] = []
        while not levels or low.shape[1] > 1:
            missing = ((0, 0), (0, -low.shape[1] % BRANCHES))
            low = np.pad(low, missing, constant_values=np.inf).reshape(3, -1, BRANCHES)
            high = np.pad(high, missing, constant_values=-np.inf).reshape(3, -1, BRANCHES)
            levels.append(tuple(np.ascontiguousarray(corner.swapaxes(1, 2)) for corner in (low, high)))
            low, high = low.min(axis=2), high.max(axis=2)
        return levels


def nearest_in_triangles(points: ArrayLike, corners: Sequence[np.ndarray] | np.ndarray) -> np.ndarray:
    """Compute (..., 3) barycentric coordinates of the points of triangles, (3, ..., 3), nearest to (..., 3) points.

    Corners that the nearest point does not depend on get exactly 0 (Ericson, "Real-Time Collision Detection", 2005,
    Section 5.1.5).
    """
    points = np.asarray(points, float)
    points = points.reshape((1,) * (np.ndim(corners[0]) - points.ndim) + points.shape)
    # Coordinates come first, so that NumPy's inner loops run along the triangles.
    point, a, b, c = (_by_component(places) for places in (points, *corners))
    ab, ac, ap = b - a, c - a, point - a
    aa, bb, mixed = _product(ab, ab), _product(ac, ac), _product(ab, ac)
    d1, d2 = _product(ab, ap), _product(ac, ap)
    d3, d4, d5, d6 = d1 - aa, d2 - mixed, d1 - mixed, d2 - bb
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    to_b, to_c = d4 - d3, d5 - d6
    total = va + vb + vc
    at_b, at_c = _ratio(vb, total), _ratio(vc, total)
    at_a = 1 - at_b - at_c
    # The regions of edges and corners; later ones override earlier ones.
    for region, of_b, of_c in (
        ((va <= 0) & (to_b >= 0) & (to_c >= 0), lambda k: 1 - _ratio(to_b[k], (to_b + to_c)[k]), None),
        ((vb <= 0) & (d2 >= 0) & (d6 <= 0), lambda k: 0.0, lambda k: _ratio(d2[k], (d2 - d6)[k])),
        ((d6 >= 0) & (d5 <= d6), lambda k: 0.0, lambda k: 1.0),
        ((vc <= 0) & (d1 >= 0) & (d3 <= 0), lambda k: _ratio(d1[k], (d1 - d3)[k]), lambda k: 0.0),
        ((d3 >= 0) & (d4 <= d3), lambda k: 1.0, lambda k: 0.0),
        ((d1 <= 0) & (d2 <= 0), lambda k: 0.0, lambda k: 0.0),
    ):
        inside = np.nonzero(region)
        at_b[inside] = of_b(inside)
        at_c[inside] = 1 - at_b[inside] if of_c is None else of_c(inside)
        at_a[inside] = 0.0 if of_c is None else 1 - at_b[inside] - at_c[inside]
    shares = np.stack([at_a, at_b, at_c], axis=-1)
    thin = total <= THIN * aa * bb
    if thin.any():
        chosen, *of_chosen = (np.broadcast_to(places, shares.shape)[thin] for places in (points, *corners))
        shares[thin] = _nearest_in_thin(chosen, of_chosen)
    return shares


def _by_component(places: ArrayLike) -> np.ndarray:
    """Move the coordinates of (..., 3) places to the front: (3, ...)."""
    places = np.asarray(places, float)
    return np.ascontiguousarray(places.transpose(-1, *range(places.ndim - 1)))


def _product(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Compute (...) scalar products of (3, ...) vectors."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def _nearest_in_thin(points: np.ndarray, corners: Sequence[np.ndarray]) -> np.ndarray:
    """Compute (k, 3) barycentric coordinates as the nearest of candidates on the edges and inside, without the
    cancellation of the products above."""
    lengths = np.stack([_dot(corners[k - 2] - corners[k], corners[k - 2] - corners[k]) for k in range(3)])
    candidates = []
    for k in range(3):
        along = np.clip(_ratio(_dot(points - corners[k], corners[k - 2] - corners[k]), lengths[k]), 0, 1)
        candidates.append(np.roll(np.stack([1 - along, along, np.zeros_like(along)], axis=-1), k, axis=-1))
    # Coordinates in the plane along the longest edge, and along the part of another side at right angles to it.
    turned = (lengths.argmax(axis=0)[:, None] + np.arange(3)) % 3
    first, second, third = np.take_along_axis(np.array(corners), turned.T[:, :, None], axis=0)
    edge, side = second - first, third - first
    across = side
    for _ in range(2):
        across = across - _ratio(_dot(across, edge), _dot(edge, edge))[:, None] * edge
    at_third = _ratio(_dot(points - first, across), _dot(across, across))
    at_second = _ratio(_dot(points - first - at_third[:, None] * side, edge), _dot(edge, edge))
    inside = np.stack([1 - at_second - at_third, at_second, at_third], axis=-1)
    inside = np.take_along_axis(inside, np.argsort(turned, axis=1), axis=1)
    candidates.append(np.where((inside > 0).all(axis=1, keepdims=True), inside, candidates[0]))
    offsets = points - np.einsum("sqc,cqx->sqx", candidates, corners)
    return np.array(candidates)[_dot(offsets, offsets).argmin(axis=0), np.arange(len(points))]


def _dot(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return np.einsum("...x,...x->...", u, v)


def _ratio(part: np.ndarray, whole: np.ndarray) -> np.ndarray:
    return np.divide(part, whole, out=np.zeros_like(part), where=whole != 0)


def _split(values: np.ndarray) -> list[np.ndarray]:
    """Split an array into parts of bounded length."""
    return np.array_split(values, max(1, -(-len(values) // BATCH)))
