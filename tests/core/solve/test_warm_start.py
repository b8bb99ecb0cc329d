# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Starting from given phases: the same basin, for less work, within the constraints; phases to coordinates and back."""

from dataclasses import replace

import numpy as np
import pytest

from synch_fields.core.connection import Connection
from synch_fields.core.errors import SettingError
from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.problem import SynchronizationProblem, Targets
from synch_fields.core.solve import Options, Status, solve

from ..direction_wishes import bordered_problem
from ..graphs import KINDS, fixed_stripes, half_turned_stripes, random_connection, random_constraints, random_values
from ..meshes import bent_square, bumpy_torus, double_torus, together


def lengths_of(phases):
    return np.abs(phases) if phases.ndim == 1 else np.linalg.norm(phases, axis=1)


def agreement(problem, first, second):
    """Mean inner product per node, 1 where two fields are the same up to what the problem leaves free."""
    product = np.vdot(first, second)
    is_turned = problem.is_complex and not len(problem.fixed.nodes) and not len(problem.drawn.nodes)
    return (abs(product) if is_turned else product.real) / len(first)


def constrained(kind, seed, nodes=40):
    if kind == "turned":  # flips on a tree: a gauge removes them
        random = np.random.default_rng(seed)
        fixed = Targets(np.array([2, 5]), random_values("flips", 2, random)) if seed % 2 else None
        return SynchronizationProblem(random_connection("flips", nodes, 0, seed), fixed=fixed)
    return SynchronizationProblem(random_connection(kind, nodes, 60, seed), **random_constraints(kind, nodes, seed))


# Pairs of problems on the same nodes, near each other.
FRAMES = [
    pytest.param(
        lambda: direction_problem(bumpy_torus(12), 4),
        lambda: direction_problem(stretched(bumpy_torus(12)), 4),
        id="mesh",
    ),
    pytest.param(
        lambda: bordered_problem(bent_square(), 4),
        lambda: bordered_problem(stretched(bent_square()), 4),
        id="fixed-mesh",
    ),
    pytest.param(
        lambda: half_turned_stripes(bumpy_torus(12), 0.5),
        lambda: half_turned_stripes(bumpy_torus(12), 0.505),
        id="flips",
    ),
    pytest.param(lambda: fixed_stripes(12), lambda: fixed_stripes(12, 0.505), id="fixed-flips"),
    *(
        pytest.param(
            lambda kind=kind, seed=seed: constrained(kind, seed),
            lambda kind=kind, seed=seed: reweighted(constrained(kind, seed)),
            id=f"{kind}-{seed}",
        )
        for kind in (*KINDS, "turned")
        for seed in (1, 2, 4)
    ),
]


def stretched(mesh):
    return type(mesh)(mesh.vertices * [1.0, 1.01, 0.99], mesh.triangles)


def reweighted(problem):
    random = np.random.default_rng(0)
    weights = problem.connection.weights * random.uniform(0.99, 1.01, len(problem.connection.weights))
    connection = replace(problem.connection, weights=weights)
    return SynchronizationProblem(connection, problem.mass, problem.merged, problem.fixed, problem.drawn)


# Coordinates


@pytest.mark.parametrize("kind", [*KINDS, "turned"])
@pytest.mark.parametrize("seed", range(4))
def test_coordinates_are_the_inverse_of_expand(kind, seed):
    """On fields in which every ground is 1: free, merged, fixed and drawn nodes, turned over or not."""
    problem = constrained(kind, seed, nodes=9)
    if kind == "turned":
        assert problem.is_complex and problem.turned.any()
    random = np.random.default_rng(seed)
    there = problem.unit_coordinates().reshape(-1, problem.block)
    grounds = [
        piece.rows[piece.ground * piece.block] // piece.block for piece in problem.pieces if piece.ground is not None
    ]
    free = np.setdiff1d(np.arange(len(there)), grounds)
    values = random.standard_normal((len(free), problem.block))
    values = values + 1j * random.standard_normal(values.shape) if problem.is_complex else values
    there[free] = values / np.linalg.norm(values, axis=1)[:, None]
    phases = problem.expand(there.ravel())
    np.testing.assert_allclose(problem.coordinates(phases), there.ravel(), atol=1e-14)
    np.testing.assert_allclose(problem.expand(problem.coordinates(phases)), phases, atol=1e-14)
    # Lengths do not matter.
    np.testing.assert_allclose(problem.coordinates(0.3 * phases), there.ravel(), atol=1e-14)


def test_coordinates_without_constraints_turn_with_the_phases():
    problem = direction_problem(bent_square(), 4)
    phases = random_values("circle", problem.connection.node_count, np.random.default_rng(0))
    np.testing.assert_allclose(problem.expand(problem.coordinates(phases)), phases, atol=1e-14)


@pytest.mark.parametrize("kind", KINDS)
def test_merged_nodes_that_disagree_meet_in_the_middle_by_mass(kind):
    connection = random_connection(kind, 6, 5, 1)
    constraints = {"merged": random_constraints(kind, 6, 1)["merged"]}
    mass = np.arange(1.0, 7.0)
    problem = SynchronizationProblem(connection, mass, **constraints)
    random = np.random.default_rng(3)
    phases = random_values(kind, 6, random)
    result = problem.expand(problem.coordinates(phases))
    merged = constraints["merged"]
    root = merged.roots[0]

    def carried(value, transport):
        """The value at the leader of a member's value."""
        if merged.transports.ndim == 1:
            return value * transport.conj()
        vector = np.array([value.real, value.imag]) if np.iscomplexobj(value) else value
        vector = transport.T @ vector
        return vector[0] + 1j * vector[1] if np.iscomplexobj(value) else vector

    total = mass[root] * phases[root]
    for node, transport in zip(merged.nodes, merged.transports, strict=True):
        total = total + mass[node] * carried(phases[node], transport)
    np.testing.assert_allclose(result[root], total / np.linalg.norm(np.atleast_1d(total)), atol=1e-13)
    others = np.setdiff1d(np.arange(6), [root, *merged.nodes])
    np.testing.assert_allclose(result[others], phases[others], atol=1e-14)


@pytest.mark.parametrize("kind", KINDS)
def test_vanishing_values_become_one(kind):
    problem = SynchronizationProblem(random_connection(kind, 9, 9, 1))
    phases = random_values(kind, 9, np.random.default_rng(0))
    phases[[0, 4]] = 0
    result = problem.expand(problem.coordinates(phases))
    np.testing.assert_allclose(lengths_of(result), 1, rtol=1e-14)
    np.testing.assert_allclose(np.delete(result, [0, 4], axis=0), np.delete(phases, [0, 4], axis=0), atol=1e-14)


# Starts


@pytest.mark.parametrize(("build", "_"), FRAMES[::2])
def test_a_solution_starts_itself(build, _):
    problem = build()
    cold = solve(problem)
    for start in (cold.phases, cold):
        warm = solve(problem, start=start)
        assert warm.energy <= cold.energy * (1 + 1e-12) + cold.noise
        # What ended on a saddle goes on from there.
        if warm.energy > (1 - 1e-6) * cold.energy - cold.noise:
            assert agreement(problem, warm.phases, cold.phases) >= 1 - 1e-6
        else:
            assert warm.energy == pytest.approx(cold.energy, rel=5e-3)
        assert warm.status is cold.status and warm.sdp_gap <= Options().target_gap
        assert warm.lower_bound <= cold.sdp_value * (1 + 1e-9) + cold.noise
        assert len(warm.variations) == 1


@pytest.mark.parametrize(("build", "change"), FRAMES[1::2])
def test_a_nearby_problem_stays_near(build, change):
    """Below the energy that the start has there, and closer to the start than a solve of its own need be."""
    before, problem = solve(build()), change()
    warm = solve(problem, start=before.phases)
    start = problem.expand(problem.coordinates(before.phases))
    assert warm.energy <= problem.energy(start) * (1 + 1e-12) + warm.noise
    assert agreement(problem, warm.phases, before.phases) > 0.97
    np.testing.assert_allclose(lengths_of(warm.phases), 1, rtol=1e-9)
    assert warm.lower_bound <= warm.sdp_value <= warm.energy * (1 + 1e-9) + warm.noise
    again = solve(problem, start=before)
    assert agreement(problem, again.phases, warm.phases) > 1 - 1e-6
    assert again.energy == pytest.approx(warm.energy, rel=1e-6, abs=warm.noise)
    # It is a local optimum: going on changes nothing.
    further = solve(problem, start=warm.phases)
    assert further.energy == pytest.approx(warm.energy, rel=1e-6, abs=warm.noise)


def test_a_start_is_followed_into_a_worse_basin():
    """One winding too many around a ring: a cold solve never returns it, a start there keeps it."""
    n = 30
    nodes = np.arange(n)
    edges = np.column_stack([nodes, (nodes + 1) % n])
    problem = SynchronizationProblem(Connection(n, edges, np.ones(n), np.full(n, np.exp(0.5j / n))))

    def energy(windings):
        return 4 * n * np.sin((2 * np.pi * windings - 0.5) / (2 * n)) ** 2

    assert solve(problem).energy == pytest.approx(energy(0), rel=1e-9)
    random = np.random.default_rng(0)
    for windings in (-1, 0, 2):
        angles = 2 * np.pi * windings * nodes / n + random.uniform(-0.3, 0.3, n)
        warm = solve(problem, start=np.exp(1j * angles))
        assert warm.energy == pytest.approx(energy(windings), rel=1e-9)
        assert warm.lower_bound <= energy(0) * (1 + 1e-9)


@pytest.mark.parametrize(
    "build",
    [
        lambda: direction_problem(bumpy_torus(20), 4),
        lambda: direction_problem(double_torus(2), 1),
        lambda: half_turned_stripes(bumpy_torus(20), 0.5),
    ],
)
def test_a_lifted_field_to_start_from_saves_work(build):
    problem = build()
    cold = solve(problem)
    phases, everything = solve(problem, start=cold.phases), solve(problem, start=cold)
    assert everything.iterations < 0.5 * cold.iterations
    assert everything.products < cold.products
    assert everything.iterations < phases.iterations
    assert everything.sdp_value == pytest.approx(cold.sdp_value, rel=2e-3)


def test_a_solution_of_another_method_or_shape_starts_the_phases_alone():
    problem = half_turned_stripes(bumpy_torus(12), 0.5)
    spectral = solve(problem, Options(method="spectral"))
    assert spectral.lifted is None
    warm = solve(problem, start=spectral)
    assert warm.energy < spectral.energy and warm.status is Status.CERTIFIED
    np.testing.assert_array_equal(warm.phases, solve(problem, start=spectral.phases).phases)
    # One more constraint: other coordinates, the same nodes.
    held = Targets(np.array([7]), warm.phases[[7]])
    more = SynchronizationProblem(problem.connection, problem.mass, fixed=held)
    result = solve(more, start=warm)
    np.testing.assert_allclose(result.phases[7], warm.phases[7], atol=1e-12)
    assert result.energy == pytest.approx(warm.energy, rel=1e-6)
    assert agreement(more, result.phases, warm.phases) > 1 - 1e-6
    # Without flips: complex coordinates, the lifted field was real.
    mesh = bumpy_torus(12)
    assert direction_problem(mesh, 1).is_complex
    assert solve(direction_problem(mesh, 1), start=warm).status is Status.CERTIFIED


@pytest.mark.parametrize("build", [lambda: fixed_stripes(12), lambda: bordered_problem(bent_square(), 1)])
def test_fixed_phases_stay_whatever_the_start_says(build):
    problem = build()
    count = problem.connection.node_count
    nodes, values = problem.fixed.nodes, problem.fixed.values
    random = np.random.default_rng(0)
    for start in (np.ones(count, complex), np.exp(2j) * solve(problem).phases, random_values("circle", count, random)):
        kept = start.copy()
        warm = solve(problem, start=start)
        np.testing.assert_array_equal(start, kept)
        np.testing.assert_allclose(warm.phases[nodes], values, atol=1e-12)
        assert warm.energy == pytest.approx(problem.energy(warm.phases), rel=1e-12)
        assert warm.energy < problem.energy(problem.expand(problem.coordinates(start)))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", [0, 1])
def test_constraints_hold_from_any_start(kind, seed):
    problem = constrained(kind, seed)
    warm = solve(problem, start=random_values(kind, 40, np.random.default_rng(seed)))
    np.testing.assert_allclose(lengths_of(warm.phases), 1, rtol=1e-9)
    np.testing.assert_allclose(problem.expand(problem.coordinates(warm.phases)), warm.phases, atol=1e-9)
    assert warm.lower_bound <= warm.energy * (1 + 1e-9)


@pytest.mark.parametrize("kind", ["circle", "flips", "rotations"])
def test_a_start_that_vanishes_in_places_is_a_start(kind):
    problem = constrained(kind, 7)
    start = random_values(kind, 40, np.random.default_rng(0))
    for zeros in (slice(5, 9), slice(None)):
        start[zeros] = 0
        warm = solve(problem, start=start)
        np.testing.assert_allclose(lengths_of(warm.phases), 1, rtol=1e-9)
        assert warm.energy < problem.energy(random_values(kind, 40, np.random.default_rng(1)))


def test_pieces_start_each_from_its_part():
    parts = [bumpy_torus(8), bent_square()]
    problem = direction_problem(together(*parts, loose=2), 4)
    alone = [solve(direction_problem(part, 4), Options(rounding="random", samples=1)).phases for part in parts]
    expected = [solve(direction_problem(part, 4), start=a) for part, a in zip(parts, alone, strict=True)]
    warm = solve(problem, start=np.concatenate([*alone, np.ones(2)]))
    assert warm.energy == pytest.approx(sum(s.energy for s in expected), rel=1e-6)
    assert (
        agreement(direction_problem(parts[0], 4), warm.phases[: parts[0].vertex_count], expected[0].phases) > 1 - 1e-6
    )


@pytest.mark.parametrize("count", [0, 1, 80, 82])
def test_a_start_of_another_size_is_refused(count):
    mesh = bent_square(8)
    problem = direction_problem(mesh, 1)
    assert problem.connection.node_count == 81
    with pytest.raises(SettingError, match="the problem \\(81,\\)") as caught:
        solve(problem, start=np.ones(count, complex))
    assert ": " in str(caught.value)
    small = solve(direction_problem(bent_square(4), 1))
    with pytest.raises(SettingError, match=r"shape \(25,"):
        solve(problem, start=small)


@pytest.mark.parametrize("how", ["continuation", "polish"])
def test_the_start_decides_with_either_descending_rounding(how):
    problem = direction_problem(bumpy_torus(12), 4)
    start = solve(problem, Options(rounding="random", samples=1)).phases
    warm = solve(problem, Options(rounding=how), start=start)
    np.testing.assert_allclose(warm.phases, solve(problem, start=start).phases, atol=1e-12)
    assert warm.energy < problem.energy(start)


@pytest.mark.parametrize(
    ("start", "options", "words"),
    [
        (np.ones((81, 2)), Options(), "shape"),
        (np.full(81, np.nan), Options(), "node 0"),
        (np.ones(81), Options(method="spectral"), "does not use a start"),
    ],
)
def test_a_start_that_does_not_fit_is_refused(start, options, words):
    problem = SynchronizationProblem(random_connection("circle", 81, extra=60, seed=1))
    with pytest.raises(SettingError, match=words):
        solve(problem, options, start=start)


def test_a_real_start_is_a_phase_on_problems_with_flips():
    problem = SynchronizationProblem(random_connection("flips", 30, extra=40, seed=1))
    assert solve(problem, start=np.ones(30)).energy <= problem.energy(np.ones(30, complex))
