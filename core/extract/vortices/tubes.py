# SPDX-License-Identifier: GPL-3.0-or-later
"""Tubes around vortices: where a map to the sphere is so far from a point (paper, Section 3.6)."""

import math
from dataclasses import dataclass

import numpy as np

from ...fields.clebsch import SphericalMap
from .isosurface import isosurface, smooth_surface

# How far vertices are moved from the nodes of the grid before they are evened, as a share of its edges.
_MARGIN = 0.25
NORTH = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Tubes:
    """A surface around vortices.

    Attributes
    ----------
    vertices, triangles : (n, 3) and (m, 3)
    sphere : (n, 3) point of the sphere at each vertex
    strength : circulation around one that the map covers once
    pieces : connected parts
    blobs : pieces without a hole, which are around no filament: their Euler characteristic is positive
    """

    vertices: np.ndarray
    triangles: np.ndarray
    sphere: np.ndarray
    strength: float
    pieces: int
    blobs: int = 0


def vortex_tubes(
    sphere: SphericalMap, point: tuple[float, float, float] | None, opening: float, smoothing: int
) -> Tubes:
    """The :class:`Tubes` of a :class:`SphericalMap`.

    Parameters
    ----------
    sphere : SphericalMap on a Grid of three dimensions
    point : of the sphere, not of unit length; tubes are around its antipode. None for the north
    opening : degrees around the antipode that are inside
    smoothing : how often vertices move to the middle of their neighbours
    """
    axis = -np.array(point or NORTH, float)
    axis /= np.linalg.norm(axis)
    angle = math.radians(opening)
    margin = _MARGIN if smoothing else 0
    surface = isosurface(sphere.found.regular_grid, sphere.sphere @ axis, math.cos(angle), margin)
    between = smooth_surface(surface.mesh, surface.interpolated(sphere.sphere), smoothing)
    # The map is on the circle there: only how far around it is taken from between the nodes.
    around = between - (between @ axis)[:, None] * axis
    around /= np.maximum(np.linalg.norm(around, axis=1, keepdims=True), 1e-12)
    shown = math.cos(angle) * axis + math.sin(angle) * around
    places = smooth_surface(surface.mesh, surface.mesh.vertices, smoothing)
    strength = sphere.found.quantum * 0.5 * (1 - math.cos(angle))
    mesh = surface.mesh
    pieces = int(mesh.pieces.max(initial=-1)) + 1
    parts = (mesh.pieces, mesh.pieces[mesh.edges[:, 0]], mesh.pieces[mesh.triangles[:, 0]])
    vertices, edges, faces = (np.bincount(part, minlength=pieces) for part in parts)
    blobs = int((vertices - edges + faces > 0).sum())
    return Tubes(places, mesh.triangles, shown, strength, pieces, blobs)
