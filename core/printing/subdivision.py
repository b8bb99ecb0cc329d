# SPDX-License-Identifier: GPL-3.0-or-later
"""Triangles cut into smaller ones on the same surface."""

from collections.abc import Callable

import numpy as np

from ..geometry import TriangleMesh

# Rounds of cutting: an edge gets a power of this many halves at most.
_ROUNDS = 12


def subdivide(mesh: TriangleMesh, size: float, most: int) -> tuple[TriangleMesh, np.ndarray]:
    """Halve edges that are longer than a size, until a number of triangles is reached.

    Returns the finer mesh, whose first vertices are the given ones, and (t,) the given triangle that contains each.
    """
    parents = np.arange(mesh.triangle_count)
    for _ in range(_ROUNDS):
        is_long = mesh.edge_lengths > size
        if not is_long.any() or mesh.triangle_count + 2 * np.count_nonzero(is_long) > most:
            break
        triangles, of = _halve_long_edges(mesh, is_long)
        i, j = mesh.edges[is_long].T
        middles = (mesh.vertices[i] + mesh.vertices[j]) / 2
        mesh, parents = TriangleMesh(np.vstack([mesh.vertices, middles]), triangles), parents[of]
    return mesh, parents


def subdivide_by(
    mesh: TriangleMesh,
    found: np.ndarray,
    values: Callable[[np.ndarray, np.ndarray], np.ndarray],
    size: float,
    tolerance: float,
    most: int,
) -> tuple[TriangleMesh, np.ndarray, np.ndarray]:
    """Halve edges along which a function is not linear.

    Parameters
    ----------
    found : (n,) values of the function at the vertices
    values : callable((k, 3) points, (k,) a vertex of the piece that each is on) -> (k,)
    size : edges that are shorter stay, scene units
    tolerance : of the function along an edge
    most : triangles, about

    Returns
    -------
    fine, parents : as :func:`subdivide`
    found : (n,) values at its vertices
    """
    vertices, owners = mesh.vertices, np.arange(mesh.vertex_count)
    done, tested = [(np.empty((0, 3), int), np.empty(0, int))], 0
    triangles, parents = mesh.triangles, np.arange(mesh.triangle_count)
    for _ in range(_ROUNDS):
        # What has no new vertex has been looked at before, and so have its edges.
        new = (triangles >= tested).any(axis=1)
        done.append((triangles[~new], parents[~new]))
        part, parents = TriangleMesh(vertices, triangles[new]), parents[new]
        triangles = part.triangles
        bent = (part.edge_lengths > size) & (part.edges.max(axis=1, initial=-1) >= tested)
        tested = len(vertices)
        i, j = part.edges[bent].T
        there = values((vertices[i] + vertices[j]) / 2, owners[i])
        # Where the function has a kink, the middle of the edge shows half of it at least.
        far = np.abs(there - (found[i] + found[j]) / 2) > tolerance / 2
        count = sum(len(some) for some, _ in done) + len(triangles)
        if not far.any() or count + 2 * np.count_nonzero(far) > most:
            break
        bent[bent] = far
        triangles, of = _halve_long_edges(part, bent)
        found, owners = np.append(found, there[far]), np.append(owners, owners[i[far]])
        vertices, parents = np.vstack([vertices, (vertices[i[far]] + vertices[j[far]]) / 2]), parents[of]
    triangles, parents = map(np.concatenate, zip(*done, (triangles, parents), strict=True))
    return TriangleMesh(vertices, triangles), parents, found


def _halve_long_edges(mesh: TriangleMesh, is_long: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(t, 3) triangles with a vertex in the middle of each long edge, and (t,) the triangle that each is a part of."""
    middle = np.where(is_long, mesh.vertex_count + np.cumsum(is_long) - 1, -1)
    corners, at = mesh.triangles, middle[mesh.triangle_edges]
    count = (at >= 0).sum(axis=1)
    # Turned so that of one the long side comes first, and of two the short one comes last.
    turn = np.where(count == 1, (at >= 0).argmax(axis=1), np.where(count == 2, ((at < 0).argmax(axis=1) + 1) % 3, 0))
    order = (turn[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(corners, order, axis=1).T
    ab, bc, ca = np.take_along_axis(at, order, axis=1).T
    # The quad that two cuts leave is cut along its shorter diagonal.
    places = np.vstack([mesh.vertices, (mesh.vertices[mesh.edges[is_long]]).mean(axis=1)])
    is_turned = np.linalg.norm(places[ab] - places[c], axis=1) > np.linalg.norm(places[a] - places[bc], axis=1)
    two, turned = (count == 2) & ~is_turned, (count == 2) & is_turned
    pieces = [
        (count == 0, [(a, b, c)]),
        (count == 1, [(a, ab, c), (ab, b, c)]),
        (two, [(ab, b, bc), (a, ab, c), (ab, bc, c)]),
        (turned, [(ab, b, bc), (a, ab, bc), (a, bc, c)]),
        (count == 3, [(a, ab, ca), (ab, b, bc), (bc, c, ca), (ab, bc, ca)]),
    ]
    made, of = [], []
    for chosen, parts in pieces:
        for part in parts:
            made.append(np.column_stack(part)[chosen])
            of.append(np.flatnonzero(chosen))
    return np.concatenate(made), np.concatenate(of)


def places_in(mesh: TriangleMesh, triangles: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """(k, 3) places in (k,) triangles, spread evenly over those with consecutive (k,) numbers (Martin Roberts' R2
    sequence, folded into the triangle)."""
    u, v = ((numbers + 0.5)[:, None] * [0.7548776662466927, 0.5698402909980532] % 1).T
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    a, b, c = (mesh.vertices[column[triangles]] for column in mesh.triangles.T)
    return a + u[:, None] * (b - a) + v[:, None] * (c - a)
