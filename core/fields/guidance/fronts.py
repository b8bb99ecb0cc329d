# SPDX-License-Identifier: GPL-3.0-or-later
"""Distance by front propagation, on triangles and in tetrahedra (Fu, Jeong, Pan, Kirby and Whitaker 2011, "A Fast
Iterative Method for Solving the Eikonal Equation on Triangulated Surfaces").

In each cell the shortest way to a corner comes straight from a point of the opposite side, on which the distance is
linear: plane fronts are exact, around a point the error is of first order in the edge length. On surfaces a front
around a single source is bent: it takes its curvature along, which changes on its way as the surface's tells (Riccati's
equation along a geodesic), and over an edge the distance sags by it. That leaves a third to a tenth of the error.
"""

import numpy as np

from ...errors import SettingError
from ...graphs import ragged_arange

# Vertices are brought up to date together that the front reaches within this many mean edge lengths.
BAND = 1.0
# Changes below this share of the mean edge length are not passed on.
SMALL = 1e-4
UNKNOWN = 1e100
# Curvature of a front at the single source that it comes from.
_POINT = 1e30
# A front that narrows to less than this on its way has come to a point.
_FOCUSED = 1e-6


def front_distance(mesh, sources):
    """Length of the shortest way on a surface to the nearest source; between two sources of an edge it is 0 too.

    Parameters
    ----------
    mesh : TriangleMesh
    sources : (n,) bool, vertices at distance 0

    Returns
    -------
    (n,) float, scene units; nan on pieces without a source and on loose vertices

    Raises
    ------
    SettingError
        for a set that is empty or of another length
    """
    sources = chosen_vertices(mesh, sources, "group of sources")
    bends = np.where(sources, _POINT, 0.0)
    bends[mesh.edges[sources[mesh.edges].all(axis=1)]] = 0.0
    curvatures = _curvatures(mesh)

    def arrivals(distances, rows):
        triangles, corners = np.divmod(rows, 3)
        target = mesh.triangles[triangles, corners]
        side = mesh.triangles[triangles[:, None], (corners[:, None] + [1, 2]) % 3]
        nearer = distances[side].min(axis=1) < distances[target]
        target, side = target[nearer], side[nearer]
        points = mesh.vertices[side] - mesh.vertices[target, None]
        found, bend = _bent(points, distances[side], bends[side], curvatures[target])
        # Of several assignments the last one stays, which is that of the shortest way.
        order = np.argsort(-found, kind="stable")
        order = order[found[order] < distances[target[order]]]
        bends[target[order]] = bend[order]
        result = np.full(len(rows), UNKNOWN)
        result[nearer] = found
        return result

    return propagate_distances(mesh.triangles, mesh.edges, mesh.edge_lengths.mean(), sources, arrivals)


def chosen_vertices(mesh, chosen, name):
    """(n,) bool, vertices of a surface or solid without loose ones; refused where there are none or not n values."""
    chosen = np.array(chosen, bool)
    if chosen.shape != (mesh.vertex_count,):
        raise SettingError(
            f"the {name} has the shape {chosen.shape} and the mesh has {mesh.vertex_count} vertices: "
            "give one truth value to each vertex"
        )
    chosen[mesh.loose_vertices] = False
    if not chosen.any():
        raise SettingError(f"no vertex with a face is in the {name}: add at least one")
    return chosen


def propagate_distances(cells, edges, length, sources, arrivals):
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
        of, place = ragged_arange(self._counts[vertices])
        return self._order[self._starts[vertices][of] + place], of


def along(begin, end, first, last):
    """Distances at the origin over segments, on which they are linear."""
    start, way, _, _ = _ways(begin, end, first, last)
    return start + way


def dot(a, b):
    """(k,) products of (k, d) vectors."""
    return np.einsum("kx,kx->k", a, b)


def _ways(begin, end, first, last):
    """Where the shortest way to the origin leaves a segment.

    Returns the distance there, how far it is to the origin, which share of the segment that is, and the length of the
    segment as the front sees it.
    """
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
    return start, np.sqrt((foot - place) ** 2 + away**2), place / length, slack * length


def _bent(points, values, bends, curvatures):
    """(k,) distances at the origin over (k, 2, 3) segments, and (k,) curvatures of the fronts that arrive there.

    Parameters
    ----------
    points : ends of the segments
    values, bends : (k, 2) distances and curvatures of the fronts at the ends
    curvatures : (k,) of the surface at the origin
    """
    start, way, share, span = _ways(points[:, 0], points[:, 1], *values.T)
    # Between a single source and a vertex beside it, the front is bent as it is at that.
    inside = ((share > 0) & (share < 1))[:, None] & (bends == _POINT)
    bends = np.where(inside, bends[:, ::-1], bends)
    bend = (1 - share) * bends[:, 0] + share * bends[:, 1]
    length = np.linalg.norm(points[:, 1] - points[:, 0], axis=1)
    start -= 0.5 * np.clip(bend, -1 / length, 1 / length) * span**2 * share * (1 - share)
    grown = np.maximum(1 + bend * way, _FOCUSED)
    most = 1 / np.maximum(way, np.finfo(float).tiny)
    return start + way, np.clip((bend - curvatures * way) / grown, -most, most)


def _curvatures(mesh):
    """(n,) Gaussian curvature at the vertices, 0 on the boundary."""
    angles = np.bincount(mesh.triangles.ravel(), mesh.corner_angles.ravel(), mesh.vertex_count)
    areas = np.where(mesh.boundary_vertices, np.inf, mesh.vertex_masses)
    return (2 * np.pi - angles) / np.maximum(areas, np.finfo(float).tiny)
