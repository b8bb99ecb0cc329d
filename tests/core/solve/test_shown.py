# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The first field, and what a solve shows before its end."""

from types import SimpleNamespace

import numpy as np
import pytest

from synch_fields.core.errors import Cancelled
from synch_fields.core.fields import direction_field
from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.fields.patterns import PatternWishes, pattern_problem
from synch_fields.core.monitor import Monitor
from synch_fields.core.problem import SynchronizationProblem
from synch_fields.core.solution import FIRST, GLANCE
from synch_fields.core.solve import Certificate, Options, Status, solve
from synch_fields.core.solve.methods.manifolds import CirclesByFields

from ..graphs import PROBLEMS, fixed_stripes, random_connection, stripes_on
from ..meshes import bumpy_torus, cube, icosphere, square, together

# Larger than what is solved all at once: stages, and fields that get better on the way.
LARGE = [
    pytest.param(lambda: direction_problem(icosphere(4), 4), id="crosses-icosphere"),
    pytest.param(lambda: direction_problem(bumpy_torus(30), 1), id="vectors-torus"),
    pytest.param(lambda: stripes_on(bumpy_torus(30), 1, 20), id="stripes-torus"),
    pytest.param(lambda: stripes_on(icosphere(4), 2, 12), id="line-stripes-icosphere"),
    pytest.param(lambda: fixed_stripes(30, 0.2), id="fixed-stripes"),
    pytest.param(lambda: direction_problem(together(icosphere(4), cube(12), icosphere(3)), 2), id="three-pieces"),
    pytest.param(lambda: SynchronizationProblem(random_connection("signs", 900, 1500, 1)), id="signs"),
    pytest.param(lambda: SynchronizationProblem(random_connection("rotations", 500, 900, 1)), id="unit-vectors"),
]


def shown_by(problem, **options):
    """Solutions that were shown, and the one in the end."""
    shown = []
    return shown, solve(problem, Options(**options), show=shown.append)


@pytest.mark.parametrize("build", [*PROBLEMS[::2], LARGE[3], LARGE[5]])
def test_the_end_is_the_same_to_the_last_bit_whether_it_is_shown_or_not(build):
    _, found = shown_by(build())
    alone = solve(build())
    for name in ("phases", "variations", "lifted", "singular_values"):
        np.testing.assert_array_equal(getattr(found, name), getattr(alone, name))
    for name in ("energy", "lower_bound", "sdp_value", "certificate", "status", "iterations", "products"):
        assert getattr(found, name) == getattr(alone, name), name


@pytest.mark.parametrize("build", LARGE)
def test_what_is_shown_gets_better_and_its_bounds_hold(build):
    problem = build()
    shown, found = shown_by(problem)
    first, last = shown[0], shown[-1]
    assert len(shown) >= 2 and first.lower_bound == 0 and first.certificate is Certificate.NONE
    assert first.status is Status.UNCERTIFIED and first.sdp_value is None
    energies = [one.energy for one in shown]
    assert energies == pytest.approx(sorted(energies, reverse=True), rel=1e-6)
    # Of several pieces, a field on the way may have been better in one, by chance.
    slack = 1e-6 if len(problem.pieces) == 1 else 0.01
    assert found.energy <= last.energy * (1 + slack)
    # Signs begin far from what crossing them leads to.
    assert first.energy <= (1.16 if problem.is_circle or problem.block > 1 else 1.3) * found.energy
    assert last.certificate is found.certificate is not Certificate.NONE and last.status is found.status
    assert all(one.lower_bound <= found.energy for one in shown) and last.lower_bound == pytest.approx(
        found.lower_bound, rel=1e-12
    )
    assert last.sdp_value == pytest.approx(found.sdp_value, rel=1e-3)
    for one in shown:
        assert one.energy == pytest.approx(problem.energy(one.phases), rel=1e-12)
        np.testing.assert_array_equal(one.variations[0], one.phases)
        np.testing.assert_allclose(np.linalg.norm(one.phases.reshape(len(one.phases), -1), axis=1), 1)
        if len(problem.fixed.nodes):
            np.testing.assert_allclose(one.phases[problem.fixed.nodes], problem.fixed.values, atol=1e-12)


def test_the_first_field_is_that_of_a_method_of_its_own():
    problem = stripes_on(bumpy_torus(30), 1, 20)
    shown, _ = shown_by(problem, seed=3)
    first = solve(problem, Options(method=FIRST, seed=3))
    np.testing.assert_array_equal(first.phases, shown[0].phases)
    assert first.lifted is None and first.lower_bound == 0
    assert not np.array_equal(first.phases, solve(problem, Options(method=FIRST, seed=4)).phases)


def test_a_field_on_a_flat_torus_without_defects_is_found_at_first():
    """Parallel directions on a plane cost nothing; a gap of nothing is shown from the first field on."""
    shown, found = shown_by(direction_problem(square(40), 4))
    assert shown[0].energy < 1e-6 * len(shown[0].phases) and found.energy < 1e-12


def test_a_field_that_may_be_integrated_is_found_at_once():
    shown, found = shown_by(direction_problem(square(40), 4), integrate=True)
    assert shown == [] and found.energy < 1e-12 and found.iterations == 0
    assert found.certificate is Certificate.PROVED and found.status is Status.CERTIFIED


@pytest.mark.parametrize("options", [{"method": "spectral"}, {"method": "diffusion"}])
def test_other_methods_show_nothing(options):
    shown, _ = shown_by(direction_problem(icosphere(3), 4), **options)
    assert shown == []


def test_what_fits_perfectly_and_small_pieces_are_not_shown_alone():
    shown, found = shown_by(direction_problem(together(icosphere(1), icosphere(1)), 1))
    assert shown == [] and found.certificate is Certificate.PROVED


def test_the_stage_says_when_a_bound_may_be_there_and_then_the_gap():
    words = []
    monitor = Monitor(lambda stage, fraction: words.append(stage))
    monitor.expect(3.4)
    monitor.at("relaxation", 0.0)
    monitor.expect(0.5)
    monitor.check()
    found = []
    monitor.on_found = lambda energy, column: found.append((energy, column))
    monitor.found(5.0, "x")
    monitor.expect(100.0)
    monitor.proved(3.0)
    monitor.found(4.0, "y")
    monitor.check()
    assert words == ["relaxation, proof in 3 s", "relaxation", "relaxation, gap 25%"]
    assert found == [(5.0, "x"), (4.0, "y")]


def test_a_solve_that_is_stopped_while_it_shows_is_cancelled():
    shown = []
    with pytest.raises(Cancelled):
        solve(direction_problem(icosphere(4), 4), callback=lambda stage, fraction: not shown, show=shown.append)
    assert len(shown) == 1


@pytest.mark.parametrize("block", [1, 2])
def test_angles_by_the_metric_of_fields_are_those_of_the_fields_velocities(block):
    random = np.random.default_rng(block)
    nodes, columns = 7, 3
    angles, vector = random.uniform(-np.pi, np.pi, (nodes, columns)), random.standard_normal((nodes, columns))
    unit = np.exp(1j * angles)
    if block == 1:
        half = random.standard_normal((nodes, nodes)) + 1j * random.standard_normal((nodes, nodes))
        point, velocity = unit, 1j * unit * vector
    else:
        half = random.standard_normal((2 * nodes, 2 * nodes))
        point, velocity = (as_pairs(numbers) for numbers in (unit, 1j * unit * vector))
    inverse = half @ half.conj().T
    metric = SimpleNamespace(precondition=lambda fields: inverse @ fields)
    answer = inverse @ velocity
    answer = answer if block == 1 else answer[::2] + 1j * answer[1::2]
    wanted = (answer / (1j * unit)).real  # the turn that is nearest to it
    np.testing.assert_allclose(CirclesByFields(block).precondition(vector, metric, point), wanted, atol=1e-12)


def as_pairs(numbers):
    """Complex rows as pairs of real ones."""
    return np.stack([numbers.real, numbers.imag], axis=1).reshape(-1, numbers.shape[1])


@pytest.mark.parametrize(("method", "most"), [(FIRST, 1.15), (GLANCE, 1.5)])
def test_stripes_at_another_spacing_are_found_as_well(method, most):
    """The first field has about the energy of the best, whatever the number of stripes, down to three edges each."""
    mesh = bumpy_torus(30)
    lines = direction_field(mesh, 2, options=Options(method="spectral"))
    for spacing in (2.0, 0.5, 0.2):
        problem = pattern_problem(mesh, lines, PatternWishes(spacing))
        assert solve(problem, Options(method=method)).energy < most * solve(problem).energy
