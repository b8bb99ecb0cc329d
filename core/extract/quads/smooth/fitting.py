# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the faces of a quad mesh as near to rectangles as the surface and its lines allow.

Each face has a target, the nearest rectangle in its own plane. A vertex moves to the mean of its faces' targets
(Bouaziz et al. 2012, Shape-Up), then back onto the surface or its feature line. The target of a face
that is turned over is turned back.
"""

import numpy as np

from ....geometry import TriangleMesh
from ....geometry.barycentric import barycentric
from ....graphs import components, sum_by
from ....unit_vectors import cross, unit_vectors
from ..features.chains import SMALLEST_GAP, Chains
from ..measure.quality import corner_angles, worst_deviations
from ..trace.quad_mesh import QuadMesh

# Share by which the sides of target rectangles are moved to their mean length in the first round, falling linearly.
SQUARE = 0.5
# Corners within this deviation from a right angle, in degrees, are good; extra weight of worse ones.
GOOD, URGENCY = 30.0, 4.0
# Part of the gap to its neighbour on the line by which a vertex may move in a round, so that no two meet.
NEARER = 0.4
_TINY = np.finfo(float).tiny


def fit_quads(
    quads: QuadMesh, mesh: TriangleMesh, free: np.ndarray, rounds: int, chains: Chains | None = None
) -> QuadMesh:
    """The quad mesh on a surface after some rounds; the targets of faces that are not quads are regular polygons.

    Only (n,) bool free vertices move, those on feature lines along the chains.
    """
    lines = sliding_lines(free, chains)
    movable = np.flatnonzero(free)
    for number in range(rounds):
        square = SQUARE * (1 - number / rounds)
        weights = _urgencies(quads)[quads.corner_faces, None]
        moved, sums = np.zeros_like(quads.vertices), np.zeros((len(quads.vertices), 1))
        np.add.at(moved, quads.corner_vertices, weights * _target_corners(quads, mesh, square))
        np.add.at(sums, quads.corner_vertices, weights)
        moved /= np.maximum(sums, _TINY)
        before, quads = quads, project_vertices(quads, mesh, lines, chains, movable, moved[movable])
        met = np.intersect1d(movable, quads.edges_without_length)
        if len(met):  # the nearest point of the surface to both is a corner: they stay where they were
            quads = quads.moved(met, before.vertices[met], before.triangles[met], before.weights[met])
    return quads


def keep_better(fitted: QuadMesh, before: QuadMesh) -> QuadMesh:
    """The fitted quad mesh; components as before whose corners got farther from right angles in the mean, and whose
    shortest edge got shorter."""
    labels = components(len(before.vertices), before.half_edges)
    of_corners = labels[before.corner_vertices]

    def measures(quads: QuadMesh) -> tuple[np.ndarray, np.ndarray]:
        ends = quads.vertices[quads.half_edges]
        shortest = np.full(labels.max(initial=-1) + 1, np.inf)
        np.minimum.at(shortest, of_corners, np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))
        return np.bincount(of_corners, np.abs(corner_angles(quads) - 90)), shortest

    (off, shortest), (off_before, shortest_before) = measures(fitted), measures(before)
    which = np.flatnonzero(((off > off_before) & (shortest < shortest_before))[labels])
    return fitted.moved(which, before.vertices[which], before.triangles[which], before.weights[which])


def part_vertices(quads: QuadMesh, mesh: TriangleMesh, kept: np.ndarray) -> QuadMesh:
    """The quad mesh with one end of each edge without length moved to the middle of its neighbours.

    It is an end that is not kept, (n,) bool, if there is one. A vertex on the rim moves between those on the rim.
    """
    short = quads.edges_without_length
    which = np.unique(np.where(kept[short[:, 0]], short[:, 1], short[:, 0]))
    if len(which) == 0:
        return quads
    edges, counts = quads.edges
    vertices, neighbours = np.concatenate([edges, edges[:, ::-1]]).T
    heard = ~quads.on_rim[vertices] | np.tile(counts == 1, 2)
    sums = sum_by(vertices[heard], quads.vertices[neighbours[heard]], len(kept))
    numbers = np.bincount(vertices[heard], minlength=len(kept))
    return project_vertices(quads, mesh, np.full(len(kept), -1), None, which, sums[which] / numbers[which, None])


def sliding_lines(free: np.ndarray, chains: Chains | None) -> np.ndarray:
    """(n,) line on which each vertex slides, -1 for none; arguments as of :func:`fit_quads`."""
    return np.full(len(free), -1) if chains is None else np.where(free, chains.lines, -1)


def project_vertices(
    quads: QuadMesh,
    mesh: TriangleMesh,
    lines: np.ndarray,
    chains: Chains | None,
    which: np.ndarray,
    places: np.ndarray,
) -> QuadMesh:
    """The quad mesh with (k,) vertices moved to the points of the surface, or of their lines, nearest to (k, 3) places.

    ``lines`` as of :func:`sliding_lines`. On a line, vertices pass neither each other nor its ends.
    """
    loose = lines[which] < 0
    normals = mesh.face_normals[quads.triangles[which]]
    ends, triangles = mesh.finder.nearest_facing(places[loose], normals[loose], nearby=True)
    quads = quads.moved(which[loose], ends, triangles, barycentric(mesh, triangles, ends))
    if chains is None or loose.all():
        return quads
    sliding = which[~loose]
    ways = _slide_along(quads, chains, sliding, places[~loose])
    return quads.moved(sliding, *chains.features.at(lines[sliding], ways))


def _slide_along(quads: QuadMesh, chains: Chains, which: np.ndarray, places: np.ndarray) -> np.ndarray:
    """(k,) positions along their lines nearest to places, limited so that the order of each line's vertices stays."""
    features = chains.features
    on_line = np.flatnonzero(chains.lines >= 0)
    ways, _ = features.nearest(chains.lines[on_line], quads.vertices[on_line])
    runs = (chains.lines + len(features.lines) * chains.groups)[on_line]
    order = np.lexsort((ways, runs))
    on_line, ways, runs = on_line[order], ways[order], runs[order]
    lines = chains.lines[on_line]
    lengths, closed = features.lengths[lines], features.closed[lines]
    firsts = np.flatnonzero(np.diff(runs, prepend=-1))
    lasts = np.append(firsts[1:], len(lines)) - 1
    behind, ahead = np.roll(ways, 1), np.roll(ways, -1)
    behind[firsts] = np.where(closed[firsts], ways[lasts] - lengths[firsts], 0)
    ahead[lasts] = np.where(closed[lasts], ways[firsts] + lengths[lasts], lengths[lasts])
    least = SMALLEST_GAP * chains.gaps[lines]
    back, on = (NEARER * np.maximum(gaps - least, 0) for gaps in (ways - behind, ahead - ways))
    at = np.zeros(len(chains.lines), int)
    at[on_line] = np.arange(len(on_line))
    at = at[which]
    steps = features.nearest(lines[at], places)[0] - ways[at]
    steps -= np.where(closed[at], lengths[at] * np.rint(steps / lengths[at]), 0)
    moved = ways[at] + np.clip(steps, -back[at], on[at])
    return np.where(closed[at], moved % lengths[at], moved)


def _urgencies(quads: QuadMesh) -> np.ndarray:
    """(f,) weights of faces in the mean of targets: the worse their worst corner, the larger."""
    return 1 + URGENCY * np.maximum(worst_deviations(quads) / GOOD - 1, 0) ** 2


def _target_corners(quads: QuadMesh, mesh: TriangleMesh, square: float) -> np.ndarray:
    """(c, 3) targets of the faces' corners."""
    targets = quads.vertices[quads.corner_vertices]
    normals = mesh.face_normals[quads.triangles][quads.corner_vertices]
    for size in np.unique(quads.sizes):
        corners = quads.starts[quads.sizes == size, None] + np.arange(size)
        places = targets[corners]
        up = normals[corners].sum(axis=1)
        targets[corners] = _rectangles(places, up, square) if size == 4 else _regular(places, up)
    return targets


def _rectangles(corners: np.ndarray, up: np.ndarray, square: float) -> np.ndarray:
    """(f, 4, 3) corners of the rectangles nearest to quads, seen from (f, 3) up; squares if ``square`` is 1."""
    middle = corners.mean(axis=1, keepdims=True)
    first = (corners[:, 1] - corners[:, 0] + corners[:, 2] - corners[:, 3]) / 2
    second = (corners[:, 3] - corners[:, 0] + corners[:, 2] - corners[:, 1]) / 2
    normals = cross(first, second)
    normals = unit_vectors(np.where(np.einsum("fx,fx->f", normals, up)[:, None] > 0, normals, up))
    lengths = np.stack([np.linalg.norm(first, axis=1), np.linalg.norm(second, axis=1)], axis=1)
    lengths += square * (lengths.mean(axis=1, keepdims=True) - lengths)
    along = unit_vectors(first) + cross(unit_vectors(second), normals)
    along = unit_vectors(along - np.einsum("fx,fx->f", along, normals)[:, None] * normals)
    u = lengths[:, :1] / 2 * along
    v = lengths[:, 1:] / 2 * cross(normals, along)
    return middle + np.stack([-u - v, u - v, u + v, v - u], axis=1)


def _regular(corners: np.ndarray, up: np.ndarray) -> np.ndarray:
    """(f, k, 3) corners of the regular polygons nearest to polygons, seen from (f, 3) up."""
    size = corners.shape[1]
    middle = corners.mean(axis=1, keepdims=True)
    offsets = corners - middle
    normals = cross(offsets, np.roll(offsets, -1, axis=1)).sum(axis=1)
    normals = unit_vectors(np.where(np.einsum("fx,fx->f", normals, up)[:, None] > 0, normals, up))
    angles = 2 * np.pi / size * np.arange(size)[:, None]
    # The mean of all corners, rotated back to the first one.
    across = cross(normals[:, None], offsets)
    spoke = (np.cos(angles) * offsets - np.sin(angles) * across).mean(axis=1)
    spoke -= np.einsum("fx,fx->f", spoke, normals)[:, None] * normals
    return middle + np.cos(angles) * spoke[:, None] + np.sin(angles) * cross(normals, spoke)[:, None]
