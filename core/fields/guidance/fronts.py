# SPDX-License-Identifier: GPL-3.0-or-later
"""Distance by front propagation, on triangles and in tetrahedra (Fu, Jeong, Pan, Kirby and Whitaker 2011, "A Fast
Iterative Method for Solving the Eikonal Equation on Triangulated Surfaces").

In each cell the shortest way to a corner comes straight from a point of the opposite side, on which the distance is
linear: plane fronts are exact, around a point the error is of first order in the edge length. The heat method is
faster, but off by more on coarse meshes and near the boundary.
"""

import numpy as np

# Vertices are brought up to date together that the front reaches within this many mean edge lengths.
BAND = 1.0
# Changes below this share of the mean edge length are not passed on.
SMALL = 1e-4
UNKNOWN = 1e100


def front_distance(mesh, sources):
    """Length of the shortest way on a surface to the nearest source; between two sources of an edge it is 0 too.

    Parameters
    ----------
    mesh : TriangleMesh
    sources : (n,) bool, vertices at distance 0

    Returns
    -------
    (n,) float, scene units; nan on pieces without a source and on loose vertices
    """

    def arrivals(distances, rows):
        triangles, corners = np.divmod(rows, 3)
        target = mesh.triangles[triangles, corners]
        side = mesh.triangles[triangles[:, None], (corners[:, None] + [1, 2]) % 3]
        nearer = distances[side].min(axis=1) < distances[target]
        result = np.full(len(rows), UNKNOWN)
        points = mesh.vertices[side[nearer]] - mesh.vertices[target[nearer], None]
        result[nearer] = along(points[:, 0], points[:, 1], *distances[side[nearer]].T)
        return result

    return propagated(mesh.triangles, mesh.edges, mesh.edge_lengths.mean(), sources, arrivals)


def propagated(cells, edges, length, sources, arrivals):
    """Distances from sources, brought up to date from near to far.

    Parameters
    ----------
    cells : (m, k) vertices
    edges : (e, 2) pairs of neighbours
    length : of a mean edge
    sources : (n,) bool
    arrivals : callable((n,) distances, rows) -> distances of corners, row k cell + corner, over the opposite sides

    Returns
    -------
    (n,) float, nan where nothing arrives
    """
    count = len(sources)
    corners = _Lists(cells.ravel(), count)
    others = _Lists(edges.T.ravel(), count)
    neighbour = edges[:, ::-1].T.ravel()
    distances = np.where(sources, 0, UNKNOWN)
    # The nearest value that changed beside a vertex since it was brought up to date.
    news = np.full(count, UNKNOWN)
    changed = np.flatnonzero(sources)
    while True:
        rows, of = others.of(changed)
        np.minimum.at(news, neighbour[rows], distances[changed][of])
        news[sources] = UNKNOWN
        first = news.min()
        if first == UNKNOWN:
            return np.where(distances < UNKNOWN, distances, np.nan)
        due = np.flatnonzero(news <= first + BAND * length)
        news[due] = UNKNOWN
        rows, of = corners.of(due)
        best = np.minimum.reduceat(arrivals(distances, rows), np.flatnonzero(np.diff(of, prepend=-1)))
        changed = due[best < distances[due] - SMALL * length]
        distances[due] = np.minimum(distances[due], best)


class _Lists:
    """Rows by the vertex that they belong to."""

    def __init__(self, vertices, count):
        self._order = np.argsort(vertices, kind="stable")
        self._counts = np.bincount(vertices, minlength=count)
        self._starts = np.cumsum(self._counts) - self._counts

    def of(self, vertices):
        """All rows of vertices, and which of these each belongs to."""
        counts = self._counts[vertices]
        of = np.repeat(np.arange(len(vertices)), counts)
        place = np.arange(len(of)) - np.repeat(np.cumsum(counts) - counts, counts)
        return self._order[self._starts[vertices][of] + place], of


def along(begin, end, first, last):
    """Distances at the origin over segments."""
    along = end - begin
    length = np.sqrt(dot(along, along))
    foot = -dot(along, begin) / length
    away = np.sqrt(np.maximum(dot(begin, begin) - foot**2, 0))
    slope = np.clip((last - first) / length, -1, 1)
    slack = np.sqrt(1 - slope**2)
    # At a slope of one the way along the segment is the best: from its lower end.
    steep = np.where(slope > 0, 0, length)
    place = np.where(slack > 0, foot - slope * away / np.where(slack > 0, slack, 1), steep)
    place = np.clip(place, 0, length)
    # Exactly at the ends, one of which may be unknown yet.
    start = np.where(place <= 0, first, np.where(place >= length, last, first + slope * place))
    return start + np.sqrt((foot - place) ** 2 + away**2)


def dot(a, b):
    """(k,) products of (k, d) vectors."""
    return np.einsum("kx,kx->k", a, b)
