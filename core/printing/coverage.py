# SPDX-License-Identifier: GPL-3.0-or-later
"""How much of layers beads cover, by samples on them."""

import numpy as np
from scipy.spatial import cKDTree

from ..graphs import ragged_arange

# Places of a bead that distances are taken to are a step over this apart: a distance of half a step is 1 % too long.
_PARTS = 8
# Farther than this from the next bead, in steps, a place is not covered by it.
REACH = 0.75
# Barycentric coordinates of the middles of a triangle's quarters.
MIDDLES = np.array([[4, 1, 1], [1, 4, 1], [1, 1, 4], [2, 2, 2]]) / 6


class BeadDistances:
    """Distances to the nearest bead of the same layer.

    Parameters
    ----------
    begins, ends : (k, 3) of straight pieces of beads
    layers : (k,) of these
    step : between beads
    """

    def __init__(self, begins, ends, layers, step):
        counts = np.maximum(np.ceil(np.linalg.norm(ends - begins, axis=1) * _PARTS / step).astype(int), 1)
        piece, place = ragged_arange(counts)
        points = begins[piece] + (place / counts[piece])[:, None] * (ends - begins)[piece]
        points, layers = np.concatenate([points, ends]), np.concatenate([layers[piece], layers])
        # Layers are far apart along a fourth axis.
        self._apart = 1e3 * (1 + np.abs(points).max(initial=0))
        self._tree = cKDTree(np.column_stack([points, self._apart * layers])) if len(points) else None

    def __call__(self, points, layers):
        """(n,) from (n, 3) points on (n,) layers; infinite on layers without a bead."""
        if self._tree is None or len(points) == 0:
            return np.full(len(points), np.inf)
        found = self._tree.query(np.column_stack([points, self._apart * layers]))[0]
        return np.where(found < self._apart / 2, found, np.inf)


def covered_share(mesh, layers, away, step):
    """Share of the area of layers that is within :data:`REACH` steps of a bead.

    Parameters
    ----------
    mesh : TriangleMesh, with triangles that are small beside a step
    layers : (t,) of its triangles
    away : BeadDistances
    step : between beads

    Returns
    -------
    (c,) of each layer, and of all together
    """
    inside = np.zeros(mesh.triangle_count)
    corners = mesh.vertices[mesh.triangles]
    for weights in MIDDLES:
        inside += (away(np.einsum("k,tkx->tx", weights, corners), layers) <= REACH * step) / len(MIDDLES)
    covered = np.bincount(layers, inside * mesh.areas)
    areas = np.bincount(layers, mesh.areas)
    return covered / np.maximum(areas, np.finfo(float).tiny), float(covered.sum() / areas.sum())
