# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sheets: which direction of one vertex goes on as which of the next, and what happens to the phases on the way."""

import numpy as np
import pytest

from synch_fields.core.fields import DirectionField, direction_field, given_directions
from synch_fields.core.matchings import after_turns, matchings

from .flat_crosses import plane_crosses, random_turns, turned_crosses, turned_phases
from .meshes import bent_square, double_torus, icosphere, square, torus


@pytest.mark.parametrize("turns", range(-5, 6))
def test_a_quarter_turn_of_a_cross_takes_x_y_to_y_and_minus_x(turns):
    """Eq. (7) written as a matrix, with the conjugation as the sign of the phase."""
    phases = np.random.default_rng(0).uniform(-9, 9, (7, 2))
    matrix = np.linalg.matrix_power(np.array([[0, 1], [-1, 0]]), turns % 4)
    np.testing.assert_array_equal(after_turns(phases, np.full(7, turns)), phases @ matrix.T)


@pytest.mark.parametrize("turns", range(-3, 4))
def test_a_half_turn_of_a_line_takes_x_to_minus_x(turns):
    phases = np.random.default_rng(0).uniform(-9, 9, (5, 1))
    np.testing.assert_array_equal(after_turns(phases, np.full(5, turns)), (-1) ** abs(turns) * phases)


def test_every_row_has_its_own_turns():
    phases = np.random.default_rng(1).uniform(-9, 9, (20, 2))
    turns = np.random.default_rng(2).integers(-6, 7, 20)
    each = [after_turns(row[None], np.array([turn]))[0] for row, turn in zip(phases, turns, strict=True)]
    np.testing.assert_array_equal(after_turns(phases, turns), each)
    # One row for many turns, and many rows for one.
    np.testing.assert_array_equal(
        after_turns(phases[0], turns[:, None])[:, 0], [after_turns(phases[0], t) for t in turns]
    )
    np.testing.assert_array_equal(after_turns(np.eye(2), 1), [[0, -1], [1, 0]])


@pytest.mark.parametrize("count", [1, 2])
def test_turns_follow_one_another(count):
    random = np.random.default_rng(3)
    phases, first, second = random.uniform(-9, 9, (30, count)), *random.integers(-4, 5, (2, 30))
    np.testing.assert_array_equal(after_turns(after_turns(phases, first), second), after_turns(phases, first + second))
    np.testing.assert_array_equal(after_turns(phases, 2 * count * first), phases)


def test_the_product_of_cosines_does_not_depend_on_the_sheet():
    random = np.random.default_rng(4)
    phases, turns = random.uniform(-9, 9, (40, 2)), random.integers(0, 4, 40)
    turned = after_turns(phases, turns)
    np.testing.assert_allclose(np.cos(turned).prod(axis=1), np.cos(phases).prod(axis=1), atol=1e-12)
    # The hand-made table of the tests is the same group.
    np.testing.assert_allclose(np.exp(1j * turned), turned_phases(np.exp(1j * phases), turns), atol=1e-12)


@pytest.mark.parametrize("symmetry", [1, 2, 4])
def test_in_the_plane_matchings_are_the_turns_between_representatives(symmetry):
    mesh = square(6)
    turns = np.random.default_rng(5).integers(0, symmetry, mesh.vertex_count)
    angles = 0.3 + 2 * np.pi / symmetry * turns
    field = given_directions(mesh, symmetry, np.column_stack([np.cos(angles), np.sin(angles), 0 * angles]))
    i, j = mesh.edges.T
    np.testing.assert_array_equal(matchings(mesh, field.angles, symmetry), (turns[j] - turns[i]) % symmetry)


@pytest.mark.parametrize("symmetry", [2, 4])
@pytest.mark.parametrize("build", [lambda: icosphere(3), torus, bent_square])
def test_the_matched_direction_is_the_nearest_one_in_space(build, symmetry):
    """On a fine mesh, where the field is smooth, it can be seen with the naked eye."""
    mesh = build()
    solved = direction_field(mesh, symmetry)
    turn = 2 * np.pi / symmetry
    shuffled = np.random.default_rng(6).integers(0, symmetry, mesh.vertex_count)
    field = DirectionField(mesh, symmetry, solved.angles + turn * shuffled)
    i, j = mesh.edges.T
    directions = np.stack([field.turned(turn * k).vectors[i] for k in range(symmetry)])
    nearness = np.einsum("kex,ex->ke", directions, field.vectors[j])
    best, second = np.sort(nearness, axis=0)[[-1, -2]]
    clear = best - second > 0.5
    assert clear.mean() > 0.95
    np.testing.assert_array_equal(matchings(mesh, field.angles, symmetry)[clear], nearness.argmax(axis=0)[clear])


@pytest.mark.parametrize("build", [lambda: icosphere(2), torus, double_torus, bent_square])
def test_other_representatives_shift_the_matchings_by_the_turns_between_them(build):
    mesh = build()
    field = direction_field(mesh, 4)
    turns = random_turns(mesh)
    i, j = mesh.edges.T
    expected = (matchings(mesh, field.angles, 4) + turns[j] - turns[i]) % 4
    np.testing.assert_array_equal(matchings(mesh, turned_crosses(field, turns).angles, 4), expected)


def test_representatives_of_a_constant_cross_are_those_that_were_asked_for():
    mesh = square(5)
    field, angles = plane_crosses(mesh, degrees=20)
    np.testing.assert_allclose(field.vectors, np.column_stack([np.cos(angles), np.sin(angles), 0 * angles]), atol=1e-12)
    assert len(np.unique(random_turns(mesh))) == 4
