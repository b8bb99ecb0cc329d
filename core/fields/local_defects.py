# SPDX-License-Identifier: GPL-3.0-or-later
"""Line ends that are moved or added in a pattern, which stays as it is farther away.

Along edge e the phases of a pattern change by its target and a residual psi_e, in [-pi, pi). Around a triangle with a
dislocation N the changes add up to 2 pi N. To carry N from one triangle to another, a path of triangles leads there,
and whole turns eta_e are added to the changes along the edges that it crosses. Since the pattern is at rest, where the
sums of w_e sin(psi_e) at its vertices vanish, the phases f that are added at the vertices near the path are those that

    minimize sum of w_e (sin(psi_e) + eta_e + (D f)_e)^2,

a linear problem, as the turns stay. Farther away f is 0, and so it is where constraints fix or join phases.

Where a pattern is mirrored, each phase is joined to its images. Of those the one nearest to the path is free, and the
others are made its images at the end; phases on the plane of a mirror stay.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.sparse import csr_matrix, diags_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from ..algebra.factorization import factorize
from ..connection import as_matrices
from ..errors import SettingError
from ..matchings import after_turns
from ..problem import SynchronizationProblem
from .patterns import Pattern

# Phases change up to this distance from the path, and a new stripe has this length, in spacings.
REACH, LENGTH = 4.0, 2.0
# The least weight of an edge; what keeps the matrix definite, as a share of its diagonal.
SMALLEST_WEIGHT, SHIFT = 1e-3, 1e-9
# In a mirrored pattern more than this share of the phases are joined to others; most images of one, in three planes.
MIRRORED_SHARE, MOST_IMAGES = 1 / 3, 8


def move_line_ends(pattern: Pattern, start: int, end: int) -> Pattern:
    """The pattern with the line ends of triangle ``start`` in triangle ``end``.

    Raises :class:`SettingError` where there are none, or where they cannot lie.
    """
    numbers, _ = pattern.edge_phases.dislocations
    if not numbers[start].any():
        raise SettingError("the line end is not there any more: choose another one")
    return pattern if start == end else _carry(pattern, start, [(end, -numbers[start])], end)


def add_stripe(pattern: Pattern, triangle: int) -> Pattern:
    """The pattern with a line end in a triangle, where a short stripe begins or a stripe is interrupted.

    The other end of the stripe lies along the lines, where it costs least. Errors as :func:`move_line_ends`.
    """
    one_form, mesh = pattern.one_form, pattern.mesh
    _, torn = pattern.edge_phases.dislocations
    vertex, centres = mesh.triangles[triangle, 0], mesh.vertices[mesh.triangles].mean(axis=1)
    x, y = mesh.tangent_frames
    tries = []
    for phase, unit in enumerate(np.eye(one_form.phase_count, dtype=int)):
        angle = one_form.angles[vertex] + phase * one_form.turn + np.pi / 2
        length = LENGTH * 2 * np.pi / one_form.rates[vertex, phase]
        along = length * (np.cos(angle) * x[vertex] + np.sin(angle) * y[vertex])
        for place in (centres[triangle] + along, centres[triangle] - along):
            end = int(((centres - place) ** 2).sum(axis=1).argmin())
            if end != triangle and not torn[end]:
                tries += [(end, unit), (end, -unit)]
    if not tries:
        raise SettingError("there is no room for another line end here: choose another face")
    return _carry(pattern, triangle, tries, triangle)


def _carry(pattern: Pattern, start: int, tries: Sequence[tuple[int, np.ndarray]], place: int) -> Pattern:
    """The pattern of least energy of several tries: each adds (k,) numbers to the triangle ``start`` and subtracts them
    from another triangle.

    Around ``place``, one of the triangles, the edges share the changes evenly, so that none exceeds half a turn.
    """
    mesh, residuals = pattern.mesh, np.sin(pattern.edge_phases.changes - pattern.one_form.changes)
    _, torn = pattern.edge_phases.dislocations
    if torn[[start, *(end for end, _ in tries)]].any():
        raise SettingError("a line end cannot lie in a face with a swirl point: choose another face")
    paths = _paths(pattern, start, [end for end, _ in tries])
    edges, free, difference = _near(pattern, np.unique(np.concatenate(paths)))
    if not np.isin(pattern.one_form.phase_count * mesh.triangles[place], free).all():
        raise SettingError("the phases here are fixed by a constraint or on a mirror plane: choose another face")
    weights = np.repeat(np.maximum(mesh.weights[edges], SMALLEST_WEIGHT), pattern.one_form.phase_count)
    matrix = difference.T @ diags_array(weights) @ difference
    factors = factorize((matrix + SHIFT * diags_array(matrix.diagonal())).tocsr(), single=False)
    around = [(edge, _sums(pattern, place, edge)) for edge in mesh.triangle_edges[place]]
    found = []
    for path, (_, added) in zip(paths, tries, strict=True):
        changes = residuals + 2 * np.pi * _turns(pattern, path, added)
        third = sum(changes[edge] @ sums for edge, sums in around) / 3
        for edge, sums in around:
            changes[edge] -= third @ sums.T
        phases = pattern.phases.copy()
        phases[free] *= np.exp(-1j * factors.solve(difference.T @ (weights * changes[edges].ravel())))
        found.append(pattern.with_phases(_with_images(pattern.problem, phases, free)))
    return min(found, key=lambda other: other.energy)


def _paths(pattern: Pattern, start: int, ends: Sequence[int]) -> list[np.ndarray]:
    """Shortest paths of adjacent triangles from one to each of the ends, without triangles with a swirl point."""
    mesh, (_, torn) = pattern.mesh, pattern.edge_phases.dislocations
    centres = mesh.vertices[mesh.triangles].mean(axis=1)
    first, second = np.arange(len(mesh.twins)) // 3, mesh.twins // 3
    passable = (mesh.twins >= 0) & ~(torn[first] | torn[second])
    first, second = first[passable], second[passable]
    lengths = np.linalg.norm(centres[first] - centres[second], axis=1)
    graph = csr_matrix((lengths, (first, second)), (len(centres), len(centres)))
    for limit in (4 * np.linalg.norm(centres[ends] - centres[start], axis=1).max(), np.inf):
        before = dijkstra(graph, indices=start, return_predecessors=True, limit=limit)[1]
        if (before[ends] >= 0).all():
            break
    paths = []
    for end in ends:
        path = [end]
        while path[-1] != start:
            path.append(int(before[path[-1]]))
            if path[-1] < 0:
                raise SettingError("a line end cannot go there: choose a face of the same part, on this side of cuts")
        paths.append(np.array(path[::-1]))
    return paths


def _turns(pattern: Pattern, path: np.ndarray, added: np.ndarray) -> np.ndarray:
    """(e, k) whole turns along the edges that a path crosses, which add (k,) numbers in its first triangle."""
    mesh = pattern.mesh
    turns, carried = np.zeros(pattern.one_form.changes.shape), -added
    for triangle, following in pairwise(path):
        (edge,) = np.intersect1d(mesh.triangle_edges[triangle], mesh.triangle_edges[following])[:1]
        turns[edge] = -carried @ _sums(pattern, triangle, edge).T
        carried = turns[edge] @ _sums(pattern, following, edge)
    return turns


def _sums(pattern: Pattern, triangle: int, edge: int) -> np.ndarray:
    """(k, k) how the changes of an edge, in the rows, count in the sums around a triangle for its first corner."""
    mesh, matchings = pattern.mesh, pattern.one_form.matchings
    units, turns = np.eye(pattern.one_form.phase_count), 0
    own, signs = mesh.triangle_edges[triangle], mesh.triangle_edge_signs[triangle]
    corner = own.tolist().index(edge)
    for before in range(corner):
        turns += signs[before] * matchings[own[before]]
    forward = units if signs[corner] > 0 else -after_turns(units, matchings[edge])
    return after_turns(forward, -turns)


def _near(pattern: Pattern, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, csr_matrix]:
    """(e,) edges near some triangles, (f,) nodes there that may change, and their (k e, f) differences along edges."""
    mesh, one_form, problem = pattern.mesh, pattern.one_form, pattern.problem
    count = one_form.phase_count
    reach = REACH * 2 * np.pi / one_form.rates[mesh.triangles[triangles]].min()
    centres = mesh.vertices[mesh.triangles[triangles]].mean(axis=1)
    distances = cKDTree(centres).query(mesh.vertices, distance_upper_bound=reach)[0]
    is_near = distances < np.inf
    is_free = np.repeat(is_near, count)
    is_free[problem.fixed.nodes] = False
    is_free &= _are_nearest_images(problem, np.repeat(distances, count))
    edges = np.flatnonzero(is_near[mesh.edges].any(axis=1))
    is_free &= np.isin(np.arange(len(is_free)) // count, mesh.edges[edges])
    tails, heads = (count * ends[:, None] + np.arange(count) for ends in mesh.edges[edges].T)
    heads = after_turns(heads + 1, -one_form.matchings[edges])  # counted from 1: each has a sign
    rows, columns = np.arange(tails.size), np.concatenate([np.abs(heads).ravel() - 1, tails.ravel()])
    values = np.concatenate([np.sign(heads).ravel(), -np.ones(tails.size)])
    difference = csr_matrix((values, (np.tile(rows, 2), columns)), (tails.size, len(is_free)))
    return edges, np.flatnonzero(is_free), difference[:, is_free]


def _are_nearest_images(problem: SynchronizationProblem, distances: np.ndarray) -> np.ndarray:
    """(k n,) bool: in a mirrored pattern the nearest phase of each group of joined ones, otherwise the phases that are
    joined to no other."""
    merged, loops = problem.merged, np.equal(*problem.connection.edges.T)
    roots = np.arange(len(distances))
    roots[merged.nodes] = merged.roots
    sizes = np.bincount(roots)[roots]
    if len(merged.nodes) <= MIRRORED_SHARE * len(distances):
        return sizes == 1
    order = np.lexsort((distances, roots))
    is_nearest = np.zeros(len(distances), bool)
    is_nearest[order[np.unique(roots[order], return_index=True)[1]]] = True
    is_nearest[problem.connection.edges[loops, 0]] = False  # on a mirror's plane
    return is_nearest & (sizes <= MOST_IMAGES)


def _with_images(problem: SynchronizationProblem, phases: np.ndarray, free: np.ndarray) -> np.ndarray:
    """The phases after the free ones changed: each phase that is joined to a free one follows it."""
    merged = problem.merged
    places, turns = np.column_stack([phases.real, phases.imag]), as_matrices(merged.transports)
    is_free = np.isin(merged.nodes, free)
    places[merged.roots[is_free]] = np.einsum("kba,kb->ka", turns[is_free], places[merged.nodes[is_free]])
    is_led = np.isin(merged.roots, np.append(free, merged.roots[is_free]))
    places[merged.nodes[is_led]] = np.einsum("kab,kb->ka", turns[is_led], places[merged.roots[is_led]])
    return places[:, 0] + 1j * places[:, 1]
