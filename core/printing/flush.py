# SPDX-License-Identifier: GPL-3.0-or-later
"""How flush layers are with parts of the surface that they were asked to lie on, by samples on these."""

import numpy as np

from ..extract.layers.surfaces import LayerSurfaces
from ..geometry import TriangleMesh
from ..geometry.nearest import NearestTriangles
from .coverage import MIDDLES
from .subdivision import subdivide

# Farther than this from the next layer, in spacings, a place of the surface is not on it.
FAR = 0.05
# Longest edge of the triangles that are sampled, in spacings, and how many there may be.
_SIZE, _MOST = 0.5, 200_000


def far_share(mesh: TriangleMesh, triangles: np.ndarray, surfaces: LayerSurfaces, spacing: float) -> float:
    """Share of the area of (k,) triangles of a mesh that is farther than :data:`FAR` spacings from all layers."""
    used, corners = np.unique(mesh.triangles[triangles], return_inverse=True)
    part, _ = subdivide(TriangleMesh(mesh.vertices[used], corners.reshape(-1, 3)), _SIZE * spacing, _MOST)
    layers = NearestTriangles(surfaces.vertices, surfaces.triangles)
    far = np.zeros(part.triangle_count)
    for weights in MIDDLES:
        points = np.einsum("k,tkx->tx", weights, part.vertices[part.triangles])
        places, _ = layers.nearest(points)
        far += (np.linalg.norm(places - points, axis=1) > FAR * spacing) / len(MIDDLES)
    return float(far @ part.areas / part.areas.sum())
