# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The circulation of one filament: what of the vorticity is carried, on coarser grids, and vorticity that is none."""

import numpy as np
import pytest

from synch_fields.core.extract.vortices.filaments import filaments
from synch_fields.core.fields.biot_savart import filament_integrals, filament_velocity
from synch_fields.core.fields.clebsch import circulations, clebsch_map, edge_integrals, quantum_for
from synch_fields.core.fields.quantum import find_quantum, halved, least_quantum, sampling_noise
from synch_fields.core.geometry.grid import Grid
from synch_fields.core.solve import Options

from ..flows import line_integrals, ring_curve

BOX = Grid((20, 20, 14), spacing=1 / 19, origin=(-0.5, -0.5, -0.34))


def sine_grid(nodes):
    return Grid((nodes,) * 3, 2 * np.pi / nodes, 0.0, True)


def ring_integrals(core, circulation=2.0):
    return filament_integrals(BOX, [(ring_curve(0.27), circulation)], core * BOX.spacing[0])


def test_the_share_of_the_only_filament_is_that_of_the_map_and_about_all():
    """A straight vortex of one quantum: what passes each of the planes across it is carried, whatever is beside it."""
    grid = Grid((15, 15, 6), spacing=1 / 14, origin=(-0.5, -0.5, 0))
    integrals = line_integrals(grid, [0.03, -0.01])
    found = clebsch_map(grid, integrals, 1.0)
    (line,) = filaments(found)
    assert line.share == pytest.approx(found.vorticity_share) == pytest.approx(1)
    assert -found.face_numbers @ found.face_shares == pytest.approx(-1)  # one against the flow's vorticity


@pytest.mark.parametrize("count", [1, 3])
def test_shares_of_filaments_add_up_to_that_of_the_map(count):
    integrals = ring_integrals(2.0)
    found = clebsch_map(BOX, integrals, quantum_for(BOX, integrals, 2 * count))
    flux = circulations(BOX, integrals)
    along = found.face_numbers * np.sign(flux)  # brute force, face by face
    expected = found.quantum * sum(along.tolist()) / np.abs(flux).sum()
    assert found.vorticity_share == pytest.approx(expected)
    assert sum(line.share for line in filaments(found)) == pytest.approx(expected)


@pytest.mark.parametrize("core", [0.3, 2.0])
def test_a_ring_gets_filaments_that_carry_what_is_wanted(core):
    integrals = ring_integrals(core)
    quantum = find_quantum(BOX, integrals, 0.8)
    found = clebsch_map(BOX, integrals, quantum)
    assert 0.65 < found.vorticity_share < 1.15
    assert quantum == float(f"{quantum:.3g}")
    # The larger circulations before it carry less, or more than there is.
    before = clebsch_map(BOX, integrals, 2 * quantum, Options(method="coarse"))
    assert not 0.83 <= before.vorticity_share <= 1.1


def test_so_many_filaments_pass_as_are_wanted():
    integrals = ring_integrals(2.0)
    quantum = find_quantum(BOX, integrals, 0.8, count=3)
    through = clebsch_map(BOX, integrals, quantum, Options(method="coarse")).face_numbers
    planes = np.unique(BOX.face_layers)
    assert max(np.maximum(sign * through[BOX.face_layers == k], 0).sum() for k in planes for sign in (1, -1)) >= 3
    assert quantum <= quantum_for(BOX, integrals, 3) * 1.01


def test_known_circulations_are_tried_first_and_the_grid_ends_the_search():
    thin = ring_integrals(0.3)
    assert find_quantum(BOX, thin, 0.8, largest=2.0) == pytest.approx(min(2.0, quantum_for(BOX, thin, 1)), rel=0.01)
    noise = np.random.default_rng(0).standard_normal(len(BOX.edges))
    assert find_quantum(BOX, noise, 0.99) >= 0.99 * least_quantum(BOX, noise)


@pytest.mark.parametrize(("shape", "periodic"), [((8, 9, 12), False), ((8, 10, 9), (True, True, False))])
def test_a_coarser_grid_has_the_circulations_of_four_faces_each(shape, periodic):
    grid = Grid(shape, (0.1, 0.2, 0.3), 1.0, periodic)
    integrals = np.random.default_rng(1).standard_normal(len(grid.edges))
    coarse, along = halved(grid, integrals)
    flux, start = circulations(grid, integrals), 0
    parts = []
    for first, second in grid.planes:  # brute force: four faces of each plane at a time
        counts = [n - (axis in (first, second) and not grid.periodic[axis]) for axis, n in enumerate(shape)]
        values = flux[start : start + np.prod(counts)].reshape(counts)
        start += values.size
        wanted = [n - (axis in (first, second) and not coarse.periodic[axis]) for axis, n in enumerate(coarse.shape)]
        total = np.zeros(wanted)
        for place in np.ndindex(*wanted):
            corner = 2 * np.array(place)
            for one in (0, 1):
                for other in (0, 1):
                    step = corner.copy()
                    step[first] += one
                    step[second] += other
                    total[place] += values[tuple(step)]
        parts.append(total.ravel())
    np.testing.assert_allclose(circulations(coarse, along), np.concatenate(parts), atol=1e-12)
    assert coarse.places[0] == pytest.approx(grid.places[0]) and coarse.spacing == pytest.approx(2 * grid.spacing)


def test_sampling_makes_vorticity_of_a_flow_without_any():
    """A potential's gradient: the trapezoidal rule's error grows by four where the spacing doubles. And noise, of which
    both sums have the same variance; vortices that the grid resolves; and rounding."""
    grid = Grid((17, 17, 17), 1 / 16, -0.5)
    x, y, z = grid.places.T
    gradient = np.column_stack([3 * x**2 * y + z**3, x**3, 3 * x * z**2])
    random = np.random.default_rng(0)
    noise = random.standard_normal(gradient.shape)
    assert sampling_noise(grid, gradient) == pytest.approx(3, abs=0.1)
    assert sampling_noise(grid, noise) == pytest.approx(1, abs=0.1)
    assert sampling_noise(grid, 1 + 1e-7 * noise.astype(np.float32)) == pytest.approx(1, abs=0.1)
    assert sampling_noise(grid, np.column_stack([y, 0 * y, 0 * y])) < 1e-12
    for core in (0.5, 1, 2):
        velocity = filament_velocity(grid.places, [(ring_curve(0.3), 1.0)], core / 16)
        assert sampling_noise(grid, velocity) < 0.5
    assert sampling_noise(Grid((5, 5, 5)), np.ones((125, 3))) is None


def test_taylor_green_vortices_are_carried_by_default():
    grid = sine_grid(16)
    x, y, z = grid.places.T
    velocity = np.column_stack([np.sin(x) * np.cos(y) * np.cos(z), -np.cos(x) * np.sin(y) * np.cos(z), 0 * x])
    integrals = edge_integrals(grid, velocity)
    assert clebsch_map(grid, integrals, quantum_for(grid, integrals, 4)).vorticity_share == 0  # the largest ones of all
    found = clebsch_map(grid, integrals, find_quantum(grid, integrals, 0.8))
    assert 0.65 < found.vorticity_share < 1.1
