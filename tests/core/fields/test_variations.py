# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Other near-optimal phases of the same solve."""

import numpy as np
import pytest

from synch_fields.core.fields import direction_field, stripe_pattern
from synch_fields.core.fields.placement import nearest_variation, variation

from ..meshes import bumpy_torus


def solved():
    mesh = bumpy_torus(16)
    return stripe_pattern(mesh, direction_field(mesh, 2), 0.37)


def projected_energy(pattern, seed):
    """The energy of the lifted field's projection on a random direction, normalized (Eq. 29)."""
    problem, lifted = pattern.problem, pattern.solution.lifted
    drawn = np.random.default_rng(seed).normal(size=(lifted.shape[1], 2)) @ [1, 1j if problem.is_complex else 0]
    rows = (lifted @ drawn).reshape(-1, problem.block)
    return pattern.with_phases(problem.expand(np.ravel(rows / np.linalg.norm(rows, axis=1, keepdims=True)))).energy


def test_variations_of_a_pattern():
    pattern = solved()
    ready = len(pattern.solution.variations)
    energies = [variation(pattern, number).energy for number in range(ready + 3)]
    assert energies[0] == pattern.solution.energy and energies[:ready] == sorted(energies[:ready])
    assert len(set(energies)) == ready + 3
    assert pattern.solution.lower_bound <= variation(pattern, ready + 1).energy < projected_energy(pattern, ready + 1)
    np.testing.assert_array_equal(variation(pattern, ready + 1).phases, variation(pattern, ready + 1).phases)


def test_of_drawn_variations_the_first_near_one_is_taken_or_else_the_nearest(monkeypatch):
    pattern = solved()
    energies = {number: variation(pattern, number).energy / pattern.solution.energy for number in range(100, 104)}
    near = [number for number, energy in energies.items() if energy <= 1.05]
    number, phases = nearest_variation(pattern, energies)
    assert number == (near or [min(energies, key=energies.get)])[0]
    np.testing.assert_array_equal(phases, variation(pattern, number).phases)
    monkeypatch.setattr("synch_fields.core.fields.placement.NEAR", -1.0)
    assert nearest_variation(pattern, energies)[0] == min(energies, key=energies.get)


def test_variations_of_a_direction_field():
    mesh = bumpy_torus(16)
    field = direction_field(mesh, 4).turned(0.2)
    assert field.energy == pytest.approx(field.solution.energy, rel=1e-9)
    other = variation(field, 30)
    assert other.energy != field.energy and sum(d.index for d in other.disclinations) == 0
    np.testing.assert_allclose(variation(field, 0).vectors, field.vectors, atol=1e-12)
