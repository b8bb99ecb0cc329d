# SPDX-License-Identifier: GPL-3.0-or-later
"""Vectors over their lengths."""

import numpy as np


def unit_vectors(vectors: np.ndarray) -> np.ndarray:
    """(..., d) real or integer vectors over their lengths; zero stays zero."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, lengths, out=np.zeros(vectors.shape), where=lengths > 0)
