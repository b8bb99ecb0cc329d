# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that carry frames: rotations and orthogonal matrices, by the solver that unit vectors have."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import polar
from scipy.sparse.csgraph import laplacian as graph_laplacian

from synch_fields.core.algebra.orthonormal import gram, nearest, orthonormalize, tangent_part
from synch_fields.core.connection import Connection, Fibre, circle_transports
from synch_fields.core.errors import SettingError
from synch_fields.core.problem import Merged, SynchronizationProblem, Targets, as_matrices
from synch_fields.core.solve import Certificate, Options, Status, solve
from synch_fields.core.solve.methods.manifolds import Columns, Lifted

from ..frame_graphs import (
    brute_force_frames,
    energy_by_hand,
    frame_laplacian,
    frame_relaxation,
    noisy_rotations,
    random_edges,
    random_frames,
)
from ..layered_solids import block

TIGHT = Options(target_gap=1e-6)


def rotations_of(connection, **constraints):
    return SynchronizationProblem(connection, fibre=Fibre.ROTATIONS, **constraints)


def assert_rotations(frames):
    np.testing.assert_allclose(frames @ frames.swapaxes(1, 2), np.broadcast_to(np.eye(3), frames.shape), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(frames), 1, atol=1e-12)


def test_three_poses_come_back_as_three_rotations():
    connection, truth = noisy_rotations(3, 6, 0.0, seed=0)
    solution = solve(rotations_of(connection))
    assert solution.phases.shape == (3, 3, 3) and solution.certificate is Certificate.PROVED
    assert solution.energy < 1e-25
    np.testing.assert_allclose(solution.phases @ solution.phases[0].T, truth @ truth[0].T, atol=1e-13)
    assert solve(SynchronizationProblem(connection)).phases.shape == (3, 3)  # one unit vector a node unless asked


@pytest.mark.parametrize(("nodes", "angle", "seed"), [(8, 0.6, 1), (10, np.pi, 2), (12, 1.5, 3), (9, np.pi, 4)])
def test_the_relaxation_is_that_of_an_interior_point_method(nodes, angle, seed):
    connection, _ = noisy_rotations(nodes, 3 * nodes, angle, seed)
    below, above = frame_relaxation(frame_laplacian(connection), 3)
    assert below == pytest.approx(above, rel=1e-7)
    solution = solve(rotations_of(connection), TIGHT)
    assert solution.certificate is Certificate.PROVED and solution.status is Status.CERTIFIED
    assert solution.sdp_value == pytest.approx(below, rel=1e-6)
    assert solution.lower_bound <= above and solution.energy >= below * (1 - 1e-9)
    assert_rotations(solution.phases)
    assert solution.energy == pytest.approx(energy_by_hand(connection, solution.phases), rel=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_it_is_exact_below_the_noise_of_strong_duality(seed):
    """Eriksson, Olsson, Kahl and Chin (2018): where all residuals of an optimum are below an angle that the graph's
    connectivity tells, the relaxation is tight there."""
    connection, truth = noisy_rotations(20, 150, 0.2, seed, weights=False)
    adjacency = np.zeros((20, 20))
    adjacency[tuple(connection.edges.T)] = adjacency[tuple(connection.edges.T[::-1])] = 1
    spectrum = np.linalg.eigvalsh(graph_laplacian(adjacency))
    allowed = 2 * np.arcsin(np.sqrt(0.25 + spectrum[1] / (2 * adjacency.sum(axis=1).max())) - 0.5)
    solution = solve(rotations_of(connection), TIGHT)
    i, j = connection.edges.T
    found = solution.phases
    residuals = found[j].swapaxes(1, 2) @ connection.transports @ found[i]
    angles = np.arccos(np.clip((np.trace(residuals, axis1=1, axis2=2) - 1) / 2, -1, 1))
    assert 0 < angles.max() < allowed
    assert solution.status is Status.CERTIFIED and solution.rank == 3
    assert solution.energy == pytest.approx(solution.lower_bound, rel=2e-6)
    assert solution.energy < connection.energy(truth)


@pytest.mark.parametrize("fibre", [Fibre.ROTATIONS, Fibre.ORTHOGONAL])
@pytest.mark.parametrize("seed", range(2))
def test_bounds_are_below_and_energies_near_the_best_of_many_searches(fibre, seed):
    connection, _ = noisy_rotations(5, 10, np.pi, seed)
    best = brute_force_frames(connection, fibre is Fibre.ROTATIONS)
    solution = solve(SynchronizationProblem(connection, fibre=fibre), Options(target_gap=1e-4))
    assert solution.lower_bound <= best * (1 + 1e-9)
    assert best * (1 - 1e-7) <= solution.energy <= best * (1 + 1e-5)


def test_reflections_are_found_where_transports_ask_for_them():
    random, (noisy, _) = np.random.default_rng(5), noisy_rotations(40, 100, 0.3, 5)
    mirrors = np.where(random.random(40) < 0.5, -1.0, 1.0)
    i, j = noisy.edges.T
    connection = replace(noisy, transports=(mirrors[i] * mirrors[j])[:, None, None] * noisy.transports)
    solution = solve(SynchronizationProblem(connection, fibre="orthogonal"), TIGHT)
    dets = np.linalg.det(solution.phases)
    np.testing.assert_allclose(dets * dets[0], mirrors * mirrors[0], atol=1e-12)
    assert solution.energy == pytest.approx(solve(rotations_of(noisy), TIGHT).energy, rel=1e-6)


def test_rotations_of_the_plane_have_twice_the_energy_of_their_phases():
    random = np.random.default_rng(2)
    edges = random_edges(60, 150, random)
    turns = circle_transports(random.uniform(-2, 2, len(edges)))
    circle = solve(SynchronizationProblem(Connection(60, edges, np.ones(len(edges)), turns)), TIGHT)
    frames = solve(rotations_of(Connection(60, edges, np.ones(len(edges)), as_matrices(turns))), TIGHT)
    assert frames.sdp_value == pytest.approx(2 * circle.sdp_value, rel=3e-6)
    assert frames.energy == pytest.approx(2 * circle.energy, rel=0.02)
    assert frames.energy >= 2 * circle.lower_bound


@pytest.mark.parametrize("angle", [0.4, 1.8])
def test_other_frames_at_the_nodes_give_the_same_rotations(angle):
    connection, _ = noisy_rotations(60, 200, angle, 1)
    turns = random_frames(60, 3, np.random.default_rng(9))
    i, j = connection.edges.T
    turned = replace(connection, transports=turns[j] @ connection.transports @ turns[i].swapaxes(1, 2))
    here, there = (solve(rotations_of(given), Options(target_gap=1e-5)) for given in (connection, turned))
    assert there.sdp_value == pytest.approx(here.sdp_value, rel=2e-5)
    assert there.energy == pytest.approx(here.energy, rel=1e-8 if angle < 1 else 0.05)
    if angle < 1:
        back = turns.swapaxes(1, 2) @ there.phases
        np.testing.assert_allclose(back @ back[0].T, here.phases @ here.phases[0].T, atol=1e-4)


def test_fixed_drawn_and_merged_rotations_are_kept():
    connection, _ = noisy_rotations(30, 60, 1.0, 3)
    random = np.random.default_rng(1)
    fixed = Targets(np.array([2, 7]), random_frames(2, 3, random))
    drawn = Targets(np.array([4, 11, 12]), random_frames(3, 3, random), np.array([0.5, 3.0, 1.0]))
    merged = Merged(np.array([20, 21]), np.array([19, 19]), random_frames(2, 3, random))
    problem = rotations_of(connection, fixed=fixed, drawn=drawn, merged=merged)
    solution = solve(problem, Options(target_gap=1e-4))
    assert_rotations(solution.phases)
    np.testing.assert_allclose(solution.phases[fixed.nodes], fixed.values, atol=1e-12)
    np.testing.assert_allclose(solution.phases[merged.nodes], merged.transports @ solution.phases[19], atol=1e-12)
    pulled = ((solution.phases[drawn.nodes] - drawn.values) ** 2).sum(axis=(1, 2))
    by_hand = energy_by_hand(connection, solution.phases) + drawn.weights @ pulled
    assert solution.energy == pytest.approx(by_hand, rel=1e-12)
    assert solution.certificate is Certificate.PROVED and 0 < solution.lower_bound <= solution.energy
    np.testing.assert_allclose(problem.expand(problem.coordinates(solution.phases)), solution.phases, atol=1e-12)
    # Free rotations cost less.
    assert solve(rotations_of(connection)).energy < connection.energy(solution.phases)


def test_several_pieces_are_solved_each_and_perfect_ones_at_once():
    first, _ = noisy_rotations(12, 30, 1.0, 3)
    second, truth = noisy_rotations(10, 20, 0.0, 4)
    parts = [(getattr(first, name), getattr(second, name)) for name in ("weights", "transports")]
    both = Connection(22, np.vstack([first.edges, second.edges + 12]), *(np.concatenate(part) for part in parts))
    solution = solve(rotations_of(both), TIGHT)
    alone = solve(rotations_of(first), TIGHT)
    assert solution.energy == pytest.approx(alone.energy, rel=1e-6) and solution.status is Status.CERTIFIED
    np.testing.assert_allclose(solution.phases[12:] @ solution.phases[12].T, truth @ truth[0].T, atol=1e-12)


def test_methods_keep_their_order():
    connection, _ = noisy_rotations(60, 150, 2.0, 1)
    problem = rotations_of(connection)
    spectral, diffusion, best = (solve(problem, Options(method=name)) for name in ("spectral", "diffusion", "sdp"))
    dense = np.linalg.eigvalsh(frame_laplacian(connection))
    assert spectral.lower_bound == pytest.approx(60 * dense[:3].sum(), rel=1e-6)
    assert spectral.lower_bound <= best.lower_bound <= best.energy <= spectral.energy
    assert best.energy <= diffusion.energy * (1 + 1e-9)
    roundings = [solve(problem, Options(rounding=name)) for name in ("svd", "random", "polish")]
    energies = [found.energy for found in (*roundings, best)]
    assert (np.diff(energies[:3]) <= 1e-6 * energies[0]).all() and energies[3] <= energies[0]
    again = solve(problem, Options(method="descent"), start=best.phases)
    assert again.energy == pytest.approx(best.energy, rel=1e-9)
    for solution in (spectral, diffusion, best, again, *roundings):
        assert_rotations(solution.phases)
        assert solution.energy == pytest.approx(energy_by_hand(connection, solution.phases), rel=1e-12)


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"fibre": "quaternions"}, "the fibre 'quaternions' is unknown: use one of vectors, orthogonal, rotations"),
        ({"transports": np.ones(3, complex)}, "nodes carry rotations and the transports are complex numbers"),
        ({"transports": np.stack([np.eye(3), -np.eye(3), np.eye(3)])}, "the transport of edge 1 is a reflection"),
        ({"fixed": Targets([0], np.ones((1, 3)))}, "values of fixed nodes have the shape (1, 3): give (1, 3, 3)"),
        ({"fixed": Targets([0], np.ones((1, 3, 3)))}, "the value of fixed node 0 is [[1.0, 1.0, 1.0]"),
        ({"fixed": Targets([0], -np.eye(3)[None])}, "the value of fixed node 0 is a reflection: give rotations"),
    ],
)
def test_what_does_not_fit_is_refused_in_one_line(change, line):
    edges, given = np.array([[0, 1], [1, 2], [0, 2]]), {"fibre": "rotations"} | change
    transports = given.pop("transports", np.tile(np.eye(3), (3, 1, 1)))
    with pytest.raises(SettingError) as error:
        SynchronizationProblem(Connection(3, edges, np.ones(3), transports), **given)
    assert str(error.value).startswith(line) and "\n" not in str(error.value)


def test_a_start_of_another_shape_is_refused():
    connection, truth = noisy_rotations(4, 3, 0.1, 0)
    with pytest.raises(SettingError, match=r"the start has the shape \(4, 3\)"):
        solve(rotations_of(connection), start=truth[:, 0])


def test_nearest_frames_are_polar_factors():
    matrices = np.random.default_rng(0).standard_normal((21, 3, 3))
    for found, given in zip(nearest(matrices, False), matrices, strict=True):
        np.testing.assert_allclose(found, polar(given)[0], atol=1e-12)
    found = nearest(matrices, True)
    np.testing.assert_allclose(np.linalg.det(found), 1)
    others = random_frames(2000, 3, np.random.default_rng(1))
    for frame, given in zip(found, matrices, strict=True):
        assert np.vdot(frame, given) >= np.einsum("nab,ab->n", others, given).max()
    # A field and its mirror image as a whole have the same rotations near them.
    fields = np.stack([matrices, matrices @ np.diag([1, 1, -1])], axis=1)
    found = nearest(fields, True, among=0)
    np.testing.assert_allclose(found[:, 0], found[:, 1], atol=1e-12)
    assert (np.linalg.det(fields[:, 0]) > 0).sum() not in (0, 21)
    np.testing.assert_array_equal(nearest(np.zeros((1, 3, 3)), True)[0], np.eye(3))


@pytest.mark.parametrize("shape", [(5, 1, 4), (5, 3, 7), (5, 3, 3, 2), (5, 1, 3, 2)])
def test_tangent_vectors_keep_frames_orthonormal_to_first_order(shape):
    random = np.random.default_rng(3)
    point = orthonormalize(random.standard_normal(shape))
    unit = np.eye(shape[1]).reshape(1, shape[1], shape[1], *[1] * (len(shape) - 3))
    np.testing.assert_allclose(gram(point, point), np.broadcast_to(unit, gram(point, point).shape), atol=1e-13)
    tangent = tangent_part(point, random.standard_normal(shape))
    np.testing.assert_allclose(gram(point, tangent), 0, atol=1e-13)
    np.testing.assert_allclose(tangent_part(point, tangent), tangent, atol=1e-13)
    moved = orthonormalize(point + 1e-5 * tangent)
    np.testing.assert_allclose(moved, point + 1e-5 * tangent, atol=1e-9)


@pytest.mark.parametrize(
    ("spheres", "columns"), [(Lifted(3, 3), 5), (Columns(3, Fibre.ROTATIONS), 2), (Columns(3, Fibre.ORTHOGONAL), 2)]
)
def test_gradients_are_the_slopes_along_moves(spheres, columns):
    random = np.random.default_rng(0)
    matrix = frame_laplacian(noisy_rotations(6, 9, 1.0, 0)[0])
    rows = len(matrix) * (1 if isinstance(spheres, Lifted) else 3)

    def image(point):
        return (matrix @ point.reshape(len(matrix), -1)).reshape(point.shape)

    point = spheres.normalize(random.standard_normal((rows, columns)))
    gradient = spheres.gradient(point, image(point))
    tangent = spheres.tangent(point, random.standard_normal(gradient.shape))
    count = len(spheres.inner(tangent, tangent))

    def energies(step):
        moved = spheres.move(point, tangent, np.full(count, step))
        return spheres.energies(moved, image(moved))

    slopes = (8 * (energies(1e-3) - energies(-1e-3)) - (energies(2e-3) - energies(-2e-3))) / 12e-3
    np.testing.assert_allclose(2 * spheres.inner(gradient, tangent), slopes, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("size", [2, 3])
def test_bounds_of_frames_with_signs_as_transports_are_proved(size):
    """Their multipliers fill blocks of the diagonal where the matrix has no entries."""
    solid = block((8, 7, 6))
    random = np.random.default_rng(size)
    signs = np.eye(size) * random.choice([-1.0, 1.0], (len(solid.edges), size))[:, None, :]
    connection = Connection(solid.vertex_count, solid.edges, np.ones(len(solid.edges)), signs)
    solution = solve(SynchronizationProblem(connection, fibre=Fibre.ORTHOGONAL))
    assert solution.certificate is Certificate.PROVED
    assert solution.lower_bound <= solution.energy
