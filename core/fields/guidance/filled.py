# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions in a solid from what its surface has: functions of a :class:`..filled_surface.FilledSurface`.

Each gives (n, 3) vectors at the solid's vertices, whose lengths do not count; zero where it has no direction, which
:func:`.solids.extend_directions` extends there. What it needs besides comes first, to be bound by
``functools.partial``, which can be pickled.
"""

from dataclasses import replace

import numpy as np

from ...geometry.filling.surface_distance import normals_at
from ...geometry.nearest import NearestTriangles, nearest_in_triangles
from ...geometry.tet_mesh import TetMesh
from .given import at_vertices, orient_vectors, principal, vectors_at, without_sign
from .potentials import harmonic_function
from .solid_distance import solid_distance
from .solids import axis_directions, check_vectors, curve_vectors, gradient_vectors, vector_directions

# Points this near to a surface, as a share of what they span, lie on it.
ON_SURFACE = 1e-6


def along_axis(axis, filled):
    """The same direction everywhere, (3,)."""
    return axis_directions(filled.solid, axis)


def between_areas(low, high, filled):
    """From one :class:`Area` of the surface to another, along a harmonic function."""
    function = harmonic_function(filled.solid, filled.vertices_on(low), filled.vertices_on(high))
    return gradient_vectors(filled.solid, function)


def away_from_area(area, filled):
    """Away from an :class:`Area` of the surface, on the shortest way inside the solid."""
    return gradient_vectors(filled.solid, solid_distance(filled.solid, filled.vertices_on(area)))


def away_from_surface(base, filled):
    """Away from another surface, a TriangleMesh, on a straight way."""
    return check_vectors(filled.solid, away_from(base, filled.solid.vertices))


def along_curves(curves, filled):
    """Along curves, (k, 3) polylines: layers cross them."""
    return curve_vectors(filled.solid, curves)


def around_curves(curves, filled):
    """Away from curves, (k, 3) polylines: layers lie around them like skins."""
    return curve_vectors(filled.solid, curves, across=True)


def of_vectors(vectors, filled):
    """Vectors at the surface's vertices, (k, 3), extended into the solid, where they are nowhere their own."""
    return vector_directions(filled.solid, filled.on_boundary(vectors))


def of_given_vectors(given, stretch, filled):
    """:class:`core.files.solid_vectors.SolidVectors`, whose space a matrix (3, 3) leads to the solid's from."""
    mesh = TetMesh(given.mesh.vertices @ stretch.T, given.mesh.tets)
    return check_vectors(filled.solid, vectors_at(mesh, at_vertices(given) @ stretch.T, filled.solid.vertices))


def of_given_lines(given, stretch, filled):
    """The same for vectors without a sign, such as principal stresses."""
    mesh = TetMesh(given.mesh.vertices @ stretch.T, given.mesh.tets)
    lines = replace(given, mesh=mesh, values=without_sign(given.values @ stretch.T))
    found = principal(vectors_at(mesh, at_vertices(lines), filled.solid.vertices))
    return check_vectors(filled.solid, orient_vectors(filled.solid, found))


def away_from(base, points):
    """(k, 3) unit directions in which the distance from a surface grows, counted negative behind its faces.

    Parameters
    ----------
    base : TriangleMesh, open or closed
    points : (k, 3)
    """
    _, found = NearestTriangles(base.vertices, base.triangles).nearest(points)
    corners = base.vertices[base.triangles[found]]
    shares = nearest_in_triangles(points, np.moveaxis(corners, 1, 0))
    offsets = points - np.einsum("pc,pcx->px", shares, corners)
    normals = normals_at(base, found, shares)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    lengths = np.linalg.norm(offsets, axis=1, keepdims=True)
    is_behind = np.einsum("px,px->p", offsets, normals) < 0
    is_on = lengths < ON_SURFACE * np.ptp(points, axis=0).max()
    signed = np.where(is_behind[:, None], -offsets, offsets)
    return np.where(is_on, normals, signed / np.where(is_on, 1, lengths))
