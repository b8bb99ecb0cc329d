# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of a moving surface: what is carried along, what stays, and how strongly the frame before is held."""

import numpy as np
import pytest

from synch_fields.core.errors import SettingError
from synch_fields.core.fields import PatternWishes, Row, boundary_line, direction_field, quad_pattern, stripe_pattern
from synch_fields.core.fields.animation import carry_angles, nearest_representatives, next_solution
from synch_fields.core.fields.directions import DirectionField, DirectionWishes
from synch_fields.core.fields.patterns import next_pattern
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.problem import SynchronizationProblem, Targets
from synch_fields.core.solve import Options, Status, solve

from ..graphs import fixed_stripes, random_connection, random_values
from ..meshes import bent_square, bumpy_torus, icosphere, square

PATTERNS = {1: stripe_pattern, 2: stripe_pattern, 4: quad_pattern}
WISHES = PatternWishes(0.6)


def moved(mesh, matrix, offset=(0.0, 0.0, 0.0)):
    return TriangleMesh(mesh.vertices @ np.transpose(matrix) + offset, mesh.triangles)


def rotation(seed=0):
    q, r = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))
    q = q * np.sign(np.diag(r))
    return q * np.linalg.det(q)


def wavy(mesh, height):
    x, y, z = mesh.vertices.T
    return TriangleMesh(np.column_stack([x, y + height * np.sin(2 * x), z * (1 + height * x)]), mesh.triangles)


@pytest.mark.parametrize("build", [icosphere, bent_square, lambda: bumpy_torus(8)])
def test_a_rigid_motion_carries_directions_as_vectors(build):
    mesh = build()
    matrix = rotation()
    other = moved(mesh, matrix, (1.0, -2.0, 3.0))
    angles = np.random.default_rng(1).uniform(-np.pi, np.pi, mesh.vertex_count)
    carried = carry_angles(angles, mesh, other)
    np.testing.assert_allclose(carried, angles, atol=1e-12)
    np.testing.assert_allclose(
        DirectionField(other, 1, carried).vectors, DirectionField(mesh, 1, angles).vectors @ matrix.T, atol=1e-12
    )


def test_a_linear_map_of_the_plane_carries_directions_by_its_rotation():
    """Where a vertex's edges spread evenly, exactly the rotation of the map's polar decomposition."""
    turns = 2 * np.pi * np.arange(6) / 6
    ring = np.column_stack([np.cos(turns), np.sin(turns), np.zeros(6)])
    mesh = TriangleMesh(np.vstack([[0, 0, 0], ring]), [(0, 1 + k, 1 + (k + 1) % 6) for k in range(6)])
    linear = np.array([[1.3, 0.4, 0], [0.1, 0.8, 0], [0, 0, 1]])
    other = moved(mesh, linear)
    u, _, v = np.linalg.svd(linear[:2, :2])
    direction = np.array([np.cos(0.7), np.sin(0.7)])
    wanted = u @ v @ direction
    angle = mesh.tangent_numbers(np.tile([*direction, 0], (7, 1)))
    carried = DirectionField(other, 1, carry_angles(np.angle(angle), mesh, other)).vectors
    np.testing.assert_allclose(carried[0], [*wanted, 0], atol=1e-12)


def test_meshes_of_other_triangles_are_refused():
    mesh = square(3)
    with pytest.raises(SettingError, match="afresh"):
        carry_angles(np.zeros(16), mesh, square(3, split="AC"))
    with pytest.raises(SettingError, match="afresh"):
        direction_field(mesh, 2, before=direction_field(square(4), 2))


@pytest.mark.parametrize("symmetry", [1, 2, 4])
def test_sheets_are_the_nearest(symmetry):
    random = np.random.default_rng(symmetry)
    angles, wanted = random.uniform(-9, 9, (2, 50))
    chosen = nearest_representatives(angles, wanted, symmetry)
    turns = (chosen - angles) * symmetry / (2 * np.pi)
    np.testing.assert_allclose(turns, np.rint(turns), atol=1e-12)
    assert (np.abs(chosen - wanted) <= np.pi / symmetry + 1e-12).all()


@pytest.mark.parametrize("symmetry", [1, 2, 4])
@pytest.mark.parametrize("hold", [0.0, 0.2])
def test_a_rigid_motion_leaves_all_phases(symmetry, hold):
    mesh = bumpy_torus(10)
    other = moved(mesh, rotation(3))
    field = direction_field(mesh, symmetry)
    pattern = PATTERNS[symmetry](mesh, field, 0.6)
    following = direction_field(other, symmetry, before=field)
    after = next_pattern(other, following, WISHES, pattern.phases, hold=hold)
    np.testing.assert_allclose(following.angles, field.angles, atol=1e-4)
    np.testing.assert_allclose(after.phases, pattern.phases, atol=1e-3)
    assert after.energy == pytest.approx(pattern.energy, rel=1e-5)
    assert after.solution.status is Status.UNCERTIFIED and after.solution.energy == pytest.approx(after.energy)


def test_a_gentle_motion_changes_little():
    """Against solves of their own, whose lines lie elsewhere in every frame; the energies are not much better."""
    mesh = bumpy_torus(10)
    field = pattern = None
    warm, cold = [], []
    for height in (0.0, 0.03, 0.06):
        frame = wavy(mesh, height)
        field = direction_field(frame, 4, before=field)
        if pattern is None:
            pattern = quad_pattern(frame, field, 0.6)
        else:
            pattern = next_pattern(frame, field, WISHES, pattern.phases, hold=0.1)
        alone = quad_pattern(frame, direction_field(frame, 4), 0.6)
        warm.append(np.cos(pattern.vertex_phases).prod(axis=1))
        cold.append(np.cos(alone.vertex_phases).prod(axis=1))
    change, independent = (np.abs(np.diff(frames, axis=0)).mean() for frames in (warm, cold))
    assert change < 0.8 * independent
    assert pattern.energy < 1.3 * quad_pattern(frame, field, 0.6).energy


def test_the_hold_shortens_the_way_and_costs_energy():
    mesh = bumpy_torus(12)
    field = direction_field(mesh, 2)
    pattern = stripe_pattern(mesh, field, 0.6)
    other = wavy(mesh, 0.25)
    following = direction_field(other, 2, before=field)
    ways, energies = [], []
    for hold in (0.0, 0.1, 1.0, 100.0):
        after = next_pattern(other, following, WISHES, pattern.phases, hold=hold)
        ways.append(np.abs(after.phases - pattern.phases).mean())
        energies.append(after.energy)
    assert ways == sorted(ways, reverse=True) and ways[-1] < 0.05 * ways[0]
    assert energies == sorted(energies)


def test_the_step_is_an_implicit_one_of_the_gradient_flow():
    """At the result the energy's gradient along the circles balances the pull to where it came from."""
    problem = SynchronizationProblem(random_connection("circle", 30, 40, 1))
    before = random_values("circle", 30, np.random.default_rng(2))
    weight = 1.7
    after = next_solution(problem, before, hold=np.full(30, weight)).phases

    def gradient(energy):
        turned = [energy(after * np.exp(1j * step * np.eye(30)[k])) for k in range(30) for step in (1e-5, -1e-5)]
        return np.diff(np.reshape(turned, (30, 2)), axis=1)[:, 0] / -2e-5

    pull = gradient(lambda phases: weight * np.sum(np.abs(phases - before) ** 2))
    assert np.abs(pull).max() > 0.1
    np.testing.assert_allclose(gradient(problem.energy), -pull, atol=1e-4)


def test_what_is_fixed_stays_fixed_and_turns_nothing():
    problem = fixed_stripes(12)
    before = np.exp(0.4j) * solve(problem).phases
    for hold in (None, np.full(len(before), 0.5)):
        after = next_solution(problem, before, hold=hold)
        np.testing.assert_allclose(after.phases[problem.fixed.nodes], problem.fixed.values, atol=1e-12)
        assert after.energy == pytest.approx(problem.energy(after.phases), rel=1e-12)
    mesh = bent_square()
    wishes = DirectionWishes(rows=(Row(boundary_line(mesh), "along"),))
    field = direction_field(mesh, 2, wishes)
    again = direction_field(mesh, 2, wishes, before=field.turned(0.3))
    np.testing.assert_allclose(np.exp(2j * again.angles), np.exp(2j * field.angles), atol=1e-3)


def test_descent_needs_a_start():
    problem = SynchronizationProblem(
        random_connection("circle", 9, 9, 1), drawn=Targets(np.array([0]), np.array([1.0 + 0j]), np.array([1.0]))
    )
    with pytest.raises(SettingError, match="give one"):
        solve(problem, Options(method="descent"))
    warm = solve(problem, Options(method="descent"), start=np.ones(9))
    assert warm.energy <= problem.energy(np.ones(9)) and warm.certificate == "none" and warm.lower_bound == 0
