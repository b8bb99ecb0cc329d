# SPDX-License-Identifier: GPL-3.0-or-later
"""Vectors over their lengths, and cross products."""

import numpy as np


def unit_vectors(vectors: np.ndarray) -> np.ndarray:
    """(..., d) real or integer vectors over their lengths; zero stays zero."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, lengths, out=np.zeros(vectors.shape), where=lengths > 0)


def cross_products(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """(..., 3) cross products as of ``np.cross``, which takes three times as long on a few vectors."""
    result = np.empty_like(first)
    for k in range(3):
        ahead, behind = (k + 1) % 3, (k + 2) % 3
        result[..., k] = first[..., ahead] * second[..., behind] - first[..., behind] * second[..., ahead]
    return result
