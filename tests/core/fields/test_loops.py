# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Circulations along square loops, against sums of edges one by one."""

import numpy as np
import pytest

from synch_fields.core.fields.clebsch import circulations, clebsch_map
from synch_fields.core.fields.loops import loop_error, sum_through_squares
from synch_fields.core.geometry.grid import Grid

from ..flows import line_integrals


@pytest.mark.parametrize("shape", [(5, 6), (4, 5, 6)])
@pytest.mark.parametrize("size", [1, 2, 3])
def test_what_passes_a_loop_is_the_circulation_along_it(shape, size):
    grid = Grid(shape, spacing=0.5)
    integrals = np.random.default_rng(0).standard_normal(len(grid.edges))
    number = {tuple(edge): k for k, edge in enumerate(grid.edges.tolist())}

    def along(start, axis, sign):
        total, node = 0.0, list(start)
        for _ in range(size):
            following = list(node)
            following[axis] += sign
            ends = [int(np.ravel_multi_index(place, shape)) for place in (node, following)]
            total += sign * integrals[number[tuple(ends[::sign])]]
            node = following
        return total, node

    expected = []
    for first, second in [(0, 1)] if len(shape) == 2 else [(0, 1), (1, 2), (2, 0)]:
        for corner in np.ndindex(*shape):
            if corner[first] + size < shape[first] and corner[second] + size < shape[second]:
                node, total = corner, 0.0
                for axis, sign in ((first, 1), (second, 1), (first, -1), (second, -1)):
                    step, node = along(node, axis, sign)
                    total += step
                expected.append(total)
    found = sum_through_squares(grid, circulations(grid, integrals), size)
    np.testing.assert_allclose(np.sort(found), np.sort(expected), atol=1e-12)


def test_a_filament_of_one_quantum_misses_nothing_and_one_of_less_than_half_is_missed():
    grid = Grid((9, 9, 5), spacing=1 / 8, origin=(-0.5, -0.5, 0))
    integrals = line_integrals(grid, [0.03, -0.01])
    found = clebsch_map(grid, integrals, 1.0)
    assert loop_error(found, 4) == pytest.approx(0, abs=1e-12)
    around = sum_through_squares(grid, found.face_numbers, 4) != 0
    missed = clebsch_map(grid, integrals, 2.5)
    assert not missed.face_numbers.any()
    assert loop_error(missed, 4) == pytest.approx(0.4 * np.sqrt(around.mean()))
    assert loop_error(found, 30) is None
