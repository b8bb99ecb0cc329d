# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From a field to one of a problem that differs little."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from synch_fields.core.connection import are_flips, as_matrices, circle_transports
from synch_fields.core.errors import Cancelled
from synch_fields.core.fields import direction_field
from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.fields.patterns import PatternWishes, pattern_problem
from synch_fields.core.problem import SynchronizationProblem
from synch_fields.core.solution import DESCENT
from synch_fields.core.solve import Options, solve
from synch_fields.core.solve.angle_matrix import AngleMatrix
from synch_fields.core.solve.warm_start import Follower

from ..graphs import fixed_stripes, half_turned_stripes, random_connection, random_constraints
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
    assert follower.follow(problem)
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
        assert follower.follow(flips) and follower.follow(problem) and fresh.follow(again)
        assert (problem._embedding is flips._embedding) == adopts
        np.testing.assert_array_equal(follower.solve(problem, phases).phases, fresh.solve(again, phases).phases)
        assert not {"factor", "pieces"} & set(vars(follower._before)) and "_embedding" in vars(follower._before)


ANGLED = {
    **{f"{kind}-{seed}": (kind, seed) for kind in ("circle", "flips") for seed in (1, 2, 4, 6)},
    "turned": ("turned", 1),
}


def angled(kind, seed, nodes=30):
    """A problem with merged, fixed and drawn nodes, and some angles at which entries of the matrix vanish."""
    random = np.random.default_rng(seed)
    known = {} if kind == "turned" else random_constraints(kind, nodes, seed)
    connection = random_connection("flips" if kind == "turned" else kind, nodes, 0 if kind == "turned" else 40, seed)
    flips = are_flips(connection.transports)
    angles = random.uniform(-np.pi, np.pi, len(flips)) * (np.arange(len(flips)) % 3 > 0)
    connection = replace(connection, transports=circle_transports(angles, flips if kind != "circle" else None))
    return SynchronizationProblem(connection, random.uniform(0.5, 2, nodes), **known)


@pytest.mark.parametrize(("kind", "seed"), ANGLED.values(), ids=ANGLED)
def test_the_matrix_for_other_angles_is_the_one_that_their_problem_has(kind, seed):
    problem = angled(kind, seed)
    turned = problem.turned_by(np.random.default_rng(9).uniform(-3, 3, len(problem.connection.edges)))
    assert problem.is_complex == (kind != "flips") and len(problem.pieces) == 1
    piece, weight = problem.pieces[0].scaled()
    matrix = AngleMatrix(problem, piece, weight)
    for other in (problem, turned):
        expected = other.pieces[0].matrix.toarray() / weight
        found = matrix.at(other.connection.transports)
        assert found.dtype == (np.float32 if kind == "flips" else np.complex64)
        np.testing.assert_allclose(found.toarray(), expected, atol=1e-6)


def test_pieces_have_matrices_for_other_angles_each_of_its_own_edges():
    mesh = together(icosphere(2), bumpy_torus(12))
    problem = direction_problem(mesh, 1)
    turned = problem.turned_by(np.random.default_rng(9).uniform(-3, 3, len(problem.connection.edges)))
    for piece, other in zip(problem.pieces, turned.pieces, strict=True):
        scaled, weight = piece.scaled()
        found = AngleMatrix(problem, scaled, weight).at(turned.connection.transports)
        assert abs(found - other.matrix / weight).max() < 1e-6


@pytest.mark.parametrize("flips", [False, True])
def test_from_the_third_problem_on_steps_are_those_of_a_follower_that_assembles_each(along, flips):
    if flips:
        mesh = bumpy_torus(24)
        field = direction_field(mesh, 2)
        along = lambda spacing: pattern_problem(mesh, field, PatternWishes(spacing))  # noqa: E731
    follower, phases = Follower(), solve(along(0.5)).phases
    for number, spacing in enumerate((0.505, 0.51, 0.515, 0.52, 0.525)):
        problem = along(spacing)
        assert follower.follow(problem)
        found = follower.solve(problem, phases)
        assert ("factor" in vars(problem)) == (number < 2) and follower._repeats == (number > 0)
        fresh = Follower()
        fresh._metrics = dict(follower._metrics)
        again = fresh.solve(along(spacing), phases)
        assert found.energy == pytest.approx(again.energy, rel=1e-5)
        np.testing.assert_allclose(found.phases, again.phases, atol=2e-3)
        phases = found.phases


def test_to_another_process_a_problem_goes_without_what_can_be_made_again(along):
    problem, count = along(0.5), len(pickle.dumps(along(0.5)))
    expected = problem.pieces[0].matrix
    assert len(pickle.dumps(problem)) == count
    assert abs(pickle.loads(pickle.dumps(problem)).pieces[0].matrix - expected).max() == 0


def test_only_fields_on_the_circle_in_few_pieces_are_followed():
    assert not Follower().follow(SynchronizationProblem(random_connection("rotations", 20)))
    assert not Follower().follow(direction_problem(together(*[icosphere(1)] * 33), 4))


def test_to_another_process_it_goes_empty(along):
    follower = Follower()
    follower.solve(along(0.5), solve(along(0.5)).phases)
    assert len(pickle.dumps(follower)) < 200 and pickle.loads(pickle.dumps(follower))._metrics == {}


def test_it_is_cancelled_by_its_callback(along):
    with pytest.raises(Cancelled):
        Follower().solve(along(0.5), np.ones(3 * 24 * 24, complex), lambda stage, fraction: False)
