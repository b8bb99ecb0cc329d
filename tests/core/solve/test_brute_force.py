# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounds and optima of small problems against brute force."""

from dataclasses import replace

import numpy as np
import pytest

from synch_fields.core.connection import Connection, circle_transports
from synch_fields.core.problem import Merged, SynchronizationProblem, Targets
from synch_fields.core.solve import Options, Status, solve
from synch_fields.core.solve.methods import staircase

from ..graphs import (
    KINDS,
    brute_force,
    lifted_matrix,
    random_connection,
    random_problem,
    random_values,
    relaxation,
)

OPTIONS = Options(target_gap=1e-4, samples=32)
GRAPHS = 12  # of each kind


def solve_both(connection, **constraints):
    return solve(SynchronizationProblem(connection, **constraints), OPTIONS), brute_force(connection, **constraints)


def assert_bracketed(solution, exact):
    """No bound may exceed the truth, and no energy may be below it."""
    assert solution.lower_bound <= exact * (1 + 1e-9) + 1e-10
    assert solution.energy >= exact * (1 - 1e-8) - 1e-10
    assert solution.lower_bound <= solution.sdp_value * (1 + 1e-9) + 1e-12
    assert solution.sdp_value <= solution.energy * (1 + 1e-9) + 1e-12
    assert solution.sdp_value <= exact * (1 + 2e-4) + 1e-10


@pytest.mark.parametrize("kind", KINDS)
def test_bounds_never_exceed_the_optimum_and_most_optima_are_found(kind):
    found = constrained = 0
    for seed in range(GRAPHS):
        connection, constraints = random_problem(kind, seed)
        problem = SynchronizationProblem(connection, **constraints)
        solution, exact = solve(problem, OPTIONS), brute_force(connection, **constraints)
        assert_bracketed(solution, exact)
        assert solution.energy == pytest.approx(problem.energy(solution.phases), rel=1e-12)
        if "fixed" in constraints:
            fixed = constraints["fixed"]
            np.testing.assert_allclose(solution.phases[fixed.nodes], fixed.values, atol=1e-9)
        found += solution.energy <= exact * (1 + 1e-5) + 1e-10
        constrained += bool(constraints)
    assert found >= 0.95 * GRAPHS and constrained >= 0.4 * GRAPHS


@pytest.mark.parametrize("bridge", ["none", "cancelling"])
def test_halves_that_nothing_holds_together_are_both_solved(bridge):
    """MAX-CUT of two complete graphs, joined by an edge of no weight or by two edges that take each other back: fields
    that vanish on one half, as their mixtures do, must not pass for cheap ones."""
    half = np.array([(i, j) for i in range(4) for j in range(i)])
    edges = np.concatenate([half, half + 4, [(0, 4)] * 2])
    weights, transports = np.ones(len(edges)), -np.ones((len(edges), 1, 1))
    weights[-2:] = 0 if bridge == "none" else 1
    transports[-1] = 1
    problem = SynchronizationProblem(Connection(8, edges, weights, transports))
    energies = [solve(problem, Options(seed=seed)).energy for seed in range(8)]
    np.testing.assert_allclose(energies, 16 if bridge == "none" else 20)


@pytest.mark.parametrize("kind", KINDS)
def test_estimated_bounds_stay_below_the_relaxation_on_these_graphs(kind, monkeypatch):
    monkeypatch.setattr(staircase, "plan_proof", lambda *_: None)
    for seed in range(GRAPHS):
        connection, constraints = random_problem(kind, seed)
        _, above = relaxation(*lifted_matrix(connection, **constraints))
        for gap in (1e-1, 1e-3):
            solution = solve(
                SynchronizationProblem(connection, **constraints), Options(target_gap=gap, rounding="svd", seed=seed)
            )
            assert solution.certificate == "estimated" or solution.lower_bound == 0
            assert solution.lower_bound <= above * (1 + 1e-9) + 1e-10
            assert solution.sdp_gap <= gap


@pytest.mark.parametrize("kind", KINDS)
def test_the_relaxation_is_that_of_an_interior_point_method(kind):
    for seed in range(GRAPHS):
        connection, constraints = random_problem(kind, seed)
        below, above = relaxation(*lifted_matrix(connection, **constraints))
        assert above == pytest.approx(below, rel=1e-8, abs=1e-8)  # the reference proves itself
        problem = SynchronizationProblem(connection, **constraints)
        for gap in (1e-1, 1e-3, 1e-6):
            solution = solve(problem, Options(target_gap=gap, rounding="svd"))
            assert solution.status is Status.CERTIFIED
            assert (1 - 1.01 * gap) * below - 1e-9 <= solution.lower_bound <= above * (1 + 1e-12) + 1e-10
            assert below * (1 - 1e-12) - 1e-10 <= solution.sdp_value
        assert solution.sdp_value == pytest.approx(above, rel=2e-6, abs=1e-8)


@pytest.mark.parametrize("kind", KINDS)
def test_no_bound_exceeds_the_relaxation_where_weights_span_six_decades(kind):
    for seed in range(5):
        connection, _ = random_problem(kind, seed)
        spread = 10 ** np.random.default_rng(seed).uniform(-3, 3, len(connection.weights))
        connection = replace(connection, weights=spread)
        below, above = relaxation(*lifted_matrix(connection))
        noise = 1e-13 * spread.sum()
        for gap in (1e-1, 1e-4):
            solution = solve(SynchronizationProblem(connection), Options(target_gap=gap))
            assert solution.lower_bound <= above * (1 + 1e-12) + noise
            assert below * (1 - 1e-12) - noise <= solution.sdp_value <= solution.energy * (1 + 1e-9) + noise


def test_flips_beside_fixed_phases():
    for seed in range(GRAPHS):
        random = np.random.default_rng(seed)
        connection = random_connection("flips", 6, extra=5, seed=seed + 500)
        fixed = Targets(random.permutation(6)[:3], np.exp(1j * random.uniform(0, 6, 3)))
        solution, exact = solve_both(connection, fixed=fixed)
        assert_bracketed(solution, exact)
        np.testing.assert_allclose(solution.phases[fixed.nodes], fixed.values, atol=1e-9)


@pytest.mark.parametrize("flips", [None, [False, True], [True, True]])
def test_one_free_node_between_two_fixed_ones_takes_the_mean(flips):
    connection = Connection(3, np.array([[0, 1], [2, 1]]), np.array([1.0, 2.0]), circle_transports([0.5, -0.3], flips))
    values = np.exp([0.2j, 1.4j])
    solution = solve(SynchronizationProblem(connection, fixed=Targets(np.array([0, 2]), values)), OPTIONS)
    second = values[1] if flips is None else values[1].conj()
    first = values[0].conj() if flips == [True, True] else values[0]
    pull = np.exp(0.5j) * first + 2 * np.exp(-0.3j) * second
    assert solution.phases[1] == pytest.approx(pull / abs(pull), abs=1e-6)
    assert solution.energy == pytest.approx(6 - 2 * abs(pull), rel=1e-9)
    assert solution.lower_bound == pytest.approx(6 - 2 * abs(pull), rel=2e-3)


def test_one_node_drawn_to_a_value_takes_it():
    connection = Connection(2, np.array([[0, 1]]), np.ones(1), np.exp([0.5j]))
    drawn = Targets(np.array([1]), np.exp([2j]), np.array([3.0]))
    solution = solve(SynchronizationProblem(connection, drawn=drawn))
    np.testing.assert_allclose(solution.phases, np.exp([1.5j, 2j]), atol=1e-6)
    assert solution.energy < 1e-12


def test_opposing_wishes_are_weighed():
    connection = Connection(2, np.array([[0, 1]]), np.array([0.5]), np.ones(1, complex))
    drawn = Targets(np.array([0, 1]), np.exp([0j, 2j]), np.array([1.0, 4.0]))
    solution, exact = solve_both(connection, drawn=drawn)
    assert_bracketed(solution, exact)
    assert solution.energy == pytest.approx(exact, rel=1e-8)


@pytest.mark.parametrize("kind", KINDS)
def test_everything_fixed_leaves_nothing_to_choose(kind):
    connection = random_connection(kind, 5, extra=4, seed=8)
    values = random_values(kind, 5, np.random.default_rng(8))
    solution = solve(SynchronizationProblem(connection, fixed=Targets(np.arange(5), values)), OPTIONS)
    np.testing.assert_allclose(solution.phases, values, atol=1e-12)
    assert solution.energy == pytest.approx(connection.energy(values), rel=1e-12)
    assert solution.lower_bound == pytest.approx(solution.energy, rel=2e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_two_edges_that_disagree_between_two_nodes(kind):
    """The smallest frustrated graph."""
    random = np.random.default_rng(1)
    connection = random_connection(kind, 2, extra=3, seed=11)
    solution, exact = solve_both(connection)
    assert_bracketed(solution, exact)
    assert solution.energy == pytest.approx(exact, rel=1e-6, abs=1e-10)
    fixed = Targets(np.array([1]), random_values(kind, 1, random))
    solution, exact = solve_both(connection, fixed=fixed)
    assert_bracketed(solution, exact)
    assert solution.energy == pytest.approx(exact, rel=1e-6, abs=1e-10)


@pytest.mark.parametrize("kind", KINDS)
def test_a_tree_is_fitted_perfectly(kind):
    solution = solve(SynchronizationProblem(random_connection(kind, 30, extra=0, seed=2)))
    assert solution.energy < 1e-12 and solution.sdp_value < 1e-10
    assert solution.lower_bound == pytest.approx(0, abs=1e-12) and solution.status is Status.CERTIFIED


def test_a_loop_merged_onto_one_node():
    """All nodes of a triangle tied to one: nothing is free, the energy is what the ties leave."""
    connection = Connection(3, np.array([[0, 1], [1, 2], [2, 0]]), np.array([1.0, 2, 3]), np.exp([0.4j, 0.9j, -0.2j]))
    merged = Merged(np.array([1, 2]), np.array([0, 0]), np.exp([0.1j, 0.3j]))
    solution = solve(SynchronizationProblem(connection, merged=merged), OPTIONS)
    expected = 1 * abs(np.exp(0.1j) - np.exp(0.4j)) ** 2
    expected += 2 * abs(np.exp(0.3j) - np.exp(1.0j)) ** 2 + 3 * abs(1 - np.exp(0.1j)) ** 2
    assert solution.energy == pytest.approx(expected, rel=1e-12)
    assert solution.lower_bound == pytest.approx(expected, rel=2e-3)
