# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Beads inside of earlier ones are found where boxes say so."""

import numpy as np

from synch_fields.core.extract.lines.isolines import End, Isolines
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.printing.overlaps import inside_earlier


def test_what_lies_inside_an_earlier_bead_is_found_and_fills_nothing_itself():
    """One bead along X at y = 1, two across it at x = 2, 0.5 wide and 0.4 high, so that 0.225 and 0.18 are inside."""
    along, across = np.linspace(0, 4, 81), np.linspace(0, 2, 41)
    flat = np.concatenate([
        np.column_stack([along, np.ones(81)]), *[np.column_stack([np.full(41, 2.0), across])] * 2
    ])  # fmt: skip
    mesh = TriangleMesh([(0, 0, 0), (10, 0, 0), (0, 10, 0)], [(0, 1, 2)])
    weights = np.column_stack([1 - flat.sum(axis=1) / 10, flat / 10])
    sizes = np.array([81, 41, 41])
    lines = Isolines(mesh, np.zeros(163, int), weights, sizes, np.full((3, 2), End.BOUNDARY))
    normals, one = np.tile([0.0, 0, 1], (163, 1)), np.ones(163)

    def found(*heights):
        tips = np.column_stack([flat, np.repeat(heights, sizes)])
        return np.split(inside_earlier(lines, tips, normals, 0.5 * one, 0.4 * one, 0.4), np.cumsum(sizes)[:-1])

    # The second one is as high as the first nearly; the third lies below the first, but not below the second, which is
    # left out at the crossing.
    first, second, third = found(0.4, 0.35, 0.0)
    crossing = np.abs(across - 1)
    assert not first.any()
    np.testing.assert_array_equal(second, crossing < 0.225)
    np.testing.assert_array_equal(third, crossing > 0.01)
    # Layers upon each other are not inside.
    assert not np.concatenate(found(0.4, 0.8, 1.2)).any()
    assert not np.concatenate(found(0.4, 0.39, 0.8)[:2]).any()
