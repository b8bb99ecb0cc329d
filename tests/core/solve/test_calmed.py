# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Candidates from calmed problems: lower energies, the same bounds, and nothing else where nothing can be calmed."""

import pickle
from copy import copy

import numpy as np
import pytest

from synch_fields.core.connection import Connection, circle_transports
from synch_fields.core.errors import Cancelled
from synch_fields.core.fields import direction_field
from synch_fields.core.fields.directions import DirectionWishes, direction_problem
from synch_fields.core.fields.patterns import PatternWishes, pattern_problem
from synch_fields.core.problem import SynchronizationProblem
from synch_fields.core.solve import Options, Status, solve

from ..graphs import brute_force, fixed_stripes, half_turned_stripes, random_connection
from ..meshes import bent_square, bumpy_torus, double_torus, icosphere, together


def quads(mesh, count=15):
    """Quads along the spectral cross field, periods along the longest side."""
    field = direction_field(mesh, 4, options=Options(method="spectral"))
    return pattern_problem(mesh, field, PatternWishes(np.ptp(mesh.vertices, axis=0).max() / count))


def without_calmer(problem):
    twin = copy(problem)
    twin.calmer = None
    return twin


def with_calmer(problem, turns):
    twin = copy(problem)
    twin.calmer = lambda: turns
    return twin


@pytest.mark.slow
def test_calmed_candidates_lower_the_energy_in_the_mean():
    """The same relaxations and bounds: only the rounding knows of the calmed problems."""
    problem = quads(bumpy_torus(36), 25)
    calmed = [solve(problem, Options(seed=seed)) for seed in range(3)]
    alone = [solve(without_calmer(problem), Options(seed=seed)) for seed in range(3)]
    for one, other in zip(calmed, alone, strict=True):
        assert one.lower_bound == other.lower_bound and one.lower_bound < one.energy
        assert one.energy == pytest.approx(problem.energy(one.phases), rel=1e-12)
    assert np.mean([s.energy for s in calmed]) < 0.99 * np.mean([s.energy for s in alone])


PROBLEMS = [
    pytest.param(lambda: direction_problem(bumpy_torus(14), 4), id="crosses"),
    pytest.param(lambda: quads(double_torus(2)), id="quads"),
    pytest.param(lambda: direction_problem(together(bumpy_torus(10), bent_square(), loose=2), 4), id="pieces"),
]


@pytest.mark.parametrize("build", PROBLEMS)
def test_turned_problems_are_those_of_the_turned_connection(build):
    problem = build()
    turns = problem.calmer()
    connection, units = problem.connection, circle_transports(0.3 * turns)
    if not problem.connection.transports.ndim == 1:
        cosine, sine = units.real, units.imag
        units = np.stack([np.stack([cosine, -sine], -1), np.stack([sine, cosine], -1)], -2)
        transports = units @ connection.transports
    else:
        transports = units * connection.transports
    afresh = SynchronizationProblem(
        Connection(connection.node_count, connection.edges, connection.weights, transports), problem.mass
    )
    for piece, other in zip(problem.turned_by(0.3 * turns).pieces, afresh.pieces, strict=True):
        np.testing.assert_array_equal(piece.rows, other.rows)
        assert abs(piece.matrix - other.matrix).max() < 1e-12


@pytest.mark.parametrize("build", PROBLEMS)
def test_calmed_problems_keep_seeds_and_the_problem_as_they_are(build):
    problem = build()
    first = solve(problem, Options(seed=3))
    again = solve(pickle.loads(pickle.dumps(problem)), Options(seed=3))
    np.testing.assert_array_equal(first.phases, again.phases)
    assert first.energy == pytest.approx(problem.energy(first.phases), rel=1e-12)
    assert first.lower_bound <= first.sdp_value <= first.energy * (1 + 1e-9)


@pytest.mark.parametrize(
    "build", [*PROBLEMS, pytest.param(lambda: half_turned_stripes(bumpy_torus(12), 0.4), id="flips")]
)
def test_turns_of_nothing_or_without_numbers_change_nothing(build):
    problem = without_calmer(build())
    count = len(problem.connection.edges)
    alone = solve(problem)
    for turns in (np.zeros(count), np.full(count, np.nan)):
        np.testing.assert_array_equal(solve(with_calmer(problem, turns)).phases, alone.phases)


def test_what_is_calmed_already_has_no_calmer():
    mesh = icosphere(2)
    assert direction_problem(mesh, 4, DirectionWishes(singularities=0.0)).calmer is None
    assert direction_problem(mesh, 4, DirectionWishes(singularities=0.5)).calmer is not None
    field = direction_field(mesh, 2, options=Options(method="spectral"))
    assert pattern_problem(mesh, field, PatternWishes(0.5, branching=0.0)).calmer is None


@pytest.mark.parametrize("kind", ["circle", "flips"])
def test_any_turns_keep_energies_above_brute_force(kind):
    """Whatever a calmer says, the result is a field of the asked problem."""
    for seed in range(10):
        connection = random_connection(kind, 5, 8, seed)
        turns = np.random.default_rng(seed).standard_normal(len(connection.edges))
        solution = solve(with_calmer(SynchronizationProblem(connection), turns), Options(samples=16))
        exact = brute_force(connection)
        assert solution.lower_bound <= exact * (1 + 1e-9) + 1e-10
        assert solution.energy >= exact * (1 - 1e-8) - 1e-10


def test_fixed_phases_stay_with_calmed_candidates():
    problem = fixed_stripes(14)
    turns = 0.3 * np.random.default_rng(0).standard_normal(len(problem.connection.edges))
    solution = solve(with_calmer(problem, turns))
    np.testing.assert_allclose(solution.phases[problem.fixed.nodes], problem.fixed.values, atol=1e-12)


def test_calmed_candidates_can_be_cancelled_and_end_in_time():
    problem = quads(bumpy_torus(20))
    with pytest.raises(Cancelled):
        solve(problem, callback=lambda stage, _: stage.split(",")[0] != "continuation")
    assert solve(problem, Options(time_limit=1e-3)).status is Status.TIME_LIMIT
