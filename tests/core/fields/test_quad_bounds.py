# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounds, relaxations and optima of quad patterns, in real and in complex coordinates."""

import numpy as np
import pytest

from synch_fields.core.connection import Connection, as_matrices, circle_transports
from synch_fields.core.fields import direction_field, given_directions, quad_pattern
from synch_fields.core.fields.patterns import PatternWishes, pattern_problem
from synch_fields.core.fields.target_one_form import TargetOneForm
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.problem import SynchronizationProblem, Targets
from synch_fields.core.solve import Options, Status, solve

from ..flat_crosses import plane_crosses, random_turns, turned_crosses
from ..graphs import brute_force, lifted_matrix, relaxation
from ..meshes import annulus, bent_square, cube, double_torus, icosphere, octahedron, rounded_cube, square, torus


def with_a_twist(problem):
    """The same problem beside a ring of three nodes that keeps a flip: everything is solved in real coordinates.

    The ring costs nothing, with all phases 1 or all -1.
    """
    old = problem.connection
    count = old.node_count
    ring = count + np.array([[0, 1], [1, 2], [2, 0]])
    connection = Connection(
        count + 3,
        np.concatenate([old.edges, ring]),
        np.append(old.weights, np.ones(3)),
        np.concatenate([as_matrices(old.transports), circle_transports(np.zeros(3), np.array([True, False, False]))]),
    )
    mass = np.append(problem.mass, np.full(3, problem.mass.mean()))
    return SynchronizationProblem(connection, mass, problem.merged, problem.fixed, problem.drawn)


def unremarkable(build, spacing, seed=0):
    """A quad problem without disclinations, full of flips that other representatives would not have."""
    mesh = build()
    field = turned_crosses(direction_field(mesh, 4), random_turns(mesh, seed))
    assert field.disclinations == []
    return pattern_problem(mesh, field, PatternWishes(spacing))


@pytest.mark.full_search
@pytest.mark.parametrize(
    ("build", "spacing"),
    [
        (bent_square, 0.19),
        (lambda: bent_square(14), 0.31),
        (lambda: annulus(rings=4, segments=32), 0.47),
        (square, 0.2),
    ],
)
def test_flips_that_can_be_removed_leave_a_complex_problem_of_the_same_value(build, spacing):
    problem = unremarkable(build, spacing)
    assert problem.connection.transports.ndim == 3 and problem.is_complex
    real = with_a_twist(problem)
    assert not real.is_complex
    options = Options(target_gap=1e-6, rounding="svd")
    first, second = solve(problem, options), solve(real, options)
    assert first.status is second.status is Status.CERTIFIED
    assert second.sdp_value == pytest.approx(first.sdp_value, rel=2e-6, abs=1e-10)
    assert second.lower_bound == pytest.approx(first.lower_bound, rel=2e-6, abs=1e-10)
    # Phases of the one are phases of the other.
    assert problem.energy(second.phases[:-3]) == pytest.approx(second.energy, rel=1e-9, abs=1e-10)
    assert second.energy >= first.lower_bound * (1 - 1e-9) - 1e-10


def test_fixed_phases_do_not_come_between_the_two_ways():
    free = unremarkable(bent_square, 0.23)
    nodes = np.array([0, 31, 90])
    fixed = Targets(nodes, np.exp([0.3j, -2j, 1j]))
    problem = SynchronizationProblem(free.connection, free.mass, fixed=fixed)
    options = Options(target_gap=1e-6, rounding="svd")
    first, second = (solve(p, options) for p in (problem, with_a_twist(problem)))
    assert problem.is_complex and first.lower_bound > solve(free, options).lower_bound
    assert second.sdp_value == pytest.approx(first.sdp_value, rel=2e-6)
    assert second.lower_bound == pytest.approx(first.lower_bound, rel=2e-6)
    for solution in (first, second):
        np.testing.assert_allclose(solution.phases[nodes], fixed.values, atol=1e-9)


@pytest.mark.parametrize("build", [lambda: icosphere(2), cube, torus, double_torus])
def test_quads_around_disclinations_need_real_coordinates(build):
    mesh = build()
    problem = pattern_problem(mesh, direction_field(mesh, 4), PatternWishes(np.ptp(mesh.vertices, axis=0).max() / 5))
    assert not problem.is_complex and problem.block == 2
    assert sum(piece.node_count for piece in problem.pieces) == 2 * mesh.vertex_count


def test_two_waves_are_two_pieces_until_a_disclination_joins_them():
    flat, sphere = square(5), icosphere(1)
    assert len(pattern_problem(flat, plane_crosses(flat)[0], PatternWishes(0.4)).pieces) == 2
    assert len(pattern_problem(sphere, direction_field(sphere, 4), PatternWishes(0.4)).pieces) == 1


# Brute force


def fan():
    """Four triangles around a vertex, bent: five vertices with a boundary."""
    return TriangleMesh(
        [[0, 0, 0.4], [1, 0, 0], [0, 1.2, 0.1], [-0.9, 0, 0], [0.1, -1, 0.3]],
        [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]],
    )


TINY = [
    pytest.param(lambda: octahedron((1.0, 1.3, 0.7)), id="octahedron"),
    pytest.param(
        lambda: TriangleMesh(np.eye(4)[:, :3], [[0, 1, 3], [1, 2, 3], [2, 0, 3], [0, 2, 1]]), id="tetrahedron"
    ),
    pytest.param(fan, id="fan"),
    pytest.param(lambda: square(1), id="two-triangles"),
]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("build", TINY)
def test_tiny_patterns_lie_between_their_bound_and_the_optimum(build, seed):
    mesh = build()
    random = np.random.default_rng(seed)
    field = given_directions(mesh, 4, random.standard_normal((mesh.vertex_count, 3)))
    spacing = random.uniform(0.4, 1.0, mesh.vertex_count)
    connection = TargetOneForm.of(mesh, field, spacing).connection
    problem = pattern_problem(mesh, field, PatternWishes(spacing))
    solution = solve(problem, Options(target_gap=1e-4, samples=32))
    best = brute_force(connection)
    assert solution.lower_bound <= best * (1 + 1e-9) + 1e-10
    assert best * (1 - 1e-8) - 1e-10 <= solution.energy <= best * (1 + 1e-5) + 1e-10
    below, above = relaxation(*lifted_matrix(connection))
    assert solution.sdp_value == pytest.approx(above, rel=2e-4, abs=1e-8)
    assert (1 - 2e-4) * below - 1e-9 <= solution.lower_bound <= above * (1 + 1e-9) + 1e-10


@pytest.mark.parametrize("build", TINY)
def test_the_optimum_of_a_tiny_pattern_does_not_depend_on_representatives(build):
    mesh = build()
    field = given_directions(mesh, 4, np.random.default_rng(8).standard_normal((mesh.vertex_count, 3)))
    bests = [
        brute_force(TargetOneForm.of(mesh, turned_crosses(field, random_turns(mesh, seed)), 0.7).connection)
        for seed in range(3)
    ]
    np.testing.assert_allclose(bests, bests[0], rtol=1e-8, atol=1e-10)


# Methods


@pytest.mark.parametrize(("build", "cells"), [(rounded_cube, 7), (torus, 4), (double_torus, 7), (bent_square, 4)])
def test_the_relaxation_lies_between_the_bound_and_every_method(build, cells):
    mesh = build()
    field, spacing = direction_field(mesh, 4), np.linalg.norm(np.ptp(mesh.vertices, axis=0)) / cells
    solution = quad_pattern(mesh, field, spacing).solution
    assert solution.status is Status.CERTIFIED and solution.certificate == "proved"
    assert solution.lower_bound <= solution.sdp_value * (1 + 1e-9) <= solution.energy * (1 + 2e-9)
    assert solution.sdp_gap <= 1e-2 * (1 + 1e-6)
    spectral = quad_pattern(mesh, field, spacing, options=Options(method="spectral")).solution
    assert spectral.energy >= solution.energy * (1 - 1e-9)
    assert spectral.spectral_bound <= solution.sdp_value * (1 + 1e-6)  # Eq. (23)
    for rounding in ("svd", "random"):
        rough = quad_pattern(mesh, field, spacing, options=Options(rounding=rounding)).solution
        assert rough.energy >= solution.lower_bound
        assert rough.lower_bound == pytest.approx(solution.lower_bound, rel=1e-9)
