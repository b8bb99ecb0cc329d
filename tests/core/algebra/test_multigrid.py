# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The covariant multigrid: what its aggregates carry, its cycle against dense matrices, and its convergence factor."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.sparse import block_diag, bsr_matrix, coo_array, diags_array
from scipy.sparse.csgraph import dijkstra
from scipy.sparse.linalg import eigsh

from synch_fields.core.algebra import metric as metric_module
from synch_fields.core.algebra.coarsening import (
    StrongGraph,
    aggregates,
    graph_laplacian,
    scalar_aggregates,
    truncated,
    turning_laplacian,
)
from synch_fields.core.algebra.metric import SMALL_AGGREGATES, Hierarchy, Metric
from synch_fields.core.connection import compose
from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.piece import Piece
from synch_fields.core.problem import Merged, SynchronizationProblem
from synch_fields.core.solve.methods.stage import Stage, Workspace

from ..direction_wishes import along_curvature, bordered_problem
from ..graphs import (
    KINDS,
    fixed_stripes,
    half_turned_stripes,
    laplacian,
    only_piece,
    random_laplacian,
    random_units,
    random_weights,
)
from ..meshes import bent_square, bumpy_torus, cube, cylinder, torus
from ..multigrid_problems import MULTILEVEL


def adjoint(units):
    return units.conj() if units.ndim == 1 else units.transpose(0, 2, 1)


def diagonal_of(units):
    """The sparse matrix that multiplies every node's rows by its unit."""
    return (
        diags_array(units).tocsr() if units.ndim == 1 else block_diag([coo_array(unit) for unit in units], format="csr")
    )


def flat_laplacian(group, mesh, random):
    """(n,) or (n, d, d) units that are parallel, the Laplacian of their connection, and its block."""
    units = random_units(group, mesh.vertex_count, random)
    i, j = mesh.edges.T
    connection = random_weights(mesh, compose(units[j], adjoint(units[i])), random)
    return units, laplacian(connection), connection.block


# Aggregates


@pytest.mark.parametrize("group", KINDS)
@pytest.mark.parametrize("build", [lambda: bumpy_torus(10), bent_square, lambda: cube(5)])
def test_every_node_follows_one_root_at_most_two_edges_away(group, build):
    mesh = build()
    matrix, block = random_laplacian(mesh, group, seed=1)
    tentative, ground = aggregates(matrix, block, None, np.random.default_rng(0))
    assert ground is None and tentative.dtype == matrix.dtype
    blocks = bsr_matrix(tentative, blocksize=(block, block))
    np.testing.assert_array_equal(np.diff(blocks.indptr), 1)
    label = blocks.indices
    np.testing.assert_array_equal(np.unique(label), np.arange(tentative.shape[1] // block))
    np.testing.assert_allclose(
        blocks.data.conj().transpose(0, 2, 1) @ blocks.data, np.tile(np.eye(block), (len(label), 1, 1)), atol=1e-14
    )
    is_root = (blocks.data == np.eye(block)).all(axis=(1, 2))
    if group != "signs":  # whose units are 1 for half of the nodes
        np.testing.assert_array_equal(np.bincount(label[is_root]), 1)
    strong = StrongGraph(matrix, block)
    graph = diags_array(np.zeros(mesh.vertex_count)).tolil()
    graph[strong.tails, strong.heads] = 1
    distances = dijkstra(graph.tocsr(), unweighted=True, indices=np.flatnonzero(is_root))
    same = label[is_root][:, None] == label
    assert (np.where(same, distances, np.inf).min(axis=0) <= 2).all()
    if group != "signs":
        assert (distances[:, is_root] + 9 * np.eye(is_root.sum()) > 2).all()


@pytest.mark.parametrize("group", KINDS)
@pytest.mark.parametrize("build", [lambda: bumpy_torus(12), bent_square, lambda: cube(6)])
def test_aggregates_of_a_flat_connection_carry_its_parallel_field(group, build):
    random = np.random.default_rng(3)
    units, matrix, block = flat_laplacian(group, build(), random)
    tentative, _ = aggregates(matrix, block, None, random)
    assert tentative.shape[1] < 0.4 * tentative.shape[0]
    value = random.standard_normal(block)
    field = units if group == "circle" else (units @ value).ravel()
    np.testing.assert_allclose(matrix @ field, 0, atol=1e-11)  # it is parallel
    sizes = np.asarray(abs(tentative).power(2).sum(axis=0)).ravel()
    coarse = (tentative.conj().T @ field) / sizes
    np.testing.assert_allclose(tentative @ coarse, field, atol=1e-12)
    # So it is parallel on the coarse level, which is a flat connection again.
    coarse_matrix = tentative.conj().T @ matrix @ tentative
    np.testing.assert_allclose(coarse_matrix @ coarse, 0, atol=1e-10)


@pytest.mark.parametrize("group", ["circle", "flips"])
@pytest.mark.parametrize("build", [lambda: bumpy_torus(12), bent_square])
def test_the_same_aggregates_carry_turns_and_values_on_nodes(group, build):
    random = np.random.default_rng(3)
    units, matrix, block = flat_laplacian(group, build(), random)
    tentative, _ = aggregates(matrix, block, None, random)
    cases = [(np.ones(len(units)), graph_laplacian, False)]
    if block == 2:
        cases.append((np.sign(np.linalg.det(units)), turning_laplacian, True))
    for field, make, of_turns in cases:
        np.testing.assert_allclose(make(matrix, block) @ field, 0, atol=1e-11)
        scalar = scalar_aggregates(tentative, block, of_turns)
        assert scalar.shape == (len(units), tentative.shape[1] // block)
        np.testing.assert_array_equal(np.diff(scalar.indptr), 1)
        np.testing.assert_array_equal(abs(scalar).data, 1)
        sizes = np.asarray(abs(scalar).sum(axis=0)).ravel()
        np.testing.assert_allclose(scalar @ (scalar.T @ field / sizes), field, atol=1e-12)


@pytest.mark.parametrize("build", MULTILEVEL)
def test_the_ground_stays_alone(build):
    piece = only_piece(build())
    tentative, coarse_ground = aggregates(piece.matrix, piece.block, piece.ground, np.random.default_rng(0))
    if piece.ground is None:
        assert coarse_ground is None
        return
    blocks = bsr_matrix(tentative, blocksize=(piece.block, piece.block))
    assert blocks.indices[piece.ground] == coarse_ground
    assert (blocks.indices == coarse_ground).sum() == 1
    np.testing.assert_array_equal(blocks.data[piece.ground], np.eye(piece.block))


@pytest.mark.parametrize("build", MULTILEVEL)
def test_levels_share_out_the_mass_and_are_galerkin_products(build):
    piece = only_piece(build())
    levels = Hierarchy(piece.matrix, piece.row_mass, piece.block, piece.ground).levels
    assert len(levels) >= 2 and levels[-1].prolongation is None
    for finer, coarser in pairwise(levels):
        assert coarser.row_mass.sum() == pytest.approx(piece.row_mass.sum(), rel=1e-5)
        assert (coarser.row_mass > 0).all()
        prolongation = finer.prolongation.toarray().astype(piece.matrix.dtype)
        expected = prolongation.conj().T @ (finer.matrix.astype(piece.matrix.dtype) @ prolongation)
        # What cancels is rounded to the last digit of the largest entry.
        rounding = 4 * np.finfo(np.float32).eps * np.abs(finer.matrix.data).max()
        np.testing.assert_allclose(coarser.matrix.toarray(), expected, atol=2e-5 * np.abs(expected).max() + rounding)
        scale = diags_array(1 / np.sqrt(finer.matrix.diagonal().real.astype(float)))
        (largest,) = eigsh((scale @ finer.matrix @ scale).astype(piece.matrix.dtype), k=1, return_eigenvectors=False)
        # Damped Jacobi smoothing and prolongation converge with this much to spare.
        assert 0.9 * largest <= finer.largest <= 1.3 * largest


# The V-cycle


@pytest.mark.parametrize("build", MULTILEVEL)
@pytest.mark.parametrize("share", [1e-4, 100])
def test_the_cycle_is_hermitian_positive_and_near_the_inverse(build, share):
    """With Jacobi before and after, no error grows and none turns over: 0 < spectrum <= 1, but for lumped masses."""
    piece = only_piece(build())
    uneven = np.ptp(np.log(piece.matrix.diagonal().real)) > np.log(1000)
    metric = Metric(
        Hierarchy(piece.matrix, piece.row_mass, piece.block, piece.ground), max(share * piece.stiffness, 1e-9)
    )
    inverse = metric.solve(np.eye(piece.matrix.shape[0], dtype=piece.matrix.dtype))
    np.testing.assert_allclose(inverse, inverse.conj().T, atol=(1e-4 if uneven else 3e-6) * np.abs(inverse).max())
    root = np.linalg.cholesky(piece.matrix.toarray() + metric.shift * np.diag(piece.row_mass))
    spectrum = np.linalg.eigvalsh(root.conj().T @ inverse @ root)
    assert spectrum[-1] <= (1.1 if uneven else 1.02)
    assert spectrum[0] >= 0.15


@pytest.mark.parametrize("build", MULTILEVEL)
@pytest.mark.parametrize("share", [1e-4])
def test_descents_take_the_sum_of_smoothing_and_the_coarser_levels(build, share):
    """ADDED_STEP times the damped inverse diagonal, and the cycle of the next level between its prolongation."""
    piece = only_piece(build())
    hierarchy = Hierarchy(piece.matrix, piece.row_mass, piece.block, piece.ground)
    metric = Metric(hierarchy, max(share * piece.stiffness, 1e-9))
    level = hierarchy.levels[0]
    prolongation = level.prolongation.toarray()
    diagonal = level.matrix.diagonal().real + metric.shift * level.row_mass
    step = metric_module.ADDED_STEP * 2 / (level.largest * (1 + metric_module.SMOOTHED_PART)) / diagonal
    coarse = Metric(hierarchy, metric.shift, 1).solve(prolongation.conj().T)
    result = metric.precondition(np.eye(piece.matrix.shape[0], dtype=piece.matrix.dtype))
    expected = np.diag(step) + prolongation @ coarse
    np.testing.assert_allclose(result, expected, atol=1e-4 * np.abs(expected).max())
    # Where the parts meet it is too long, nowhere much too short.
    root = np.linalg.cholesky(piece.matrix.toarray() + metric.shift * np.diag(piece.row_mass))
    spectrum = np.linalg.eigvalsh(root.conj().T @ result @ root)
    assert 0.15 <= spectrum[0] and spectrum[-1] <= 2.7


@pytest.mark.parametrize("build", MULTILEVEL)
def test_from_a_coarse_level_on_it_is_the_inverse_there(build):
    piece = only_piece(build())
    hierarchy = Hierarchy(piece.matrix, piece.row_mass, piece.block, piece.ground)
    depth = len(hierarchy.levels) - 1
    level, shift = hierarchy.levels[depth], 0.01 * piece.stiffness
    matrix = level.matrix.toarray().astype(piece.matrix.dtype) + shift * np.diag(level.row_mass.astype(float))
    image = Metric(hierarchy, shift, depth).solve(matrix)
    np.testing.assert_allclose(image, np.eye(len(matrix)), atol=1e-3)


def test_solve_keeps_shape_and_dtype_and_columns_apart():
    for build in (lambda: direction_problem(bumpy_torus(14), 1), lambda: fixed_stripes(14)):
        piece = only_piece(build())
        metric = Metric(Hierarchy(piece.matrix, piece.row_mass, piece.block, piece.ground), 0.1)
        random = np.random.default_rng(0)
        columns = random.standard_normal((piece.matrix.shape[0], 3)).astype(piece.matrix.dtype)
        kept = columns.copy()
        result = metric.solve(columns)
        assert result.dtype == columns.dtype and result.shape == columns.shape
        np.testing.assert_array_equal(columns, kept)
        for k in range(3):
            alone = metric.solve(columns[:, k])
            assert alone.shape == (len(columns),)
            np.testing.assert_allclose(alone, result[:, k], atol=1e-5 * np.abs(alone).max())
        single = metric.solve(np.asfortranarray(columns.astype(metric.dtype)))
        assert single.dtype == metric.dtype
        np.testing.assert_allclose(single, result, atol=1e-5 * np.abs(result).max())


@pytest.mark.parametrize("group", KINDS)
def test_other_coordinates_give_the_same_cycle_in_them(group, monkeypatch):
    """Nothing but the random start of the power method knows coordinates; its result is set to a bound."""
    monkeypatch.setattr(metric_module, "largest_eigenvalue", lambda matrix, inverse_diagonal, random: 2.0)
    mesh, random = bumpy_torus(22), np.random.default_rng(5)
    matrix, block = random_laplacian(mesh, group, seed=6)
    units = random_units(group, mesh.vertex_count, random)
    turn = diagonal_of(units)
    turned = (turn @ matrix @ turn.conj().T).tocsr()
    mass = np.repeat(random.uniform(0.5, 2, mesh.vertex_count), block)
    here, there = Hierarchy(matrix, mass, block), Hierarchy(turned, mass, block)
    assert [level.matrix.shape for level in here.levels] == [level.matrix.shape for level in there.levels]
    assert len(here.levels) >= 2
    columns = random.standard_normal((matrix.shape[0], 4)).astype(matrix.dtype)
    for shift in (1e-3, 1.0):
        expected = turn @ Metric(here, shift).solve(columns)
        result = Metric(there, shift).solve(turn @ columns)
        np.testing.assert_allclose(result, expected, atol=1e-5 * np.abs(expected).max())


# The convergence factor


def gradient_iterations(piece, metric, tolerance=1e-6, most=100):
    """Steps of preconditioned conjugate gradients for a random right-hand side, in double precision."""
    random = np.random.default_rng(0)
    residual = random.standard_normal(piece.matrix.shape[0]).astype(piece.matrix.dtype)
    residual[piece.unused_rows] = 0
    enough = tolerance * np.linalg.norm(residual)
    direction, size = np.zeros_like(residual), np.inf
    for step in range(1, most):
        steepest = metric.solve(residual)
        new_size = np.vdot(steepest, residual).real
        direction = steepest + new_size / size * direction
        size = new_size
        image = piece.matrix @ direction + metric.shift * piece.row_mass * direction
        residual = residual - size / np.vdot(direction, image).real * image
        if np.linalg.norm(residual) <= enough:
            return step
    return most


def crosses_along_the_rims(across):
    return bordered_problem(cylinder(segments=3 * across, rows=across), 4)


@pytest.mark.parametrize(
    ("build", "block"),
    [
        pytest.param(lambda across: direction_problem(bumpy_torus(across), 1), 1, id="vectors"),
        pytest.param(lambda across: direction_problem(bumpy_torus(across), 4), 1, id="crosses"),
        pytest.param(lambda across: half_turned_stripes(bumpy_torus(across), 0.35), 2, id="stripes-with-flips"),
        pytest.param(crosses_along_the_rims, 1, id="crosses-along-the-rims"),
    ],
)
def test_iterations_hardly_grow_as_a_mesh_is_refined(build, block):
    iterations = []
    for across in (18, 36, 72):
        piece = only_piece(build(across))
        assert piece.block == block and piece.node_count > 2.8 * across**2
        metric = Metric(Hierarchy(piece.matrix, piece.row_mass, piece.block, piece.ground), 0.05)
        iterations.append(gradient_iterations(piece, metric))
    assert max(iterations) <= 20
    assert iterations[2] < 1.5 * iterations[0]


@pytest.mark.parametrize("build", MULTILEVEL)
def test_few_iterations_on_every_kind(build):
    piece = only_piece(build())
    metric = Metric(Hierarchy(piece.matrix, piece.row_mass, piece.block, piece.ground), 1e-4 * piece.stiffness)
    assert gradient_iterations(piece, metric) <= 20


@pytest.mark.parametrize(
    "build",
    [
        lambda: direction_problem(bumpy_torus(52), 1),
        lambda: half_turned_stripes(bumpy_torus(52), 0.35),
        lambda: SynchronizationProblem(
            random_weights(torus(around=160, across=60), np.ones(28800, complex), np.random.default_rng(0))
        ),
    ],
)
def test_coarse_levels_together_are_smaller_than_the_finest(build):
    piece = only_piece(build())
    hierarchy = Hierarchy(piece.matrix, piece.row_mass, piece.block)
    assert len(hierarchy.levels) == 3
    assert hierarchy.complexity == sum(level.matrix.nnz for level in hierarchy.levels) / piece.matrix.nnz < 1.6


def guided_crosses(across):
    return direction_problem(bumpy_torus(across), 4, along_curvature(bumpy_torus(across)))


def crosses_led_by_one_node(across):
    problem = direction_problem(bumpy_torus(across), 4)
    nodes = np.arange(0, len(problem.mass), 8)
    return SynchronizationProblem(
        problem.connection,
        problem.mass,
        merged=Merged(nodes[1:], np.zeros(len(nodes) - 1, int), np.ones(len(nodes) - 1, complex)),
    )


@pytest.mark.parametrize("build", [guided_crosses, crosses_led_by_one_node, crosses_along_the_rims])
def test_a_node_with_many_neighbours_does_not_fill_the_coarse_levels(build):
    """The ground of soft wishes has every node beside it, the leader of a merged group many."""
    piece = only_piece(build(26))
    assert np.diff(piece.matrix.indptr).max() > 100
    assert Hierarchy(piece.matrix, piece.row_mass, piece.block, piece.ground).complexity < 1.6
    assert Hierarchy(graph_laplacian(piece.matrix, piece.block), piece.mass, 1).complexity < 1.6


@pytest.mark.parametrize("make", [lambda mesh: direction_problem(mesh, 4), lambda mesh: half_turned_stripes(mesh, 0.4)])
def test_long_thin_triangles_do_not_fill_the_coarse_levels(make):
    piece = only_piece(make(cylinder(height=40 * np.pi, segments=80, rows=80)))
    hierarchy = Hierarchy(piece.matrix, piece.row_mass, piece.block, piece.ground)
    assert hierarchy.levels[0].tentative.shape[1] > SMALL_AGGREGATES * piece.matrix.shape[0]
    assert hierarchy.complexity < 1.6  # 2.5 and more with all entries
    assert gradient_iterations(piece, Metric(hierarchy, 1e-4 * piece.stiffness)) <= 20


@pytest.mark.parametrize("group", KINDS)
def test_prolongations_without_small_entries_carry_the_parallel_field(group):
    random = np.random.default_rng(3)
    mesh = cylinder(segments=30, rows=30)
    units, matrix, block = flat_laplacian(group, mesh, random)
    tentative, _ = aggregates(matrix, block, None, random)
    smoothed = (tentative - diags_array(0.6 / matrix.diagonal().real) @ (matrix @ tentative)).tocsr()
    prolongation = truncated(smoothed, tentative, block)
    assert tentative.nnz < prolongation.nnz < 0.8 * smoothed.nnz
    field = units if group == "circle" else (units @ random.standard_normal(block)).ravel()
    coarse = (tentative.conj().T @ field) / np.asarray(abs(tentative).power(2).sum(axis=0)).ravel()
    np.testing.assert_allclose(prolongation @ coarse, field, atol=1e-12)
    assert np.diff(prolongation.tocsc().indptr).min() > 0


@pytest.mark.parametrize(
    ("make", "metric_of"), [(graph_laplacian, Stage.smoothing), (turning_laplacian, Stage.candidate_metric)]
)
def test_turns_and_values_on_nodes_are_solved_as_fast(make, metric_of):
    """Real Laplacians: the turning one of an unbalanced graph has negative links, and no null space."""
    iterations = []
    for across in (26, 52):
        piece = only_piece(half_turned_stripes(bumpy_torus(across), 0.35))
        matrix = make(piece.matrix, piece.block)
        nodes = Piece(
            matrix, matrix, piece.mass, block=1, is_complex=False, ground=None, rows=np.arange(len(piece.mass))
        )
        iterations.append(gradient_iterations(nodes, metric_of(Workspace(piece).stages[0], 0.05)))
    assert max(iterations) <= 20 and iterations[1] < 1.3 * iterations[0]
