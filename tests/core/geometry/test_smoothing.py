# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Smoothing of lines: their ends are held, and steps there and back keep their size."""

import numpy as np
import pytest

from synch_fields.core.geometry.smoothing import smooth_line

THERE, THERE_AND_BACK = (0.5,), (0.33, -0.34)


@pytest.mark.parametrize("steps", [THERE, THERE_AND_BACK])
def test_smoothing_holds_the_ends(steps):
    points = np.random.default_rng(0).standard_normal((9, 3))
    moved = smooth_line(points, False, 5, steps)
    np.testing.assert_array_equal(moved[[0, -1]], points[[0, -1]])
    assert np.abs(np.diff(moved, 2, axis=0)).sum() < np.abs(np.diff(points, 2, axis=0)).sum()


@pytest.mark.parametrize("steps", [THERE, THERE_AND_BACK])
def test_waves_around_a_closed_line_shrink_as_often_as_the_steps_say(steps):
    """Each wave of a closed line of equal steps is multiplied by 1 - s (1 - cos) with every step s."""
    turn = np.arange(12) * 2 * np.pi / 12
    for waves in (1, 2, 6):
        factor = np.prod([1 - step * (1 - np.cos(2 * np.pi * waves / 12)) for step in steps]) ** 5
        line = np.column_stack([np.cos(waves * turn), np.sin(waves * turn), np.cos(waves * turn + 1)])
        np.testing.assert_allclose(smooth_line(line, True, 5, steps), factor * line, atol=1e-12)


def test_steps_there_and_back_take_off_what_changes_from_each_to_the_next_and_leave_the_size():
    turn = np.arange(12) * 2 * np.pi / 12
    circle = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    jagged = circle + 0.2 * np.array([0, 0, 1]) * (-1) ** np.arange(12)[:, None]
    moved = smooth_line(jagged, True, 5, THERE_AND_BACK)
    assert np.abs(moved[:, 2]).max() < 0.02
    assert np.linalg.norm(moved[:, :2], axis=1) == pytest.approx(1, abs=0.02)
