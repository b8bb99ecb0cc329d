# SPDX-License-Identifier: GPL-3.0-or-later
"""Vectors over their lengths, and vector products."""

import numpy as np


def unit_vectors(vectors: np.ndarray) -> np.ndarray:
    """(..., d) real or integer vectors over their lengths; zero stays zero."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, lengths, out=np.zeros(vectors.shape), where=lengths > 0)


def cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Vector products of (..., 3) vectors: as :func:`numpy.cross`, without its checks, which take longer than few
    products."""
    a, b, c = u[..., 0], u[..., 1], u[..., 2]
    d, e, f = v[..., 0], v[..., 1], v[..., 2]
    return np.stack([b * f - c * e, c * d - a * f, a * e - b * d], axis=-1)
