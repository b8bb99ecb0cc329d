# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From a field to one of a problem that differs little."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from synch_fields.core.connection import as_matrices
from synch_fields.core.errors import Cancelled
from synch_fields.core.fields import direction_field
from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.fields.patterns import PatternWishes, pattern_problem
from synch_fields.core.problem import SynchronizationProblem
from synch_fields.core.solution import DESCENT
from synch_fields.core.solve import Options, solve
from synch_fields.core.solve.warm_start import Follower

from ..graphs import fixed_stripes, half_turned_stripes, random_connection
from ..meshes import bumpy_torus, icosphere, together


@pytest.fixture(scope="module")
def along():
    """Stripes on a torus at any spacing, along the same lines."""
    mesh = bumpy_torus(24)
    field = direction_field(mesh, 1)
    return lambda spacing: pattern_problem(mesh, field, PatternWishes(spacing))


def test_some_steps_lead_near_the_local_optimum_that_descent_reaches(along):
    before = solve(along(0.5))
    problem = along(0.505)
    followed = Follower().solve(problem, before.phases)
    reached = solve(problem, Options(method=DESCENT), start=before.phases)
    start = problem.energy(before.phases)
    assert followed.energy == pytest.approx(problem.energy(followed.phases), rel=1e-12)
    np.testing.assert_allclose(np.abs(followed.phases), 1)
    assert start - followed.energy > 0.7 * (start - reached.energy) > 0


def test_the_metric_is_made_once_and_does_as_well_for_what_follows(along, monkeypatch):
    follower, fresh = Follower(), []
    follower.solve(along(0.5), solve(along(0.5)).phases)
    metric = follower._metrics[0][1]
    phases = solve(along(0.5)).phases
    for spacing in (0.505, 0.51, 0.515):
        problem = along(spacing)
        fresh.append(Follower().solve(problem, phases).energy)
        found = follower.solve(problem, phases)
        assert follower._metrics[0][1] is metric
        # With its own metric it would not come much further.
        assert found.energy < problem.energy(phases) and found.energy == pytest.approx(fresh[-1], rel=0.02)
        phases = found.phases


@pytest.mark.parametrize(
    "build",
    [
        pytest.param(lambda: fixed_stripes(24), id="fixed, with flips"),
        pytest.param(lambda: half_turned_stripes(bumpy_torus(24), 0.5), id="with flips"),
        pytest.param(lambda: direction_problem(together(icosphere(2), bumpy_torus(12)), 4), id="two pieces"),
    ],
)
def test_any_phases_are_followed_to_less_energy_and_constraints_hold(build):
    problem = build()
    random = np.random.default_rng(0)
    phases = solve(problem).phases * np.exp(0.3j * random.standard_normal(problem.connection.node_count))
    follower = Follower()
    assert follower.take_on(problem)
    found = follower.solve(problem, phases)
    assert found.energy < problem.energy(phases)
    np.testing.assert_allclose(found.phases[problem.fixed.nodes], problem.fixed.values, atol=1e-12)


def test_a_problem_takes_from_the_one_before_only_what_is_its_own():
    """The same graph and flips with other angles; then other flips, weights, and fixed values."""
    flips = fixed_stripes(24)
    transports = flips.connection.transports
    turn = as_matrices(np.full(len(transports), np.exp(0.1j)))
    others = [
        replace(flips.connection, transports=turn @ transports),
        replace(flips.connection, transports=np.where(np.arange(len(turn))[:, None, None] % 7 == 0, turn, transports)),
        replace(flips.connection, weights=2 * flips.connection.weights),
        flips.connection,
    ]
    fixed = [flips.fixed, flips.fixed, flips.fixed, replace(flips.fixed, values=-1j * flips.fixed.values)]
    phases = solve(flips).phases
    for connection, targets, adopts in zip(others, fixed, (True, False, False, False), strict=True):
        follower, fresh = Follower(), Follower()
        problem, again = (SynchronizationProblem(connection, flips.mass, fixed=targets) for _ in range(2))
        assert follower.take_on(flips) and follower.take_on(problem) and fresh.take_on(again)
        assert (problem._embedding is flips._embedding) == adopts
        np.testing.assert_array_equal(follower.solve(problem, phases).phases, fresh.solve(again, phases).phases)
        assert not {"factor", "pieces"} & set(vars(follower._before)) and "_embedding" in vars(follower._before)


def test_only_fields_on_the_circle_in_few_pieces_are_followed():
    assert not Follower().take_on(SynchronizationProblem(random_connection("rotations", 20)))
    assert not Follower().take_on(direction_problem(together(*[icosphere(1)] * 33), 4))


def test_to_another_process_it_goes_empty(along):
    follower = Follower()
    follower.solve(along(0.5), solve(along(0.5)).phases)
    assert len(pickle.dumps(follower)) < 200 and pickle.loads(pickle.dumps(follower))._metrics == {}


def test_it_is_cancelled_by_its_callback(along):
    with pytest.raises(Cancelled):
        Follower().solve(along(0.5), np.ones(3 * 24 * 24, complex), lambda stage, fraction: False)
