# SPDX-License-Identifier: GPL-3.0-or-later
"""The boundary of the surface as part of the graph of its grid lines."""

import numpy as np

# A boundary that bulges by more than this, in distances between two lines that meet it, keeps a corner there, and
# everywhere where it turns by more than this at once.
BULGE, SHARP = 0.3, np.radians(60)
# A line that meets the boundary within this part of an edge from a vertex passes through the vertex.
_THROUGH = 1e-4


def border_of(mesh, crossings, met, node_count, on_grid):
    """The boundary as pieces with the surface on their left, and which of its vertices are corners.

    Parameters
    ----------
    met : (c,) bool, crossings at which a line reaches the boundary
    node_count : number of nodes before the boundary's vertices, which are nodes from there on
    on_grid : (n,) bool, vertices on lines of both phases: corners of the grid, unless lines pass through them

    Returns
    -------
    (b, 2) nodes of the pieces, (v,) bool corners, and (v,) the vertices
    """
    half = np.flatnonzero(mesh.twins < 0)
    heads = np.roll(mesh.triangles, -1, axis=1).ravel()
    following = np.full(mesh.vertex_count, -1)
    following[mesh.triangles.ravel()[half]] = half
    vertices = np.flatnonzero(following >= 0)
    number = np.full(mesh.vertex_count, -1)
    number[vertices] = node_count + np.arange(len(vertices))
    pieces, corners = [], np.zeros(len(vertices), bool)
    waiting = np.ones(mesh.vertex_count, bool)
    for first in vertices:
        nodes, points, hit = [], [], []
        vertex = first
        while waiting[vertex]:
            waiting[vertex] = False
            edge = mesh.triangle_edges.ravel()[following[vertex]]
            head = heads[following[vertex]]
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


def _corners(points, hit, is_vertex):
    """Indices of the places on a closed loop that its faces cannot do without, besides those where lines meet it.

    They bulge from between two lines, or make a triangle of a loop that fewer lines meet. A loop that none meets is
    closed by the face around it.
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
        sharp = between[turns(points, between) > SHARP]
        if len(sharp):
            corners += sharp.tolist()
        elif len(bulge) and bulge.max() > BULGE * length:
            corners.append(between[bulge.argmax()])
    if chosen:
        corners += farthest_added(points, [*chosen, *corners], np.flatnonzero(is_vertex), 3)
    return np.array(corners, int)


def farthest_added(points, taken, spare, wanted):
    """Indices of the points, one after another the farthest from those taken, that make up a number of them.

    Parameters
    ----------
    points : (p, 3)
    taken : indices of at least one of them
    spare : (s,) indices of those that may be added
    wanted : how many there are to be with those taken, as far as there are any to spare
    """
    added: list[int] = []
    while len(taken) + len(added) < wanted:
        spare = np.setdiff1d(spare, [*taken, *added])
        if len(spare) == 0:
            break
        distances = np.linalg.norm(points[spare, None] - points[[*taken, *added]], axis=2).min(axis=1)
        added.append(spare[distances.argmax()])
    return added


def _is_crossed_beside(points, hit, is_vertex, places):
    """(k,) bool: whether a line meets a closed line of points right beside some of its vertices."""
    through = np.zeros(len(places), bool)
    vertices = np.flatnonzero(is_vertex)
    for way in (1, -1):
        beside = (places + way) % len(points)
        following = vertices[(np.searchsorted(vertices, places) + way) % len(vertices)]
        edge = np.linalg.norm(points[following] - points[places], axis=1)
        through |= hit[beside] & (np.linalg.norm(points[beside] - points[places], axis=1) < _THROUGH * edge)
    return through


def turns(points, places):
    """Angles by which a closed line turns at some of its points."""
    ahead = points[(places + 1) % len(points)] - points[places]
    behind = points[places] - points[places - 1]
    across = np.linalg.norm(np.cross(behind, ahead), axis=1)
    return np.arctan2(across, np.einsum("ij,ij->i", behind, ahead))
