# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Many connected pieces: perfect fits found at once, small ones solved together, each as well as alone."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from synch_fields.core import monitor
from synch_fields.core.connection import Connection, circle_transports
from synch_fields.core.fields import direction_field, stripe_pattern
from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.geometry import TriangleMesh, triangle_mesh
from synch_fields.core.problem import Merged, SynchronizationProblem, Targets, join_targets
from synch_fields.core.solution import DESCENT
from synch_fields.core.solve import METHODS, Options, Status, solve
from synch_fields.core.solve.batched import components as together

from ..graphs import KINDS, random_connection, random_values, relaxation
from ..meshes import bent_square, cube, icosphere, square
from ..meshes import together as meshes_together


def side_by_side(connections):
    """One connection of several, which are not joined."""
    starts = np.cumsum([0, *(c.node_count for c in connections)])
    return Connection(
        int(starts[-1]),
        np.concatenate([c.edges + start for c, start in zip(connections, starts, strict=False)]),
        np.concatenate([c.weights for c in connections]),
        np.concatenate([c.transports for c in connections]),
    )


def gauge_transformed(kind, nodes, random, extra=8, noise=0.0):
    """A connection that random values fit, and these."""
    connection = random_connection(kind, nodes, extra, seed=int(random.integers(1e6)))
    values = random_values(kind, nodes, random)
    i, j = connection.edges.T
    if connection.transports.ndim == 1:
        transports = values[j] * values[i].conj()
    else:
        flips = np.linalg.det(connection.transports) < 0
        before = np.where(flips, values[i].conj(), values[i])
        transports = circle_transports(np.angle(values[j] * before.conj()), flips)
    if noise and transports.ndim == 1:
        transports = transports * np.exp(1j * noise * random.standard_normal(len(transports)))
    return replace(connection, transports=transports), values


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("kind", ["circle", "flips"])
def test_pieces_that_fit_perfectly_cost_no_steps(kind, method):
    random = np.random.default_rng(1)
    parts = [gauge_transformed(kind, 7, random) for _ in range(50)]
    problem = SynchronizationProblem(side_by_side([connection for connection, _ in parts]))
    solution = solve(problem, Options(method=method))
    assert solution.energy < 1e-25 and solution.lower_bound == 0 and solution.gap == 0 and solution.iterations == 0
    assert solution.status is (Status.CERTIFIED if method == "sdp" else Status.UNCERTIFIED)


@pytest.mark.parametrize("kind", ["circle", "flips"])
def test_what_is_fixed_merged_and_wished_counts_in_a_perfect_fit(kind):
    random = np.random.default_rng(2)
    (first, values), (second, others) = (gauge_transformed(kind, 9, random) for _ in range(2))
    connection, wanted = side_by_side([first, second]), np.append(values, others)
    fixed = Targets(np.array([2, 12]), wanted[[2, 12]])
    drawn = Targets(np.array([5, 15]), wanted[[5, 15]], np.ones(2))
    merged = Merged(np.array([7]), np.array([4]), wanted[[7]] * wanted[[4]].conj())
    solution = solve(SynchronizationProblem(connection, merged=merged, fixed=fixed, drawn=drawn))
    assert solution.energy < 1e-25 and solution.iterations == 0
    np.testing.assert_allclose(solution.phases, wanted, atol=1e-12)
    # A wish that contradicts what is fixed in its piece leaves an energy, there alone.
    spoiled = replace(drawn, values=drawn.values * np.array([1, -1]))
    solution = solve(SynchronizationProblem(connection, merged=merged, fixed=fixed, drawn=spoiled))
    assert solution.energy > 0.01 and solution.status is Status.CERTIFIED and solution.sdp_gap <= 0.01
    np.testing.assert_allclose(solution.phases[:9], wanted[:9], atol=1e-12)


@pytest.mark.parametrize("kind", ["circle", "flips"])
@pytest.mark.parametrize("is_fixed", [False, True])
def test_small_pieces_reach_the_relaxation_of_an_interior_point_method(kind, is_fixed):
    connections = [random_connection(kind, nodes, extra=nodes, seed=nodes) for nodes in (5, 6, 9, 14)]
    random = np.random.default_rng(0)
    fixed = Targets(np.array([1, 13]), random_values(kind, 2, random)) if is_fixed else None
    problem = SynchronizationProblem(side_by_side(connections), fixed=fixed)
    assert problem.is_complex == (kind == "circle")
    dense = [relaxation(p.matrix.toarray(), np.repeat(np.arange(p.node_count), p.block)) for p in problem.pieces]
    below, above = np.sum(dense, axis=0)
    for gap in (1e-2, 1e-4):
        solution = solve(problem, Options(target_gap=gap))
        assert "small pieces" in solution.times and solution.status is Status.CERTIFIED
        assert solution.certificate == "proved" and solution.sdp_gap <= gap
        assert below * (1 - 1.01 * gap) <= solution.lower_bound <= above * (1 + 1e-9)
        assert below * (1 - 1e-9) <= solution.sdp_value <= solution.energy * (1 + 1e-12)
        assert solution.lifted.shape == (problem.factor.shape[1], solution.rank)
        value = sum(float(piece.energy(solution.lifted[piece.rows]).sum()) for piece in problem.pieces)
        assert below * (1 - 1e-9) <= value <= below * (1 + 1.1 * gap)


@pytest.mark.parametrize("symmetry", [1, 2, 4])
def test_pieces_that_are_solved_together_are_as_good_as_alone(symmetry, monkeypatch):
    # Which triangles a problem is posed on is chosen for a mesh, not for its pieces.
    monkeypatch.setattr(triangle_mesh, "MOST_CLIPPED", np.inf)
    random = np.random.default_rng(symmetry)
    parts = [cube(1), cube(2), bent_square(3), icosphere(1), icosphere(0), square(3)]
    parts = [TriangleMesh(p.vertices + 0.1 * random.standard_normal(p.vertices.shape), p.triangles) for p in parts]
    whole = solve(direction_problem(meshes_together(*parts), symmetry))
    alone = [solve(direction_problem(part, symmetry)) for part in parts]
    assert whole.energy <= sum(s.energy for s in alone) * (1 + 1e-9)
    assert whole.sdp_value == pytest.approx(sum(s.sdp_value for s in alone), rel=1e-2)
    assert whole.status is Status.CERTIFIED and whole.lower_bound <= whole.energy
    energies = [direction_problem(meshes_together(*parts), symmetry).energy(field) for field in whole.variations]
    np.testing.assert_allclose(np.diff(energies).clip(None, 0), 0, atol=1e-9)


@pytest.mark.parametrize("symmetry", [2, 4])
def test_a_large_piece_is_what_it_is_beside_one(symmetry):
    other = icosphere(2)
    beside = solve(direction_problem(meshes_together(other, icosphere(0), loose=1), symmetry))
    as_before = solve(direction_problem(meshes_together(other, other), symmetry))
    np.testing.assert_array_equal(beside.phases[: other.vertex_count], as_before.phases[: other.vertex_count])


def test_strips_stripes_and_struts_are_certified():
    parts = [square(4, 1, 4.0, 0.5), square(9, 1, 9.0, 0.4), bent_square(2), cube(2), square(20, 1, 7.0, 0.3)]
    mesh = meshes_together(*(TriangleMesh(p.vertices + 20 * k, p.triangles) for k, p in enumerate(parts * 3)))
    field = direction_field(mesh, 2)
    pattern = stripe_pattern(mesh, field, 0.7)
    for solution in (field.solution, pattern.solution):
        assert solution.status is Status.CERTIFIED and solution.certificate == "proved" and solution.sdp_gap <= 1e-2


def test_nearly_perfect_fits_have_no_gap_that_rounding_makes():
    for noise in (1e-4, 1e-6, 1e-8, 1e-10):
        random = np.random.default_rng(3)
        connection = side_by_side([gauge_transformed("circle", 8, random, noise=noise)[0] for _ in range(20)])
        solution = solve(SynchronizationProblem(connection))
        assert solution.status is Status.CERTIFIED and 0 <= solution.sdp_gap <= 1e-2
        assert 0 <= solution.lower_bound <= solution.sdp_value <= solution.energy * (1 + 1e-9) < 1e3 * noise**2


def test_weights_of_pieces_may_differ_by_any_factor():
    connections = [random_connection("circle", 8, extra=9, seed=seed) for seed in range(6)]
    plain = [solve(SynchronizationProblem(side_by_side([c, c]))).energy / 2 for c in connections]
    scales = 10.0 ** np.array([-12, 0, 12, -6, 6, 3])
    scaled = [replace(c, weights=scale * c.weights) for c, scale in zip(connections, scales, strict=True)]
    problem = SynchronizationProblem(side_by_side(scaled))
    solution = solve(problem)
    found = problem.pieces.energies(problem.coordinates(solution.phases))
    np.testing.assert_allclose(found / scales, plain, rtol=1e-6)


@pytest.mark.parametrize("kind", ["circle", "flips"])
def test_small_pieces_descend_from_where_they_are(kind):
    connections = [random_connection(kind, 12, extra=9, seed=seed) for seed in range(4)]
    problem = SynchronizationProblem(side_by_side(connections))
    start = random_values(kind, 48, np.random.default_rng(5))
    alone = [
        solve(SynchronizationProblem(c), Options(method=DESCENT), start=start[12 * k : 12 * k + 12])
        for k, c in enumerate(connections)
    ]
    found = solve(problem, Options(method=DESCENT), start=start)
    assert found.status is Status.UNCERTIFIED
    own, begun = (problem.pieces.energies(problem.coordinates(phases)) for phases in (found.phases, start))
    assert (own < 0.9 * begun).all()
    # Descents in other metrics may end in other optima; some end in the same, and none can go on.
    assert min(abs(own - [s.energy for s in alone]) / own) < 1e-6
    for k, c in enumerate(connections):
        further = solve(SynchronizationProblem(c), Options(method=DESCENT), start=found.phases[12 * k : 12 * k + 12])
        assert further.energy == pytest.approx(own[k], rel=1e-6)
    again = solve(problem, start=found)
    np.testing.assert_allclose(again.energy, found.energy, rtol=1e-9)


def test_time_that_runs_out_among_small_pieces_leaves_phases():
    problem = SynchronizationProblem(side_by_side([random_connection("circle", 9, 9, seed) for seed in range(30)]))
    solution = solve(problem, Options(time_limit=1e-9))
    assert solution.status is Status.TIME_LIMIT and solution.lower_bound == 0 < solution.energy
    np.testing.assert_allclose(np.abs(solution.phases), 1)


@pytest.mark.parametrize("kind", ["circle", "flips"])
@pytest.mark.parametrize("has_start", [False, True])
def test_time_that_runs_out_among_small_pieces_leaves_the_best_so_far(kind, has_start, monkeypatch):
    """With a clock that goes on by one whenever it is looked at."""
    count = itertools.count()
    monkeypatch.setattr(monitor.time, "perf_counter", lambda: float(next(count)))
    problem = SynchronizationProblem(side_by_side([random_connection(kind, 9, 9, seed) for seed in range(30)]))
    start = random_values(kind, 270, np.random.default_rng(5)) if has_start else None
    for method in ("sdp", DESCENT) if has_start else ("sdp",):
        limits = (3, 10, 15, 20, 1e9)
        found = [solve(problem, Options(method=method, time_limit=limit), start=start) for limit in limits]
        assert [s.status is Status.TIME_LIMIT for s in found] == [True] * 4 + [False]
        energies = [problem.pieces.energies(problem.coordinates(solution.phases)) for solution in found]
        assert all((late <= energies[0] * (1 + 1e-9)).all() for late in energies[:-1])
        assert found[-1].energy * (1 - 1e-9) <= found[-2].energy < 0.9 * found[0].energy
        assert all(solution.lower_bound <= found[-1].energy * (1 + 1e-9) for solution in found)


def test_many_stacks_are_as_good_as_one(monkeypatch):
    problem = SynchronizationProblem(side_by_side([random_connection("circle", 9, 9, seed) for seed in range(12)]))
    one = solve(problem)
    monkeypatch.setattr(together, "AT_ONCE", 1)
    stacks = together._split_by_size(problem.pieces.sizes, np.arange(12), problem.block, Options().samples)
    assert sorted(np.concatenate(stacks)) == list(range(12)) and len(stacks) == 12
    many = solve(problem)
    assert many.energy == pytest.approx(one.energy, rel=1e-9)
    assert many.lower_bound == pytest.approx(one.lower_bound, rel=1e-2)


def fuzzed(kind, random):
    """A problem that some phases fit perfectly: pieces of any size, weights of any unit, some nodes fixed or drawn."""
    parts = [
        gauge_transformed(kind, int(random.integers(2, 12)), random, int(random.integers(0, 8)) if size else 0)
        for size in random.integers(0, 2, int(random.integers(1, 6)))
    ]
    connection, values = side_by_side([c for c, _ in parts]), np.concatenate([v for _, v in parts])
    unit = 10.0 ** random.choice([-12, 0, 12])
    spread = 10.0 ** random.uniform(-3, 3, len(connection.weights)) if random.random() < 0.5 else 1.0
    connection = replace(connection, weights=unit * spread * connection.weights)
    nodes = np.flatnonzero(random.random(len(values)) < 0.2)
    fixed = Targets(nodes, values[nodes])
    drawn = (
        join_targets(
            [
                Targets(
                    np.setdiff1d(np.arange(3), nodes),
                    values[np.setdiff1d(np.arange(3), nodes)],
                    np.full(len(np.setdiff1d(np.arange(3), nodes)), unit),
                )
            ]
        )
        if len(values) > 3
        else None
    )
    return SynchronizationProblem(connection, fixed=fixed, drawn=drawn)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("kind", ["circle", "flips"])
def test_no_bound_lies_above_the_energy_of_a_perfect_fit(kind, method):
    random = np.random.default_rng(11)
    for _ in range(10):
        problem = fuzzed(kind, random)
        solution = solve(problem, Options(method=method, seed=int(random.integers(100))))
        assert 0 <= solution.lower_bound <= solution.energy
        assert solution.spectral_bound is None or solution.spectral_bound <= solution.energy
        assert solution.energy <= 1e-8 * problem.pieces.weights.sum()
        assert method != "sdp" or (solution.status is Status.CERTIFIED and solution.gap <= 1e-2)


@pytest.mark.parametrize("kind", KINDS)
def test_other_phases_of_the_problem_have_a_bound_below_them(kind):
    solution = solve(SynchronizationProblem(random_connection(kind, 6, extra=0, seed=1)))
    assert replace(solution, energy=0.0).lower_bound == 0
    spectral = solve(SynchronizationProblem(random_connection(kind, 6, extra=4, seed=1)), Options(method="spectral"))
    lower = replace(spectral, energy=0.5 * spectral.lower_bound)
    assert lower.lower_bound == lower.spectral_bound == lower.energy and lower.gap == 0


@pytest.mark.parametrize("kind", ["circle", "flips"])
def test_noise_is_a_share_of_all_weights_whether_they_cancel_or_not(kind):
    random = np.random.default_rng(4)
    connection, values = gauge_transformed(kind, 6, random)
    connection = replace(connection, weights=1e12 * connection.weights)
    free, held = SynchronizationProblem(connection), SynchronizationProblem(connection, fixed=Targets(range(6), values))
    block = free.block
    assert free.pieces.scales.sum() == pytest.approx(2 * block * connection.weights.sum())
    assert free.pieces.weights.sum() == pytest.approx(free.pieces.scales.sum())
    solution = solve(held)
    assert held.pieces.weights.sum() < 1e-6 * held.pieces.scales.sum() <= free.pieces.scales.sum()
    assert solution.energy < solution.noise and solution.gap == 0 and solution.status is Status.CERTIFIED


def test_a_heavy_ground_has_a_phase_in_the_spectral_relaxation():
    random = np.random.default_rng(6)
    connection = side_by_side([random_connection("flips", 14, extra=9, seed=seed) for seed in range(3)])
    fixed = Targets(np.array([0, 20, 30]), random_values("flips", 3, random))
    mass = np.ones(42)
    mass[fixed.nodes] = 1e3
    problem = SynchronizationProblem(connection, mass, fixed=fixed)
    solution = solve(problem, Options(method="spectral"))
    assert 0 < solution.lower_bound <= solution.energy < 4 * connection.weights.sum()
    np.testing.assert_allclose(solution.phases[fixed.nodes], fixed.values, atol=1e-12)
