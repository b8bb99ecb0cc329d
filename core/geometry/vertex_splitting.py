# SPDX-License-Identifier: GPL-3.0-or-later
"""Splitting of vertices in which a solid or its surface touches itself."""

import numpy as np

from ..graphs import components


def split_pinched_vertices(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Split the vertices of (b, 3) triangles of a closed surface so that the triangles around each form one fan.

    Triangles of one fan share edges. Where more than two meet in an edge, all of them stay together. Returns (v,) the
    given vertex of each vertex, ascending, and (b, 3) triangles of these.
    """
    tails, heads = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    keys = np.minimum(tails, heads) * (triangles.max(initial=0) + 1) + np.maximum(tails, heads)
    order = np.argsort(keys, kind="stable")
    meet = keys[order[1:]] == keys[order[:-1]]
    return merge_corners(triangles, corner_links(triangles, order[:-1][meet], order[1:][meet]))


def corner_links(triangles: np.ndarray, halves: np.ndarray, others: np.ndarray) -> np.ndarray:
    """List (2 k, 2) corners that become one vertex when (k,) pairs of half-edges, of either direction, are joined.

    Corner c = 3 t + k is the tail of half-edge c.
    """
    opposite = triangles.ravel()[halves] != triangles.ravel()[others]
    tails = np.where(opposite, next_half_edges(others), others)
    heads = np.where(opposite, others, next_half_edges(others))
    return np.concatenate([np.column_stack([halves, tails]), np.column_stack([next_half_edges(halves), heads])])


def next_half_edges(halves: np.ndarray) -> np.ndarray:
    """Find the next half-edge in the same triangle."""
    return halves - halves % 3 + (halves + 1) % 3


def previous_half_edges(halves: np.ndarray) -> np.ndarray:
    """Find the previous half-edge in the same triangle."""
    return halves - halves % 3 + (halves + 2) % 3


def merge_corners(cells: np.ndarray, links: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Merge corners of cells that (l, 2) links join into vertices: the given vertex of each, and the cells in these."""
    labels = components(cells.size, links)
    count = labels.max(initial=-1) + 1
    source, numbers = np.unique(cells.ravel() * count + labels, return_inverse=True)
    return source // max(count, 1), numbers.reshape(cells.shape)
