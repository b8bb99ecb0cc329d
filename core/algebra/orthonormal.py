# SPDX-License-Identifier: GPL-3.0-or-later
"""Orthonormal vectors at nodes (the Stiefel manifold): (n, k, m) real arrays, or (n, k, m, c) with c columns each.

Unit vectors are the case k = 1.
"""

import numpy as np


def _dots(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Compute (n,) or (n, c) inner products of vectors (n, m) or (n, m, c)."""
    return np.einsum("ij,ij->i", first, second) if first.ndim == 2 else (first * second).sum(axis=1)


def gram(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Compute (n, k, k) or (n, k, k, c) symmetric parts of the inner products of the vectors of each node."""
    count = first.shape[1]
    products = np.empty((len(first), count, count, *first.shape[3:]), first.dtype)
    for row in range(count):
        products[:, row, row] = _dots(first[:, row], second[:, row])
        for other in range(row):
            mixed = _dots(first[:, row], second[:, other]) + _dots(first[:, other], second[:, row])
            products[:, row, other] = products[:, other, row] = 0.5 * mixed
    return products


def tangent_part(point: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Project vectors to the tangent space at orthonormal ones, subtracting their symmetric products with these."""
    products = gram(point, vectors)[:, :, :, None]
    across = np.empty_like(vectors)
    for row in range(point.shape[1]):
        np.multiply(point[:, 0], products[:, row, 0], out=across[:, row])
        for other in range(1, point.shape[1]):
            across[:, row] += point[:, other] * products[:, row, other]
    return np.subtract(vectors, across, out=across)


def orthonormalize(vectors: np.ndarray) -> np.ndarray:
    """Make the vectors of each node orthonormal in place, by Gram-Schmidt; zero vectors stay. Returns them."""
    tiny = np.finfo(vectors.dtype).tiny
    for row in range(vectors.shape[1]):
        vector = vectors[:, row]
        for other in 2 * [*range(row)]:  # twice, against rounding errors
            vector -= vectors[:, other] * _dots(vector, vectors[:, other])[:, None]
        vector *= (1 / np.maximum(np.sqrt(_dots(vector, vector)), tiny))[:, None]
    return vectors


def nearest(matrices: np.ndarray, is_special: bool, among: int | None = None) -> np.ndarray:
    """Find the orthogonal matrices nearest to (..., d, d) ones; the identity for zero.

    Parameters
    ----------
    matrices : (..., d, d)
    is_special : whether to find rotations
    among : axis of fields; a field most of whose matrices reflect is reflected first
    """
    left, _, right = np.linalg.svd(matrices)
    if is_special:
        signs = np.linalg.det(left @ right)
        if among is not None:
            whole = np.where(signs.sum(axis=among, keepdims=True) < 0, -1, 1).astype(signs.dtype)
            right[..., -1] *= whole[..., None]
            signs = signs * whole
        left[..., -1] *= np.sign(signs)[..., None]
    return left @ right
