# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers or blocks for each node or edge, and the sparse matrices that they form.

Operators that act within the rows of each node are (N,) numbers, one per row, or (n, d, d) blocks, one per node.
"""

import numpy as np
from scipy.sparse import bsr_matrix, coo_matrix, csr_matrix, diags_array


def on_rows(multipliers: np.ndarray, block: int) -> np.ndarray:
    """Repeat (n,) numbers of nodes for their rows; (n, d, d) blocks stay."""
    return np.repeat(multipliers, block) if multipliers.ndim == 1 else multipliers


def rows_of(nodes: np.ndarray, block: int) -> np.ndarray:
    """Find the rows of (k,) nodes that have ``block`` rows each."""
    return (block * nodes[:, None] + np.arange(block)).ravel()


def traces(multipliers: np.ndarray) -> np.ndarray:
    """Compute the traces of (n, d, d) blocks; (n,) numbers stay."""
    return multipliers if multipliers.ndim == 1 else np.trace(multipliers, axis1=1, axis2=2)


def with_diagonal(blocks: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """Add (N,) numbers to the diagonal of numbers or blocks."""
    if blocks.ndim == 1:
        return blocks + numbers
    return blocks + numbers.reshape(len(blocks), -1, 1) * np.eye(blocks.shape[1], dtype=blocks.dtype)


def times(blocks: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Multiply numbers or blocks by an (N,) vector."""
    if blocks.ndim == 1:
        return blocks * vector
    return (blocks @ vector.reshape(len(blocks), -1, 1)).ravel()


def clip_eigenvalues(blocks: np.ndarray, largest: np.ndarray) -> np.ndarray:
    """Project numbers or symmetric blocks to eigenvalues between 0 and the least of a block's (N,) numbers."""
    if blocks.ndim == 1:
        return blocks.clip(0, largest)
    values, vectors = np.linalg.eigh(blocks)
    values = values.clip(0, largest.reshape(len(blocks), -1).min(axis=1, keepdims=True))
    return (vectors * values[:, None, :]) @ vectors.swapaxes(1, 2)


def block_diagonal(blocks: np.ndarray) -> csr_matrix:
    """Build the sparse (N, N) matrix with numbers or blocks on its diagonal."""
    if blocks.ndim == 1:
        return diags_array(blocks)
    count, block = blocks.shape[:2]
    return bsr_matrix((blocks, np.arange(count), np.arange(count + 1)), shape=(count * block, count * block)).tocsr()


def scale_blocks(blocks: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Multiply (k,) numbers or (k, d, d) blocks by (k,) numbers."""
    return blocks * scale.reshape(-1, *[1] * (blocks.ndim - 1))


def block_matrix(rows: np.ndarray, columns: np.ndarray, values: np.ndarray, shape: tuple[int, int]) -> csr_matrix:
    """Build the CSR matrix with (k,) numbers or (k, d, d) blocks at block positions, summed where repeated."""
    if values.ndim == 1:
        return coo_matrix((values, (rows, columns)), shape=shape).tocsr()
    block = values.shape[1]
    inner = np.arange(block)
    rows = np.broadcast_to(rows[:, None, None] * block + inner[:, None], values.shape).ravel()
    columns = np.broadcast_to(columns[:, None, None] * block + inner, values.shape).ravel()
    return coo_matrix((values.ravel(), (rows, columns)), shape=(shape[0] * block, shape[1] * block)).tocsr()
