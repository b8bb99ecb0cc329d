# SPDX-License-Identifier: GPL-3.0-or-later
"""The boundary of the surface as part of the graph of its grid lines."""

import numpy as np

from ....geometry import TriangleMesh
from ....unit_vectors import cross
from ...lines.edge_crossings import Crossings

# The boundary keeps a corner where it bulges by more than this part of the distance between two lines that meet it, or
# turns by more than this angle at a vertex.
BULGE, SHARP = 0.3, np.radians(60)
# A line that meets the boundary within this part of an edge from a vertex passes through the vertex.
_THROUGH = 1e-4


def boundary_segments(
    mesh: TriangleMesh, crossings: Crossings, met: np.ndarray, node_count: int, on_grid: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The boundary as segments with the surface on their left, and its corners.

    Parameters
    ----------
    met : (c,) bool, crossings at which a line reaches the boundary
    node_count : node of the first boundary vertex; the others follow
    on_grid : (n,) bool, vertices on lines of both phases: corners of the grid, unless lines pass through them

    Returns (b, 2) nodes of the segments, (v,) bool corners, and (v,) boundary vertices.
    """
    half = np.flatnonzero(mesh.twins < 0)
    heads = np.roll(mesh.triangles, -1, axis=1).ravel()
    # The half-edge of the boundary that leaves each vertex.
    leaving = np.full(mesh.vertex_count, -1)
    leaving[mesh.triangles.ravel()[half]] = half
    vertices = np.flatnonzero(leaving >= 0)
    number = np.full(mesh.vertex_count, -1)
    number[vertices] = node_count + np.arange(len(vertices))
    pieces, corners = [], np.zeros(len(vertices), bool)
    waiting = np.ones(mesh.vertex_count, bool)
    for first in vertices:
        # Along one loop: nodes and their places, and which are met by lines.
        nodes, points, hit = [], [], []
        vertex = first
        while waiting[vertex]:
            waiting[vertex] = False
            edge = mesh.triangle_edges.ravel()[leaving[vertex]]
            head = heads[leaving[vertex]]
            passed = crossings.starts[edge] + np.arange(crossings.counts[edge])
            shares = crossings.shares[passed]
            if vertex > head:
                passed, shares = passed[::-1], 1 - shares[::-1]
            nodes += [number[vertex], *passed]
            points.append(mesh.vertices[vertex] + np.outer([0, *shares], mesh.vertices[head] - mesh.vertices[vertex]))
            hit += [False, *met[passed]]
            vertex = head
        if nodes:
            loop = np.array(nodes)
            pieces.append(np.column_stack([loop, np.roll(loop, -1)]))
            way, met_there, is_vertex = np.concatenate(points), np.array(hit), loop >= node_count
            places = np.flatnonzero(is_vertex)
            turned = places[on_grid[vertices[loop[places] - node_count]]]
            turned = turned[~_is_crossed_beside(way, met_there, is_vertex, turned)]
            chosen = loop[np.union1d(_corners(way, met_there, is_vertex), turned)]
            corners[chosen - node_count] = True
    return np.concatenate([np.empty((0, 2), int), *pieces]), corners, vertices


def _corners(points: np.ndarray, hit: np.ndarray, is_vertex: np.ndarray) -> np.ndarray:
    """Indices of the corners that a closed loop needs besides the places where lines meet it.

    The loop bulges there between two lines; or fewer than three lines meet it, and corners complete a triangle. A loop
    that no line meets gets none: the face around it contains it.
    """
    chosen = np.flatnonzero(hit).tolist()
    corners = []
    for start, stop in zip(chosen, [*chosen[1:], chosen[0] + len(points)] if chosen else [], strict=True):
        between = np.arange(start + 1, stop) % len(points)
        between = between[is_vertex[between]]
        chord = points[stop % len(points)] - points[start]
        length = np.linalg.norm(chord)
        away = points[between] - points[start]
        along = np.clip(away @ chord / max(length**2, np.finfo(float).tiny), 0, 1)
        bulge = np.linalg.norm(away - along[:, None] * chord, axis=1)
        sharp = between[turning_angles(points, between) > SHARP]
        if len(sharp):
            corners += sharp.tolist()
        elif len(bulge) and bulge.max() > BULGE * length:
            corners.append(between[bulge.argmax()])
    if chosen:
        corners += add_farthest(points, [*chosen, *corners], np.flatnonzero(is_vertex), 3)
    return np.array(corners, int)


def add_farthest(points: np.ndarray, taken: list[int], spare: np.ndarray, wanted: int) -> list[int]:
    """Indices of points added one by one, each the farthest from the ``taken`` and added ones, until ``wanted`` in all.

    ``points`` are (p, 3), ``taken`` holds at least one index, ``spare`` (s,) the indices that may be added.
    """
    added: list[int] = []
    while len(taken) + len(added) < wanted:
        spare = np.setdiff1d(spare, [*taken, *added])
        if len(spare) == 0:
            break
        distances = np.linalg.norm(points[spare, None] - points[[*taken, *added]], axis=2).min(axis=1)
        added.append(spare[distances.argmax()])
    return added


def _is_crossed_beside(points: np.ndarray, hit: np.ndarray, is_vertex: np.ndarray, places: np.ndarray) -> np.ndarray:
    """(k,) bool: whether a line meets the closed polyline right beside each of the given vertices."""
    through = np.zeros(len(places), bool)
    vertices = np.flatnonzero(is_vertex)
    for step in (1, -1):
        beside = (places + step) % len(points)
        following = vertices[(np.searchsorted(vertices, places) + step) % len(vertices)]
        edge = np.linalg.norm(points[following] - points[places], axis=1)
        through |= hit[beside] & (np.linalg.norm(points[beside] - points[places], axis=1) < _THROUGH * edge)
    return through


def vertex_places(mesh: TriangleMesh, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(k,) a triangle at each vertex, and (k, 3) barycentric coordinates of the vertex there."""
    corner_of = np.zeros(mesh.vertex_count, int)
    corner_of[mesh.triangles.ravel()] = np.arange(3 * mesh.triangle_count)
    return corner_of[vertices] // 3, np.eye(3)[corner_of[vertices] % 3]


def turning_angles(points: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Angles by which a closed polyline turns at some of its points."""
    ahead = points[(places + 1) % len(points)] - points[places]
    behind = points[places] - points[places - 1]
    across = np.linalg.norm(cross(behind, ahead), axis=1)
    return np.arctan2(across, np.einsum("ij,ij->i", behind, ahead))
