# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is left of lines that a hand draws."""

from itertools import pairwise

import numpy as np
import pytest

from synch_fields.core.geometry.drawn import parts, simplify_polyline, smooth_polyline


def flat(x, y):
    return np.column_stack([x, y, np.zeros(len(x))])


def test_a_line_is_taken_apart_where_it_jumps_and_single_points_are_left_out():
    points = flat([0, 1, 2, 9, 10, 30, 50], np.zeros(7))
    first, second = parts(points, np.full(6, 2.0))
    np.testing.assert_array_equal(first, points[:3])
    np.testing.assert_array_equal(second, points[3:5])
    assert len(parts(points, np.full(6, 100.0))) == 1


@pytest.mark.parametrize("times", [1, 5])
def test_waves_of_a_length_shrink_by_their_factor_and_ends_stay(times):
    """(1 + cos k) / 2 each time, for k radians from point to point, where both ends are nodes of the wave."""
    k = np.pi / 8
    numbers = np.arange(33)
    points = flat(numbers, np.sin(k * numbers))
    found = smooth_polyline(points, times)
    np.testing.assert_allclose(found, flat(numbers, ((1 + np.cos(k)) / 2) ** times * np.sin(k * numbers)), atol=1e-12)


def test_points_with_no_share_stay():
    points = flat(np.arange(9), np.arange(9) % 2)
    shares = np.where(np.arange(9) < 4, 0.0, 1.0)
    found = smooth_polyline(points, 1, shares)
    np.testing.assert_array_equal(found[:4], points[:4])
    np.testing.assert_allclose(found[4:8, 1], 0.5)


def distance_to(points, line):
    """From points to a polyline, by its pieces one after the other."""
    best = np.full(len(points), np.inf)
    for start, end in pairwise(line):
        for number, point in enumerate(points):
            share = np.clip((point - start) @ (end - start) / ((end - start) @ (end - start)), 0, 1)
            best[number] = min(best[number], np.linalg.norm(point - start - share * (end - start)))
    return best


@pytest.mark.parametrize("tolerance", [0.3, 0.03, 0.003])
def test_nothing_that_is_left_out_lies_far_from_what_is_kept(tolerance):
    angles = np.linspace(0, 5, 400)
    points = np.column_stack([np.cos(angles), np.sin(angles), 0.1 * angles])
    kept = simplify_polyline(points, tolerance, np.inf)
    assert kept[0] == 0 and kept[-1] == 399
    assert distance_to(points, points[kept]).max() <= tolerance
    # A chord of an arc of radius 1 that is off by t spans an angle of about 2 root(2 t).
    assert len(kept) < 2 * 5 / (2 * np.sqrt(2 * tolerance)) + 4


def test_a_straight_line_needs_its_ends_and_no_piece_is_too_long():
    points = flat(np.linspace(0, 1, 101), np.zeros(101))
    assert simplify_polyline(points, 1e-9, np.inf).tolist() == [0, 100]
    kept = simplify_polyline(points, 1e-9, 0.2)
    assert np.diff(points[kept, 0]).max() <= 0.2 + 1e-12 and len(kept) <= 10
    assert simplify_polyline(points[:2], 0.0, 0.001).tolist() == [0, 1]


def test_points_in_one_place_are_no_trouble():
    points = np.ones((5, 3))
    assert simplify_polyline(points, 0.1, 1.0).tolist() == [0, 4]
