# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions in a solid from what its surface has: functions of a :class:`..filled_surface.FilledSurface`.

Each gives (n, 3) unit vectors at the solid's vertices. What it needs besides comes first, to be bound by
``functools.partial``, which can be pickled.
"""

import numpy as np

from ...geometry.filling.surface_distance import normals_at
from ...geometry.nearest import NearestTriangles, nearest_in_triangles
from .solids import axis_directions, curve_directions, distance_directions, harmonic_directions, vector_directions

# Points this near to a surface, as a share of what they span, lie on it.
ON_SURFACE = 1e-6


def along_axis(axis, filled):
    """The same direction everywhere, (3,)."""
    return axis_directions(filled.solid, axis)


def between_areas(low, high, filled):
    """From one :class:`Area` of the surface to another, along a harmonic function."""
    return harmonic_directions(filled.solid, filled.vertices_on(low), filled.vertices_on(high))


def away_from_area(area, filled):
    """Away from an :class:`Area` of the surface, on the shortest way inside the solid."""
    return distance_directions(filled.solid, filled.vertices_on(area))


def away_from_surface(base, filled):
    """Away from another surface, a TriangleMesh, on a straight way."""
    return vector_directions(filled.solid, away_from(base, filled.solid.vertices))


def along_curves(curves, filled):
    """Along curves, (k, 3) polylines: layers cross them."""
    return curve_directions(filled.solid, curves)


def around_curves(curves, filled):
    """Away from curves, (k, 3) polylines: layers lie around them like skins."""
    return curve_directions(filled.solid, curves, across=True)


def of_vectors(vectors, filled):
    """Vectors at the surface's vertices, (k, 3), extended into the solid."""
    return vector_directions(filled.solid, filled.on_boundary(vectors))


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
