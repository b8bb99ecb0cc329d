# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Variations and placed defects: projections of the lifted field on chosen directions."""

import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.fields import direction_field, quad_pattern, stripe_pattern
from synch_fields.core.fields.placement import nearest_variation, variation
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.solve import Options
from synch_fields.core.solve.lifted import LiftedField

from ..direction_wishes import boundary_row
from ..meshes import annulus, bumpy_torus, icosphere, together


def solved(kind, mesh=None, rows=()):
    mesh = bumpy_torus(16) if mesh is None else mesh
    symmetry, solve = {"vector": (1, stripe_pattern), "line": (2, stripe_pattern), "cross": (4, quad_pattern)}[kind]
    pattern = solve(mesh, direction_field(mesh, symmetry), 0.37, rows)
    return pattern, LiftedField(pattern.problem, pattern.solution)


KINDS = ["vector", "line", "cross"]


@pytest.mark.parametrize("kind", KINDS)
def test_phases_are_the_projection_of_the_lifted_rows(kind):
    """Vertex by vertex from the rows themselves, up to the gauge that no energy sees."""
    pattern, field = solved(kind)
    direction = field.random_direction(3)
    phases = field.phases(direction)
    block = pattern.problem.block
    rows = (field.lifted @ direction).reshape(-1, block)
    rows = rows if block == 1 else rows[:, 0] + 1j * rows[:, 1]
    expected = np.ravel(rows / np.abs(rows))
    turned = pattern.problem.turned
    np.testing.assert_allclose(np.where(turned, phases.conj(), phases), expected, atol=1e-12)
    np.testing.assert_allclose(np.abs(phases), 1, atol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_without_nodes_it_is_svd_rounding(kind):
    pattern, field = solved(kind)
    _, _, axes = np.linalg.svd(field.lifted, full_matrices=False)
    by_svd = pattern.with_phases(field.phases(axes[0].conj()))
    assert pattern.with_phases(field.phases(field.direction())).energy == pytest.approx(by_svd.energy, rel=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_variations_lie_above_the_bound_and_differ(kind):
    pattern, field = solved(kind)
    energies = [pattern.with_phases(field.phases(field.random_direction(seed))).energy for seed in range(4)]
    assert min(energies) >= pattern.solution.lower_bound and len(set(np.round(energies, 6))) == 4
    np.testing.assert_array_equal(field.phases(field.random_direction(1)), field.phases(field.random_direction(1)))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("vertex", [5, 333])
def test_the_field_vanishes_at_a_placed_defect(kind, vertex):
    _, field = solved(kind)
    node = vertex * (2 if kind == "cross" else 1)
    rows = field.problem.rows_of(np.array([node])).ravel()
    for direction in (field.direction([node]), field.random_direction(4, [node])):
        assert np.abs(field.lifted[rows] @ direction).max() < 1e-12


def test_fixed_phases_stay_and_cannot_be_places():
    mesh = annulus(0.5, 2.0, rings=10, segments=60)
    pattern, field = solved("line", mesh, [boundary_row(mesh, "phase")])
    rim = np.flatnonzero(mesh.boundary_vertices)
    for seed in range(3):
        np.testing.assert_allclose(field.phases(field.random_direction(seed))[rim], 1, atol=1e-12)
    with pytest.raises(SettingError, match=f"node {rim[0]} is fixed"):
        field.direction([rim[0]])
    inside = np.flatnonzero(~mesh.boundary_vertices)[40]
    assert np.isfinite(pattern.with_phases(field.phases(field.direction([inside]))).energy)


def test_every_piece_follows():
    mesh = together(icosphere(2), TriangleMesh(icosphere(2).vertices + [4, 0, 0], icosphere(2).triangles))
    pattern, field = solved("vector", mesh)
    assert len(pattern.problem.pieces) == 2
    energies = [pattern.with_phases(field.phases(field.random_direction(seed))).energy for seed in range(3)]
    assert np.isfinite(energies).all() and min(energies) >= pattern.solution.lower_bound


def test_other_methods_have_no_lifted_field():
    mesh = icosphere(2)
    pattern = stripe_pattern(mesh, direction_field(mesh, 1), 0.4, options=Options(method="spectral"))
    with pytest.raises(SettingError, match="method sdp"):
        LiftedField(pattern.problem, pattern.solution)


def test_variations_of_a_pattern():
    pattern, field = solved("line")
    ready = len(pattern.solution.variations)
    energies = [variation(pattern, number).energy for number in range(ready + 3)]
    assert energies[0] == pattern.solution.energy and energies[:ready] == sorted(energies[:ready])
    assert len(set(energies)) == ready + 3
    projected = pattern.with_phases(field.phases(field.random_direction(ready + 1)))
    assert variation(pattern, ready + 1).energy < projected.energy
    np.testing.assert_array_equal(variation(pattern, ready + 1).phases, variation(pattern, ready + 1).phases)


def test_of_drawn_variations_the_first_near_one_is_taken_or_else_the_nearest(monkeypatch):
    pattern, _ = solved("line")
    energies = {number: variation(pattern, number).energy / pattern.solution.energy for number in range(100, 104)}
    near = [number for number, energy in energies.items() if energy <= 1.05]
    assert nearest_variation(pattern, energies) == (near or [min(energies, key=energies.get)])[0]
    monkeypatch.setattr("synch_fields.core.fields.placement.NEAR", -1.0)
    assert nearest_variation(pattern, energies) == min(energies, key=energies.get)


def test_variations_of_a_direction_field():
    mesh = bumpy_torus(16)
    field = direction_field(mesh, 4).turned(0.2)
    assert field.energy == pytest.approx(field.solution.energy, rel=1e-9)
    other = variation(field, 30)
    assert other.energy != field.energy and sum(d.index for d in other.disclinations) == 0
    np.testing.assert_allclose(variation(field, 0).vectors, field.vectors, atol=1e-12)
