# SPDX-License-Identifier: GPL-3.0-or-later
"""Cut-away solids: the surface that is left, as triangles in tetrahedra, and the phases at their corners."""

from dataclasses import dataclass

import numpy as np

from synch_fields.core.geometry.tet_mesh import TET_EDGES, TetMesh
from synch_fields.core.interpolate_solid import evaluate_in_tets

# Triangles in punctured tetrahedra are cut into 4 so often: a corner attribute is linear.
HALVINGS = 4
# Of a triangle with one or two corners above a plane, what is above it: pairs of corners between which its own lie,
# counted from the corner that is alone.
KEPT = {1: (((0, 0), (0, 1), (0, 2)),), 2: (((0, 1), (1, 1), (2, 2)), ((0, 1), (2, 2), (0, 2)))}


@dataclass(frozen=True)
class Surface:
    """(k,) tetrahedron that each triangle lies in, and (k, 3, 4) weights of its corners there."""

    mesh: TetMesh
    tets: np.ndarray
    weights: np.ndarray

    @property
    def points(self):
        """(k, 3, 3)"""
        return np.einsum("kci,kix->kcx", self.weights, self.mesh.vertices[self.mesh.tets[self.tets]])

    def chosen(self, rows):
        return Surface(self.mesh, self.tets[rows], self.weights[rows])

    def with_others(self, *others):
        parts = (self, *others)
        tets, weights = (np.concatenate([getattr(part, name) for part in parts]) for name in ("tets", "weights"))
        return Surface(self.mesh, tets, weights)

    def clipped(self, function):
        """The part where a function, given by (n,) values at the solid's vertices, is not below zero."""
        values = np.einsum("kci,ki->kc", self.weights, function[self.mesh.tets[self.tets]])
        above = values >= 0
        count = above.sum(axis=1)
        parts = [self.chosen(count == 3)]
        for wanted, patterns in KEPT.items():
            rows = np.flatnonzero(count == wanted)
            # The corner that is alone comes first.
            first = np.argmax(above[rows] if wanted == 1 else ~above[rows], axis=1)
            order = (first[:, None] + np.arange(3)) % 3
            weights = np.take_along_axis(self.weights[rows], order[..., None], axis=1)
            heights = np.take_along_axis(values[rows], order, axis=1)
            for pattern in patterns:
                corners = [_between(weights, heights, i, j) for i, j in pattern]
                parts.append(Surface(self.mesh, self.tets[rows], np.stack(corners, axis=1)))
        return parts[0].with_others(*parts[1:])

    def finer(self):
        """Every triangle cut into four."""
        a, b, c = np.moveaxis(self.weights, 1, 0)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        parts = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
        return Surface(self.mesh, np.tile(self.tets, 4), np.concatenate([np.stack(p, axis=1) for p in parts]))

    def refined(self, phases):
        """With small triangles in punctured tetrahedra."""
        punctured = phases.punctured[self.tets]
        small = self.chosen(punctured)
        for _ in range(HALVINGS):
            small = small.finer()
        return self.chosen(~punctured).with_others(small)

    def values(self, phases):
        """(k, 3) phases at the corners, which go on over each triangle."""
        values = evaluate_in_tets(phases, np.repeat(self.tets, 3), self.weights.reshape(-1, 4)).reshape(-1, 3)
        punctured = phases.punctured[self.tets]
        turns = np.rint((values - values[:, :1]) / (2 * np.pi))
        return np.where(punctured[:, None], values - 2 * np.pi * turns, values)


def _between(weights, heights, i, j):
    """Corner i, or where the height is zero between two."""
    if i == j:
        return weights[:, i]
    share = (heights[:, i] / (heights[:, i] - heights[:, j]))[:, None]
    return (1 - share) * weights[:, i] + share * weights[:, j]


def boundary(mesh):
    """The boundary as a :class:`Surface`."""
    triangles = mesh.boundary_triangles
    tets = mesh.face_tets[mesh.boundary_faces, 0]
    return Surface(mesh, tets, (mesh.tets[tets][:, None] == triangles[:, :, None]).astype(float))


def section(mesh, function):
    """Where a function, given by (n,) values at the solid's vertices, is zero."""
    heights = function[mesh.tets]
    above = heights >= 0
    parts = []
    for code in range(1, 15):
        pattern = np.array([code >> k & 1 for k in range(4)], bool)
        rows = np.flatnonzero((above == pattern).all(axis=1))
        crossed = [(i, j) for i, j in TET_EDGES if pattern[i] != pattern[j]]
        if len(crossed) == 4:
            # Around the quad, neighbours share a corner.
            (a, b), (c, d) = np.flatnonzero(pattern), np.flatnonzero(~pattern)
            crossed = [(a, c), (b, c), (b, d), (a, d)]
        every = np.tile(np.eye(4), (len(rows), 1, 1))
        points = [_between(every, heights[rows], i, j) for i, j in crossed]
        for k in range(1, len(points) - 1):
            parts.append(Surface(mesh, rows, np.stack([points[0], points[k], points[k + 1]], axis=1)))
    return parts[0].with_others(*parts[1:])


def cut_away(mesh, cuts):
    """What is left of a solid without its part where normal . x > offset for both of two planes, the cuts."""
    one, other = (mesh.vertices @ np.array(normal, float) - offset for normal, offset in cuts)
    whole = boundary(mesh)
    return whole.clipped(-one).with_others(
        whole.clipped(one).clipped(-other), section(mesh, one).clipped(other), section(mesh, other).clipped(one)
    )


def lowest(mesh, heights, share):
    """What is left of a solid without its part above a share of the largest of (n,) heights."""
    below = share * heights.max() - heights
    return boundary(mesh).clipped(below).with_others(section(mesh, below))
