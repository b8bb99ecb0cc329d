# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The problem's sparse matrices against the definition of the energy, term by term."""

import numpy as np
import pytest

from synch_fields.core.connection import Connection, circle_transports
from synch_fields.core.errors import SettingError
from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.problem import Merged, SynchronizationProblem, Targets

from .frame_graphs import random_frames
from .graphs import KINDS, as_blocks, as_vectors, quadratic, random_connection, random_constraints, random_values
from .meshes import torus


def energy_by_hand(connection, phases, drawn=None):
    """Sum over edges of w |phi_j - g phi_i|^2, in real coordinates, one edge at a time."""
    vectors, total = as_vectors(phases), 0.0
    for (i, j), weight, block in zip(
        connection.edges, connection.weights, as_blocks(connection.transports), strict=True
    ):
        total += weight * ((vectors[j] - block @ vectors[i]) ** 2).sum()
    if drawn is not None:
        for node, weight, value in zip(drawn.nodes, drawn.weights, as_vectors(drawn.values), strict=True):
            total += weight * ((vectors[node] - value) ** 2).sum()
    return total


def random_coordinates(problem, seed):
    """Random unit coordinates in which every ground is 1."""
    random = np.random.default_rng(seed)
    coordinates = problem.unit_coordinates()
    blocks = coordinates.reshape(-1, problem.block)
    values = random.standard_normal(blocks.shape)
    values = values + 1j * random.standard_normal(blocks.shape) if problem.is_complex else values
    values /= np.linalg.norm(values, axis=1)[:, None]
    for piece in problem.pieces:
        if piece.ground is not None:
            ground = piece.rows[piece.ground * piece.block] // piece.block
            values[ground] = blocks[ground]
    return values.ravel()


def energy_of_pieces(problem, coordinates):
    return sum(float(piece.energy(coordinates[piece.rows][:, None])[0]) for piece in problem.pieces)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(4))
def test_energy_is_the_sum_over_edges(kind, seed):
    connection = random_connection(kind, nodes=9, extra=12, seed=seed)
    phases = random_values(kind, 9, np.random.default_rng(seed + 50))
    expected = energy_by_hand(connection, phases)
    assert connection.energy(phases) == pytest.approx(expected, rel=1e-12)
    assert SynchronizationProblem(connection).energy(phases) == pytest.approx(expected, rel=1e-12)


def test_a_flip_conjugates_before_turning():
    transports = circle_transports([0.3, -1.2, 2.5], [False, True, True])
    phase = np.exp(0.7j)
    moved = transports @ [phase.real, phase.imag]
    np.testing.assert_allclose(moved[:, 0] + 1j * moved[:, 1], [np.exp(1j), np.exp(-1.9j), np.exp(1.8j)], rtol=1e-14)
    np.testing.assert_allclose(circle_transports([0.3, 0.4]), np.exp([0.3j, 0.4j]), rtol=1e-14)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(12))
def test_pieces_have_the_energy_of_the_phases_that_they_expand_to(kind, seed):
    connection = random_connection(kind, nodes=9, extra=9, seed=seed)
    constraints = random_constraints(kind, 9, seed)
    problem = SynchronizationProblem(connection, **constraints)
    coordinates = random_coordinates(problem, seed)
    phases = problem.expand(coordinates)
    expected = energy_by_hand(connection, phases, constraints.get("drawn"))
    assert problem.energy(phases) == pytest.approx(expected, rel=1e-12)
    assert energy_of_pieces(problem, coordinates) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(12))
def test_expanded_phases_keep_the_constraints(kind, seed):
    constraints = random_constraints(kind, 9, seed)
    problem = SynchronizationProblem(random_connection(kind, nodes=9, seed=seed), **constraints)
    vectors = as_vectors(problem.expand(random_coordinates(problem, seed)))
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=1), 1, rtol=1e-12)
    if "fixed" in constraints:
        np.testing.assert_allclose(
            vectors[constraints["fixed"].nodes], as_vectors(constraints["fixed"].values), atol=1e-14
        )
    if "merged" in constraints:
        merged = constraints["merged"]
        expected = np.einsum("kab,kb->ka", as_blocks(merged.transports), vectors[merged.roots])
        np.testing.assert_allclose(vectors[merged.nodes], expected, atol=1e-14)


def natural(piece):
    """The piece's dense matrix in the order of the problem's rows."""
    order = np.argsort(piece.rows)
    return piece.matrix.toarray()[np.ix_(order, order)]


@pytest.mark.parametrize("kind", KINDS)
def test_the_matrix_is_the_dense_connection_laplacian(kind):
    connection = random_connection(kind, nodes=8, extra=10, seed=3)
    (piece,) = SynchronizationProblem(connection).pieces
    dense = quadratic(connection)[0]
    matrix = natural(piece)
    if piece.is_complex:
        blocks = np.array([[matrix.real, -matrix.imag], [matrix.imag, matrix.real]])
        matrix = blocks.transpose(2, 0, 3, 1).reshape(16, 16)
    np.testing.assert_allclose(matrix, dense, atol=1e-12)


def test_the_matrix_of_merged_nodes_is_the_contracted_laplacian():
    connection = random_connection("flips", nodes=8, extra=10, seed=4)
    random = np.random.default_rng(4)
    merged = Merged(np.array([1, 5]), np.array([2, 2]), circle_transports(random.uniform(0, 6, 2), [True, False]))
    (piece,) = SynchronizationProblem(connection, merged=merged).pieces
    assert piece.node_count == 6
    dense = quadratic(connection, merged=merged)[0]
    np.testing.assert_allclose(np.linalg.eigvalsh(piece.matrix.toarray()), np.linalg.eigvalsh(dense), atol=1e-10)


def test_masses_of_merged_nodes_add_up():
    connection = random_connection("circle", nodes=6, seed=1)
    mass = np.arange(1.0, 7.0)
    merged = Merged(np.array([0, 3]), np.array([5, 5]), np.ones(2, complex))
    (piece,) = SynchronizationProblem(connection, mass, merged=merged).pieces
    assert sorted(piece.mass.tolist()) == [2.0, 3.0, 5.0, 1.0 + 4.0 + 6.0]


def test_neighbours_are_near_in_the_matrix_however_the_nodes_are_numbered():
    mesh = torus()
    shuffled = np.random.default_rng(0).permutation(mesh.vertex_count)
    mesh = TriangleMesh(mesh.vertices[np.argsort(shuffled)], shuffled[mesh.triangles])
    (piece,) = direction_problem(mesh, 4).pieces
    tails, heads = piece.matrix.nonzero()
    assert np.abs(mesh.edges[:, 0] - mesh.edges[:, 1]).max() > 200
    assert np.abs(tails - heads).max() < 3 * 2 * 12


def test_pieces_are_the_connected_components_and_isolated_nodes_have_none():
    random = np.random.default_rng(0)
    edges = np.array([[0, 2], [2, 4], [4, 0], [5, 1], [1, 7]])
    connection = Connection(9, edges, np.ones(5), np.exp(1j * random.uniform(0, 6, 5)))
    problem = SynchronizationProblem(connection)
    assert sorted(sorted(p.rows.tolist()) for p in problem.pieces) == [[0, 2, 4], [1, 5, 7]]
    bridged = SynchronizationProblem(connection, merged=Merged(np.array([7]), np.array([4]), np.ones(1, complex)))
    assert [p.node_count for p in bridged.pieces] == [5]


def test_each_connected_piece_has_a_ground_of_its_own():
    edges = np.array([[0, 1], [1, 2], [3, 4], [4, 5], [6, 7]])
    connection = Connection(8, edges, np.ones(5), np.ones(5, complex))
    fixed = Targets(np.array([0, 3]), np.exp(np.array([0.5j, 2j])))
    problem = SynchronizationProblem(connection, fixed=fixed)
    assert sorted(p.ground is None for p in problem.pieces) == [False, False, True]
    phases = problem.expand(problem.unit_coordinates())
    np.testing.assert_allclose(phases[[0, 3]], fixed.values)


@pytest.mark.parametrize("kind", ["flips", "rotations"])
def test_the_unused_rows_of_the_ground_are_costly(kind):
    random = np.random.default_rng(2)
    connection = random_connection(kind, nodes=7, seed=2)
    problem = SynchronizationProblem(connection, fixed=Targets(np.array([1]), random_values(kind, 1, random)))
    (piece,) = problem.pieces
    assert len(piece.unused_rows) == problem.block - 1
    matrix = piece.matrix.toarray()
    for row in piece.unused_rows:
        off_diagonal = np.delete(matrix[row], row)
        assert not off_diagonal.any() and matrix[row, row] > 0
    used = np.setdiff1d(np.arange(len(matrix)), piece.unused_rows)
    expected = (piece.factor.T @ piece.factor).toarray()[np.ix_(used, used)]
    np.testing.assert_allclose(matrix[np.ix_(used, used)], expected, atol=1e-12)


@pytest.mark.parametrize(
    ("constraints", "node"),
    [
        (dict(fixed=Targets(np.array([1, 1]), np.ones(2, complex))), 1),
        (dict(merged=Merged(np.array([2, 2]), np.array([0, 1]), np.ones(2, complex))), 2),
        (
            dict(
                fixed=Targets(np.array([3]), np.ones(1, complex)),
                merged=Merged(np.array([3]), np.array([0]), np.ones(1, complex)),
            ),
            3,
        ),
        (
            dict(
                fixed=Targets(np.array([0]), np.ones(1, complex)),
                merged=Merged(np.array([3]), np.array([0]), np.ones(1, complex)),
            ),
            0,
        ),
        (dict(merged=Merged(np.array([1, 2]), np.array([2, 4]), np.ones(2, complex))), 2),
        (dict(merged=Merged(np.array([4]), np.array([4]), np.ones(1, complex))), 4),
    ],
)
def test_conflicting_constraints_are_refused_by_the_name_of_the_node(constraints, node):
    with pytest.raises(SettingError, match=f"node {node} "):
        SynchronizationProblem(random_connection("circle", nodes=6), **constraints)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(6))
def test_coordinates_of_expanded_phases_are_those_they_came_from(kind, seed):
    constraints = random_constraints(kind, 9, seed)
    problem = SynchronizationProblem(random_connection(kind, nodes=9, seed=seed), **constraints)
    coordinates = random_coordinates(problem, seed)
    np.testing.assert_allclose(problem.coordinates(problem.expand(coordinates)), coordinates, atol=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("fibre", ["orthogonal", "rotations"])
def test_unit_coordinates_of_frames_are_the_frame_at_every_node(fibre, dimension):
    """Of nodes that nothing constrains; the relaxation's lifted point begins with them where no piece tells more."""
    random = np.random.default_rng(dimension)
    edges = np.array([[0, 1], [1, 2]])  # and a node alone
    transports = random_frames(2, dimension, random)
    problem = SynchronizationProblem(Connection(4, edges, np.ones(2), transports), fibre=fibre)
    frames = problem.expand(problem.unit_coordinates())
    np.testing.assert_allclose(frames, np.tile(np.eye(dimension), (4, 1, 1)), atol=1e-14)
    np.testing.assert_allclose(problem.coordinates(frames), problem.unit_coordinates(), atol=1e-14)
