# SPDX-License-Identifier: GPL-3.0-or-later
"""The points of a regular grid that lie in a solid, and where in its tetrahedra."""

import numpy as np

# Points that are tried at once, a few hundred bytes each.
BATCH = 500_000
# A point that is outside by less than this, as a barycentric weight, counts as inside.
SLACK = 1e-9


def points_inside(mesh, origin, step, counts):
    """Points origin + step * (i, j, k) inside the solid, each once.

    Parameters
    ----------
    mesh : TetMesh
    origin : (3,) place of the first point
    step : distance between two
    counts : (3,) points along each axis

    Returns
    -------
    places : (k, 3) integers i, j, k
    tets : (k,) tetrahedron that each lies in
    weights : (k, 4) barycentric weights there
    """
    corners = (mesh.vertices - origin)[mesh.tets] / step
    low = np.clip(np.ceil(corners.min(axis=1) - SLACK).astype(int), 0, None)
    high = np.minimum(np.floor(corners.max(axis=1) + SLACK).astype(int), np.array(counts) - 1)
    sizes = np.clip(high - low + 1, 0, None)
    totals = sizes.prod(axis=1)
    ends = np.cumsum(totals)
    cuts = np.searchsorted(ends, np.arange(BATCH, ends[-1], BATCH))
    parts = []
    for rows in np.split(np.arange(mesh.tet_count), cuts):
        places, tets = _in_boxes(low, sizes, rows)
        weights = _weights(mesh, tets, origin + step * places)
        inside = (weights >= -SLACK).all(axis=1)
        parts.append((places[inside], tets[inside], weights[inside]))
    places, tets, weights = (np.concatenate(column) for column in zip(*parts, strict=True))
    _, first = np.unique(np.ravel_multi_index(places.T, counts), return_index=True)
    return places[first], tets[first], weights[first]


def _in_boxes(low, sizes, rows):
    """All places in boxes, and which box each is in."""
    totals = sizes[rows].prod(axis=1)
    boxes = np.repeat(rows, totals)
    number = np.arange(len(boxes)) - np.repeat(np.cumsum(totals) - totals, totals)
    number, k = np.divmod(number, sizes[boxes, 2])
    i, j = np.divmod(number, sizes[boxes, 1])
    return low[boxes] + np.column_stack([i, j, k]), boxes


def _weights(mesh, tets, points):
    """(k, 4) barycentric weights of points in tetrahedra."""
    offsets = points - mesh.vertices[mesh.tets[tets, 0]]
    others = np.einsum("kix,kx->ki", mesh.hat_gradients[tets, 1:], offsets)
    return np.column_stack([1 - others.sum(axis=1), others])
