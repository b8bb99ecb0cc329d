# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Two phases walked from vertex to vertex, the defects that the walks meet, and what stays in place inside them."""

from cmath import exp, phase
from itertools import product

import numpy as np
import pytest

from synch_fields.core.defects import wrap
from synch_fields.core.fields import direction_field, quad_pattern
from synch_fields.core.fields.target_one_form import TargetOneForm
from synch_fields.core.geometry.polygons import Polygons
from synch_fields.core.interpolate import EdgePhases, disclination_centres, dislocation_numbers, evaluate, face_phases

from .flat_crosses import (
    plane_crosses,
    plane_edge_phases,
    plane_waves,
    random_crosses,
    random_edge_phases,
    random_turns,
    turned_crosses,
)
from .meshes import double_torus, icosphere, octahedron, quad_torus, renumbered, square, torus

A = np.array([[0, 1], [-1, 0]])


def power(turns):
    return np.linalg.matrix_power(A, turns % 4)


def walked(edge_phases, corners):
    """Values along a closed walk, vertex by vertex with matrices, and the quarter turns of the way."""
    lookup = {tuple(edge): e for e, edge in enumerate(edge_phases.mesh.edges.tolist())}
    values, turns = [edge_phases.arguments[corners[0]]], 0
    for i, j in zip(corners, np.roll(corners, -1), strict=True):
        e = lookup[min(i, j), max(i, j)]
        change, matching = edge_phases.changes[e], int(edge_phases.matchings[e])
        if i > j:  # known for the phases of j, which lie a matching behind those of i
            change, matching = -power(matching) @ change, -matching
        values.append(values[-1] + power(-turns) @ change)
        turns += matching
    return np.array(values), turns % 4


@pytest.mark.parametrize("build", [lambda: icosphere(1), lambda: torus(around=10, across=6), octahedron])
def test_walks_are_those_of_matrices(build):
    mesh = build()
    edge_phases = random_edge_phases(mesh, random_crosses(mesh), 0.7)
    values, turns = edge_phases.around(mesh.triangles)
    assert len(np.unique(turns)) >= 3
    for corners, found, turned in zip(mesh.triangles.tolist(), values, turns, strict=True):
        expected, total = walked(edge_phases, corners)
        np.testing.assert_allclose(found, expected, atol=1e-12)
        assert turned == total
        # Back at the first vertex its own phases are met, in the sheet that the way has led to.
        missed = expected[-1] - power(-total) @ edge_phases.arguments[corners[0]]
        np.testing.assert_allclose(wrap(missed), 0, atol=1e-9)


@pytest.mark.parametrize("build", [lambda: icosphere(2), torus, double_torus])
def test_there_and_back_is_nothing(build):
    mesh = build()
    edge_phases = random_edge_phases(mesh, random_crosses(mesh), 0.4)
    values, turns = edge_phases.around(mesh.edges)
    assert not turns.any() and len(np.unique(edge_phases.matchings)) == 4
    np.testing.assert_allclose(values[:, 2], values[:, 0], atol=1e-9)


@pytest.mark.parametrize("build", [lambda: icosphere(2), torus, double_torus])
def test_walks_turn_around_disclinations_by_their_index(build):
    mesh = build()
    field = random_crosses(mesh)
    indices = np.zeros(mesh.triangle_count)
    for defect in field.disclinations:
        indices[defect.triangle] = defect.index
    assert len(np.unique(indices)) >= 3
    edge_phases = random_edge_phases(mesh, turned_crosses(field, random_turns(mesh)), 0.4)
    numbers, torn = dislocation_numbers(edge_phases, mesh.triangles)
    _, turns = edge_phases.around(mesh.triangles)
    np.testing.assert_array_equal(turns, np.rint(-4 * indices).astype(int) % 4)
    np.testing.assert_array_equal(torn, turns != 0)
    assert not numbers[torn].any() and numbers[~torn].any(axis=0).all()


def test_numbers_are_windings_of_each_phase():
    """Corner by corner with complex numbers, in the sheet of the first corner."""
    mesh = torus(around=14, across=8)
    field = turned_crosses(direction_field(mesh, 4), random_turns(mesh))
    growth = TargetOneForm.of(mesh, field, 0.4)
    edge_phases = random_edge_phases(mesh, field, 0.4)
    numbers, torn = dislocation_numbers(edge_phases, mesh.triangles)
    lookup = {tuple(edge): e for e, edge in enumerate(mesh.edges.tolist())}
    for triangle, number in zip(mesh.triangles[~torn].tolist(), numbers[~torn], strict=True):
        total, sheet = np.zeros(2), 0
        for i, j in zip(triangle, np.roll(triangle, -1), strict=True):
            e = lookup[min(i, j), max(i, j)]
            asked, matching = growth.changes[e], int(growth.matchings[e])
            if i > j:
                asked, matching = -power(matching) @ asked, -matching
            misses = power(-matching) @ edge_phases.arguments[j] - edge_phases.arguments[i] - asked
            taken = asked + [phase(exp(1j * miss)) for miss in misses]
            total, sheet = total + power(-sheet) @ taken, sheet + matching
        np.testing.assert_allclose(total / (2 * np.pi), number, atol=1e-9)
    assert numbers.any(axis=0).all()


# Disclinations


@pytest.mark.parametrize("turns", [1, 2, 3])
def test_the_centre_of_a_disclination_is_the_one_place_that_a_walk_leaves_alone(turns):
    """Brute force over the grid of all multiples of pi nearby."""
    grid = np.pi * np.array(list(product(range(-14, 15), repeat=2)))
    for missed in product(range(-3, 4), repeat=2):
        own = np.random.default_rng(turns).uniform(-np.pi, np.pi, 2)
        end = power(-turns) @ own + 2 * np.pi * np.array(missed)
        values = np.array([[own, [9.0, 9.0], [9.0, 9.0], end]])
        centre = disclination_centres(values, np.array([turns]))[0]
        stays = [p for p in grid if np.abs(power(-turns) @ p + 2 * np.pi * np.array(missed) - p).max() < 1e-9]
        assert len(stays) == 1
        np.testing.assert_allclose(centre, stays[0], atol=1e-9)


def test_the_centre_of_half_a_disclination_of_lines_lies_between_its_values():
    for missed in range(-4, 5):
        values = np.array([[[0.7], [9.0], [9.0], [-0.7 + 2 * np.pi * missed]]])
        assert disclination_centres(values, np.array([1])) == pytest.approx(np.pi * missed)


@pytest.mark.parametrize("build", [lambda: icosphere(2), torus, double_torus])
def test_a_centre_is_the_same_from_every_corner(build):
    """Two walks that start elsewhere know other phases of it: other by quarter turns and whole periods."""
    mesh = build()
    edge_phases = random_edge_phases(mesh, random_crosses(mesh), 0.4)
    _, torn = dislocation_numbers(edge_phases, mesh.triangles)
    first = mesh.triangles[torn]
    second = np.roll(first, -1, axis=1)
    centres = []
    for corners in (first, second):
        values, turns = edge_phases.around(corners)
        centres.append(disclination_centres(values, turns))
        np.testing.assert_allclose(np.sin(centres[-1]), 0, atol=1e-9)
    change, matching = edge_phases.between(first[:, 0], first[:, 1])
    for seen, other, on_the_way, m, i, j in zip(*centres, change, matching, first[:, 0], second[:, 0], strict=True):
        reached = power(m) @ (edge_phases.arguments[i] + on_the_way)
        periods = edge_phases.arguments[j] - reached
        np.testing.assert_allclose(other, power(m) @ seen + periods, atol=1e-8)


# Faces


@pytest.mark.parametrize("symmetry", [1, 2, 4])
def test_every_phase_has_its_face_values(symmetry):
    mesh, polygons = quad_torus()
    field = direction_field(mesh, symmetry)
    parts = face_phases(random_edge_phases(mesh, field, 0.4), polygons)
    assert len(parts) == (2 if symmetry == 4 else 1)
    for part in parts:
        assert part.corner_phase.shape == polygons.corner_vertices.shape
        assert part.index.shape == part.index_2.shape == part.closing.shape == polygons.starts.shape
        np.testing.assert_array_equal(part.corner_place, parts[0].corner_place)
        np.testing.assert_array_equal(part.unfit, parts[0].unfit)


@pytest.mark.parametrize("degrees", [0, 27])
def test_face_values_of_plane_waves_are_plane_waves(degrees):
    mesh = square(6)
    edge_phases = plane_edge_phases(mesh, degrees, 0.35)
    _, angles = plane_crosses(mesh, degrees)
    polygons = Polygons.of_triangles(mesh)
    random = np.random.default_rng(1)
    triangles, weights = random.integers(0, mesh.triangle_count, 100), random.dirichlet(np.ones(3), 100)
    points = np.einsum("ki,kix->kx", weights, mesh.vertices[mesh.triangles[triangles]])
    found = np.column_stack(
        [evaluate(part, polygons, triangles, weights) for part in face_phases(edge_phases, polygons)]
    )
    expected = plane_waves(angles[mesh.triangles[triangles, 0]], 0.35, points)
    np.testing.assert_allclose(wrap(found - expected), 0, atol=1e-9)


def test_the_sum_of_numbers_does_not_depend_on_who_counts():
    """Renumbered vertices have the same phases: sizes of dislocations, in whichever phase they are."""
    mesh = torus()
    pattern = quad_pattern(mesh, direction_field(mesh, 4), 0.22)
    numbers, torn = dislocation_numbers(pattern.edge_phases, mesh.triangles)
    assert numbers.any() and torn.any()
    other, vertex, triangle = renumbered(mesh)
    old = np.argsort(vertex)
    changes, matched = pattern.edge_phases.between(*old[other.edges].T)
    moved = EdgePhases(other, pattern.edge_phases.arguments[old], changes, matched)
    other_numbers, other_torn = dislocation_numbers(moved, other.triangles)
    np.testing.assert_array_equal(other_torn[triangle], torn)
    np.testing.assert_array_equal(np.sort(np.abs(other_numbers[triangle])), np.sort(np.abs(numbers)))
    # A dislocation is listed once for each phase that it is in.
    assert len(pattern.dislocations) == np.count_nonzero(numbers)
    for defect in pattern.dislocations:
        assert numbers[defect.triangle, defect.phase] == defect.index


@pytest.mark.parametrize("seed", range(3))
def test_walks_around_the_triangles_of_the_mesh_are_those_around_their_corners(seed):
    mesh = torus(9)
    edge_phases = random_edge_phases(mesh, direction_field(mesh, 4), 0.4, seed)
    for found, expected in zip(
        edge_phases.around(mesh.triangles), edge_phases.around(mesh.triangles.copy()), strict=True
    ):
        np.testing.assert_array_equal(found, expected)
        assert not found.flags.writeable and expected.flags.writeable
