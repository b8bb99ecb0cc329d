# SPDX-License-Identifier: GPL-3.0-or-later
"""The points of a regular grid in a solid, and their places in its tetrahedra."""

from collections.abc import Iterator

import numpy as np

from ...geometry.tet_mesh import TetMesh

# Points that are tested at once, a few hundred bytes each.
BATCH = 500_000
# A point that is outside by less than this, as a barycentric weight, counts as inside.
SLACK = 1e-9


def points_inside(
    mesh: TetMesh, origin: np.ndarray, step: float, counts: np.ndarray
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Points origin + step * (i, j, k) inside the solid, with (3,) counts along the axes.

    Yields (k, 3) places i, j, k, the (k,) tetrahedra that they lie in, and (k, 4) barycentric weights there, some at a
    time; a point on a wall between tetrahedra comes once for each of them.
    """
    corners = (mesh.vertices - origin)[mesh.tets] / step
    low = np.clip(np.ceil(corners.min(axis=1) - SLACK).astype(int), 0, None)
    high = np.minimum(np.floor(corners.max(axis=1) + SLACK).astype(int), np.array(counts) - 1)
    sizes = np.clip(high - low + 1, 0, None)
    ends = np.cumsum(sizes.prod(axis=1))
    for first in range(0, ends[-1], BATCH):
        numbers = np.arange(first, min(first + BATCH, ends[-1]))
        tets = np.searchsorted(ends, numbers, side="right")
        places = low[tets] + _in_box(numbers - ends[tets], sizes[tets])
        weights = _weights(mesh, tets, origin + step * places)
        inside = (weights >= -SLACK).all(axis=1)
        yield places[inside], tets[inside], weights[inside]


def _in_box(numbers: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """(k, 3) places of numbered points in boxes of (k, 3) sizes; negative numbers count from the end."""
    numbers, k = np.divmod(numbers, sizes[:, 2])
    numbers, j = np.divmod(numbers, sizes[:, 1])
    return np.column_stack([numbers % sizes[:, 0], j, k])


def _weights(mesh: TetMesh, tets: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(k, 4) barycentric weights of points in tetrahedra."""
    offsets = points - mesh.vertices[mesh.tets[tets, 0]]
    others = np.einsum("kix,kx->ki", mesh.hat_gradients[tets, 1:], offsets)
    return np.column_stack([1 - others.sum(axis=1), others])
