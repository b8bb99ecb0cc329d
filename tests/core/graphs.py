# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Small synchronization problems; their optima by brute force and relaxations that share no code with core."""

from itertools import product

import numpy as np
import pytest
from scipy.linalg import LinAlgError, eigh
from scipy.sparse import bsr_matrix

from synch_fields.core.connection import Connection, circle_transports
from synch_fields.core.fields.directions import direction_field, direction_problem, given_directions
from synch_fields.core.fields.patterns import PatternWishes, pattern_problem
from synch_fields.core.problem import Merged, SynchronizationProblem, Targets

from .meshes import bent_square, bumpy_torus, cube, double_torus, icosphere, slivers

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
    """Some of merged, fixed and drawn, on different nodes, as arguments of a problem of 4 nodes or more."""
    random = np.random.default_rng(seed)
    shuffled = random.permutation(nodes)
    few = 2 if nodes >= 6 else 1
    chosen = {}
    if seed % 2 == 0:
        chosen["fixed"] = Targets(shuffled[:few], random_values(kind, few, random))
    if seed % 3 != 0:
        transports = random_transports(kind, few, random)
        chosen["merged"] = Merged(shuffled[few : 2 * few], np.repeat(shuffled[2 * few], few), transports)
    if seed % 5 < 3:
        drawn = shuffled[2 * few - 1 : 2 * few + 2]
        chosen["drawn"] = Targets(drawn, random_values(kind, 3, random), random.uniform(0.2, 3, 3))
    return chosen


def random_problem(kind, seed):
    """A connection of 4 to 12 nodes, from nearly a tree to dense, and constraints for every other seed."""
    random = np.random.default_rng(seed + 1000)
    nodes = int(random.integers(4, 13))
    connection = random_connection(kind, nodes, int(random.integers(1, 3 * nodes)), seed)
    return connection, random_constraints(kind, nodes, seed // 2) if seed % 2 else {}


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


def brute_force(connection, starts=200, kept=10, seed=0, **constraints):
    """Lowest energy over all phases: every sign for d = 1, otherwise node by node from many starts at once.

    The best value of one node, given the others, is the opposite of their pull. A node that sees itself,
    through nodes merged into it, has no such formula; its own block is then replaced by a multiple of 1
    above it that agrees at the current value, so that no step ever raises the energy.
    """
    a, b, c, d = quadratic(connection, **constraints)
    n = len(b) // d
    if d == 1:
        return float(_energies(a, b, c, np.array(list(product((-1.0, 1.0), repeat=n))).T).min())
    random = np.random.default_rng(seed)
    x = random.standard_normal((n, d, starts))
    x = (x / np.linalg.norm(x, axis=1, keepdims=True)).reshape(n * d, starts)
    nodes = [slice(i, i + d) for i in range(0, n * d, d)]
    above = [np.linalg.eigvalsh(a[node, node])[-1] for node in nodes]
    energies = _energies(a, b, c, x)
    for sweep in range(1, 3001):
        for node, top in zip(nodes, above, strict=True):
            pull = top * x[node] - a[node] @ x - b[node, None]
            lengths = np.sqrt((pull * pull).sum(axis=0))
            x[node] = np.where(lengths > 1e-14, pull / np.maximum(lengths, 1e-14), x[node])
        if sweep % 20 == 0:
            before, energies = energies, _energies(a, b, c, x)
            if (before - energies).max() <= 1e-13 * energies.min() + 1e-16 * np.trace(a):
                break
        if sweep == 60:
            order = np.argsort(energies)[:kept]
            x, energies = x[:, order], energies[order]
    return float(energies.min())


def _energies(a, b, c, x):
    return ((a @ x) * x).sum(axis=0) + 2 * b @ x + c


def lifted_matrix(connection, **constraints):
    """Dense matrix of the relaxation in real coordinates, the node of each row, the held values being one row."""
    a, b, c, d = quadratic(connection, **constraints)
    nodes = np.repeat(np.arange(len(b) // d), d)
    if "fixed" in constraints or "drawn" in constraints:
        a, nodes = np.block([[a, b[:, None]], [b, c]]), np.append(nodes, len(b) // d)
    return a, nodes


def relaxation(matrix, nodes):
    """Two bounds of the relaxation (22), min <L, X> over X >= 0 whose block at each node has trace 1.

    The primal-dual interior-point method of Helmberg, Rendl, Vanderbei and Wolkowicz (1996). The first bound is
    the value of a feasible point of the dual, the second that of one of the relaxation: where they agree,
    they prove each other.

    Parameters
    ----------
    matrix : (N, N) dense, real symmetric or complex Hermitian
    nodes : (N,) node of each row
    """
    share = np.eye(nodes.max() + 1)[nodes]
    x = np.diag(1 / share.sum(axis=0)[nodes]).astype(matrix.dtype)
    dominant = 1.9 * matrix.diagonal().real - np.abs(matrix).sum(axis=1)  # less than this leaves S > 0
    duals = np.array([dominant[nodes == node].min() for node in range(share.shape[1])])
    before, gap = np.inf, np.vdot(x, matrix).real - duals.sum()
    while 1e-9 * np.vdot(x, matrix).real + 1e-13 * np.trace(matrix).real < gap < 0.999 * before:
        try:
            x, duals = _interior_step(matrix, nodes, share, x, duals, gap)
        except LinAlgError:  # definite no more: rounding has the last word
            break
        before, gap = gap, np.vdot(x, matrix).real - duals.sum()
    # What rounding has left of infeasibility is taken off.
    values, vectors = np.linalg.eigh(x)
    columns = vectors * np.sqrt(np.maximum(values, 0))
    columns /= np.sqrt(share @ (share.T @ (np.abs(columns) ** 2).sum(axis=1)))[:, None]
    duals = duals + min(np.linalg.eigvalsh(matrix - np.diag(duals[nodes]))[0], 0)
    return float(duals.sum()), float(np.vdot(columns, matrix @ columns).real)


def _interior_step(matrix, nodes, share, x, duals, gap):
    """X + dX is to be a multiple of (S + dS)^-1 to first order, with dS = -diag(rise) and unchanged traces."""
    slack = matrix - np.diag(duals[nodes])
    inverse = np.linalg.inv(slack)
    target = gap / (4 * len(matrix))
    traces = 1 - target * share.T @ inverse.diagonal().real
    rise = np.linalg.solve(share.T @ (inverse * x.conj()).real @ share, traces)
    move = target * inverse - x + inverse @ (rise[nodes][:, None] * x)
    move = (move + move.conj().T) / 2
    return x + longest_step(x, move) * move, duals + longest_step(slack, -np.diag(rise[nodes])) * rise


def longest_step(point, move):
    """Share of ``move``, at most all of it, that keeps ``point`` positive definite."""
    lowest = eigh(move, point, eigvals_only=True)[0]
    return min(1.0, -0.9 / lowest) if lowest < 0 else 1.0


def stripes_on(mesh, symmetry, stripes):
    field = direction_field(mesh, symmetry)
    return pattern_problem(mesh, field, PatternWishes(np.linalg.norm(np.ptp(mesh.vertices, axis=0)) / stripes))


def half_turned_stripes(mesh, spacing):
    """Stripes along lines that come back turned by half a turn around the z axis: no gauge removes their flips."""
    x, y, _ = mesh.vertices.T
    angle = np.arctan2(y, x)
    around = np.column_stack([-np.sin(angle), np.cos(angle), np.zeros_like(angle)])
    across = np.cross(mesh.vertex_normals, around)
    vectors = np.cos(angle / 2)[:, None] * around + np.sin(angle / 2)[:, None] * across
    return pattern_problem(mesh, given_directions(mesh, 2, vectors), PatternWishes(spacing))


def fixed_rotations():
    connection = random_connection("rotations", 40, extra=60, seed=1)
    return SynchronizationProblem(
        connection, fixed=Targets(np.arange(2), random_values("rotations", 2, np.random.default_rng(0)))
    )


# Of every kind, small enough for dense linear algebra.
PROBLEMS = [
    pytest.param(lambda: direction_problem(icosphere(2), 1), id="vectors-icosphere"),
    pytest.param(lambda: direction_problem(cube(4), 4), id="crosses-cube"),
    pytest.param(lambda: direction_problem(double_torus(), 2), id="lines-double-torus"),
    pytest.param(lambda: direction_problem(slivers(), 4), id="crosses-slivers"),
    pytest.param(lambda: stripes_on(bent_square(), 1, 5), id="stripes-bent-square"),
    pytest.param(lambda: stripes_on(icosphere(2), 2, 4), id="line-stripes-icosphere"),
    pytest.param(lambda: SynchronizationProblem(random_connection("flips", 40, 60, 2)), id="flips"),
    pytest.param(lambda: SynchronizationProblem(random_connection("signs", 40, 60, 3)), id="signs"),
    pytest.param(fixed_rotations, id="fixed-rotations"),
]


def random_units(group, count, random):
    """A unit number or orthogonal matrix for each node."""
    if group == "flips":
        return circle_transports(random.uniform(-np.pi, np.pi, count), random.random(count) < 0.5)
    return random_transports(group, count, random)


def laplacian(connection):
    """sum of w |x_j - g x_i|^2 as a sparse matrix in the coordinates of the transports, whatever they are."""
    blocks = connection.transports.reshape(-1, connection.block, connection.block)
    ends = np.stack([np.broadcast_to(np.eye(connection.block), blocks.shape), -blocks], axis=1)
    ends = ends * np.sqrt(connection.weights)[:, None, None, None]
    starts, columns = 2 * np.arange(len(blocks) + 1), connection.edges[:, ::-1].ravel()
    shape = (len(blocks) * connection.block, connection.node_count * connection.block)
    factor = bsr_matrix((ends.reshape(-1, *blocks.shape[1:]), columns, starts), shape=shape).tocsr()
    return (factor.conj().T @ factor).tocsr()


def random_weights(mesh, transports, random):
    return Connection(mesh.vertex_count, mesh.edges, random.uniform(0.5, 2, len(mesh.edges)), transports)


def random_laplacian(mesh, group, seed):
    """A Laplacian with random weights and transports, and rows per node."""
    random = np.random.default_rng(seed)
    connection = random_weights(mesh, random_units(group, len(mesh.edges), random), random)
    return laplacian(connection), connection.block


def only_piece(problem):
    (piece,) = problem.pieces
    return piece


def fixed_stripes(across, spacing=0.5):
    """Stripes with flips and a ground in real coordinates."""
    problem = half_turned_stripes(bumpy_torus(across), spacing)
    count = problem.connection.node_count
    fixed = Targets(np.array([3, count // 3, 2 * count // 3]), np.exp(np.array([0.2j, 1j, -2j])))
    return SynchronizationProblem(problem.connection, problem.mass, fixed=fixed)
