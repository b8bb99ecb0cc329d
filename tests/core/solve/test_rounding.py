# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From the relaxation to phases: diffusion against exact solves, crossings of known halves, variations in order."""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from synch_fields.core.algebra import workers
from synch_fields.core.connection import Connection, circle_transports
from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.monitor import SILENT, Monitor
from synch_fields.core.problem import SynchronizationProblem
from synch_fields.core.solution import Clock
from synch_fields.core.solve import Options, solve
from synch_fields.core.solve.methods import rounding
from synch_fields.core.solve.methods.diffusion import diffuse
from synch_fields.core.solve.methods.manifolds import random_columns
from synch_fields.core.solve.methods.stage import Workspace
from synch_fields.core.solve.methods.staircase import relax

from ..direction_wishes import bordered_problem
from ..graphs import KINDS, fixed_stripes, half_turned_stripes, only_piece, random_connection
from ..meshes import bent_square, bumpy_torus, double_torus, icosphere, quad_torus, together, torus


def relaxed(piece):
    """Workspace, lifted field and energy per mass of the relaxation."""
    workspace = Workspace(piece)
    relaxation = relax(workspace, Options(), SILENT, Clock())
    return workspace, relaxation.lifted, relaxation.value / piece.mass.sum()


# Diffusion

DIFFUSED = [
    pytest.param(lambda: direction_problem(bumpy_torus(14), 4), id="crosses"),
    pytest.param(lambda: bordered_problem(bent_square(), 1), id="fixed-vectors"),
    pytest.param(lambda: half_turned_stripes(bumpy_torus(14), 0.4), id="flips"),
    pytest.param(lambda: fixed_stripes(10), id="fixed-flips"),
    pytest.param(lambda: SynchronizationProblem(random_connection("signs", 60, 90, 0)), id="signs"),
    pytest.param(lambda: SynchronizationProblem(random_connection("rotations", 60, 90, 0)), id="rotations"),
]


def exact_step(piece, spheres, columns, tau):
    """(M + tau L)^-1 M x, normalized, by dense linear algebra."""
    mass = np.diag(piece.row_mass)
    return spheres.normalize(np.linalg.solve(mass + tau * piece.matrix.toarray(), mass @ columns))


@pytest.mark.parametrize("build", DIFFUSED)
@pytest.mark.parametrize(("time", "angles", "energies"), [(0.2, 0.6, 0.03), (0.03, 0.1, 1e-3), (0.005, 0.01, 1e-4)])
def test_a_step_of_diffusion_is_nearly_an_exact_solve(build, time, angles, energies):
    """From rounded fields, as a continuation meets them; long steps differ where values vanish before normalizing."""
    piece = only_piece(build())
    workspace, lifted, density = relaxed(piece)
    stage, tau = workspace.stages[0], time / density
    directions = rounding.random_directions(piece.is_complex, lifted.shape[1], 5, np.random.default_rng(0))
    start = rounding.projections(stage, lifted, directions, 5, SILENT).astype(piece.matrix.dtype)
    exact = exact_step(piece, stage.candidates, start, tau)
    result = diffuse(stage, start, [stage.metric(1 / tau)], 1, SILENT)
    assert result.dtype == stage.matrix.dtype
    errors, changes = np.linalg.norm(result - exact, axis=0), np.linalg.norm(exact - start, axis=0)
    assert (errors <= angles * changes + 1e-4).all()
    np.testing.assert_allclose(piece.energy(result.astype(exact.dtype)), piece.energy(exact), rtol=energies)
    # Two steps are two exact ones.
    twice = diffuse(stage, start, [stage.metric(4 / tau), stage.metric(16 / tau)], 1, SILENT)
    exact = exact_step(piece, stage.candidates, exact_step(piece, stage.candidates, start, tau / 4), tau / 16)
    np.testing.assert_allclose(piece.energy(twice.astype(exact.dtype)), piece.energy(exact), rtol=2 * energies)


# Projections


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("batch", [1, 10**6])
def test_projections_are_the_best_of_the_lifted_field_seen_along_directions(kind, batch, monkeypatch):
    monkeypatch.setattr(rounding, "MOST_AT_ONCE", batch)
    piece = only_piece(SynchronizationProblem(random_connection(kind, 30, 40, 1)))
    workspace, lifted, _ = relaxed(piece)
    directions = rounding.random_directions(piece.is_complex, lifted.shape[1], 20, np.random.default_rng(2))
    assert directions.shape == (lifted.shape[1], 21)
    np.testing.assert_array_equal(directions[:, 0], np.eye(lifted.shape[1])[0])
    groups = (lifted @ directions).reshape(30, piece.block, 21)
    fields = (groups / np.linalg.norm(groups, axis=1, keepdims=True)).reshape(-1, 21)
    values = piece.energy(fields)
    best = np.argsort(values)[:6]
    result = rounding.projections(workspace.stages[0], lifted, directions, 6, SILENT)
    np.testing.assert_allclose(piece.energy(result.astype(lifted.dtype)), values[best], rtol=1e-5)
    if kind != "signs":  # of which many have the same energy
        np.testing.assert_allclose(result, fields[:, best], atol=1e-4)


# Crossings


def crossings(stage, columns, density, count):
    smoothing = stage.smoothing(density / rounding.CROSSING_TIME)
    return rounding.crossings(stage, columns, smoothing, count, SILENT)


@pytest.mark.parametrize("kind", KINDS)
def test_a_column_crossed_with_itself_is_itself(kind):
    """Also where it is turned as a whole, which changes nothing of its energy."""
    piece = only_piece(SynchronizationProblem(random_connection(kind, 60, 80, 3)))
    workspace = Workspace(piece)
    stage = workspace.stages[0]
    column = stage.candidates.normalize(random_columns(piece, 1, np.random.default_rng(0)).astype(stage.matrix.dtype))
    turned = column * stage.matrix.dtype.type(np.exp(2j) if piece.is_complex else -1)
    for other in (column, turned):
        crossed = crossings(stage, np.hstack([column, other]), piece.stiffness, 5)
        np.testing.assert_allclose(crossed, column, atol=2e-6)


def two_rings(with_flips, n=30, flux=0.8, weak=1e-3):
    """Two rings that hardly touch, and two fields: each winds once, at a high price, around one of them.

    With flips, nodes are turned over at random, and a triangle with one flip, which costs nothing, keeps the solver
    from turning them back. Returns the connection, (nodes, 2) phases, and the energy of a ring without and with a
    winding.
    """
    random, count = np.random.default_rng(7), 2 * n + 2
    ring = np.column_stack([np.arange(n), (np.arange(n) + 1) % n])
    triangle = [[0, 2 * n], [2 * n, 2 * n + 1], [2 * n + 1, 0]]
    edges = np.vstack([ring, n + ring, [[n // 2, n + n // 2]], triangle])
    weights = np.where(np.arange(len(edges)) == 2 * n, weak, 1.0)
    i, j = edges.T
    angles, sheets = random.uniform(-np.pi, np.pi, count), random.random(count) < 0.5 * with_flips
    flips = np.arange(len(edges)) == (len(edges) - 1 if with_flips else -1)
    turns = angles[j] - np.where(flips, -1, 1) * angles[i]
    turns[: 2 * n] += flux / n
    transports = circle_transports(np.where(sheets[j], -turns, turns), flips ^ sheets[i] ^ sheets[j])
    fields = np.repeat(angles[:, None], 2, axis=1)
    winding = 2 * np.pi * np.arange(n) / n
    fields[:n, 0] += winding
    fields[n : 2 * n, 1] += winding
    phases = np.exp(1j * np.where(sheets, -1, 1)[:, None] * fields)
    low, high = (4 * n * np.sin(total / (2 * n)) ** 2 for total in (flux, flux - 2 * np.pi))
    return Connection(count, edges, weights, transports), phases, low, high


@pytest.mark.parametrize("with_flips", [False, True])
def test_a_crossing_takes_the_better_half_of_each(with_flips):
    weak = 1e-3
    connection, phases, low, high = two_rings(with_flips, weak=weak)
    problem = SynchronizationProblem(connection)
    assert problem.is_complex != with_flips
    piece = only_piece(problem)
    workspace = Workspace(piece)
    columns = np.column_stack([problem.coordinates(p) for p in phases.T])[piece.rows]
    alone = piece.energy(columns)
    np.testing.assert_allclose(alone, low + high, atol=4 * weak)
    assert high > 40 * low
    density = alone[0] / piece.mass.sum()
    for order in ([0, 1], [1, 0]):
        parents = columns[:, order].astype(workspace.stages[0].matrix.dtype)
        crossed = crossings(workspace.stages[0], parents, density, 5)
        assert crossed.shape == (len(columns), 1)
        assert piece.energy(crossed.astype(columns.dtype))[0] == pytest.approx(2 * low, abs=4 * weak + 1e-3 * low)


def test_every_batch_of_projections_asks_the_monitor(monkeypatch):
    monkeypatch.setattr(rounding, "MOST_AT_ONCE", 1)
    monkeypatch.setattr(workers, "WORKERS", 1)
    piece = only_piece(SynchronizationProblem(random_connection("circle", 30, 40, 1)))
    workspace, lifted, _ = relaxed(piece)
    directions = rounding.random_directions(piece.is_complex, lifted.shape[1], 39, np.random.default_rng(0))
    asked = []
    monitor = Monitor(lambda stage, fraction: asked.append(stage))
    rounding.projections(workspace.stages[0], lifted, directions, 8, monitor)
    assert len(asked) == 40 / 4 + 8 / 4


@pytest.mark.parametrize(("usable", "wanted"), [(2**33, 5), (2**20, 3), (np.inf, 5)])
def test_as_many_cores_work_at_once_as_fit_into_memory(monkeypatch, usable, wanted):
    monkeypatch.setattr(workers, "WORKERS", 8)
    monkeypatch.setattr(rounding, "room", lambda: SimpleNamespace(usable=usable))
    asked, share_out = [], rounding.share_out
    monkeypatch.setattr(rounding, "share_out", lambda *arguments: asked.append(arguments[-1]) or share_out(*arguments))
    stage = SimpleNamespace(matrix=SimpleNamespace(shape=(36_000, 36_000), dtype=np.dtype(np.complex64)), width=1)
    columns = np.arange(38)
    made = rounding._in_batches(stage, lambda batch, monitor: 2 * batch, columns, SILENT)
    np.testing.assert_array_equal(made, 2 * columns)
    assert asked == [wanted]


@pytest.mark.parametrize("count", [1, 2, 3, 25])
def test_no_batch_is_empty_however_large_the_mesh(count):
    stage = SimpleNamespace(matrix=SimpleNamespace(shape=(500_000, 500_000), dtype=np.dtype(np.complex64)), width=1)
    batches = []
    rounding._in_batches(stage, lambda batch, monitor: batches.append(batch) or batch, np.arange(count), SILENT)
    assert min(len(batch) for batch in batches) > 0 and sum(len(batch) for batch in batches) == count


def test_pairs_are_crossed_whose_better_local_energies_have_the_least_sum(monkeypatch):
    piece = only_piece(direction_problem(bumpy_torus(10), 4))
    workspace, lifted, density = relaxed(piece)
    stage = workspace.stages[0]
    directions = rounding.random_directions(piece.is_complex, lifted.shape[1], 40, np.random.default_rng(1))
    parents = rounding.projections(stage, lifted, directions, 5, SILENT)
    local = np.real(parents.conj() * (stage.matrix @ parents))
    smooth = stage.smoothing(density / rounding.CROSSING_TIME).solve(local)
    pairs = [[i, j] for i in range(5) for j in range(i + 1, 5)]
    sums = [
        sum(
            min((s, e) for s, e in zip(*node, strict=True))[1]
            for node in zip(smooth[:, pair], local[:, pair], strict=True)
        )
        for pair in pairs
    ]
    alone = np.hstack([crossings(stage, parents[:, pairs[k]], density, 1) for k in np.argsort(sums)])
    for batch in (1, 10**7):
        monkeypatch.setattr(rounding, "MOST_AT_ONCE", batch)
        np.testing.assert_allclose(crossings(stage, parents, density, 4), alone[:, :4], atol=1e-5)
        np.testing.assert_allclose(crossings(stage, parents, density, 99), alone, atol=1e-5)


def test_columns_of_the_same_energy_are_one():
    piece = only_piece(direction_problem(bent_square(), 4))
    stage = Workspace(piece).stages[0]
    columns = stage.candidates.normalize(random_columns(piece, 3, np.random.default_rng(0)).astype(np.complex64))
    many = np.hstack([columns, columns * np.complex64(np.exp(1j)), columns[:, ::-1]])
    result = rounding.distinct_columns(stage, many)
    np.testing.assert_allclose(rounding.energies(stage, result), np.sort(rounding.energies(stage, columns)), rtol=1e-5)


# Continuation and roundings


@pytest.mark.parametrize("build", DIFFUSED)
def test_a_continuation_returns_distinct_fields_best_first(build):
    piece = only_piece(build())
    workspace, lifted, density = relaxed(piece)
    stage = workspace.stages[0]
    fields, timed_out = rounding.continuation(
        workspace.stages[0], lifted, 32, density, np.random.default_rng(0), SILENT
    )
    assert not timed_out
    values = piece.energy(fields.astype(piece.matrix.dtype))
    assert 1 <= fields.shape[1] <= rounding.ALONE.kept
    assert (np.diff(values) > -1e-6 * values[:-1]).all()
    agreement = np.abs(fields.conj().T @ fields) / stage.node_count
    assert (agreement[np.triu_indices(fields.shape[1], 1)] <= rounding.SAME_FIELD + 1e-5).all()
    assert not np.abs(fields[piece.unused_rows]).any() and np.isfinite(fields).all()
    lengths = np.linalg.norm(fields.reshape(-1, piece.block, fields.shape[1]), axis=1)
    np.testing.assert_allclose(lengths, 1, atol=1e-5)
    # It is worth more than the projections that it starts from, or these were optimal.
    directions = rounding.random_directions(piece.is_complex, lifted.shape[1], 32, np.random.default_rng(0))
    projected = rounding.projections(stage, lifted, directions, 1, SILENT)
    assert values[0] <= piece.energy(projected.astype(piece.matrix.dtype))[0] * (1 + 1e-6)


VARIED = [
    pytest.param(lambda: direction_problem(bumpy_torus(10), 4), id="crosses"),
    pytest.param(lambda: half_turned_stripes(bumpy_torus(10), 0.4), id="flips"),
    pytest.param(lambda: fixed_stripes(10), id="fixed-flips"),
    pytest.param(lambda: bordered_problem(bent_square(), 4), id="fixed-crosses"),
    pytest.param(lambda: direction_problem(together(double_torus(), bumpy_torus(8), loose=2), 4), id="pieces"),
    pytest.param(lambda: SynchronizationProblem(random_connection("signs", 60, 90, 0)), id="signs"),
    pytest.param(lambda: SynchronizationProblem(random_connection("rotations", 60, 90, 0)), id="rotations"),
]


@pytest.mark.parametrize("build", VARIED)
@pytest.mark.parametrize("how", ["continuation", "polish", "random", "svd"])
def test_variations_are_other_phases_best_first(build, how):
    problem = build()
    solution = solve(problem, Options(rounding=how, samples=16))
    np.testing.assert_array_equal(solution.variations[0], solution.phases)
    energies = [problem.energy(phases) for phases in solution.variations]
    assert energies[0] == solution.energy
    assert (np.diff(energies) >= -1e-6 * energies[0]).all()
    lengths = np.abs(solution.variations) if problem.is_circle else np.linalg.norm(solution.variations, axis=-1)
    np.testing.assert_allclose(lengths, 1, atol=1e-12)
    if how == "continuation":
        assert (np.diff(energies) > 0).all()
    if how == "svd":
        assert len(energies) == 1
    for phases in solution.variations:
        np.testing.assert_allclose(phases[problem.fixed.nodes], problem.fixed.values, atol=1e-6)


def test_frustrated_problems_have_several_variations():
    for build in (VARIED[0].values[0], VARIED[1].values[0]):
        solution = solve(build())
        assert len(solution.variations) > 1
        first, second = solution.variations[:2]
        assert np.abs(np.vdot(first, second)) < 0.9995 * len(first)  # not the same turned as a whole


@pytest.mark.parametrize(
    "build",
    [
        pytest.param(lambda: direction_problem(bumpy_torus(14), 4), id="crosses"),
        pytest.param(lambda: direction_problem(torus(), 4), id="round-torus"),
        pytest.param(lambda: direction_problem(quad_torus()[0], 2), id="lines"),
        pytest.param(lambda: half_turned_stripes(bumpy_torus(14), 0.4), id="stripes"),
        pytest.param(lambda: direction_problem(icosphere(3), 1), id="sphere"),
    ],
)
def test_each_rounding_is_at_least_as_good_as_the_cheaper_one(build):
    problem = build()
    energies = {r: solve(problem, Options(rounding=r)).energy for r in ("continuation", "polish", "random", "svd")}
    assert energies["continuation"] <= energies["polish"] * (1 + 5e-3) + 1e-9
    assert energies["polish"] <= energies["random"] * (1 + 1e-6) + 1e-9
    assert energies["random"] <= energies["svd"] * (1 + 1e-6) + 1e-9


def test_continuation_gains_where_there_is_something_to_gain():
    problem = half_turned_stripes(bumpy_torus(14), 0.4)
    energies = [solve(problem, Options(rounding=r)).energy for r in ("continuation", "polish", "random", "svd")]
    assert all(a < 0.995 * b for a, b in pairwise(energies))


def test_effort_grows_with_the_size_and_ends_where_memory_would():
    sizes = [1, 1000, 5000, 10_000, 20_000, 500_000, 800_000, 1_000_000, 9_000_000]
    efforts = [rounding._effort(size) for size in sizes]
    assert efforts == pytest.approx([0.8, 0.8, 1, 2**0.5, 2, 2, 1.25, 1, 1])
