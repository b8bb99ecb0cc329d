# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Graphs whose nodes carry frames, and independent solutions: an interior-point method, and many local searches."""

import numpy as np
from scipy.linalg import LinAlgError, block_diag
from scipy.spatial.transform import Rotation

from synch_fields.core.connection import Connection

from .graphs import longest_step


def random_frames(count, dimension, random, special=True):
    """(count, d, d) orthogonal matrices drawn at random, rotations if ``special``."""
    frames = np.linalg.qr(random.standard_normal((count, dimension, dimension)))[0]
    if special:
        frames[:, :, 0] *= np.linalg.det(frames)[:, None]
    return frames


def random_edges(nodes, extra, random):
    """(e, 2) a random tree and up to ``extra`` more edges."""
    tree = np.column_stack([random.integers(0, np.arange(1, nodes)), np.arange(1, nodes)])
    more = random.integers(0, nodes, (extra, 2))
    return np.unique(np.sort(np.vstack([tree, more[more[:, 0] != more[:, 1]]]), axis=1), axis=0)


def noisy_rotations(nodes, extra, angle, seed, weights=True):
    """A connection of SO(3) that turns by up to ``angle`` off what (n, 3, 3) true rotations ask for, and these."""
    random = np.random.default_rng(seed)
    edges = random_edges(nodes, extra, random)
    truth = random_frames(nodes, 3, random)
    axes = random.standard_normal((len(edges), 3))
    axes *= (angle * random.random(len(edges)) / np.linalg.norm(axes, axis=1))[:, None]
    transports = truth[edges[:, 1]] @ truth[edges[:, 0]].swapaxes(1, 2) @ Rotation.from_rotvec(axes).as_matrix()
    sizes = random.uniform(0.5, 2, len(edges)) if weights else np.ones(len(edges))
    return Connection(nodes, edges, sizes, transports), truth


def energy_by_hand(connection, frames):
    """Sum over edges of w |X_j - g X_i|^2, one edge at a time."""
    edges = zip(connection.edges, connection.weights, connection.transports, strict=True)
    return sum(weight * np.sum((frames[j] - block @ frames[i]) ** 2) for (i, j), weight, block in edges)


def frame_laplacian(connection):
    """Dense (n d, n d) matrix of the energy."""
    d, n = connection.transports.shape[1], connection.node_count
    matrix = np.zeros((n * d, n * d))
    for (i, j), weight, block in zip(connection.edges, connection.weights, connection.transports, strict=True):
        difference = np.zeros((d, n * d))
        difference[:, j * d : j * d + d], difference[:, i * d : i * d + d] = np.eye(d), -block
        matrix += weight * difference.T @ difference
    return matrix


def frame_relaxation(matrix, d):
    """Two bounds of min <L, X> over X >= 0 whose block at each node is the unit matrix.

    The interior-point method of Helmberg, Rendl, Vanderbei and Wolkowicz (1996), as :func:`.graphs.relaxation` for
    traces: the first bound is the value of a feasible point of the dual, the second that of one of the relaxation.
    """
    size = len(matrix)
    nodes, inner = range(size // d), np.transpose(np.triu_indices(d))
    constraints = np.zeros((len(nodes) * len(inner), size, size))
    for number, (node, (a, b)) in enumerate((node, pair) for node in nodes for pair in inner):
        constraints[number, node * d + a, node * d + b] = constraints[number, node * d + b, node * d + a] = 0.5
        constraints[number, node * d + a, node * d + b] += 0.5 * (a == b)
        constraints[number, node * d + b, node * d + a] = constraints[number, node * d + a, node * d + b]
    values = np.tile((inner[:, 0] == inner[:, 1]).astype(float), len(nodes))
    x, lowest = np.eye(size), (1.9 * matrix.diagonal() - np.abs(matrix).sum(axis=1)).min()
    duals = lowest * values
    before, gap = np.inf, np.vdot(x, matrix) - values @ duals
    while 1e-10 * np.vdot(x, matrix) < gap < 0.999 * before:
        slack = matrix - np.tensordot(duals, constraints, 1)
        try:
            inverse, target = np.linalg.inv(slack), gap / (4 * size)
            seen = inverse @ constraints @ x
            system = np.tensordot(seen, constraints, [(2, 1), (1, 2)])
            rise = np.linalg.solve(system, values - target * np.tensordot(constraints, inverse, [(1, 2), (1, 0)]))
            move = target * inverse - x + np.tensordot(rise, seen, 1)
            move = (move + move.T) / 2
            fall = -np.tensordot(rise, constraints, 1)
            x, duals = x + longest_step(x, move) * move, duals + longest_step(slack, fall) * rise
        except LinAlgError:
            break
        before, gap = gap, np.vdot(x, matrix) - values @ duals
    slack = matrix - np.tensordot(duals, constraints, 1)
    shrinks = []
    for node in nodes:
        sizes, axes = np.linalg.eigh(x[node * d : node * d + d, node * d : node * d + d])
        shrinks.append((axes / np.sqrt(sizes)) @ axes.T)
    shrink = block_diag(*shrinks)
    lower = values @ duals + size * min(np.linalg.eigvalsh(slack)[0], 0)
    return float(lower), float(np.vdot(shrink @ x @ shrink, matrix))


def brute_force_frames(connection, special, starts=60, sweeps=150, seed=0):
    """Lowest energy found node by node: each takes the frame nearest to its pull, from many random starts at once."""
    d, n = connection.transports.shape[1], connection.node_count
    random = np.random.default_rng(seed)
    frames = random_frames(starts * n, d, random, special).reshape(starts, n, d, d)
    for _ in range(sweeps):
        for node in range(n):
            pull = np.zeros((starts, d, d))
            for (i, j), weight, block in zip(connection.edges, connection.weights, connection.transports, strict=True):
                if node == i:
                    pull += weight * block.T @ frames[:, j]
                if node == j:
                    pull += weight * block @ frames[:, i]
            left, _, right = np.linalg.svd(pull)
            if special:
                left[:, :, -1] *= np.linalg.det(left @ right)[:, None]
            frames[:, node] = left @ right
    return min(energy_by_hand(connection, found) for found in frames)
