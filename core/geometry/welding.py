# SPDX-License-Identifier: GPL-3.0-or-later
"""Welding of boundary vertices at the same place where this closes edges."""

import numpy as np
from scipy.spatial import cKDTree

from ..graphs import components
from .triangle_mesh import TriangleMesh

# Vertices closer than this share of the surface's size are at the same place.
SAME_PLACE = 1e-6


def welded_vertices(places: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Find the (n,) vertex that represents each vertex at (n, 3) places: itself, or the first that it is joined with.

    Two boundary edges whose ends are at the same places become one. Closed bodies are not joined where they touch.
    """
    own = np.arange(len(places))
    mesh = TriangleMesh(places, triangles)
    ends = mesh.edges[mesh.boundary_edges]
    ends = ends[np.isfinite(places[ends]).all(axis=(1, 2))]
    rim = np.unique(ends)
    if len(rim) == 0:
        return own
    size = np.ptp(places[rim], axis=0).max()
    pairs = cKDTree(places[rim]).query_pairs(SAME_PLACE * size, output_type="ndarray")
    if len(pairs) == 0:
        return own
    spots = own.copy()
    spots[rim] = components(len(rim), pairs)
    met = spots[ends]
    ends, met = (values[met[:, 0] != met[:, 1]] for values in (ends, met))
    swapped = met[:, 0] > met[:, 1]
    ends[swapped], met[swapped] = ends[swapped][:, ::-1], met[swapped][:, ::-1]
    order = np.lexsort(met.T)
    ends, met = ends[order], met[order]
    same = np.flatnonzero((met[1:] == met[:-1]).all(axis=1))
    joined = np.concatenate([np.column_stack([ends[same, k], ends[same + 1, k]]) for k in (0, 1)])
    labels = components(len(places), joined)
    first = np.unique(labels, return_index=True)[1]
    return first[labels]
