# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions in a solid from data on its surface, as functions of a :class:`..filled_surface.FilledSurface`.

Each returns (n, 3) vectors of any length at the solid's vertices, zero where :func:`.solids.extend_directions` has to
extend them. The surface is the last argument: the others are bound by ``functools.partial``, which can be pickled.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from ...geometry.filling.closed_surface import Area
from ...geometry.filling.surface_distance import normals_at
from ...geometry.nearest import NearestTriangles, nearest_in_triangles
from ...geometry.tet_mesh import TetMesh
from ...geometry.triangle_mesh import TriangleMesh
from ...graphs import components
from ...trees import along_trees
from ...unit_vectors import unit_vectors
from .potentials import harmonic_function
from .solid_distance import solid_distance
from .solids import axis_directions, check_vectors, curve_vectors, gradient_vectors, vector_directions

if TYPE_CHECKING:
    from ...files.solid_vectors import SolidVectors
    from ..filled_surface import FilledSurface

# Points this near to a surface, as a share of their extent, lie on it.
ON_SURFACE = 1e-6
# Tetrahedra around a point, by their centres, among which the one that contains it best is chosen; points at once.
_NEAR, _BATCH = 24, 20_000


def along_axis(axis: ArrayLike, filled: "FilledSurface") -> np.ndarray:
    """A constant direction, (3,)."""
    return axis_directions(filled.solid, axis)


def between_areas(low: Area, high: Area, filled: "FilledSurface") -> np.ndarray:
    """From one area of the surface to another, along a harmonic function."""
    function = harmonic_function(filled.solid, filled.vertices_on(low), filled.vertices_on(high))
    return gradient_vectors(filled.solid, function)


def away_from_area(area: Area, filled: "FilledSurface") -> np.ndarray:
    """Away from an area of the surface, on the shortest way inside the solid."""
    return gradient_vectors(filled.solid, solid_distance(filled.solid, filled.vertices_on(area)))


def away_from_surface(base: TriangleMesh, filled: "FilledSurface") -> np.ndarray:
    """Away from another surface, on a straight way."""
    return check_vectors(filled.solid, away_from(base, filled.solid.vertices))


def along_curves(curves: Sequence[ArrayLike], filled: "FilledSurface") -> np.ndarray:
    """Along curves, (k, 3) polylines, so that layers cross them."""
    return curve_vectors(filled.solid, curves)


def around_curves(curves: Sequence[ArrayLike], filled: "FilledSurface") -> np.ndarray:
    """Away from curves, (k, 3) polylines, so that layers lie around them like skins."""
    return curve_vectors(filled.solid, curves, across=True)


def of_vectors(vectors: np.ndarray, filled: "FilledSurface") -> np.ndarray:
    """(k, 3) vectors at the surface's vertices, extended into the solid."""
    return vector_directions(filled.solid, filled.on_boundary(vectors))


def of_given_vectors(given: "SolidVectors", stretch: np.ndarray, filled: "FilledSurface") -> np.ndarray:
    """Vectors of a file, mapped to the solid's space by a (3, 3) matrix."""
    mesh = TetMesh(given.mesh.vertices @ stretch.T, given.mesh.tets)
    values = given.values if given.at_vertices else given.mesh.at_vertices(given.values)
    return check_vectors(filled.solid, vectors_at(mesh, values @ stretch.T, filled.solid.vertices))


def of_given_lines(given: "SolidVectors", stretch: np.ndarray, filled: "FilledSurface") -> np.ndarray:
    """Vectors of a file that have no sign, such as principal stresses, mapped by a (3, 3) matrix and oriented alike."""
    mesh = TetMesh(given.mesh.vertices @ stretch.T, given.mesh.tets)
    values = line_matrices(given.values @ stretch.T)
    values = values if given.at_vertices else mesh.at_vertices(values)
    found = principal_vectors(vectors_at(mesh, values, filled.solid.vertices))
    return check_vectors(filled.solid, orient_vectors(filled.solid, found))


def away_from(base: TriangleMesh, points: np.ndarray) -> np.ndarray:
    """(k, 3) unit directions at points in which the signed distance from a surface grows, negative behind its faces."""
    _, found = NearestTriangles(base.vertices, base.triangles).nearest(points)
    corners = base.vertices[base.triangles[found]]
    shares = nearest_in_triangles(points, np.moveaxis(corners, 1, 0))
    offsets = points - np.einsum("pc,pcx->px", shares, corners)
    normals = unit_vectors(normals_at(base, found, shares))
    lengths = np.linalg.norm(offsets, axis=1, keepdims=True)
    is_behind = np.einsum("px,px->p", offsets, normals) < 0
    is_on = lengths < ON_SURFACE * np.ptp(points, axis=0).max()
    signed = np.where(is_behind[:, None], -offsets, offsets)
    return np.where(is_on, normals, signed / np.where(is_on, 1, lengths))


def vectors_at(mesh: TetMesh, values: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(k, ...) values at points from (n, ...) values at vertices, linear in each tetrahedron; outside of the solid,
    those at its nearest side."""
    tree = cKDTree(mesh.vertices[mesh.tets].mean(axis=1))
    near = min(_NEAR, mesh.tet_count)
    found = np.empty((len(points), *values.shape[1:]))
    for part in np.array_split(np.arange(len(points)), len(points) // _BATCH + 1):
        tets = tree.query(points[part], near)[1].reshape(len(part), near)
        offsets = points[part][:, None] - mesh.vertices[mesh.tets[tets, 0]]
        others = np.einsum("knix,knx->kni", mesh.hat_gradients[tets, 1:], offsets)
        weights = np.concatenate([1 - others.sum(axis=2, keepdims=True), others], axis=2)
        best = weights.min(axis=2).argmax(axis=1)
        rows = np.arange(len(part))
        inside = np.maximum(weights[rows, best], 0)
        inside /= inside.sum(axis=1, keepdims=True)
        found[part] = np.einsum("ki,ki...->k...", inside, values[mesh.tets[tets[rows, best]]])
    return found


def line_matrices(vectors: np.ndarray) -> np.ndarray:
    """(k, 3, 3) matrices v v^T / |v| of vectors, whose means are those of lines."""
    return vectors[:, :, None] * unit_vectors(vectors)[:, None]


def principal_vectors(matrices: np.ndarray) -> np.ndarray:
    """(k, 3) eigenvectors of the largest eigenvalues of symmetric matrices, as long as these; of either sign."""
    values, vectors = np.linalg.eigh(matrices)
    return vectors[:, :, 2] * values[:, 2:]


def orient_vectors(mesh: TetMesh, lines: np.ndarray) -> np.ndarray:
    """(n, 3) vectors of either sign, oriented along shortest paths from one vertex in each piece; zero where neighbours
    still disagree, around lines that come back to themselves reversed."""
    i, j = mesh.edges.T
    agree = np.where(np.einsum("ex,ex->e", lines[i], lines[j]) < 0, -1.0, 1.0)
    roots = np.unique(components(mesh.vertex_count, mesh.edges), return_index=True)[1]
    signs = along_trees(mesh.vertex_count, i, j, agree.astype(complex), roots).real
    turned = np.where(signs < 0, -1.0, 1.0)[:, None] * lines
    odd = np.einsum("ex,ex->e", turned[i], turned[j]) < 0
    turned[mesh.edges[odd]] = 0
    return turned
