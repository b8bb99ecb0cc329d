# SPDX-License-Identifier: GPL-3.0-or-later
"""The nearest points of triangles, in double precision, by NumPy and SciPy alone.

The triangle whose centre is nearest gives a first distance. Boxes around groups of triangles rule out groups that are
farther, then smaller ones in the others, down to single triangles, and the nearest of those that are left is taken.
"""

from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from ..errors import MeshError

# Boxes in a larger one.
BRANCHES = 4
# Triangles whose sizes differ by less than this power of two share boxes: one that is far larger would widen them all.
SIZE_POWER = 3
# Pairs of a point and a box that are looked at together, which bounds the memory to about a kilobyte times as many.
BATCH = 16384
# Squared sine of the angle at the first corner up to which a triangle is thin.
THIN = 1e-4
# Share of the largest coordinate that the computed distances may be wrong by, by far.
ROUNDING = 1e-14


class NearestTriangles:
    """Triangles that can be asked for the nearest point; pickled as its two arrays.

    Parameters
    ----------
    vertices : (n, 3)
    triangles : (m, 3) of them, of any shape and size, without area too

    Raises
    ------
    MeshError
        where there are no triangles
    """

    def __init__(self, vertices, triangles):
        self.vertices, self.triangles = np.array(vertices, float), np.array(triangles, int)
        if len(self.triangles) == 0:
            raise MeshError("there are no faces to find the nearest points on: add some")

    def __getstate__(self):
        return {"vertices": self.vertices, "triangles": self.triangles}

    def nearest(self, points):
        """Where the triangles are nearest to points, and which these are.

        Parameters
        ----------
        points : (k, 3)

        Returns
        -------
        places : (k, 3)
        triangles : (k,), the first of those at the same distance
        """
        points = np.asarray(points, float).reshape(-1, 3)
        found = self._centres.query(points)[1]
        places, squares = np.empty_like(points), np.empty(len(points))
        parts = _parts(np.arange(len(points)))
        for part in parts:
            places[part], squares[part] = self._measured(points[part], found[part])
        slack = ROUNDING * max(np.abs(self.vertices).max(), np.abs(points).max(initial=0))
        top = len(self._boxes) - 1
        # The last part first, so that few parts wait at any time.
        waiting = [(top, part, np.zeros(len(part), int)) for part in parts[::-1]]
        while waiting:
            level, at, nodes = waiting.pop()
            # Places by component, so that the loops are along the pairs.
            low, high = (np.take(corner, nodes, axis=2) for corner in self._boxes[level])
            here = points.T[:, None, at]
            gaps = np.maximum(low - here, here - high)
            gaps = np.maximum(gaps, 0, out=gaps)
            gaps *= gaps
            near = gaps[0] + gaps[1] + gaps[2] <= (np.sqrt(squares[at]) + slack) ** 2
            rows, branches = np.nonzero(np.ascontiguousarray(near.T))
            at, nodes = at[rows], BRANCHES * nodes[rows] + branches
            if level:
                pairs = zip(_parts(at), _parts(nodes), strict=True)
                waiting.extend([(level - 1, *pair) for pair in pairs][::-1])
            else:
                self._improve(points, at, self._order[nodes], found, places, squares)
        return places, found

    def _improve(self, points, at, triangles, found, places, squares):
        """Take those of (c,) triangles that are nearer to points than what was found; (c,) points in rising order."""
        other = triangles != found[at]
        at, triangles = at[other], triangles[other]
        if len(at) == 0:
            return
        new_places, new_squares = self._measured(points[at], triangles)
        starts = np.flatnonzero(np.diff(at, prepend=-1))
        owners = np.cumsum(np.diff(at, prepend=-1) > 0) - 1
        least = np.minimum.reduceat(new_squares, starts)[owners]
        first = np.minimum.reduceat(np.where(new_squares == least, triangles, len(self.triangles)), starts)[owners]
        is_better = (new_squares < squares[at]) | ((new_squares == squares[at]) & (triangles < found[at]))
        better = np.flatnonzero((triangles == first) & is_better)
        at = at[better]
        found[at], places[at], squares[at] = triangles[better], new_places[better], new_squares[better]

    def _measured(self, points, triangles):
        """(c, 3) places of (c,) triangles that are nearest to (c, 3) points, and (c,) squares of the distances."""
        corners = self._corners[:, triangles]
        shares = nearest_in_triangles(points, corners)
        places = np.einsum("pc,cpx->px", shares, corners)
        return places, np.einsum("px,px->p", points - places, points - places)

    @cached_property
    def _corners(self):
        """(3, m, 3) places."""
        return self.vertices[self.triangles.T]

    @cached_property
    def _centres(self):
        return cKDTree(self._corners.mean(axis=0))

    @cached_property
    def _order(self):
        """(m,) triangles in an order in which those of about the same size and place are together."""
        sizes = np.linalg.norm(self._corners - self._centres.data, axis=2).max(axis=0)
        powers = np.frexp(np.maximum(sizes, np.finfo(float).tiny))[1] // SIZE_POWER
        order = self._centres.tree.indices
        return order[np.argsort(powers[order], kind="stable")]

    @cached_property
    def _boxes(self):
        """Lowest and highest corners of boxes around triangles, around groups of them and so on, up to a single group.

        (3, BRANCHES, g) each, of those that are in g larger boxes.
        """
        low, high = self._corners[:, self._order].min(axis=0).T, self._corners[:, self._order].max(axis=0).T
        levels: list[tuple] = []
        while not levels or low.shape[1] > 1:
            missing = ((0, 0), (0, -low.shape[1] % BRANCHES))
            low = np.pad(low, missing, constant_values=np.inf).reshape(3, -1, BRANCHES)
            high = np.pad(high, missing, constant_values=-np.inf).reshape(3, -1, BRANCHES)
            levels.append(tuple(np.ascontiguousarray(corner.swapaxes(1, 2)) for corner in (low, high)))
            low, high = low.min(axis=2), high.max(axis=2)
        return levels


def nearest_in_triangles(points, corners):
    """Shares of the corners in the nearest point of triangles; exactly 0 for the corners that it does not depend on.

    Parameters
    ----------
    points : (..., 3)
    corners : (3, ..., 3)

    Returns
    -------
    (..., 3) barycentric coordinates

    Source
    ------
    Ericson, "Real-Time Collision Detection" (2005), Section 5.1.5
    """
    points = np.asarray(points, float)
    points = points.reshape((1,) * (np.ndim(corners[0]) - points.ndim) + points.shape)
    # By component, so that the loops are along the triangles.
    point, a, b, c = (_by_component(places) for places in (points, *corners))
    ab, ac, ap = b - a, c - a, point - a
    aa, bb, cross = _product(ab, ab), _product(ac, ac), _product(ab, ac)
    d1, d2 = _product(ab, ap), _product(ac, ap)
    d3, d4, d5, d6 = d1 - aa, d2 - cross, d1 - cross, d2 - bb
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    to_b, to_c = d4 - d3, d5 - d6
    total = va + vb + vc
    at_b, at_c = _ratio(vb, total), _ratio(vc, total)
    at_a = 1 - at_b - at_c
    # The regions of edges and corners, a later one before those above it.
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
        points, *corners = (np.broadcast_to(places, shares.shape)[thin] for places in (points, *corners))
        shares[thin] = _nearest_in_thin(points, corners)
    return shares


def _by_component(places):
    """(3, ...) of (..., 3) places."""
    return np.ascontiguousarray(np.moveaxis(np.asarray(places, float), -1, 0))


def _product(u, v):
    """(...) scalar products of (3, ...) vectors."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def _nearest_in_thin(points, corners):
    """(k, 3) shares as above, the nearest of those on the edges and inside: where the products above cancel."""
    lengths = np.stack([_dot(corners[k - 2] - corners[k], corners[k - 2] - corners[k]) for k in range(3)])
    candidates = []
    for k in range(3):
        along = np.clip(_ratio(_dot(points - corners[k], corners[k - 2] - corners[k]), lengths[k]), 0, 1)
        candidates.append(np.roll(np.stack([1 - along, along, np.zeros_like(along)], axis=-1), k, axis=-1))
    # The plane as it is spanned by the longest edge and what is across it in another.
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


def _dot(u, v):
    return np.einsum("...x,...x->...", u, v)


def _ratio(part, whole):
    return np.divide(part, whole, out=np.zeros_like(part), where=whole != 0)


def _parts(values):
    """An array cut into those of bounded length."""
    return np.array_split(values, max(1, -(-len(values) // BATCH)))
