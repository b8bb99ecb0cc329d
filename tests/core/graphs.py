# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Small random synchronization problems, and their optima by brute force that shares no code with core."""

from itertools import product

import numpy as np

from synch_fields.core.connection import Connection, circle_transports
from synch_fields.core.problem import Merged, Targets

KINDS = ("circle", "flips", "signs", "rotations")


def random_edges(nodes, extra, random):
    """A random spanning tree and extra more edges, in random directions, without loops."""
    edges = [(int(random.integers(0, k)), k) for k in range(1, nodes)]
    while len(edges) < nodes - 1 + extra:
        i, j = random.integers(0, nodes, 2)
        if i != j:
            edges.append((int(i), int(j)))
    edges = np.array(edges)
    swap = random.random(len(edges)) < 0.5
    edges[swap] = edges[swap][:, ::-1]
    return edges


def random_transports(kind, count, random):
    if kind == "circle":
        return np.exp(1j * random.uniform(-np.pi, np.pi, count))
    if kind == "flips":
        flips = random.random(count) < 0.5
        flips[0] = True  # otherwise the transports are complex numbers
        return circle_transports(random.uniform(-np.pi, np.pi, count), flips)
    if kind == "signs":
        return random.choice([-1.0, 1.0], count)[:, None, None]
    return np.linalg.qr(random.standard_normal((count, 4, 4)))[0]


def random_connection(kind, nodes=6, extra=6, seed=0):
    random = np.random.default_rng(seed)
    edges = random_edges(nodes, extra, random)
    return Connection(nodes, edges, random.uniform(0.2, 2, len(edges)), random_transports(kind, len(edges), random))


def random_values(kind, count, random):
    """Unit values as constraints and energies take them."""
    if kind in ("circle", "flips"):
        return np.exp(1j * random.uniform(-np.pi, np.pi, count))
    values = random.standard_normal((count, 1 if kind == "signs" else 4))
    return values / np.linalg.norm(values, axis=1)[:, None]


def random_constraints(kind, nodes, seed):
    """Some of merged, fixed and drawn, on different nodes, as arguments of a problem."""
    random = np.random.default_rng(seed)
    shuffled = random.permutation(nodes)
    chosen = {}
    if seed % 2 == 0:
        chosen["fixed"] = Targets(shuffled[:2], random_values(kind, 2, random))
    if seed % 3 != 0:
        transports = random_transports(kind, 2, random)
        chosen["merged"] = Merged(shuffled[2:4], shuffled[[4, 4]], transports)
    if seed % 5 < 3:
        drawn = shuffled[3:6]
        chosen["drawn"] = Targets(drawn, random_values(kind, 3, random), random.uniform(0.2, 3, 3))
    return chosen


def as_blocks(transports):
    """Real (k, d, d) matrices of any transports."""
    if transports.ndim == 3:
        return transports
    return np.array([[[t.real, -t.imag], [t.imag, t.real]] for t in transports])


def as_vectors(values):
    values = np.asarray(values)
    return np.column_stack([values.real, values.imag]) if np.iscomplexobj(values) else values


def quadratic(connection, merged=None, fixed=None, drawn=None):
    """Dense (A, b, c) with energy = x A x + 2 b x + c over the free nodes' real coordinates x."""
    blocks = as_blocks(connection.transports)
    d, n = blocks.shape[1], connection.node_count
    held = np.zeros(n * d)
    spread = np.eye(n * d)
    rows = np.arange(n * d).reshape(n, d)
    free = np.ones(n, bool)
    if merged is not None:
        for node, root, block in zip(merged.nodes, merged.roots, as_blocks(merged.transports), strict=True):
            spread[rows[node]] = 0
            spread[np.ix_(rows[node], rows[root])] = block
            free[node] = False
    if fixed is not None:
        for node, value in zip(fixed.nodes, as_vectors(fixed.values), strict=True):
            spread[rows[node]] = 0
            held[rows[node]] = value
            free[node] = False
    spread = spread[:, rows[free].ravel()]
    a, b, c = np.zeros((spread.shape[1],) * 2), np.zeros(spread.shape[1]), 0.0
    for (i, j), weight, block in zip(connection.edges, connection.weights, blocks, strict=True):
        linear, constant = spread[rows[j]] - block @ spread[rows[i]], held[rows[j]] - block @ held[rows[i]]
        a, b, c = a + weight * linear.T @ linear, b + weight * linear.T @ constant, c + weight * constant @ constant
    if drawn is not None:
        for node, weight, value in zip(drawn.nodes, drawn.weights, as_vectors(drawn.values), strict=True):
            linear, constant = spread[rows[node]], held[rows[node]] - value
            a, b, c = a + weight * linear.T @ linear, b + weight * linear.T @ constant, c + weight * constant @ constant
    return a, b, c, d


def brute_force(connection, starts=40, sweeps=60, seed=0, **constraints):
    """Lowest energy over all phases: every sign for d = 1, otherwise node by node from many starts.

    On the circle each node takes the best of 64 angles, then Newton's method finishes; in higher
    dimensions the merged nodes must not see themselves along an edge.
    """
    a, b, c, d = quadratic(connection, **constraints)
    n = len(b) // d
    if d == 1:
        x = np.array(list(product((-1.0, 1.0), repeat=n)))
        return float((np.einsum("si,ij,sj->s", x, a, x) + 2 * x @ b + c).min())
    random = np.random.default_rng(seed)
    x = random.standard_normal((starts, n, d))
    x /= np.linalg.norm(x, axis=2)[:, :, None]
    for sweep in range(sweeps if d == 2 else 5 * sweeps):
        for i in range(n):
            own = slice(i * d, i * d + d)
            outer = b[own] + x.reshape(starts, -1) @ a[:, own] - x[:, i] @ a[own, own]
            x[:, i] = _best_on_circle(a[own, own], outer, x[:, i], sweep < 3) if d == 2 else _opposite(outer, x[:, i])
    x = x.reshape(starts, -1)
    return float((np.einsum("si,ij,sj->s", x, a, x) + 2 * x @ b + c).min())


def _opposite(outer, current):
    lengths = np.linalg.norm(outer, axis=1)[:, None]
    return np.where(lengths > 1e-14, -outer / np.maximum(lengths, 1e-14), current)


def _best_on_circle(own, outer, current, search):
    """Minimum of x own x + 2 outer x over the circle for all starts at once."""
    if search:
        angles = np.linspace(-np.pi, np.pi, 64, endpoint=False)
        points = np.stack([np.cos(angles), np.sin(angles)])
        values = np.einsum("ak,ab,bk->k", points, own, points) + 2 * outer @ points
        angle = angles[values.argmin(axis=1)]
    else:
        angle = np.arctan2(current[:, 1], current[:, 0])
    for _ in range(3):
        x = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        t = np.stack([-x[:, 1], x[:, 0]], axis=1)
        slope = np.einsum("sa,ab,sb->s", x, own, t) + (outer * t).sum(1)
        bend = np.einsum("sa,ab,sb->s", t, own, t) - np.einsum("sa,ab,sb->s", x, own, x) - (outer * x).sum(1)
        step = np.where(bend > 1e-9, slope / np.where(bend > 1e-9, bend, 1), np.sign(slope) * 0.05)
        angle = angle - np.clip(step, -0.1, 0.1)
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)
