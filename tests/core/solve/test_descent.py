# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Descent on products of spheres: slopes by finite differences, optima in closed form, digits; products by threads."""

import numpy as np
import pytest

from synch_fields.core.connection import Connection
from synch_fields.core.errors import Cancelled
from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.monitor import SILENT, Monitor
from synch_fields.core.problem import SynchronizationProblem
from synch_fields.core.solve.methods.descent import descend, rounding_noise
from synch_fields.core.solve.methods.manifolds import Circles, Columns, Lifted, candidates, random_columns
from synch_fields.core.solve.methods.stage import Workspace

from ..graphs import brute_force, half_turned_stripes, only_piece, random_connection
from ..meshes import bumpy_torus

# Of every sphere and every number of rows per node that a problem can have: class, kind of problem, columns.
SPHERES = [
    pytest.param(Lifted(1), "circle", 4, id="lifted-complex"),
    pytest.param(Lifted(2), "flips", 5, id="lifted-pairs"),
    pytest.param(Lifted(1), "signs", 3, id="lifted-signs"),
    pytest.param(Lifted(4), "rotations", 6, id="lifted-rotations"),
    pytest.param(Circles(1), "circle", 4, id="circles-complex"),
    pytest.param(Circles(2), "flips", 3, id="circles-pairs"),
    pytest.param(Columns(1), "signs", 3, id="columns-signs"),
    pytest.param(Columns(2), "flips", 3, id="columns-pairs"),
    pytest.param(Columns(4), "rotations", 3, id="columns-rotations"),
]
FIELDS = [p for p in SPHERES if not p.id.startswith("lifted")]


def random_point(spheres, kind, columns, seed):
    piece = only_piece(SynchronizationProblem(random_connection(kind, 12, extra=20, seed=seed)))
    random = np.random.default_rng(seed)
    return piece, spheres.normalize(random_columns(piece, columns, random)), random


def random_tangent(spheres, point, image, random):
    vector = random.standard_normal(spheres.gradient(point, image).shape)
    return spheres.tangent(point, vector)


def dense_energies(piece, point):
    """x^H L x of each column."""
    matrix = piece.matrix.toarray()
    return np.array([(column.conj() @ matrix @ column).real for column in point.T])


def unit_lengths(spheres, point):
    """Lengths of all unit vectors of a point."""
    groups = point.reshape(-1, spheres.block, point.shape[1])
    return np.linalg.norm(groups, axis=(1, 2) if isinstance(spheres, Lifted) else 1)


# Spheres


@pytest.mark.parametrize(("spheres", "kind", "columns"), SPHERES)
@pytest.mark.parametrize("precision", [np.float32, np.float64])
def test_multiples_are_added_in_place(spheres, kind, columns, precision):
    piece, point, random = random_point(spheres, kind, columns, 0)
    first, second = (random_tangent(spheres, point, piece.matrix @ point, random).astype(precision) for _ in range(2))
    shares = np.arange(1, len(spheres.inner(first, second)) + 1) / 4
    expected = first + shares * second
    spheres.add(first, shares, second)
    np.testing.assert_allclose(first, expected, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize(("spheres", "kind", "columns"), SPHERES)
def test_points_are_unit_vectors_and_fields_are_so_where_they_vanish(spheres, kind, columns):
    piece, _, random = random_point(spheres, kind, columns, seed=0)
    rough = random_columns(piece, columns, random)
    rough[: spheres.block] = 0
    point = spheres.normalize(rough)
    lengths = unit_lengths(spheres, point)
    np.testing.assert_allclose(lengths[1:], 1, rtol=1e-14)
    np.testing.assert_array_equal(lengths[0], 0 if isinstance(spheres, Lifted) else 1)
    scale = unit_lengths(spheres, rough)[1:]
    kept = point.reshape(-1, spheres.block, columns)[1:] * scale.reshape(len(scale), 1, -1)
    np.testing.assert_allclose(kept, rough.reshape(-1, spheres.block, columns)[1:], rtol=1e-13)


@pytest.mark.parametrize(("spheres", "kind", "columns"), SPHERES)
def test_energies_are_the_quadratic_form(spheres, kind, columns):
    piece, point, _ = random_point(spheres, kind, columns, seed=1)
    expected = dense_energies(piece, point)
    if isinstance(spheres, Lifted):
        expected = expected.sum(keepdims=True)
        assert spheres.multipliers(point, piece.matrix @ point).sum() == pytest.approx(expected[0], rel=1e-13)
    np.testing.assert_allclose(spheres.energies(point, piece.matrix @ point), expected, rtol=1e-12)
    np.testing.assert_allclose(piece.energy(point).sum(), expected.sum(), rtol=1e-12)


@pytest.mark.parametrize(("spheres", "kind", "columns"), SPHERES)
@pytest.mark.parametrize("seed", range(3))
def test_gradients_are_the_slopes_along_moves(spheres, kind, columns, seed):
    """The gradient is half the energy's; moving starts in the tangent's direction and stays on the spheres."""
    piece, point, random = random_point(spheres, kind, columns, seed)
    gradient = spheres.gradient(point, piece.matrix @ point)
    tangent = random_tangent(spheres, point, piece.matrix @ point, random)
    count = len(spheres.inner(tangent, tangent))
    assert count == (1 if isinstance(spheres, Lifted) else columns)

    def energies(step):
        moved = spheres.move(point, tangent, np.full(count, step))
        np.testing.assert_allclose(unit_lengths(spheres, moved), 1, rtol=1e-13)
        return spheres.energies(moved, piece.matrix @ moved)

    slopes = (8 * (energies(1e-3) - energies(-1e-3)) - (energies(2e-3) - energies(-2e-3))) / 12e-3
    scale = piece.matrix.diagonal().real.sum()
    np.testing.assert_allclose(2 * spheres.inner(gradient, tangent), slopes, atol=1e-9 * scale)
    # It is tangent itself.
    np.testing.assert_allclose(spheres.tangent(point, gradient), gradient, atol=1e-12)


@pytest.mark.parametrize(("spheres", "kind", "columns"), FIELDS)
def test_each_column_moves_by_its_own_length(spheres, kind, columns):
    piece, point, random = random_point(spheres, kind, columns, seed=4)
    tangent = random_tangent(spheres, point, piece.matrix @ point, random)
    lengths = np.array([0.0, 0.3, 1.0, 0.5][:columns])
    together = spheres.move(point, tangent, lengths)
    np.testing.assert_allclose(together[:, 0], point[:, 0], atol=1e-15)
    for k in range(columns):
        alone = spheres.move(point[:, k : k + 1], tangent[:, k : k + 1], lengths[k : k + 1])
        np.testing.assert_array_equal(together[:, k], alone[:, 0])


@pytest.mark.parametrize("kind", ["circle", "flips"])
def test_moves_on_circles_turn_by_the_arc_tangent(kind):
    spheres = candidates(1 if kind == "circle" else 2, True)
    piece, point, random = random_point(spheres, kind, 3, seed=5)
    tangent = random.standard_normal((piece.node_count, 3))
    moved = spheres.move(point, tangent, np.ones(3))
    before, after = (
        a if kind == "circle" else a.reshape(-1, 2, 3)[:, 0] + 1j * a.reshape(-1, 2, 3)[:, 1] for a in (point, moved)
    )
    np.testing.assert_allclose(np.angle(after / before), np.arctan(tangent), atol=1e-14)


def test_a_lifted_field_of_one_real_column_is_a_set_of_signs():
    spheres = Lifted(1)
    _, point, _ = random_point(spheres, "signs", 1, seed=0)
    np.testing.assert_allclose(np.abs(point), 1, rtol=1e-15)
    np.testing.assert_allclose(spheres.tangent(point, np.ones(point.shape)), 0, atol=1e-15)


def test_candidates_of_the_circle_are_turned_and_others_are_vectors():
    assert candidates(1, True) == Circles(1) and candidates(2, True) == Circles(2)
    assert candidates(1, False) == Columns(1) and candidates(4, False) == Columns(4)


# Descent


def loop(n, flux, seed=0):
    angles = np.random.default_rng(seed).uniform(-np.pi, np.pi, n)
    angles[-1] = flux - angles[:-1].sum()
    nodes = np.arange(n)
    return SynchronizationProblem(
        Connection(n, np.column_stack([nodes, (nodes + 1) % n]), np.ones(n), np.exp(1j * angles))
    )


def loop_energy(n, flux):
    """All edges miss by the same angle."""
    return n * 4 * np.sin(flux / (2 * n)) ** 2


def descent_of(piece, spheres, start, tolerance=1e-14, steps=300, **more):
    """In double precision, with the metric that the solver takes for such spheres."""
    workspace = Workspace(piece)
    shift = 0.01 * piece.stiffness
    is_circle = isinstance(spheres, Circles)
    metric = workspace.stages[0].candidate_metric(shift) if is_circle else workspace.stages[0].metric(shift)
    return descend(workspace.matrix, spheres, start, metric, tolerance, steps, SILENT, **more)


@pytest.mark.parametrize("n", [3, 8, 20])
@pytest.mark.parametrize("flux", [0.3, 2.0, 3.0])
def test_every_field_on_a_loop_ends_with_some_number_of_windings(n, flux):
    """The local optima are the windings whose edges miss by less than a quarter turn."""
    piece = only_piece(loop(n, flux))
    start = random_columns(piece, 30, np.random.default_rng(n))
    values = descent_of(piece, Circles(1), start).values
    shares = flux + 2 * np.pi * np.arange(-n, n)
    optima = loop_energy(n, shares[np.abs(shares) < n * np.pi / 2])
    relative = np.abs(values[:, None] - optima) / optima
    assert relative.min(axis=1).max() < 1e-12
    assert relative[:, optima.argmin()].min() < 1e-12


@pytest.mark.parametrize("n", [3, 12, 60])
@pytest.mark.parametrize("flux", [0.3, 2.0, 3.0])
def test_a_lifted_field_on_a_loop_finds_the_optimum(n, flux):
    piece = only_piece(loop(n, flux))
    start = random_columns(piece, 4, np.random.default_rng(n))
    (value,) = descent_of(piece, Lifted(1), start).values
    assert value == pytest.approx(loop_energy(n, flux), rel=1e-12)


@pytest.mark.parametrize("angles", [(0.5, 2.5), (1.5, -1.5), (3.0, 1.0)])
def test_vectors_on_a_loop_turn_in_the_plane_of_the_smaller_angle(angles):
    n, random = 9, np.random.default_rng(3)
    turns = np.linalg.qr(random.standard_normal((n, 4, 4)))[0]
    holonomy = np.zeros((4, 4))
    for k, angle in enumerate(angles):
        c, s = np.cos(angle), np.sin(angle)
        holonomy[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] = [[c, -s], [s, c]]
    nodes = np.arange(n)
    transports = turns[(nodes + 1) % n] @ turns.transpose(0, 2, 1)
    transports[-1] = turns[0] @ holonomy @ turns[-1].T
    problem = SynchronizationProblem(Connection(n, np.column_stack([nodes, (nodes + 1) % n]), np.ones(n), transports))
    start = random_columns(only_piece(problem), 30, random)
    values = descent_of(only_piece(problem), Columns(4), start).values
    exact = loop_energy(n, min(np.abs(angles)))
    assert values.min() == pytest.approx(exact, rel=1e-12)
    assert (values >= exact * (1 - 1e-12)).all()


@pytest.mark.parametrize("kind", ["circle", "flips", "rotations"])
@pytest.mark.parametrize("seed", range(4))
def test_the_best_of_many_descents_is_the_brute_force_optimum(kind, seed):
    connection = random_connection(kind, 7, extra=8, seed=seed)
    piece = only_piece(SynchronizationProblem(connection))
    start = random_columns(piece, 100, np.random.default_rng(seed))
    spheres = candidates(piece.block, piece.is_circle)
    values = descent_of(piece, spheres, start, tolerance=1e-13).values
    assert values.min() == pytest.approx(brute_force(connection), rel=1e-9)


@pytest.mark.parametrize(("spheres", "kind", "columns"), SPHERES)
def test_values_fall_with_every_step_and_belong_to_the_point(spheres, kind, columns):
    piece, start, _ = random_point(spheres, kind, columns, seed=6)
    before = spheres.energies(start, piece.matrix @ start)
    for steps in (0, 1, 2, 5, 20):
        descent = descent_of(piece, spheres, start, steps=steps)
        assert descent.steps <= steps and descent.products >= (descent.steps if steps else 1) * columns
        np.testing.assert_allclose(
            spheres.energies(descent.point, piece.matrix @ descent.point), descent.values, rtol=1e-12
        )
        np.testing.assert_allclose(unit_lengths(spheres, descent.point), 1, rtol=1e-13)
        assert (descent.values <= before * (1 + 1e-14)).all()
        before = descent.values


def newton_decrease(piece, phases):
    """What Newton's method would still save of the energy, by the dense Hessian in angles."""
    matrix = piece.matrix.toarray()
    agreement = phases.conj()[:, None] * matrix * phases
    gradient = 2 * agreement.imag.sum(axis=1)
    hessian = 2 * (agreement.real - np.diag(agreement.real.sum(axis=1)))
    return 0.5 * gradient @ np.linalg.lstsq(hessian, gradient, rcond=1e-9)[0]


def test_digits_in_both_precisions():
    """What a Newton step would still save is below what each precision can tell."""
    piece = only_piece(direction_problem(bumpy_torus(14), 4))
    workspace = Workspace(piece)
    stage, spheres = workspace.stages[0], Circles(1)
    metric = workspace.stages[0].candidate_metric(0.01 * piece.stiffness)
    start = random_columns(piece, 3, np.random.default_rng(0))
    single = descend(stage.matrix, spheres, start.astype(np.complex64), metric, 1e-9, 400, SILENT)
    assert single.point.dtype == np.complex64 and single.steps < 400
    double = descend(workspace.matrix, spheres, start, metric, 1e-14, 400, SILENT)
    assert double.point.dtype == np.complex128 and double.steps < 400
    for descent, digits in ((single, 2e-6), (double, 1e-12)):
        for k in range(3):
            value = float(piece.energy(descent.point[:, k : k + 1].astype(complex))[0])
            assert 0 <= newton_decrease(piece, descent.point[:, k].astype(complex)) <= digits * value
            assert descent.values[k] == pytest.approx(value, abs=1e-2 * digits * piece.matrix.diagonal().real.sum())


@pytest.mark.parametrize(
    ("build", "spheres", "digits"),
    [
        pytest.param(lambda: direction_problem(bumpy_torus(14), 4), Circles(1), 3e-6, id="crosses"),
        pytest.param(lambda: direction_problem(bumpy_torus(14), 4), Lifted(1), 5e-6, id="lifted-crosses"),
        pytest.param(lambda: half_turned_stripes(bumpy_torus(14), 0.4), Circles(2), 3e-6, id="stripes"),
        # Whose Hessian is nearly singular at the optimum: steps become as small as single precision's noise.
        pytest.param(lambda: half_turned_stripes(bumpy_torus(14), 0.4), Lifted(2), 1e-4, id="lifted-stripes"),
    ],
)
def test_single_precision_ends_near_where_double_does(build, spheres, digits):
    piece = only_piece(build())
    workspace = Workspace(piece)
    stage, shift = workspace.stages[0], 0.01 * piece.stiffness
    metric = workspace.stages[0].candidate_metric(shift) if isinstance(spheres, Circles) else stage.metric(shift)
    start = random_columns(piece, 6, np.random.default_rng(1)).astype(stage.matrix.dtype)
    single = descend(stage.matrix, spheres, start, metric, 1e-9, 400, SILENT)
    reached = spheres.normalize(single.point.astype(piece.matrix.dtype))
    energies = spheres.energies(reached, workspace.matrix @ reached)
    # Turns by rounded cosines add up: lengths of candidates drift by a millionth in a hundred steps.
    np.testing.assert_allclose(unit_lengths(spheres, single.point), 1, rtol=1e-5)
    np.testing.assert_allclose(single.values, energies, rtol=1e-5)
    further = descend(workspace.matrix, spheres, reached, metric, 1e-12, 400, SILENT)
    # Of six fields one or two may rest near a saddle, which single precision does not see.
    close = (energies - further.values) <= digits * further.values
    assert np.count_nonzero(~close) <= (2 if len(close) > 1 else 0)
    assert (further.values <= energies * (1 + 1e-12)).all()


def test_the_relaxation_has_one_value_whatever_the_start():
    piece = only_piece(direction_problem(bumpy_torus(14), 4))
    starts = (random_columns(piece, rank, np.random.default_rng(rank)) for rank in (4, 5, 8))
    values = [descent_of(piece, Lifted(1), start, tolerance=1e-13).values[0] for start in starts]
    np.testing.assert_allclose(values, values[0], rtol=1e-11)


def test_the_rounding_noise_is_about_what_energies_scatter_by():
    """Energies of one field in many coordinates differ by rounding only."""
    piece = only_piece(direction_problem(bumpy_torus(14), 1))
    stage = Workspace(piece).stages[0]
    random = np.random.default_rng(0)
    turns = np.exp(1j * random.uniform(0, 2 * np.pi, 40))
    columns = (Circles(1).normalize(random_columns(piece, 1, random)) * turns).astype(np.complex64)
    scatter = np.ptp(Circles(1).energies(columns, stage.matrix @ columns))
    assert rounding_noise(stage.matrix) / 30 < scatter < 30 * rounding_noise(stage.matrix)


@pytest.mark.parametrize("lifted", [False, True])
def test_memory_goes_on_where_a_descent_ended(lifted):
    piece = only_piece(direction_problem(bumpy_torus(14), 4))
    spheres, columns = (Lifted(1), 5) if lifted else (Circles(1), 1)
    start = random_columns(piece, columns, np.random.default_rng(3))
    whole = descent_of(piece, spheres, start, tolerance=1e-10)
    memory = []
    most = whole.steps * 3 // 4
    first = descent_of(piece, spheres, start, 1e-10, most, memory=memory)
    assert first.steps == most and len(memory) == spheres.memory
    again = list(memory)
    # A few steps further, it is ahead of a descent that has to learn the curvature anew.
    soon = descent_of(piece, spheres, first.point, 0.0, 8, memory=again)
    assert soon.values[0] < descent_of(piece, spheres, first.point, 0.0, 8).values[0] * (1 + 1e-3)
    # The same steps are taken as without an end in between.
    second = descent_of(piece, spheres, first.point, 1e-10, memory=memory)
    assert abs(most + second.steps - whole.steps) <= 2
    assert second.values[0] == pytest.approx(whole.values[0], rel=1e-8)
    # At its end nothing is left to do, which only a full memory tells at once.
    assert descent_of(piece, spheres, second.point, 1e-9, memory=memory).steps == 1
    assert descent_of(piece, spheres, second.point, 1e-9).steps > spheres.memory


def test_time_limits_end_a_descent_with_the_point_so_far_and_cancelling_raises():
    piece = only_piece(direction_problem(bumpy_torus(14), 4))
    stage = Workspace(piece).stages[0]
    start = Lifted(1).normalize(random_columns(piece, 5, np.random.default_rng(3)).astype(np.complex64))
    descent = descend(stage.matrix, Lifted(1), start, stage.metric(1.0), 1e-6, 50, Monitor(time_limit=1e-9))
    assert descent.out_of_time and descent.steps == 0
    np.testing.assert_allclose(descent.point, start, atol=1e-6)
    assert not descend(stage.matrix, Lifted(1), start, stage.metric(1.0), 1e-6, 50, Monitor(time_limit=99)).out_of_time
    with pytest.raises(Cancelled):
        descend(stage.matrix, Lifted(1), start, stage.metric(1.0), 1e-6, 50, Monitor(lambda stage, fraction: False))


def test_a_perfect_fit_is_left_alone():
    """At energy 0 no relative tolerance is ever reached: the slopes vanish."""
    piece = only_piece(loop(12, 0.0))
    point = np.exp(1j * np.angle(np.linalg.eigh(piece.matrix.toarray())[1][:, :1]))
    for spheres in (Circles(1), Lifted(1)):
        descent = descent_of(piece, spheres, point)
        assert descent.steps < 50 and abs(descent.values[0]) < 1e-13
        np.testing.assert_allclose(np.abs(descent.point), 1, rtol=1e-13)
