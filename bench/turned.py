# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces of revolution in even triangles: rings with as many vertices as they are long."""

import numpy as np

from synch_fields.core.geometry import TriangleMesh

# Rings of a smaller radius, in sides of triangles, are a single vertex.
POLE = 1e-6


def turned(profile, size, closed=False):
    """The :class:`TriangleMesh`, with triangles of a size, of a profile that is turned about the z axis.

    The profile, (k, 2) radius and height along a fine line, has the outside to the right of its way; where it is
    closed, its end leads back to its beginning.
    """
    radii, heights = _even(np.vstack([profile, profile[:1]]) if closed else np.asarray(profile), size * np.sqrt(0.75)).T
    if closed:
        radii, heights = radii[:-1], heights[:-1]
    counts = np.where(radii < POLE * size, 1, np.maximum(np.round(2 * np.pi * radii / size), 3)).astype(int)
    first = np.cumsum(counts) - counts
    ring = np.repeat(np.arange(len(counts)), counts)
    # Every other ring stands half a step further, so that rings of equally many vertices make equal triangles.
    shares = (np.arange(len(ring)) - first[ring] + 0.5 * (ring % 2)) / counts[ring]
    turns = 2 * np.pi * shares
    points = np.column_stack([radii[ring] * np.cos(turns), radii[ring] * np.sin(turns), heights[ring]])
    above = np.arange(1, len(counts) + (1 if closed else 0)) % len(counts)
    below = np.arange(len(above))
    parts = [
        _between(first[b], counts[b], b % 2, first[a], counts[a], a % 2) for b, a in zip(below, above, strict=True)
    ]
    return TriangleMesh(points, np.concatenate(parts))


def _even(profile, step):
    """The line at even distances of about a step, its ends included."""
    lengths = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(profile, axis=0), axis=1))])
    places = np.linspace(0, lengths[-1], max(int(np.round(lengths[-1] / step)), 2) + 1)
    return np.column_stack([np.interp(places, lengths, values) for values in profile.T])


def _between(low, low_count, low_odd, high, high_count, high_odd):
    """Triangles between two rings, by the first vertex and the number of each, and whether it stands half a step on.

    Each step along one ring leads to the vertex of the other that is passed by then, so the steps' middles decide.
    """
    low_middles = (np.arange(low_count) + 0.5 + 0.5 * low_odd) / low_count
    high_middles = (np.arange(high_count) + 0.5 + 0.5 * high_odd) / high_count
    parts = []
    if low_count > 1:
        here = np.arange(low_count)
        across = np.searchsorted(high_middles, low_middles, side="left") % high_count
        parts.append(np.column_stack([low + here, low + (here + 1) % low_count, high + across]))
    if high_count > 1:
        here = np.arange(high_count)
        across = np.searchsorted(low_middles, high_middles, side="right") % low_count
        parts.append(np.column_stack([high + (here + 1) % high_count, high + here, low + across]))
    return np.concatenate(parts)
