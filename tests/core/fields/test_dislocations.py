# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Dislocations: how many a pattern must have, and where line fields tear."""

import cmath

import numpy as np
import pytest

from synch_fields.core.fields import direction_field, given_directions, stripe_pattern
from synch_fields.core.fields.target_one_form import TargetOneForm
from synch_fields.core.interpolate import dislocation_numbers

from ..meshes import CLOSED, annulus, disk, icosphere, torus


def random_phases(mesh, field, spacing, seed=0):
    growth = TargetOneForm.of(mesh, field, spacing)
    phases = np.exp(1j * np.random.default_rng(seed).uniform(-np.pi, np.pi, growth.masses.shape))
    return growth.edge_phases(phases), growth


def winding_along(mesh, edge_phases, vertices):
    """Total phase change over 2 pi along a closed walk through neighbouring vertices."""
    changes, _ = edge_phases.between(vertices, np.roll(vertices, -1))
    return changes.sum() / (2 * np.pi)


def rim(mesh, radius):
    """Vertices at a distance from the z axis, counterclockwise."""
    ring = np.flatnonzero(np.abs(np.linalg.norm(mesh.vertices[:, :2], axis=1) - radius) < 1e-9)
    return ring[np.argsort(np.arctan2(mesh.vertices[ring, 1], mesh.vertices[ring, 0]))]


def spokes(symmetry, seed=0):
    """Stripes along the radii of an annulus: evenly spaced, 4 would meet its inner rim and 32 its outer one."""
    mesh = annulus(0.25, 2.0, rings=18, segments=108)
    signs = (
        np.random.default_rng(seed).choice([-1, 1], mesh.vertex_count) if symmetry == 2 else np.ones(mesh.vertex_count)
    )
    field = given_directions(mesh, symmetry, signs[:, None] * mesh.vertices)
    return mesh, signs, stripe_pattern(mesh, field, 2 * np.pi / 16)


def test_spokes_of_constant_spacing_fork_as_often_as_the_rims_differ():
    """The outer rim has room for more spokes: each additional one starts at a dislocation."""
    mesh, _, pattern = spokes(1)
    inner = winding_along(mesh, pattern.edge_phases, rim(mesh, 0.25))
    outer = winding_along(mesh, pattern.edge_phases, rim(mesh, 2.0))
    assert inner == pytest.approx(round(inner), abs=1e-9) and abs(inner - 4) < 3.5
    assert outer == pytest.approx(round(outer), abs=1e-9) and abs(outer - 32) < 7.5
    assert [d.index for d in pattern.dislocations] == [1] * round(outer - inner)
    assert {d.kind for d in pattern.dislocations} == {"dislocation"}
    # One winding number for all radii would cost the integral of (w / r - 16)^2, at its best w.
    best = 16 * 1.75 / np.log(8)
    smooth = 2 * np.pi * (best**2 * np.log(8) - 2 * best * 16 * 1.75 + 128 * (4 - 1 / 16))
    assert pattern.solution.lower_bound < pattern.solution.energy < 0.5 * smooth


def test_spokes_given_as_lines_fork_as_often():
    mesh, signs, pattern = spokes(2)
    turns = []
    for radius in (0.25, 2.0):
        ring = rim(mesh, radius)
        values, sheet = pattern.edge_phases.around(ring[None])
        assert sheet[0] == 0
        turns.append(signs[ring[0]] * (values[0, -1, 0] - values[0, 0, 0]) / (2 * np.pi))
    assert abs(turns[0] - 4) < 3.5 and abs(turns[1] - 32) < 7.5
    # Signs of indices belong to the sheet of a triangle's first corner.
    first = mesh.triangles[[d.triangle for d in pattern.dislocations], 0]
    total = sum(d.index * signs[v] for d, v in zip(pattern.dislocations, first, strict=True))
    assert total == pytest.approx(turns[1] - turns[0], abs=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_the_number_is_the_winding_of_the_phases(seed):
    """Corner by corner with complex numbers, as the residue of three wrapped changes."""
    mesh = torus(around=16, across=8)
    field = direction_field(mesh, 1)
    edge_phases, growth = random_phases(mesh, field, 0.3, seed)
    phases = np.exp(1j * edge_phases.arguments[:, 0])
    numbers, torn = dislocation_numbers(edge_phases, mesh.triangles)
    lookup = {tuple(e): a for e, a in zip(mesh.edges.tolist(), growth.changes[:, 0], strict=True)}
    for t, triangle in enumerate(mesh.triangles.tolist()):
        total = 0.0
        for k in range(3):
            i, j = triangle[k], triangle[(k + 1) % 3]
            asked = lookup[i, j] if i < j else -lookup[j, i]
            total += asked + cmath.phase(phases[j] / (phases[i] * cmath.exp(1j * asked)))
        assert total / (2 * np.pi) == pytest.approx(numbers[t, 0], abs=1e-9)
    assert not torn.any() and len(np.unique(numbers)) >= 3


@pytest.mark.parametrize("spacing", [0.2, 0.7])
@pytest.mark.parametrize(("build", "characteristic"), CLOSED)
def test_dislocations_of_vector_stripes_cancel_on_closed_surfaces(build, characteristic, spacing):
    """Every edge is walked once in each direction, so that all windings add up to nothing."""
    mesh = build()
    field = given_directions(mesh, 1, np.random.default_rng(3).standard_normal((mesh.vertex_count, 3)))
    edge_phases, _ = random_phases(mesh, field, spacing)
    numbers, _ = dislocation_numbers(edge_phases, mesh.triangles)
    assert numbers.any() and numbers.sum() == 0


@pytest.mark.parametrize("seed", range(3))
def test_dislocations_inside_a_rim_are_its_winding(seed):
    mesh = disk(6, 30)
    field = given_directions(mesh, 1, np.tile([1.0, 0, 0], (mesh.vertex_count, 1)))
    edge_phases, _ = random_phases(mesh, field, 0.4, seed)
    numbers, _ = dislocation_numbers(edge_phases, mesh.triangles)
    assert numbers.sum() == pytest.approx(winding_along(mesh, edge_phases, rim(mesh, 1.0)), abs=1e-9)


def test_line_fields_tear_exactly_at_half_integer_disclinations():
    for mesh in (icosphere(3), torus()):
        random = np.random.default_rng(1)
        for vectors in (direction_field(mesh, 2).vectors, random.standard_normal((mesh.vertex_count, 3))):
            field = given_directions(mesh, 2, vectors)
            edge_phases, _ = random_phases(mesh, field, 0.4)
            numbers, torn = dislocation_numbers(edge_phases, mesh.triangles)
            odd = {d.triangle for d in field.disclinations if round(2 * d.index) % 2}
            assert set(np.flatnonzero(torn).tolist()) == odd
            assert not numbers[torn].any()
    assert odd


def test_half_a_disclination_in_a_disk_tears_one_triangle():
    mesh = disk(8, 40)
    home = 200
    x, y, _ = (mesh.vertices - mesh.vertices[mesh.triangles[home]].mean(axis=0)).T
    angles = np.arctan2(y, x) / 2
    field = given_directions(mesh, 2, np.column_stack([np.cos(angles), np.sin(angles), 0 * x]))
    pattern = stripe_pattern(mesh, field, 0.3)
    _, torn = dislocation_numbers(pattern.edge_phases, mesh.triangles)
    assert np.flatnonzero(torn).tolist() == [home]
    assert [(d.triangle, d.index) for d in field.disclinations] == [(home, 0.5)]


@pytest.mark.parametrize("symmetry", [1, 2])
def test_reversing_a_vector_field_conjugates_its_stripes(symmetry):
    """Turning every direction over turns all sheets over and leaves the pattern as it is."""
    mesh = icosphere(2)
    field = direction_field(mesh, symmetry)
    pattern = stripe_pattern(mesh, field, 0.5)
    reverse = TargetOneForm.of(mesh, field.turned(np.pi), 0.5).edge_phases(pattern.solution.phases.conj())
    np.testing.assert_allclose(reverse.changes, -pattern.edge_phases.changes, atol=1e-9)
    numbers, _ = dislocation_numbers(pattern.edge_phases, mesh.triangles)
    np.testing.assert_array_equal(dislocation_numbers(reverse, mesh.triangles)[0], -numbers)
