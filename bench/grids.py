# SPDX-License-Identifier: GPL-3.0-or-later
"""Singular Clebsch maps on a grid (Section 3.6.1): the velocity of a trefoil vortex as a connection."""

import numpy as np

from synch_fields.core.connection import Connection, circle_transports
from synch_fields.core.problem import SynchronizationProblem

# Lengths are in units of the box's longest side.
SIZE = 0.32
CORE = 0.06
SEGMENTS = 120
# Filaments that the vortex is cut into: its circulation over 2 pi hbar.
QUANTA = 6
CHUNK = 1 << 14


def trefoil_problem(shape):
    """Nodes of a box grid of cubes, open boundary.

    An edge turns the phase by the integral of velocity / hbar along it (Eq. 12), by the trapezoidal rule; its
    weight is the dual area over the length, as in the cotangent rule, and a node's mass is its dual volume.

    Parameters
    ----------
    shape : nodes along x, y and z
    """
    spacing = 1 / (max(shape) - 1)
    nodes = np.arange(np.prod(shape)).reshape(shape)
    axes = [spacing * (np.arange(count) - (count - 1) / 2) for count in shape]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    rotations = trefoil_velocity(places.reshape(-1, 3)).reshape(*shape, 3)
    dual_lengths = [np.full(count, spacing) for count in shape]
    for lengths in dual_lengths:
        lengths[[0, -1]] /= 2
    edges, angles, weights = [], [], []
    for axis in range(3):
        tails = np.delete(nodes, -1, axis).ravel()
        heads = np.delete(nodes, 0, axis).ravel()
        along = rotations[..., axis].ravel()
        edges.append(np.column_stack([tails, heads]))
        angles.append(spacing * (along[tails] + along[heads]) / 2)
        others = [np.ones(count - 1) if other == axis else dual_lengths[other] for other, count in enumerate(shape)]
        weights.append(_outer(others).ravel() / spacing)
    connection = Connection(
        nodes.size, np.concatenate(edges), np.concatenate(weights), circle_transports(np.concatenate(angles))
    )
    return SynchronizationProblem(connection, _outer(dual_lengths).ravel())


def _outer(factors):
    x, y, z = factors
    return x[:, None, None] * y[:, None] * z


def trefoil_velocity(places):
    """(n, 3) velocity / hbar of a trefoil filament with a soft core, by Biot and Savart's law."""
    turn = 2 * np.pi * np.arange(SEGMENTS + 1) / SEGMENTS
    curve = np.column_stack(
        [np.sin(turn) + 2 * np.sin(2 * turn), np.cos(turn) - 2 * np.cos(2 * turn), -np.sin(3 * turn)]
    )
    curve *= SIZE / 3
    middles, segments = (curve[1:] + curve[:-1]) / 2, np.diff(curve, axis=0)
    moments = np.cross(segments, middles)
    velocity = np.empty_like(places)
    for start in range(0, len(places), CHUNK):
        chunk = places[start : start + CHUNK]
        squares = (chunk**2).sum(axis=1)[:, None] + (middles**2).sum(axis=1) - 2 * chunk @ middles.T + CORE**2
        kernel = 1 / (squares * np.sqrt(squares))
        velocity[start : start + CHUNK] = np.cross(kernel @ segments, chunk) - kernel @ moments
    # Circulation = 2 pi hbar QUANTA, over 4 pi.
    return velocity * (QUANTA / 2)
