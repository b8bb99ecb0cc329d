# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Linking numbers and writhe of knots and links whose invariants are known, and counted from crossings."""

import numpy as np
import pytest

from synch_fields.core.extract.vortices import linking_numbers as module
from synch_fields.core.extract.vortices.filaments import Filament
from synch_fields.core.extract.vortices.linking_numbers import linking_number, linking_numbers, writhe

from ...flows import ring_curve

TURN = np.linspace(0, 2 * np.pi, 120, endpoint=False)


def torus_curve(p, q, offset=0.0, turns=TURN):
    """Runs p times around the axis and q times around the tube, to the right for positive q."""
    radius = 2 + np.cos(q * turns + offset)
    return np.column_stack([radius * np.cos(p * turns), radius * np.sin(p * turns), -np.sin(q * turns + offset)])


def borromean():
    """Three ellipses in the coordinate planes."""
    flat = np.column_stack([2 * np.cos(TURN), np.sin(TURN), 0 * TURN])
    return [np.roll(flat, turn, axis=1) for turn in range(3)]


def counted(first, second, directions):
    """Mean over directions of the signed crossings of two polygons as they are seen from there."""
    total = 0.0
    for view in directions:
        u = np.cross(view, [0.3, 0.5, 0.8])
        u /= np.linalg.norm(u)
        v = np.cross(view, u)
        a, b = (np.column_stack([curve @ u, curve @ v]) for curve in (first, second))
        da, db = np.roll(a, -1, axis=0) - a, np.roll(b, -1, axis=0) - b
        cross = da[:, None, 0] * db[None, :, 1] - da[:, None, 1] * db[None, :, 0]
        away = b[None] - a[:, None]
        with np.errstate(all="ignore"):
            s = (away[..., 0] * db[None, :, 1] - away[..., 1] * db[None, :, 0]) / cross
            t = (away[..., 0] * da[:, None, 1] - away[..., 1] * da[:, None, 0]) / cross
        met = (s > 0) & (s < 1) & (t > 0) & (t < 1)
        if first is second:
            gap = np.abs(np.subtract.outer(np.arange(len(a)), np.arange(len(a))))
            met &= (gap > 1) & (gap < len(a) - 1)
        heights = [(curve @ view, (np.roll(curve, -1, axis=0) - curve) @ view) for curve in (first, second)]
        (low, rise), (other_low, other_rise) = heights
        over = low[:, None] + s * rise[:, None] > other_low + t * other_rise
        total += (np.sign(cross) * np.where(over, 1, -1) * met).sum()
    return total / len(directions)


def views(count):
    """Directions evenly over the sphere (a spiral)."""
    z = 1 - (2 * np.arange(count) + 1) / count
    angle = np.pi * (1 + np.sqrt(5)) * np.arange(count)
    return np.column_stack([np.sqrt(1 - z**2) * np.cos(angle), np.sqrt(1 - z**2) * np.sin(angle), z])


@pytest.mark.parametrize("links", [-3, -1, 1, 2])
def test_linking_numbers_of_torus_links_are_their_turns(links):
    first, second = torus_curve(1, links), torus_curve(1, links, np.pi)
    assert linking_number(first, second) == pytest.approx(links, abs=1e-6)
    assert linking_number(first, second[::-1]) == pytest.approx(-links, abs=1e-6)
    assert counted(first, second, views(3)) / 2 == pytest.approx(links)


def test_rings_and_borromean_rings_are_linked_as_they_are():
    first, second = ring_curve(1.0)[:-1], ring_curve(1.0, (1, 0, 0), 1)[:-1]
    assert abs(linking_number(first, second)) == pytest.approx(1, abs=1e-9)
    assert linking_number(first, second + [5, 0, 0]) == pytest.approx(0, abs=1e-9)
    rings = borromean()
    for k in range(3):
        assert linking_number(rings[k], rings[k - 1]) == pytest.approx(0, abs=1e-9)


def test_writhe_is_the_mean_of_the_crossings_seen():
    assert writhe(ring_curve(1.0)[:-1]) == pytest.approx(0, abs=1e-9)
    for p, q in ((2, 3), (2, -3), (3, 2)):
        knot = torus_curve(p, q)
        assert writhe(knot) == pytest.approx(counted(knot, knot, views(400)) / 2, abs=0.03)
        assert writhe(knot) == pytest.approx(-writhe(knot * [1, 1, -1]), abs=1e-9)


def test_helicity_of_linked_rings_is_twice_their_linking():
    rings = [Filament(ring_curve(1.0)[:-1], 2.0, True), Filament(ring_curve(1.0, (1, 0, 0), 1)[:-1], 3.0, True)]
    open_line = Filament(np.array([[0, 0, -1.0], [0, 0, 1.0]]), 1.0, False)
    found = linking_numbers([rings[0], open_line, rings[1]], np.zeros(3))
    assert found.loops == (0, 2) and abs(found.numbers[0, 1]) == 1
    np.testing.assert_array_equal(found.numbers, found.numbers.T)
    assert found.helicity == pytest.approx(2 * 2 * 3 * found.numbers[0, 1], abs=1e-6)
    assert linking_numbers([open_line], np.zeros(3)).helicity == 0


def test_in_a_periodic_box_images_count():
    """A ring through its own image, and one that a ring of the next box goes through."""
    first = Filament(ring_curve(1.0)[:-1], 1.0, True)
    second = Filament(ring_curve(1.0, (1, 0, 0), 1)[:-1] + [30, 0, 0], 1.0, True)
    alone = linking_numbers([first, second], np.zeros(3)).numbers
    assert alone[0, 1] == 0
    assert abs(linking_numbers([first, second], np.array([10.0, 10, 10])).numbers[0, 1]) == 1
    assert linking_numbers([first, second], np.array([12.3, 10, 10])).numbers[0, 1] == 0


def test_too_many_points_are_left_alone(monkeypatch):
    monkeypatch.setattr("synch_fields.core.extract.vortices.linking_numbers.MOST_PAIRS", 100)
    assert linking_numbers([Filament(ring_curve(1.0)[:-1], 1.0, True)], np.zeros(3)) is None


def test_long_filaments_count_by_their_middles_where_they_are_far(monkeypatch):
    """Two linked rings and a trefoil against the integral that is exact for polygons."""
    turn = np.linspace(0, 2 * np.pi, 300, endpoint=False)
    trefoil = np.column_stack(
        [np.sin(turn) + 2 * np.sin(2 * turn), np.cos(turn) - 2 * np.cos(2 * turn), -np.sin(3 * turn)]
    )
    rings = [
        np.column_stack([np.cos(turn), np.sin(turn), 0 * turn]),
        np.column_stack([1 + np.cos(turn), 0 * turn, np.sin(turn)]),
    ]
    exact = writhe(trefoil), linking_number(*rings)
    monkeypatch.setattr(module, "_MANY_PAIRS", 1000)
    near = writhe(trefoil), linking_number(*rings)
    assert near != exact and np.allclose(near, exact, atol=2e-3) and abs(round(near[1])) == 1


def test_open_filaments_have_a_writhe_of_their_own():
    """A helix along z: that of one turn of radius a and pitch 2 pi b is known for long ones, 1 - b / sqrt(a^2 + b^2) a
    turn; a straight one has none."""
    turns, b = 24, 0.5
    angle = np.linspace(0, 2 * np.pi * turns, 60 * turns + 1)
    helix = Filament(np.column_stack([np.cos(angle), np.sin(angle), b * angle]), 1.0, False)
    straight = Filament(np.array([[0, 0, 0], [0, 0, 1.0], [0, 0, 2]]), 1.0, False)
    found = linking_numbers([helix, straight], np.zeros(3))
    assert found.loops == () and found.writhes.shape == (0,) and found.helicity == 0
    assert found.all_writhes[1] == 0
    assert found.all_writhes[0] / turns == pytest.approx(1 - b / np.hypot(1, b), rel=0.06)
