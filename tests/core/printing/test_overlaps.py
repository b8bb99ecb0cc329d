# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Beads inside of earlier ones are found where boxes say so."""

from dataclasses import replace

import numpy as np
import pytest

from synch_fields.core.extract.lines.isolines import End, Isolines
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.printing.overlaps import find_overlaps


def lines_at(flat, sizes):
    """Open lines through (n, 2) places."""
    mesh = TriangleMesh([(0, 0, 0), (10, 0, 0), (0, 10, 0)], [(0, 1, 2)])
    weights = np.column_stack([1 - flat.sum(axis=1) / 10, flat / 10])
    return Isolines(mesh, np.zeros(len(flat), int), weights, np.array(sizes), np.full((len(sizes), 2), End.BOUNDARY))


def test_the_point_before_is_the_one_whose_next_it_is_and_open_lines_begin_with_themselves():
    flat = np.column_stack([np.arange(7) / 2, np.ones(7)])
    lines = replace(lines_at(flat, [3, 4]), ends=np.array([[End.BOUNDARY] * 2, [End.CLOSED] * 2]))
    np.testing.assert_array_equal(lines.next, [1, 2, 2, 4, 5, 6, 3])
    np.testing.assert_array_equal(lines.previous, [0, 0, 1, 6, 3, 4, 5])


def test_what_lies_inside_an_earlier_bead_is_found_and_fills_nothing_itself():
    """One bead along X at y = 1, two across it at x = 2, 0.5 wide and 0.4 high, so that 0.225 and 0.18 are inside."""
    along, across = np.linspace(0, 4, 81), np.linspace(0, 2, 41)
    flat = np.concatenate([
        np.column_stack([along, np.ones(81)]), *[np.column_stack([np.full(41, 2.0), across])] * 2
    ])  # fmt: skip
    sizes = np.array([81, 41, 41])
    lines = lines_at(flat, sizes)
    up, one = np.tile([0.0, 0, 1], (163, 1)), np.ones(163)

    def found(*heights, tools=up):
        tips = np.column_stack([flat, np.repeat(heights, sizes)])
        return np.split(find_overlaps(lines, tips, tools, 0.5 * one, 0.4 * one, 0.4), np.cumsum(sizes)[:-1])

    # The second one is as high as the first nearly. The third lies below the first, but not below the second, which is
    # left out at the crossing.
    crossing = np.abs(across - 1)
    first, second, third = found(0.4, 0.35, 0.0, tools=np.where(np.arange(163) < 122, 1, -1)[:, None] * up)
    assert not first.any()
    np.testing.assert_array_equal(second, crossing < 0.225)
    np.testing.assert_array_equal(third, crossing > 0.01)
    # With the tool above it, the tip would come there through the first one.
    assert found(0.4, 0.35, 0.0)[2].all()
    # Layers upon each other are not inside.
    assert not np.concatenate(found(0.4, 0.8, 1.2)).any()
    assert not found(0.4, 0.39, 0.8)[1].any()


def test_ends_that_lie_below_an_earlier_bead_are_left_out_up_to_where_the_way_is_free():
    """Two beads one above the other, of which the lower one comes second: it ends where the upper one begins."""
    along = np.linspace(0, 4, 81)
    flat = np.concatenate([np.column_stack([along[20:61], np.ones(41)]), np.column_stack([along, np.ones(81)])])
    tips = np.column_stack([flat, np.repeat([1.5, 0.5], [41, 81])])
    up, one = np.tile([0.0, 0, 1], (122, 1)), np.ones(122)

    def found(chosen):
        return find_overlaps(
            lines_at(flat[chosen], [41, chosen[41:].sum()]),
            tips[chosen],
            up[chosen],
            0.5 * one[chosen],
            0.4 * one[chosen],
            0.8,
        )

    # The lower bead reaches past the upper one on both sides: all of it stays, because its ends are free. Cut short
    # below the upper one, it loses all that lies below that.
    assert not found(np.ones(122, bool)).any()
    chosen = np.append(np.ones(41, bool), along < 2)
    np.testing.assert_array_equal(np.flatnonzero(found(chosen)), 41 + np.flatnonzero((along > 0.775) & (along < 2)))


@pytest.mark.parametrize("begin", [None, 0, 20, 61])
def test_a_line_that_comes_back_below_its_own_top_is_left_out_there_wherever_it_begins(begin):
    """There along X, and back 0.1 lower: open, or closed and begun at one of its points."""
    along = np.linspace(0, 4, 41)
    order = np.roll(np.arange(80), -(begin or 0))
    flat = np.column_stack([np.concatenate([along, along[-2:0:-1]]), np.ones(80)])[order]
    tips = np.column_stack([flat, np.where(order < 41, 1, 0.9)])
    ends = np.full((1, 2), End.BOUNDARY if begin is None else End.CLOSED)
    one = np.ones(80)
    found = find_overlaps(
        replace(lines_at(flat, [80]), ends=ends), tips, np.tile([0.0, 0, 1], (80, 1)), 0.5 * one, 0.4 * one, 0.4
    )
    # Up to a width behind, the tip stands on its own bead.
    assert not found[order <= 41].any()
    assert found[(order > 41) & (order < 79)].all()


def test_a_closed_line_of_one_point_is_outside_of_itself():
    lines = replace(lines_at(np.array([[1.0, 1.0]]), [1]), ends=np.array([[End.CLOSED] * 2]))
    with np.errstate(all="raise"):
        found = find_overlaps(lines, np.ones((1, 3)), np.array([[0.0, 0, 1]]), np.ones(1), np.ones(1), 0.4)
    assert not found.any()
