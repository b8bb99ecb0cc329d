# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How even a pattern is, against closed forms in the plane: a spacing that varies along a line, sheared quads."""

from dataclasses import replace

import numpy as np
import pytest

from synch_fields.core.fields import DirectionWishes, direction_field, quad_pattern, stripe_pattern
from synch_fields.core.fields.evenness import SHARES, Evenness, evenness, quantiles
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.interpolate import EdgePhases, dislocation_numbers
from synch_fields.core.matchings import after_turns

from ..flat_crosses import random_turns
from ..meshes import icosphere, square

# Of the spacing that grows along x from the one to the other.
NARROW, WIDE = 0.1, 0.14


def stretching_stripes(columns=60):
    """Stripes across x in a unit square whose distance grows evenly, and the (n,) distances."""
    mesh = square(columns)
    x = mesh.vertices[:, :1]
    spacings = NARROW + (WIDE - NARROW) * x
    phases = 2 * np.pi / (WIDE - NARROW) * np.log(spacings)
    i, j = mesh.edges.T
    return EdgePhases(mesh, phases, phases[j] - phases[i], np.zeros(len(mesh.edges), int)), spacings


def sheared_quads(mesh, first, second):
    """Quads whose phases have two constant gradients (x, y), in sheets of all kinds, and (n, 2) lengths of these."""
    turns = random_turns(mesh)
    phases = mesh.vertices[:, :2] @ np.transpose([first, second])
    lengths = np.abs(after_turns(np.linalg.norm([first, second], axis=1) * np.ones_like(phases), turns))
    i, j = mesh.edges.T
    changes = after_turns(phases[j] - phases[i], turns[i])
    return EdgePhases(mesh, after_turns(phases, turns), changes, (turns[j] - turns[i]) % 4), lengths


def test_stripes_as_a_map_asks_for_are_even():
    phases, spacings = stretching_stripes()
    found = evenness(phases, 2 * np.pi / spacings)
    np.testing.assert_allclose(found.spacings, 1, rtol=2e-3)
    np.testing.assert_allclose(found.errors, 0, atol=2e-3)
    assert found.figures["off_share"] == 0 and found.angles is None and "angles" not in found.figures


def test_quantiles_and_share_of_a_spacing_that_grows_evenly():
    phases, _ = stretching_stripes()
    asked = 0.1
    figures = evenness(phases, np.full((phases.mesh.vertex_count, 1), 2 * np.pi / asked)).figures
    expected = (NARROW + (WIDE - NARROW) * np.array(SHARES)) / asked
    np.testing.assert_allclose(figures["spacing"], expected, atol=0.01)
    assert figures["off_share"] == pytest.approx((WIDE / asked - 1.25) / ((WIDE - NARROW) / asked), abs=0.02)
    # As many lines are too near where twice the shortest distance was asked for.
    figures = evenness(phases, np.full((phases.mesh.vertex_count, 1), 2 * np.pi / (2 * NARROW))).figures
    assert figures["off_share"] == 1


@pytest.mark.parametrize("degrees", [90, 72, 120])
def test_sheared_quads_have_two_corners_and_the_asked_spacings(degrees):
    mesh = square(8)
    angle = np.radians(30 + degrees)
    first, second = 40 * np.array([np.cos(np.radians(30)), 0.5]), 25 * np.array([np.cos(angle), np.sin(angle)])
    phases, lengths = sheared_quads(mesh, first, second)
    found = evenness(phases, lengths)
    np.testing.assert_allclose(found.spacings, 1, rtol=1e-9)
    acute = min(degrees, 180 - degrees)
    np.testing.assert_allclose(found.figures["angles"][::4], [acute, 180 - acute], atol=1e-9)
    # Of two phases that are off, the one that is off by the larger factor tells.
    sheets = np.abs(after_turns(np.array([1.0, 2.0]) * np.ones_like(lengths), random_turns(mesh)))
    np.testing.assert_allclose(evenness(phases, lengths / sheets).errors, -0.5, rtol=1e-9)
    np.testing.assert_allclose(evenness(phases, lengths * [1.3, 1.3]).errors, 0.3, rtol=1e-9)


@pytest.mark.parametrize("solve, symmetry", [(stripe_pattern, 2), (quad_pattern, 4)])
def test_triangles_with_a_defect_do_not_count(solve, symmetry):
    mesh = icosphere(3)
    pattern = solve(mesh, direction_field(mesh, symmetry), 0.5)
    numbers, torn = dislocation_numbers(pattern.edge_phases, mesh.triangles)
    counted = np.isfinite(pattern.evenness.spacings).all(axis=1)
    np.testing.assert_array_equal(counted, ~torn & ~numbers.any(axis=1))
    assert 0 < (~counted).sum() < 100
    assert (pattern.evenness.errors[~counted] == 0).all() and (pattern.evenness.errors[counted] != 0).any()


def test_flattened_quads_are_measured_by_the_spacing_that_was_asked_for():
    vertices = icosphere(3).vertices
    mesh = TriangleMesh(vertices * [1, 1, 3], icosphere(3).triangles)
    field = direction_field(mesh, 4, DirectionWishes(singularities=0.0))
    pattern = quad_pattern(mesh, field, 0.5, branching=0.0)
    plain = evenness(pattern.edge_phases, np.full((mesh.vertex_count, 2), 2 * np.pi / 0.5))
    np.testing.assert_allclose(pattern.evenness.spacings, plain.spacings, rtol=1e-12)
    assert np.ptp(field.scale) > 0.2
    of_scaled = evenness(pattern.edge_phases, pattern.one_form.rates).figures["spacing"]
    assert np.ptp(of_scaled) < 0.9 * np.ptp(plain.figures["spacing"])


def test_a_phase_that_does_not_grow_is_far_off_and_nothing_is_told_of_defects_alone():
    mesh = square(2)
    phases = EdgePhases(mesh, np.zeros((9, 1)), np.zeros((len(mesh.edges), 1)), np.zeros(len(mesh.edges), int))
    figures = evenness(phases, np.ones((9, 1))).figures
    assert figures["off_share"] == 1 and np.isfinite(figures["spacing"]).all()
    torn = replace(phases, matchings=np.ones(len(mesh.edges), int))
    assert evenness(torn, np.ones((9, 1))).figures is None


def test_quantiles_follow_the_weights():
    values, weights = np.array([3.0, 1.0, 2.0]), np.array([1.0, 8.0, 1.0])
    np.testing.assert_array_equal(quantiles(values, weights, [0.5, 0.85, 0.95]), [1, 2, 3])
    assert Evenness(weights, values[:, None], None).figures["off_share"] == pytest.approx(0.2)
