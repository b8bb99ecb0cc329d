# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The Laplacians on the nodes: of the graph, and of the turns that a field can make."""

import numpy as np
import pytest

from synch_fields.core.algebra.coarsening import graph_laplacian, turning_laplacian
from synch_fields.core.connection import Connection, circle_transports
from synch_fields.core.problem import SynchronizationProblem, Targets

from ..graphs import KINDS, laplacian, only_piece, random_edges, random_units


def simple_edges(nodes, extra, random):
    """Random connected edges, no pair joined twice."""
    return np.unique(np.sort(random_edges(nodes, extra, random), axis=1), axis=0)


@pytest.mark.parametrize("group", KINDS)
def test_the_graph_laplacian_forgets_the_transports(group):
    random = np.random.default_rng(2)
    edges = simple_edges(12, 20, random)
    connection = Connection(12, edges, random.uniform(0.2, 2, len(edges)), random_units(group, len(edges), random))
    expected = np.zeros((12, 12))
    for (i, j), weight in zip(edges, connection.weights, strict=True):
        expected[[i, j], [i, j]] += weight
        expected[[i, j], [j, i]] -= weight
    result = graph_laplacian(laplacian(connection), connection.block)
    np.testing.assert_allclose(result.toarray(), expected, atol=1e-12)


def agreeing(flip_share, seed, nodes=9):
    """A connection that angles fit perfectly: conjugate before turning where it flips."""
    random = np.random.default_rng(seed)
    edges = simple_edges(nodes, 12, random)
    angles = random.uniform(-np.pi, np.pi, nodes)
    flips = random.random(len(edges)) < flip_share
    i, j = edges.T
    transports = circle_transports(angles[j] - np.where(flips, -1, 1) * angles[i], flips)
    return Connection(nodes, edges, random.uniform(0.2, 2, len(edges)), transports), angles


def hessian(energy, angles, step=1e-3):
    """Second differences of a function of angles."""
    shifts = step * np.eye(len(angles))
    return np.array(
        [
            [
                sum(s * t * energy(angles + s * a + t * b) for s in (1, -1) for t in (1, -1)) / (4 * step**2)
                for b in shifts
            ]
            for a in shifts
        ]
    )


def natural(piece, matrix):
    """A matrix on the piece's nodes, dense, in the order of the problem's."""
    order = np.argsort(piece.rows[:: piece.block])
    return matrix.toarray()[np.ix_(order, order)]


@pytest.mark.parametrize("flip_share", [0.0, 0.5])
@pytest.mark.parametrize("seed", range(3))
def test_the_turning_laplacian_is_half_the_hessian_in_angles(flip_share, seed):
    connection, angles = agreeing(flip_share, seed)
    problem = SynchronizationProblem(connection)
    assert connection.energy(np.exp(1j * angles)) < 1e-25
    assert problem.is_complex == (flip_share == 0)  # these flips are unbalanced
    piece = only_piece(problem)
    expected = hessian(lambda a: connection.energy(np.exp(1j * a)), angles) / 2
    result = natural(piece, turning_laplacian(piece.matrix, piece.block))
    np.testing.assert_allclose(result, expected, atol=2e-6)


def test_turns_of_nodes_that_a_gauge_turns_over_count_with_the_other_sign():
    random = np.random.default_rng(1)
    edges = simple_edges(9, 12, random)
    sheets, angles = random.random(9) < 0.5, random.uniform(-np.pi, np.pi, 9)
    flips = sheets[edges[:, 0]] != sheets[edges[:, 1]]
    transports = circle_transports(angles[edges[:, 1]] - np.where(flips, -1, 1) * angles[edges[:, 0]], flips)
    problem = SynchronizationProblem(Connection(9, edges, random.uniform(0.2, 2, len(edges)), transports))
    assert problem.is_complex and problem.turned.any()
    sign = np.where(problem.turned, -1, 1)
    expected = hessian(lambda a: problem.energy(np.exp(1j * a)), angles) / 2
    piece = only_piece(problem)
    result = natural(piece, turning_laplacian(piece.matrix, 1))
    np.testing.assert_allclose(result * np.outer(sign, sign), expected, atol=2e-6)


@pytest.mark.parametrize("seed", range(3))
def test_a_ground_in_real_coordinates_does_not_turn(seed):
    """The other nodes' turns cost what they cost beside fixed and drawn ones; the ground's row stands alone."""
    connection, angles = agreeing(0.5, seed)
    phases = np.exp(1j * angles)
    fixed, wished = np.array([1, 4]), np.array([0, 4 + seed, 8])
    wished = np.setdiff1d(wished, fixed)
    drawn = Targets(wished, phases[wished], np.array([0.7, 1.3, 0.4])[: len(wished)])
    problem = SynchronizationProblem(connection, fixed=Targets(fixed, phases[fixed]), drawn=drawn)
    piece = only_piece(problem)
    assert piece.block == 2 and piece.rows[2 * piece.ground] == 2 * (piece.node_count - 1)
    free = np.setdiff1d(np.arange(9), fixed)

    def energy(turned):
        everything = angles.copy()
        everything[free] = turned
        return problem.energy(np.exp(1j * everything))

    assert energy(angles[free]) < 1e-25
    result = natural(piece, turning_laplacian(piece.matrix, piece.block, piece.ground))
    np.testing.assert_allclose(result[:-1, :-1], hessian(energy, angles[free]) / 2, atol=2e-6)
    assert not result[-1, :-1].any() and not result[:-1, -1].any() and result[-1, -1] > 0
