# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The helicity of flows in closed form."""

import numpy as np
import pytest

from synch_fields.core.fields.biot_savart import filament_integrals
from synch_fields.core.fields.clebsch import edge_integrals
from synch_fields.core.fields.loops import flow_helicity
from synch_fields.core.geometry.grid import Grid

from ..flows import ring_curve


def test_that_of_arnold_beltrami_and_childress_is_its_speed_squared():
    """The flow is its own vorticity: A^2 + B^2 + C^2 over a period; its mirror image has the opposite."""
    grid = Grid((32,) * 3, 2 * np.pi / 32, 0.0, True)
    x, y, z = grid.places.T
    a, b, c = 1.0, 0.8, 0.5
    flow = np.column_stack(
        [a * np.sin(z) + c * np.cos(y), b * np.sin(x) + a * np.cos(z), c * np.sin(y) + b * np.cos(x)]
    )
    expected = (a**2 + b**2 + c**2) * (2 * np.pi) ** 3
    found = flow_helicity(grid, edge_integrals(grid, flow))
    assert found == pytest.approx(expected, rel=0.03)
    other = np.column_stack(
        [a * np.cos(z) + c * np.sin(y), b * np.cos(x) + a * np.sin(z), c * np.cos(y) + b * np.sin(x)]
    )
    assert flow_helicity(grid, edge_integrals(grid, other)) == pytest.approx(-expected, rel=0.03)


def test_linked_rings_have_twice_the_product_of_their_circulations():
    """Their linking number is 1 and they have no twist; cores reach out into the box, less where they are thin."""
    grid = Grid((36, 28, 28), 3 / 27, -1.45)
    rings = ring_curve(0.6, (0.1, 0, 0), 2, 60), ring_curve(0.6, (0.7, 0, 0), 1, 60)
    found = []
    for core in (0.2, 0.1):
        first, second = (filament_integrals(grid, [(ring, g)], core) for ring, g in zip(rings, (1.0, 2.0), strict=True))
        assert abs(flow_helicity(grid, first)) < 1e-6
        found.append(flow_helicity(grid, first + second))
        assert flow_helicity(grid, first - second) == pytest.approx(-found[-1])
    assert 0.6 * 4 < found[0] < found[1] < 4 and found[1] == pytest.approx(4, rel=0.12)
