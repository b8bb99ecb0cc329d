# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A velocity from its vorticity: circulations are those that were given, and a known flow comes back."""

import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.fields.clebsch import circulations, edge_integrals
from synch_fields.core.fields.vorticity import edges_of_faces, vorticity_integrals
from synch_fields.core.geometry.grid import Grid


def as_densities(grid, flux):
    """Circulations as arrays over the faces along each normal, over their areas."""
    parts, start = [], 0
    for plane in grid.planes:
        shape = [n - (axis in plane and not grid.periodic[axis]) for axis, n in enumerate(grid.shape)]
        parts.append(flux[start : start + np.prod(shape)].reshape(shape) / np.prod(grid.spacing[list(plane)]))
        start += np.prod(shape)
    return parts


@pytest.mark.parametrize("periodic", [False, True, (True, False, False), (False, True, True)])
def test_circulations_come_back_exactly_on_any_box(periodic):
    grid = Grid((6, 8, 7), (0.3, 0.2, 0.5), 0.7, periodic)
    integrals = np.random.default_rng(0).standard_normal(len(grid.edges))
    flux = circulations(grid, integrals)
    again = edges_of_faces(grid, as_densities(grid, flux))
    np.testing.assert_allclose(circulations(grid, again), flux, atol=1e-12)
    assert np.abs(again - integrals).max() > 0.1  # another one, as the potential's gradient is gone


def test_the_flow_of_arnold_beltrami_and_childress_is_its_own_vorticity():
    errors = []
    for nodes in (16, 32):
        grid = Grid((nodes,) * 3, 2 * np.pi / nodes, 0.0, True)
        x, y, z = grid.places.T
        flow = np.column_stack([np.sin(z) + np.cos(y), np.sin(x) + np.cos(z), np.sin(y) + np.cos(x)])
        errors.append(np.abs(vorticity_integrals(grid, flow) - edge_integrals(grid, flow)).max() / grid.spacing[0])
    assert errors[1] < 0.3 * errors[0] and errors[1] < 0.02  # of second order


def test_a_vortex_in_an_open_box_has_its_circulations():
    """The vorticity of a Lamb-Oseen vortex, whose circulation around a circle is known: 1 - exp(-r^2)."""
    grid = Grid((33, 33, 9), 0.25, (-4, -4, -1))
    radius = np.hypot(*grid.places[:, :2].T)
    vorticity = np.zeros((grid.node_count, 3))
    vorticity[:, 2] = np.exp(-(radius**2)) / np.pi
    flux = circulations(grid, vorticity_integrals(grid, vorticity))
    middle = grid.faces[:, 0] % 9 == 4
    across = (grid.face_planes == (0, 1)).all(axis=1) & middle
    inside = np.abs(grid.places[grid.faces[across]].mean(axis=1)[:, :2]).max(axis=1) < 3
    assert flux[across][inside].sum() == pytest.approx(1, abs=1e-3)
    assert np.abs(flux[~(grid.face_planes == (0, 1)).all(axis=1)]).max() < 1e-12


def test_what_is_no_vorticity_is_refused():
    for grid, values in ((Grid((4, 4)), np.zeros((16, 3))), (Grid((4, 4, 4)), np.zeros((64, 2)))):
        with pytest.raises(SettingError, match="give three numbers a node"):
            vorticity_integrals(grid, values)
    with pytest.raises(SettingError, match="not numbers"):
        vorticity_integrals(Grid((4, 4, 4)), np.full((64, 3), np.nan))
