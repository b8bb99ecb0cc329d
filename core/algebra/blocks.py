# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers or blocks of numbers, one for each node or edge, and the sparse matrices that they make.

What acts on the rows of each node by itself is (N,) numbers, one a row, or (n, d, d) blocks, one a node.
"""

import numpy as np
from scipy.sparse import bsr_matrix, coo_matrix, diags_array


def on_rows(multipliers, block):
    """(n,) numbers of nodes as those of their rows; (n, d, d) blocks as they are."""
    return np.repeat(multipliers, block) if multipliers.ndim == 1 else multipliers


def traces(multipliers):
    """(n,) numbers as they are; of (n, d, d) blocks the sums of their diagonals."""
    return multipliers if multipliers.ndim == 1 else np.trace(multipliers, axis1=1, axis2=2)


def with_diagonal(blocks, numbers):
    """Numbers or blocks plus (N,) numbers on the diagonal."""
    if blocks.ndim == 1:
        return blocks + numbers
    return blocks + numbers.reshape(len(blocks), -1, 1) * np.eye(blocks.shape[1], dtype=blocks.dtype)


def times(blocks, vector):
    """Numbers or blocks times an (N,) vector."""
    if blocks.ndim == 1:
        return blocks * vector
    return (blocks @ vector.reshape(len(blocks), -1, 1)).ravel()


def clip_eigenvalues(blocks, largest):
    """The nearest numbers or symmetric blocks between 0 and (N,) numbers, of which the least of a block counts."""
    if blocks.ndim == 1:
        return blocks.clip(0, largest)
    values, vectors = np.linalg.eigh(blocks)
    values = values.clip(0, largest.reshape(len(blocks), -1).min(axis=1, keepdims=True))
    return (vectors * values[:, None, :]) @ vectors.swapaxes(1, 2)


def block_diagonal(blocks):
    """Numbers or blocks as a sparse matrix (N, N)."""
    if blocks.ndim == 1:
        return diags_array(blocks)
    count, block = blocks.shape[:2]
    return bsr_matrix((blocks, np.arange(count), np.arange(count + 1)), shape=(count * block, count * block)).tocsr()


def scale_blocks(blocks, scale):
    """(k,) numbers or (k, d, d) blocks times (k,) numbers."""
    return blocks * scale.reshape(-1, *[1] * (blocks.ndim - 1))


def block_matrix(rows, columns, values, shape):
    """CSR of (k,) numbers or (k, d, d) blocks at block positions."""
    if values.ndim == 1:
        return coo_matrix((values, (rows, columns)), shape=shape).tocsr()
    block = values.shape[1]
    inner = np.arange(block)
    rows = np.broadcast_to(rows[:, None, None] * block + inner[:, None], values.shape).ravel()
    columns = np.broadcast_to(columns[:, None, None] * block + inner, values.shape).ravel()
    return coo_matrix((values.ravel(), (rows, columns)), shape=(shape[0] * block, shape[1] * block)).tocsr()
