# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Turning nodes over and choosing other coordinates at them changes the phases' names and nothing else."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from synch_fields.core.connection import Connection, circle_transports
from synch_fields.core.gauge import balance
from synch_fields.core.problem import Merged, SynchronizationProblem, Targets
from synch_fields.core.solve import Options, solve

from .graphs import KINDS, as_blocks, brute_force, quadratic, random_connection, random_edges, random_transports


@pytest.mark.parametrize("seed", range(30))
def test_flips_vanish_exactly_where_some_choice_of_sheets_removes_them(seed):
    random = np.random.default_rng(seed)
    edges = np.vstack([random_edges(4, 1 + seed % 3, random), 4 + random_edges(3, seed % 2, random)])
    flips = random.random(len(edges)) < 0.5
    turned, balanced = balance(8, edges, flips)
    for nodes in (range(4), range(4, 7), range(7, 8)):
        inside = np.isin(edges[:, 0], nodes)
        i, j = edges[inside].T - nodes[0]
        choices = np.array(list(product((False, True), repeat=len(nodes))))
        removes_all = ~(flips[inside] ^ choices[:, i] ^ choices[:, j]).any(axis=1)
        assert balanced[list(nodes)].all() == removes_all.any() == balanced[list(nodes)].any()
        if removes_all.any():
            assert not (flips[inside] ^ turned[edges[inside, 0]] ^ turned[edges[inside, 1]]).any()
            assert not turned[nodes[0]]
        else:
            assert not turned[list(nodes)].any()


def gauged(connection, seed):
    """The same connection in other coordinates: phi = block @ phi' at every node."""
    random = np.random.default_rng(seed)
    if connection.transports.ndim == 1:
        units = np.exp(1j * random.uniform(0, 2 * np.pi, connection.node_count))
        i, j = connection.edges.T
        return replace(connection, transports=units[j].conj() * connection.transports * units[i]), units
    d = connection.block
    units = np.linalg.qr(random.standard_normal((connection.node_count, d, d)))[0]
    units = random.choice([-1.0, 1.0], len(units))[:, None, None] if d == 1 else units
    i, j = connection.edges.T
    return replace(connection, transports=units[j].transpose(0, 2, 1) @ connection.transports @ units[i]), units


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(3))
def test_a_gauge_change_leaves_spectrum_optimum_and_bound_alone(kind, seed):
    connection = random_connection(kind, nodes=12, extra=14, seed=seed)
    other, units = gauged(connection, seed + 1)
    np.testing.assert_allclose(
        np.linalg.eigvalsh(quadratic(other)[0]), np.linalg.eigvalsh(quadratic(connection)[0]), atol=1e-10
    )
    options = Options(target_gap=1e-6)
    first = solve(SynchronizationProblem(connection), options)
    second = solve(SynchronizationProblem(other), options)
    assert second.sdp_value == pytest.approx(first.sdp_value, rel=3e-6)
    assert second.lower_bound == pytest.approx(first.lower_bound, rel=3e-6)
    assert second.energy == pytest.approx(first.energy, rel=1e-5)
    spread = units * second.phases if kind == "circle" else None
    if kind in ("signs", "rotations"):
        spread = np.einsum("nab,nb->na", units, second.phases)
    if kind == "flips":
        pairs = np.column_stack([second.phases.real, second.phases.imag])
        spread = np.einsum("nab,nb->na", units, pairs) @ [1, 1j]
    assert connection.energy(spread) == pytest.approx(second.energy, rel=1e-9)


def turned_over(connection, turned):
    """O(2) transports of a U(1) connection whose nodes turned carry the conjugate of their phase."""
    conjugation = np.diag([1.0, -1.0])
    blocks = as_blocks(connection.transports)
    i, j = connection.edges.T
    blocks = np.where(turned[i][:, None, None], blocks @ conjugation, blocks)
    return replace(connection, transports=np.where(turned[j][:, None, None], conjugation @ blocks, blocks))


@pytest.mark.parametrize("seed", range(6))
def test_balanced_flips_are_solved_as_complex_numbers_with_the_same_result(seed):
    connection = random_connection("circle", nodes=10, extra=12, seed=seed)
    turned = np.random.default_rng(seed).random(10) < 0.5
    turned[0] = not turned[1]
    flipped = turned_over(connection, turned)
    problem = SynchronizationProblem(flipped)
    assert (np.linalg.det(flipped.transports) < 0).any()
    assert problem.is_complex and problem.block == 1
    result = solve(problem, Options(target_gap=1e-6))
    plain = solve(SynchronizationProblem(connection), Options(target_gap=1e-6))
    assert result.lower_bound == pytest.approx(plain.lower_bound, rel=3e-6)
    assert result.energy == pytest.approx(plain.energy, rel=1e-6)
    assert connection.energy(np.where(turned, result.phases.conj(), result.phases)) == pytest.approx(result.energy)


@pytest.mark.parametrize("seed", range(6))
def test_the_real_path_agrees_with_the_complex_one(seed):
    connection = random_connection("circle", nodes=10, extra=12, seed=seed)
    turned = np.random.default_rng(seed).random(10) < 0.5
    values = np.exp(1j * np.arange(2.0))
    fixed = Targets(np.array([2, 7]), np.where(turned[[2, 7]], values.conj(), values))
    # A far component that no choice of sheets balances puts the whole problem on the real path.
    over = turned_over(connection, turned)
    edges = np.vstack([over.edges, [[10, 11], [10, 11]]])
    far = circle_transports([0.0, 0.0], [True, False])
    mixed = Connection(12, edges, np.concatenate([over.weights, [1e-3, 1e-3]]), np.concatenate([over.transports, far]))
    real = SynchronizationProblem(mixed, fixed=fixed)
    assert not real.is_complex
    plain = SynchronizationProblem(connection, fixed=Targets(fixed.nodes, values))
    options = Options(target_gap=1e-5)
    first, second = solve(plain, options), solve(real, options)
    # phi_11 = phi_10 and its conjugate: real phases satisfy both.
    assert second.energy == pytest.approx(first.energy, rel=1e-5)
    # Phases and their conjugates are relaxed together in O(2), so that its relaxation may be weaker only.
    assert second.sdp_value <= first.sdp_value * (1 + 3e-5)
    assert second.lower_bound <= first.energy * (1 + 1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_merged_flips_unbalance_a_graph_without_flips(seed):
    """Two nodes tied by a conjugation on a graph whose own transports are plain turns."""
    connection = random_connection("circle", nodes=6, extra=5, seed=seed)
    merged = Merged(np.array([4]), np.array([1]), circle_transports([0.4], [True]))
    solution = solve(SynchronizationProblem(connection, merged=merged))
    exact = brute_force(connection, merged=merged)
    assert solution.phases[4] == pytest.approx(np.exp(0.4j) * solution.phases[1].conj())
    assert solution.lower_bound <= exact * (1 + 1e-9) + 1e-12
    assert solution.energy == pytest.approx(exact, rel=1e-4)


@pytest.mark.parametrize("seed", range(4))
def test_merged_turns_join_a_graph_with_flips(seed):
    """Transports of merged nodes given as complex numbers beside an O(2) connection."""
    turned = np.array([True, False, True, False, True, True])
    connection = turned_over(random_connection("circle", nodes=6, extra=5, seed=seed), turned)
    merged = Merged(np.array([3]), np.array([1]), np.exp([0.4j]))
    solution = solve(SynchronizationProblem(connection, merged=merged))
    exact = brute_force(connection, merged=merged)
    assert solution.phases[3] == pytest.approx(np.exp(0.4j) * solution.phases[1])
    assert solution.lower_bound <= exact * (1 + 1e-9) + 1e-12
    assert solution.energy == pytest.approx(exact, rel=1e-4)


def test_unbalanced_flips_take_the_real_path():
    random = np.random.default_rng(0)
    edges = np.array([[0, 1], [1, 2], [2, 0]])
    for flips, expected in (([True, False, False], False), ([True, True, False], True)):
        connection = Connection(3, edges, np.ones(3), circle_transports(random.uniform(0, 6, 3), flips))
        problem = SynchronizationProblem(connection)
        assert problem.is_complex is expected and problem.block == (1 if expected else 2)
    assert SynchronizationProblem(Connection(3, edges, np.ones(3), random_transports("circle", 3, random))).is_complex
