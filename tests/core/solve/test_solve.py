# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a caller of solve() relies on: reproducible, additive over pieces, stoppable, with every method and rounding."""

import json
import pickle
import time
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from synch_fields.core.connection import Connection
from synch_fields.core.errors import Cancelled, SettingError
from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.problem import SynchronizationProblem
from synch_fields.core.solution import ROUNDINGS
from synch_fields.core.solve import METHODS, Certificate, Options, Status, solve, solver

from ..graphs import KINDS, random_connection, random_values
from ..meshes import bent_square, bumpy_torus, cube, double_torus, icosphere, square, together, torus


def assert_consistent(solution, problem):
    """Unit phases, and the energy that these phases have."""
    lengths = np.abs(solution.phases) if solution.phases.ndim == 1 else np.linalg.norm(solution.phases, axis=1)
    np.testing.assert_allclose(lengths, 1, atol=1e-9)
    assert solution.energy == pytest.approx(problem.energy(solution.phases), rel=1e-12)
    assert 0 <= solution.lower_bound <= solution.energy * (1 + 1e-9) + 1e-12


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("kind", KINDS)
def test_every_method_solves_every_kind(method, kind):
    connection = random_connection(kind, 30, extra=40, seed=5)
    problem = SynchronizationProblem(connection)
    solution = solve(problem, Options(method=method))
    assert_consistent(solution, problem)
    random = np.random.default_rng(0)
    by_chance = min(connection.energy(random_values(kind, 30, random)) for _ in range(50))
    assert solution.energy < 0.8 * by_chance
    assert solution.lower_bound > 0
    if method == "sdp":
        assert solution.status is Status.CERTIFIED and solution.spectral_bound is None
        assert solution.sdp_gap <= Options().target_gap
    else:
        assert solution.status is Status.UNCERTIFIED and solution.sdp_value is None and solution.sdp_gap is None
        assert solution.spectral_bound == solution.lower_bound


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("seed", [0, 3])
def test_the_same_seed_gives_the_same_result(method, seed):
    problem = direction_problem(bent_square(), 4)
    options = Options(method=method, seed=seed)
    first = solve(problem, options)
    second = solve(direction_problem(bent_square(), 4), options)
    np.testing.assert_array_equal(first.phases, second.phases)
    assert (first.energy, first.lower_bound, first.sdp_value) == (second.energy, second.lower_bound, second.sdp_value)
    assert first.iterations == second.iterations and first.products == second.products


def test_another_seed_gives_other_candidates_and_the_same_bound():
    problem = direction_problem(double_torus(), 4)
    solutions = [solve(problem, Options(seed=seed, rounding="random", samples=1)) for seed in range(6)]
    assert len({round(s.energy, 6) for s in solutions}) > 1
    bounds = [s.lower_bound for s in solutions]
    np.testing.assert_allclose(bounds, bounds[0], rtol=2.1e-3)


def test_energies_and_bounds_of_pieces_add_up():
    parts = [icosphere(2), torus(around=12, across=8), cube(3)]
    whole = solve(direction_problem(together(*parts), 4))
    alone = [solve(direction_problem(part, 4)) for part in parts]
    assert whole.lower_bound == pytest.approx(sum(s.lower_bound for s in alone), rel=1e-3)
    assert whole.sdp_value == pytest.approx(sum(s.sdp_value for s in alone), rel=1e-3)
    assert whole.energy == pytest.approx(sum(s.energy for s in alone), rel=0.02)
    assert whole.lifted.shape == (sum(p.vertex_count for p in parts), whole.rank)
    np.testing.assert_allclose(np.linalg.norm(whole.lifted, axis=1), 1, rtol=1e-5)


@pytest.mark.parametrize("method", METHODS)
def test_isolated_nodes_are_tolerated(method):
    # A torus whose least eigenvalue is single: of a sphere's eigenvectors each order of the rows has another.
    mesh = together(bumpy_torus(8), square(4), loose=3)
    problem = direction_problem(mesh, 1)
    solution = solve(problem, Options(method=method))
    assert_consistent(solution, problem)
    np.testing.assert_array_equal(solution.phases[-3:], 1)
    assert solution.energy == pytest.approx(solve(direction_problem(bumpy_torus(8), 1), Options(method=method)).energy)


@pytest.mark.parametrize("method", METHODS)
def test_nodes_without_any_edge_have_the_phase_one(method):
    problem = SynchronizationProblem(Connection(4, np.zeros((0, 2), int), np.zeros(0), np.zeros(0, complex)))
    solution = solve(problem, Options(method=method))
    np.testing.assert_array_equal(solution.phases, np.ones(4))
    assert solution.energy == 0 and solution.lower_bound == 0 and solution.gap == 0


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("kind", KINDS)
def test_perfect_fits_are_found_by_every_method(method, kind):
    """Zero energy leaves no scale for the solver's shifts."""
    for nodes in (2, 5, 40):
        problem = SynchronizationProblem(random_connection(kind, nodes, extra=0, seed=nodes))
        solution = solve(problem, Options(method=method))
        assert_consistent(solution, problem)
        assert solution.energy < 1e-10


def test_a_field_that_integrates_is_found_and_proved_without_a_relaxation():
    """A connected graph whose transports lead from one random field to itself: any spanning tree has the answer."""
    connection = random_connection("circle", 500, extra=900, seed=2)
    values = random_values("circle", 500, np.random.default_rng(1))
    i, j = connection.edges.T
    transports = values[j] * values[i].conj()
    integrating = Options(integrate=True)
    solution = solve(SynchronizationProblem(replace(connection, transports=transports)), integrating)
    off = solution.phases * values.conj()
    np.testing.assert_allclose(off, off[0], atol=1e-12)
    assert solution.iterations == solution.products == 0 and solution.energy < 1e-20
    assert solution.certificate is Certificate.PROVED and solution.status is Status.CERTIFIED
    # With one contradiction it has to be relaxed.
    transports[np.isin(connection.edges, connection.edges[-1]).all(axis=1)] *= -1
    assert solve(SynchronizationProblem(replace(connection, transports=transports)), integrating).iterations > 0


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("count", [2, 4, 40])
def test_equal_phases_on_an_unweighted_loop(method, count):
    """Whole numbers throughout: a factorization meets exactly singular pivots where others meet rounding noise."""
    edges = np.column_stack([np.arange(count), (np.arange(count) + 1) % count])
    for transports in (np.ones(count, complex), np.ones((count, 1, 1)), np.tile(np.eye(4), (count, 1, 1))):
        problem = SynchronizationProblem(Connection(count, edges, np.ones(count), transports))
        solution = solve(problem, Options(method=method))
        assert_consistent(solution, problem)
        assert solution.energy < 1e-10


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("stop_at", [1, 2, 10])
def test_cancelling_raises_at_the_next_question(method, stop_at):
    asked = []

    def callback(stage, fraction):
        asked.append((stage, fraction))
        return len(asked) < stop_at

    problem = direction_problem(torus(), 4)
    if method == "spectral" and stop_at > 1:
        pytest.skip("asks once a piece")
    with pytest.raises(Cancelled) as caught:
        solve(problem, Options(method=method), callback)
    assert len(asked) == stop_at
    assert "\n" not in str(caught.value) and str(caught.value)


def test_progress_is_a_rising_share():
    asked = []
    solve(direction_problem(together(icosphere(2), torus()), 4), callback=lambda *a: asked.append(a) or True)
    fractions = [fraction for _, fraction in asked]
    assert fractions == sorted(fractions) and 0 <= fractions[0] and fractions[-1] <= 1
    assert len({stage for stage, _ in asked}) >= 3


@pytest.mark.parametrize("method", METHODS)
def test_a_time_limit_that_has_passed_leaves_usable_phases(method):
    problem = direction_problem(together(bent_square(12), torus()), 4)
    start = time.perf_counter()
    solution = solve(problem, Options(method=method, time_limit=1e-9))
    assert time.perf_counter() - start < 2
    assert_consistent(solution, problem)
    assert solution.status is Status.TIME_LIMIT


def test_progress_is_told_in_plain_numbers():
    """NumPy's own are no JSON, and what they are compared with are no plain truths."""
    kinds = set()
    solve(direction_problem(together(bent_square(6), bumpy_torus(10)), 4), callback=lambda _, f: kinds.add(type(f)))
    assert kinds == {float}


@pytest.mark.parametrize("method", ["sdp", "descent"])
def test_a_time_limit_that_has_passed_leaves_the_start(method):
    problem = direction_problem(torus(), 4)
    start = solve(problem)
    solution = solve(problem, Options(method=method, time_limit=1e-9), start=start)
    assert solution.status is Status.TIME_LIMIT and solution.energy == pytest.approx(start.energy, rel=1e-9)
    np.testing.assert_allclose(solution.phases, start.phases, atol=1e-6)


@pytest.mark.parametrize("questions", [3, 10, 30, 60, 130])
def test_a_time_limit_at_any_moment_leaves_usable_phases(questions, monkeypatch):
    """The clock jumps past the deadline after a number of questions, wherever the solver is then."""
    from synch_fields.core import monitor

    class Jumping:
        count = 0

        @classmethod
        def perf_counter(cls):
            cls.count += 1
            return 1e9 if cls.count > questions else 0.0

    # A piece that is solved with others, and one that is calmed.
    problem = direction_problem(together(bent_square(6), bumpy_torus(10)), 4)
    full = solve(problem)
    monkeypatch.setattr(monitor, "time", Jumping)
    solution = solve(problem, Options(time_limit=1.0))
    assert_consistent(solution, problem)
    assert solution.status is Status.TIME_LIMIT
    assert solution.lower_bound <= full.sdp_value * (1 + 1e-9)


def test_a_generous_time_limit_changes_nothing():
    problem = direction_problem(bent_square(), 4)
    np.testing.assert_array_equal(solve(problem, Options(time_limit=1000)).phases, solve(problem).phases)


@pytest.mark.parametrize("build", [double_torus, lambda: icosphere(3), lambda: cube(6)])
@pytest.mark.parametrize("symmetry", [1, 4])
def test_roundings_are_worth_their_effort(build, symmetry):
    problem = direction_problem(build(), symmetry)
    energies = {r: solve(problem, Options(rounding=r)).energy for r in ROUNDINGS}
    assert energies["random"] <= energies["svd"] * (1 + 1e-6)  # in single precision
    assert energies["polish"] <= energies["random"] * (1 + 1e-9)
    assert energies["continuation"] <= energies["random"] * (1 + 1e-9)
    assert energies["continuation"] <= energies["polish"] * 1.05


def test_more_samples_never_hurt_random_rounding():
    problem = direction_problem(double_torus(), 4)
    few, many = (solve(problem, Options(rounding="random", samples=s)).energy for s in (1, 256))
    assert many < few


def test_the_relaxation_rounds_better_than_the_eigenvector():
    problem = direction_problem(double_torus(), 1)
    assert solve(problem).energy < solve(problem, Options(method="spectral")).energy


def test_polished_phases_are_a_local_optimum():
    problem = direction_problem(double_torus(), 4)
    solution = solve(problem)
    (piece,) = problem.pieces
    phases = solution.phases[piece.rows]
    residual = (np.conj(phases) * (piece.matrix @ phases)).imag
    assert np.abs(residual).max() < 1e-3 * np.abs(piece.matrix.diagonal()).max()
    # Turning any one phase a little does not help.
    for node in range(0, len(solution.phases), 17):
        for angle in (-0.05, 0.05):
            phases = solution.phases.copy()
            phases[node] *= np.exp(1j * angle)
            assert problem.energy(phases) > solution.energy


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (dict(method="magic"), "method 'magic'"),
        (dict(rounding="none"), "rounding 'none'"),
        (dict(target_gap=0.0), "target gap"),
        (dict(target_gap=1e-8), "target gap is 1e-08: give a share from 1e-06"),
        (dict(target_gap=1.0), "target gap"),
        (dict(target_gap=float("nan")), "target gap"),
        (dict(samples=0), "samples"),
        (dict(time_limit=0.0), "time limit"),
        (dict(time_limit=-1.0), "time limit"),
        (dict(time_limit=float("nan")), "time limit"),
    ],
)
def test_options_out_of_range_are_refused(change, word):
    with pytest.raises(SettingError, match=word) as caught:
        solve(direction_problem(icosphere(1), 1), replace(Options(), **change))
    assert ": " in str(caught.value) and "\n" not in str(caught.value)


def test_pieces_have_the_weakest_certificate_and_the_most_severe_status(monkeypatch):
    """Whatever order the kinds are declared in, and whichever piece comes first."""
    weakest_first = [Certificate.NONE, Certificate.ESTIMATED, Certificate.PROVED]
    mildest_first = [
        Status.CERTIFIED,
        Status.ESTIMATED,
        Status.TARGET_GAP_NOT_REACHED,
        Status.MAX_RANK,
        Status.TIME_LIMIT,
        Status.UNCERTIFIED,
    ]
    assert set(weakest_first) == set(Certificate) and set(mildest_first) == set(Status)
    solved, given = solver._solve_piece, iter(())
    monkeypatch.setattr(solver, "_solve_piece", lambda *arguments: replace(solved(*arguments), **next(given)))
    problem = direction_problem(together(cube(4), cube(4)), 1)  # too large to be solved together
    for name, ranked in (("certificate", weakest_first), ("status", mildest_first[::-1])):
        for first, second in combinations(ranked, 2):
            for pair in ((first, second), (second, first)):
                given = iter([{name: kind} for kind in pair])
                assert getattr(solve(problem, Options(rounding="svd")), name) is first


def test_reports_say_certificates_and_statuses_in_words():
    solution = solve(direction_problem(cube(2), 2))
    assert json.dumps([solution.certificate, solution.status.value]) == '["proved", "certified"]'
    assert f"{solution.certificate}" == "proved" and Status("certified") is Status.CERTIFIED
    assert pickle.loads(pickle.dumps(solution)).certificate is Certificate.PROVED
