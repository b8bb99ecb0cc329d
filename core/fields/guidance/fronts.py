# SPDX-License-Identifier: GPL-3.0-or-later
"""Distance by front propagation, on triangles and in tetrahedra (Fu, Jeong, Pan, Kirby and Whitaker 2011, "A Fast
Iterative Method for Solving the Eikonal Equation on Triangulated Surfaces").

In each cell the shortest way to a corner is straight from a point of the opposite side, on which the distance is
linear: plane fronts are exact, and around a point the error is of first order in the edge length. On surfaces a front
around a single source is curved: its curvature is propagated by Riccati's equation along a geodesic, which involves
that of the surface, and lowers the distance along an edge. That leaves a third to a tenth of the error.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ...errors import SettingError
from ...geometry.tet_mesh import TetMesh
from ...geometry.triangle_mesh import TriangleMesh
from ...graphs import ragged_arange

# Vertices that the front reaches within this many mean edge lengths are updated together.
BAND = 1.0
# Changes below this share of the mean edge length are not propagated.
SMALL = 1e-4
UNKNOWN = 1e100
# Curvature of a front at a single source.
_POINT = 1e30
# A front that narrows to less than this on its way has focused in a point.
_FOCUSED = 1e-6


def front_distance(mesh: TriangleMesh, sources: ArrayLike) -> np.ndarray:
    """(n,) lengths of the shortest ways on a surface to the nearest of (n,) bool sources, scene units.

    They are 0 along edges between two sources, and nan on pieces without a source and on loose vertices.

    Raises :class:`SettingError` for a set that is empty or of another length.
    """
    is_source = chosen_vertices(mesh, sources, "group of sources")
    bends = np.where(is_source, _POINT, 0.0)
    bends[mesh.edges[is_source[mesh.edges].all(axis=1)]] = 0.0
    curvatures = _curvatures(mesh)

    def arrivals(distances: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Distances of corners over the opposite sides, as :func:`propagate_distances` asks for them.

        Where one is below a vertex's distance, ``bends`` gets the curvature of the front that arrives there.
        """
        triangles, corners = np.divmod(rows, 3)
        target = mesh.triangles[triangles, corners]
        side = mesh.triangles[triangles[:, None], (corners[:, None] + [1, 2]) % 3]
        nearer = distances[side].min(axis=1) < distances[target]
        target, side = target[nearer], side[nearer]
        points = mesh.vertices[side] - mesh.vertices[target, None]
        found, bend = _across_segments(points, distances[side], bends[side], curvatures[target])
        # Of several assignments to a vertex the last one stays, that of the shortest way.
        order = np.argsort(-found, kind="stable")
        order = order[found[order] < distances[target[order]]]
        bends[target[order]] = bend[order]
        result = np.full(len(rows), UNKNOWN)
        result[nearer] = found
        return result

    return propagate_distances(mesh.triangles, mesh.edges, mesh.edge_lengths.mean(), is_source, arrivals)


def chosen_vertices(mesh: TriangleMesh | TetMesh, chosen: ArrayLike, name: str) -> np.ndarray:
    """(n,) bool, the chosen vertices of a surface or solid without loose ones; refuses empty sets and other lengths."""
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


def propagate_distances(
    cells: np.ndarray,
    edges: np.ndarray,
    length: float,
    sources: np.ndarray,
    arrivals: Callable[[np.ndarray, np.ndarray], np.ndarray],
) -> np.ndarray:
    """(n,) distances from sources, updated from near to far; nan where no front arrives.

    Parameters
    ----------
    cells : (m, k) vertices
    edges : (e, 2) pairs of neighbours
    length : mean length of the edges
    sources : (n,) bool
    arrivals : ((n,) distances, rows) -> distances of corners over the opposite sides; row k cell + corner
    """
    count = len(sources)
    corners = _Lists(cells.ravel(), count)
    others = _Lists(edges.T.ravel(), count)
    neighbour = edges[:, ::-1].T.ravel()
    distances = np.where(sources, 0, UNKNOWN)
    # The nearest value that changed beside a vertex since its last update.
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
    """Rows sorted by their vertices."""

    def __init__(self, vertices: np.ndarray, count: int) -> None:
        self._order = np.argsort(vertices, kind="stable")
        self._counts = np.bincount(vertices, minlength=count)
        self._starts = np.cumsum(self._counts) - self._counts

    def of(self, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """All rows of some vertices, and the index among these of each row's vertex."""
        of, place = ragged_arange(self._counts[vertices])
        return self._order[self._starts[vertices][of] + place], of


def along(begin: np.ndarray, end: np.ndarray, first: np.ndarray, last: np.ndarray) -> np.ndarray:
    """(k,) distances at the origin over segments on which they are linear."""
    start, way, _, _ = _ways(begin, end, first, last)
    return start + way


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(k,) products of (k, d) vectors."""
    return np.einsum("kx,kx->k", a, b)


def _ways(
    begin: np.ndarray, end: np.ndarray, first: np.ndarray, last: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """The shortest ways to the origin over segments on which distances are linear.

    Returns the distance where the way leaves the segment, the length from there to the origin, the place as a share of
    the segment, and the length of the segment projected on the front.
    """
    along = end - begin
    length = np.sqrt(dot(along, along))
    foot = -dot(along, begin) / length
    away = np.sqrt(np.maximum(dot(begin, begin) - foot**2, 0))
    slope = np.clip((last - first) / length, -1, 1)
    slack = np.sqrt(1 - slope**2)
    # At a slope of one the shortest way is along the segment, from its lower end.
    steep = np.where(slope > 0, 0, length)
    place = np.where(slack > 0, foot - slope * away / np.where(slack > 0, slack, 1), steep)
    place = np.clip(place, 0, length)
    # Exactly at the ends, one of which may be unknown yet.
    start = np.where(place <= 0, first, np.where(place >= length, last, first + slope * place))
    return start, np.sqrt((foot - place) ** 2 + away**2), place / length, slack * length


def _across_segments(
    points: np.ndarray, values: np.ndarray, bends: np.ndarray, curvatures: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(k,) distances at the origin over (k, 2, 3) segments, and (k,) curvatures of the fronts that arrive there.

    ``values`` and ``bends`` are (k, 2) distances and curvatures of the fronts at the ends, ``curvatures`` (k,) of the
    surface at the origin.
    """
    start, way, share, span = _ways(points[:, 0], points[:, 1], *values.T)
    # Between a single source and a vertex beside it, the front has the curvature at that vertex.
    inside = ((share > 0) & (share < 1))[:, None] & (bends == _POINT)
    bends = np.where(inside, bends[:, ::-1], bends)
    bend = (1 - share) * bends[:, 0] + share * bends[:, 1]
    length = np.linalg.norm(points[:, 1] - points[:, 0], axis=1)
    start -= 0.5 * np.clip(bend, -1 / length, 1 / length) * span**2 * share * (1 - share)
    grown = np.maximum(1 + bend * way, _FOCUSED)
    most = 1 / np.maximum(way, np.finfo(float).tiny)
    return start + way, np.clip((bend - curvatures * way) / grown, -most, most)


def _curvatures(mesh: TriangleMesh) -> np.ndarray:
    """(n,) Gaussian curvature at the vertices, 0 on the boundary."""
    angles = np.bincount(mesh.triangles.ravel(), mesh.corner_angles.ravel(), mesh.vertex_count)
    areas = np.where(mesh.boundary_vertices, np.inf, mesh.vertex_masses)
    return (2 * np.pi - angles) / np.maximum(areas, np.finfo(float).tiny)
