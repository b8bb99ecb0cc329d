# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Edges and diagonals of a quad mesh near feature lines, from which chains of edges are made.

Few vertices are near most lines, so that lists take less time than arrays. A vertex near a line stays in place until a
chain takes it.
"""

from dataclasses import dataclass, replace
from math import dist

import numpy as np
from scipy.spatial import cKDTree

from ....geometry import TriangleMesh
from ....graphs import pairs_within
from ..trace.quad_mesh import QuadMesh
from .feature_lines import FeatureLines


@dataclass(frozen=True)
class EdgeNet:
    """Edges and diagonals of a quad mesh near feature lines.

    Attributes
    ----------
    places : coordinates of the vertices
    near : for each line, the position along it of the vertices near it, and their distance from it
    passages : for each vertex, the other ends of edges of the boundary, of other edges, and of diagonals
    on_rim : (n,) bool, vertices on the boundary
    has_cuts : whether there are diagonals
    taken : vertices on lines and at corners
    """

    places: list[list[float]]
    near: list[dict[int, tuple[float, float]]]
    passages: tuple[dict[int, list[int]], ...]
    on_rim: np.ndarray
    has_cuts: bool
    taken: set[int]

    @classmethod
    def of(cls, quads: QuadMesh, features: FeatureLines, reach: float, taken: np.ndarray, has_cuts: bool) -> "EdgeNet":
        """The net of a quad mesh whose (n,) bool taken vertices are at corners; near a line are those within reach."""
        counts = np.array([len(line) for line in features.lines], int)
        of_points = np.repeat(np.arange(len(counts)), counts)
        points, reaches = np.concatenate(features.lines), reach + features.lengths / counts
        rows, found = pairs_within(cKDTree(quads.vertices), features.mesh.vertices[points], reaches[of_points])
        is_same = pieces_of(quads, features.mesh)[found] == features.mesh.pieces[points[rows]]
        usable = ~taken[found] & is_same
        keys = np.unique(of_points[rows[usable]] * len(taken) + found[usable])
        numbers, vertices = np.divmod(keys, len(taken))
        ways, apart = (values.tolist() for values in features.nearest(numbers, quads.vertices[vertices]))
        near: list[dict[int, tuple[float, float]]] = [{} for _ in features.lines]
        for number, vertex, way, away in zip(numbers.tolist(), vertices.tolist(), ways, apart, strict=True):
            near[number][vertex] = way, away
        at_corners = set(np.flatnonzero(taken).tolist())
        empty = cls(quads.vertices.tolist(), near, (), quads.on_rim, has_cuts, at_corners)
        return empty.of_faces(quads)

    def of_faces(self, quads: QuadMesh) -> "EdgeNet":
        """The net with other faces on the same vertices."""
        edges, counts = quads.edges
        inside, is_near = edges[counts != 1], np.zeros(len(self.places), bool)
        is_near[list(set(self.taken).union(*self.near))] = True
        parts = edges[counts == 1], inside, _diagonals(quads) if self.has_cuts else inside[:0]
        return replace(self, passages=tuple(_neighbours(part[is_near[part].all(axis=1)]) for part in parts))

    def take(self, vertices: np.ndarray) -> None:
        """Let vertices be on a line."""
        self.taken.update(vertices.tolist())

    def free_near(self, number: int) -> dict[int, tuple[float, float]]:
        """The positions along a line, and distances from it, of the vertices near it that are not taken."""
        return {vertex: position for vertex, position in self.near[number].items() if vertex not in self.taken}

    def step(self, vertex: int, other: int) -> float:
        """The distance between two vertices."""
        return dist(self.places[vertex], self.places[other])


def _neighbours(pairs: np.ndarray) -> dict[int, list[int]]:
    """The vertices that (k, 2) pairs join with each vertex."""
    found: dict[int, list[int]] = {}
    for i, j in pairs.tolist():
        found.setdefault(i, []).append(j)
        found.setdefault(j, []).append(i)
    return found


def pieces_of(quads: QuadMesh, mesh: TriangleMesh) -> np.ndarray:
    """(n,) component of the surface that each vertex of the quad mesh is on."""
    return mesh.pieces[mesh.triangles[quads.triangles, 0]]


def _diagonals(quads: QuadMesh) -> np.ndarray:
    """(d, 2) vertices between which a face can be cut in two: not joined by an edge, nor corners of another face."""
    across = [np.empty((0, 2), int)]
    for size in np.unique(quads.sizes):
        corners = quads.corner_vertices[quads.starts[quads.sizes == size, None] + np.arange(size)]
        across += [corners[:, [i, j]] for i in range(size) for j in range(i + 2, size - (i == 0))]
    pairs, faces = np.unique(np.sort(np.concatenate(across), axis=1), axis=0, return_counts=True)
    pairs = pairs[faces == 1]
    count = len(quads.vertices)
    return pairs[~np.isin(pairs @ [count, 1], quads.edges[0] @ [count, 1])]
