# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The metric of descents: lowered hierarchies, what is not positive definite, and where single precision ends."""

import numpy as np
import pytest
from scipy.sparse import csr_matrix

from synch_fields.core.algebra.metric import (
    LARGEST_DENSE,
    Hierarchy,
    Inverse,
    Metric,
    dense_inverse,
    with_positive_diagonal,
)
from synch_fields.core.connection import Connection
from synch_fields.core.monitor import SILENT
from synch_fields.core.problem import SynchronizationProblem
from synch_fields.core.solution import Clock
from synch_fields.core.solve import Options, solve
from synch_fields.core.solve.methods.manifolds import random_columns
from synch_fields.core.solve.methods.spectral import smallest_eigenpair
from synch_fields.core.solve.methods.stage import SUBTRACTED, Workspace
from synch_fields.core.solve.methods.staircase import relax

from ..graphs import only_piece
from ..multigrid_problems import MULTILEVEL


@pytest.mark.parametrize("build", [build for build in MULTILEVEL if build.id != "slivers"])
@pytest.mark.parametrize("depth", [0, 1])
def test_a_lowered_hierarchy_is_that_of_the_matrix_less_the_diagonal(build, depth):
    piece = only_piece(build())
    hierarchy = Hierarchy(piece.matrix, piece.row_mass, piece.block, piece.ground)
    diagonal = np.random.default_rng(0).uniform(0, 0.1, hierarchy.levels[depth].matrix.shape[0])
    diagonal *= hierarchy.levels[depth].matrix.diagonal().real
    lowered = hierarchy.lowered(diagonal, depth)
    matrix = hierarchy.levels[depth].matrix.toarray() - np.diag(diagonal)
    for level, before in zip(lowered.levels, hierarchy.levels[depth:], strict=True):
        np.testing.assert_allclose(level.matrix.toarray(), matrix, atol=2e-5 * np.abs(matrix).max())
        assert level.prolongation is before.prolongation
        if level.prolongation is not None:
            prolongation = level.prolongation.toarray()
            matrix = prolongation.conj().T @ matrix @ prolongation


@pytest.mark.parametrize("size", [1, 7, LARGEST_DENSE, LARGEST_DENSE + 1])
@pytest.mark.parametrize("dtype", [np.float32, np.complex64])
def test_small_matrices_are_inverted_and_larger_ones_factorized(size, dtype):
    """Tridiagonal ones, whose off-diagonal numbers have any phase; one eigenvalue below zero is enough to refuse."""
    phase = np.full(size - 1, 0.6 + 0.8j if dtype == np.complex64 else 1, dtype)
    dense = (2.1 * np.eye(size) + np.diag(phase, 1) + np.diag(phase.conj(), -1)).astype(dtype)
    right = np.random.default_rng(0).standard_normal((size, 3)).astype(dtype)
    expected = np.linalg.solve(dense.astype(complex), right)
    np.testing.assert_allclose(Inverse(csr_matrix(dense)).solve(right), expected, atol=2e-5 * np.abs(expected).max())
    if size <= LARGEST_DENSE:
        inverse = dense_inverse(csr_matrix(dense))
        assert inverse.dtype == dtype and inverse.flags.c_contiguous
        np.testing.assert_allclose(inverse @ dense, np.eye(size), atol=2e-4)
    lowest = np.linalg.eigvalsh(dense)[0]
    below = csr_matrix(dense - np.float32(lowest + 0.01) * np.eye(size, dtype=np.float32))
    assert not Inverse(below).is_definite and (size > LARGEST_DENSE or dense_inverse(below) is None)


@pytest.mark.parametrize("build", MULTILEVEL)
def test_what_is_not_positive_definite_is_seen(build):
    """By a diagonal below zero; or by the smallest level, where all diagonals are fine."""
    piece = only_piece(build())
    hierarchy = Hierarchy(piece.matrix, piece.row_mass, piece.block, piece.ground)
    shift = 1e-3 * piece.stiffness
    assert hierarchy.lowered(2 * piece.matrix.diagonal().real + 1) is None
    lowest = smallest_eigenpair(piece, 0)[0]
    assert Metric(hierarchy.lowered(0.01 * lowest * piece.row_mass), shift).is_definite
    lowered = hierarchy.lowered((1.5 * lowest + 2 * shift) * piece.row_mass)
    assert lowered is None or not Metric(lowered, shift).is_definite


def opposing_problem(degree, seed):
    """A random graph whose ends all want to differ: multipliers of rough fields are as large as the diagonal."""
    random = np.random.default_rng(seed)
    edges = np.unique(np.sort(random.integers(0, 400, (200 * degree, 2)), axis=1), axis=0)
    edges = edges[edges[:, 0] < edges[:, 1]]
    return SynchronizationProblem(Connection(400, edges, np.ones(len(edges)), -np.ones(len(edges), complex)))


@pytest.mark.parametrize("degree", [8, 16, 40])
@pytest.mark.parametrize("start", ["rough", "constant"])
def test_the_metric_of_any_field_is_positive(degree, start):
    piece, _ = only_piece(opposing_problem(degree, 0)).scaled()
    stage, size = Workspace(piece).stages[0], piece.matrix.shape[0]
    rough = random_columns(piece, 6, np.random.default_rng(0))
    point = stage.lifted.normalize(rough if start == "rough" else np.ones_like(rough))
    inverse = stage.metric_at(point).solve(np.eye(size, dtype=piece.matrix.dtype))
    assert np.linalg.eigvalsh(0.5 * (inverse + inverse.conj().T))[0] > 0


@pytest.mark.parametrize("seed", range(5))
def test_a_weak_link_between_uneven_masses_is_solved(seed):
    """Where the smallest shift drowns in single precision."""
    random = np.random.default_rng(seed)
    halves = [(a + half, b + half) for half in (0, 75) for a, b in random.integers(0, 75, (300, 2)) if a != b]
    edges = np.unique(np.sort([*halves, *[(k + h, k + h + 1) for h in (0, 75) for k in range(74)]], axis=1), axis=0)
    edges = np.vstack([edges, [0, 75]])
    weights = np.append(np.ones(len(edges) - 1), 1e-6)
    phases = np.exp(2j * np.pi * random.uniform(size=150))
    transports = phases[edges[:, 1]] * phases[edges[:, 0]].conj()
    mass = np.repeat([1.0, 100.0], 75)
    problem = SynchronizationProblem(Connection(150, edges, weights, transports), mass)
    for options in (Options(), Options(method="diffusion")):
        assert solve(problem, options).energy < 1e-5


@pytest.mark.parametrize("build", MULTILEVEL)
def test_the_metric_of_a_lifted_field_is_near_the_laplacian_less_its_multipliers(build):
    """At the optimum it is L + shift M less a share of the multipliers; from a rough point it is at least positive."""
    piece, _ = only_piece(build()).scaled()
    workspace = Workspace(piece)
    stage, unit = workspace.stages[0], np.eye(piece.matrix.shape[0], dtype=piece.matrix.dtype)
    point = relax(workspace, Options(target_gap=1e-3), SILENT, Clock()).lifted
    duals = SUBTRACTED * stage.lifted.multipliers(point, workspace.matrix @ point).clip(0)
    expected = piece.matrix.toarray() - np.diag(np.repeat(duals, piece.block))
    expected += (1 - SUBTRACTED) * stage.shift_at(point) * np.diag(piece.row_mass)
    root = np.linalg.cholesky(expected)
    spectrum = np.linalg.eigvalsh(root.conj().T @ stage.metric_at(point).solve(unit) @ root)
    assert 0.1 <= spectrum[0] and spectrum[-1] <= 1.2
    rough = stage.lifted.normalize(random_columns(piece, 6, np.random.default_rng(0)))
    inverse = stage.metric_at(rough).solve(unit)
    assert np.linalg.eigvalsh(0.5 * (inverse + inverse.conj().T))[0] > 0


def test_diagonals_that_rounding_made_negative_are_raised_and_others_kept():
    matrix = csr_matrix(np.array([[-2e-5, 1e-5, 0], [1e-5, 4e-5, 0], [0, 0, 1]], np.complex64))
    raised = with_positive_diagonal(matrix)
    np.testing.assert_allclose(raised.diagonal(), [2e-4, 2e-4, 1], rtol=1e-5)
    assert raised.dtype == matrix.dtype and raised[0, 1] == matrix[0, 1]
    assert np.linalg.eigvalsh(raised.toarray()).min() > 0
    positive = only_piece(MULTILEVEL[0].values[0]()).matrix
    assert with_positive_diagonal(positive) is positive
