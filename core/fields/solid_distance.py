# SPDX-License-Identifier: GPL-3.0-or-later
"""Distance inside a solid by front propagation (Fu, Kirby and Whitaker 2013, "A Fast Iterative Method for Solving the
Eikonal Equation on Tetrahedral Domains").

In each tetrahedron the shortest way to a corner comes straight from a point of the opposite face, on which the distance
is linear: plane fronts are exact, around a point the error is of first order in the edge length. The heat method is
faster, but off by more on coarse solids and near the boundary.
"""

import numpy as np

from ..errors import SettingError
from ..interpolate_solid import FACE_CORNERS

# Vertices are brought up to date together that the front reaches within this many mean edge lengths.
BAND = 1.0
# Changes below this share of the mean edge length are not passed on.
SMALL = 1e-4
UNKNOWN = 1e100


def solid_distance(mesh, sources):
    """Length of the shortest way inside the solid to the nearest source; between three sources of a face it is 0 too.

    Parameters
    ----------
    mesh : TetMesh
    sources : (n,) bool, vertices at distance 0

    Returns
    -------
    (n,) float, scene units; nan on pieces without a source and on loose vertices

    Raises
    ------
    SettingError
        for a set that is empty or of another length
    """
    sources = np.array(sources, bool)
    if sources.shape != (mesh.vertex_count,):
        raise SettingError(
            f"the sources have the shape {sources.shape} and the solid has {mesh.vertex_count} vertices: "
            "give one truth value to each vertex"
        )
    sources[mesh.loose_vertices] = False
    if not sources.any():
        raise SettingError("no vertex of a tetrahedron is among the sources: add at least one to the group")
    corners = _Lists(mesh.tets.ravel(), mesh.vertex_count)
    others = _Lists(mesh.edges.T.ravel(), mesh.vertex_count)
    neighbour = mesh.edges[:, ::-1].T.ravel()
    length = mesh.edge_lengths.mean()
    distances = np.where(sources, 0, UNKNOWN)
    # The nearest value that changed beside a vertex since it was brought up to date.
    news = np.full(mesh.vertex_count, UNKNOWN)
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
        best = np.minimum.reduceat(_arrivals(mesh, distances, rows), np.flatnonzero(np.diff(of, prepend=-1)))
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


def _arrivals(mesh, distances, rows):
    """(k,) distances at corners, 4 t + k, over the opposite faces; unknown where these are farther than the corners."""
    tets, corners = np.divmod(rows, 4)
    target = mesh.tets[tets, corners]
    face = mesh.tets[tets[:, None], FACE_CORNERS[corners]]
    nearer = distances[face].min(axis=1) < distances[target]
    result = np.full(len(rows), UNKNOWN)
    result[nearer] = _over_faces(
        distances[face[nearer]], mesh.vertices[face[nearer]] - mesh.vertices[target[nearer], None]
    )
    return result


def _over_faces(values, points):
    """(k,) distances at the origin over (k, 3, 3) triangles, on which they are linear."""
    one, two = points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]
    gram = np.array([_dot(one, one), _dot(one, two), _dot(two, two)])
    scale = gram[0] * gram[2] - gram[1] ** 2
    slopes = values[:, 1:].T - values[:, 0]
    # Solutions of the Gram matrix: where the target projects to, and the slope of the distance.
    foot = np.array([-_dot(one, points[:, 0]), -_dot(two, points[:, 0])])
    shares, steepness = _solved(gram, scale, foot), _solved(gram, scale, slopes)
    height = np.maximum(_dot(points[:, 0], points[:, 0]) - (foot * shares).sum(axis=0), 0)
    slack = 1 - np.minimum((slopes * steepness).sum(axis=0), 2)
    through = shares - np.sqrt(height / np.where(slack > 0, slack, 1)) * steepness
    inside = (slack > 0) & (through >= 0).all(axis=0) & (through.sum(axis=0) <= 1)
    result = values[:, 0] + (slopes * shares).sum(axis=0) + np.sqrt(height * np.maximum(slack, 0))
    rim = np.flatnonzero(~inside)
    sides = [_along(points[rim, k - 1], points[rim, k], values[rim, k - 1], values[rim, k]) for k in range(3)]
    result[rim] = np.minimum.reduce(sides)
    return result


def _along(begin, end, first, last):
    """Distances at the origin over segments."""
    along = end - begin
    length = np.sqrt(_dot(along, along))
    foot = -_dot(along, begin) / length
    away = np.sqrt(np.maximum(_dot(begin, begin) - foot**2, 0))
    slope = np.clip((last - first) / length, -1, 1)
    slack = np.sqrt(1 - slope**2)
    # At a slope of one the way along the segment is the best: from its lower end.
    steep = np.where(slope > 0, 0, length)
    place = np.where(slack > 0, foot - slope * away / np.where(slack > 0, slack, 1), steep)
    place = np.clip(place, 0, length)
    # Exactly at the ends, one of which may be unknown yet.
    start = np.where(place <= 0, first, np.where(place >= length, last, first + slope * place))
    return start + np.sqrt((foot - place) ** 2 + away**2)


def _solved(gram, scale, right):
    return np.array([gram[2] * right[0] - gram[1] * right[1], gram[0] * right[1] - gram[1] * right[0]]) / scale


def _dot(a, b):
    return np.einsum("kx,kx->k", a, b)
