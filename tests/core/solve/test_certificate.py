# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounds: the chain of Eq. (23), and the certificate against dense linear algebra."""

import numpy as np
import pytest
from scipy.linalg import eigh

from synch_fields.core.fields.directions import direction_problem
from synch_fields.core.fields.guidance.solids import axis_directions
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.monitor import SILENT
from synch_fields.core.solve import Certificate, Options, solve
from synch_fields.core.solve.methods import certificate, spectral
from synch_fields.core.solve.methods.certificate import (
    lower_bound,
    measure_slack,
    plan_proof,
    prove,
)
from synch_fields.core.solve.methods.descent import descend
from synch_fields.core.solve.methods.manifolds import Lifted, random_columns
from synch_fields.core.solve.methods.stage import Workspace

from ..graphs import PROBLEMS
from ..layered_solids import block, layer_problem
from ..meshes import square, torus


def rough_point(piece, steps, rank=5):
    """Workspace, shift of A, a lifted point some steps away from the optimum, its multipliers and its value."""
    workspace, spheres = Workspace(piece), Lifted(piece.block)
    shift = 1e-2 * np.abs(piece.matrix.diagonal()).sum() / piece.row_mass.sum()
    metric = workspace.stages[0].metric(shift)
    start = random_columns(piece, rank, np.random.default_rng(7))
    descent = descend(workspace.matrix, spheres, start, metric, 0.0, steps, SILENT)
    duals = spheres.multipliers(descent.point, workspace.matrix @ descent.point)
    return workspace, shift, descent.point, duals, float(descent.values[0])


def dense_depth(piece, shift, duals):
    """Smallest t with S + t A >= 0, by dense generalized eigenvalues."""
    slack = piece.matrix.toarray() - np.diag(np.repeat(duals, piece.block))
    return -eigh(slack, piece.matrix.toarray() + shift * np.diag(piece.row_mass), eigvals_only=True)[0]


@pytest.mark.parametrize("build", PROBLEMS)
def test_spectral_bound_lower_bound_value_and_energy_are_in_order(build):
    problem = build()
    options = Options(target_gap=1e-4)
    sdp, spectral = solve(problem, options), solve(problem, Options(method="spectral"))
    dense = 0.0
    for piece in problem.pieces:
        dense += piece.mass.sum() * eigh(piece.matrix.toarray(), np.diag(piece.row_mass), eigvals_only=True)[0]
    assert spectral.spectral_bound == spectral.lower_bound == pytest.approx(dense, rel=1e-6, abs=1e-9)
    assert spectral.spectral_bound <= sdp.lower_bound * (1 + 2e-4) + 1e-9
    assert sdp.lower_bound <= sdp.sdp_value * (1 + 1e-12)
    assert sdp.sdp_value <= sdp.energy * (1 + 1.1e-4)
    assert spectral.energy >= sdp.lower_bound
    assert sdp.sdp_gap <= 1e-4 and sdp.gap == pytest.approx(1 - sdp.lower_bound / sdp.energy)


@pytest.mark.parametrize("build", PROBLEMS)
@pytest.mark.parametrize("steps", [6, 80])
def test_depth_is_the_most_negative_relative_eigenvalue(build, steps):
    for piece in build().pieces:
        workspace, shift, point, duals, _ = rough_point(piece, steps)
        exact = dense_depth(piece, shift, duals)
        metric = workspace.stages[0].metric(shift)
        slack = measure_slack(workspace, shift, metric, point, duals, np.random.default_rng(0), SILENT)
        # A Krylov space finds no more than there is, in single precision.
        assert slack.depth <= exact * (1 + 1e-4) + 1e-5
        assert slack.depth >= (0.8 if steps == 6 else 0.9) * exact - 0.01
        # What it may have missed is in the error.
        assert slack.depth + slack.error >= exact * (1 - 1e-3) - 1e-5


@pytest.mark.parametrize("build", PROBLEMS)
@pytest.mark.parametrize("steps", [6, 80])
def test_proofs_succeed_exactly_where_the_slack_is_definite(build, steps):
    for piece in build().pieces:
        _, shift, _, duals, _ = rough_point(piece, steps)
        exact = dense_depth(piece, shift, duals)
        plan = plan_proof(piece, long_proofs=True)
        assert prove(piece, shift, duals, 1.01 * exact + 1e-7, plan)
        if exact > 1e-5:
            assert not prove(piece, shift, duals, 0.99 * exact, plan)
        assert not prove(piece, shift, duals + 10 * np.abs(duals).max() + 1, 0.5 * max(exact, 0), plan)


@pytest.mark.parametrize("build", PROBLEMS)
@pytest.mark.parametrize(("share", "tries"), [(0.9, 1), (3.0, 2), (np.inf, 2)])
def test_what_rounding_may_hide_is_taken_off_before_a_matrix_counts_as_definite(build, share, tries, monkeypatch):
    """An eps for each entry of a row, and 16 for each rounding of a term; more, once, where the error is larger."""
    seen = []
    for piece in build().pieces:
        shift, depth, plan = 0.5, 0.25, plan_proof(piece, long_proofs=True)
        diagonal = piece.matrix.diagonal().real * (1 + depth) + depth * shift * piece.row_mass
        first = 16.0 * plan.elimination.chains.max() * diagonal
        errors = share * first if np.isfinite(share) else None

        def error(matrix, _, errors=errors):
            seen.append(matrix)
            return errors

        monkeypatch.setattr(certificate, "rounding_error", error)
        is_proved = prove(piece, shift, np.zeros(len(piece.mass)), depth, plan)
        assert is_proved == (errors is not None) and len(seen) == (tries if is_proved else 1)
        scale = (1 + depth) * np.abs(piece.matrix.diagonal()) + shift * piece.row_mass
        for allowed in [first, 1.1 * share * first][: len(seen)]:
            taken = diagonal - seen.pop(0).diagonal().real
            # Parts of complex inner products are real ones of twice the length.
            unit = np.finfo(float).eps * (np.sqrt(2) if piece.is_complex else 1)
            expected = unit * (np.diff(piece.matrix.indptr) * diagonal + allowed)
            rounding = 4 * np.finfo(float).eps * scale
            assert (np.abs(taken - expected) <= rounding).all() and (expected > 50 * rounding).all()


@pytest.mark.parametrize("slope", [0.004, 0.02])
def test_bounds_of_nearly_flat_sheets_are_proved(slope):
    """Where the energy is tiny against the weights, allowances for rounding must be small as well."""
    mesh = square(100)
    x, y, _ = mesh.vertices.T
    vertices = np.column_stack([x, y, slope * np.sin(7 * x + 1) * np.cos(5 * y)])
    problem = direction_problem(TriangleMesh(vertices, mesh.triangles), 4)
    solution = solve(problem, Options(rounding="svd"))
    assert solution.certificate is Certificate.PROVED and solution.sdp_gap <= 1e-2
    assert solution.energy < 1e-6 * sum(piece.total_weight for piece in problem.pieces)


@pytest.mark.parametrize("build", PROBLEMS)
@pytest.mark.parametrize("steps", [6, 25])
def test_bounds_from_rough_points_stay_below_the_relaxation(build, steps):
    problem = build()
    total, values = 0.0, 0.0
    for piece in problem.pieces:
        _, shift, _, duals, value = rough_point(piece, steps)
        depth = max(dense_depth(piece, shift, duals), 0) * (1 + 1e-9) + 1e-12
        bound = lower_bound(piece, shift, duals, depth)
        # The dual point is feasible: S >= 0 for its multipliers, by dense eigenvalues.
        feasible = (duals - depth * shift * piece.mass) / (1 + depth)
        assert bound == pytest.approx(feasible.sum(), rel=1e-12)
        lowest = np.linalg.eigvalsh(piece.matrix.toarray() - np.diag(np.repeat(feasible, piece.block)))[0]
        assert lowest >= -1e-7 * np.abs(piece.matrix.diagonal()).max()
        total, values = total + bound, values + value
    best = solve(problem, Options(target_gap=1e-5, rounding="svd"))
    assert total <= best.sdp_value * (1 + 1e-9) <= values * (1 + 1e-4)


def test_multipliers_sum_to_the_value():
    (piece,) = direction_problem(torus(around=12, across=8), 4).pieces
    _, _, _, duals, value = rough_point(piece, 5)
    assert duals.sum() == pytest.approx(value, rel=1e-12)


def test_proofs_are_tried_up_to_a_number_of_products(monkeypatch):
    solid = block((12, 12, 12))
    for problem in (
        direction_problem(torus(around=60, across=24), 4),
        layer_problem(solid, axis_directions(solid, (0, 0, 1)), 0.3),
    ):
        (piece,) = problem.pieces
        products = plan_proof(piece).elimination.products / piece.matrix.nnz
        for most, is_tried in ((products * 1.001, True), (products * 0.999, False)):
            monkeypatch.setattr(certificate, "LONGEST_ELIMINATION", most)
            assert (plan_proof(piece) is not None) == is_tried
            assert plan_proof(piece, long_proofs=True) is not None
        monkeypatch.undo()


def test_proofs_are_tried_up_to_a_number_of_rows_and_that_included(monkeypatch):
    (piece,) = direction_problem(torus(around=24, across=12), 4).pieces
    for most, is_provable in ((piece.matrix.shape[0], True), (piece.matrix.shape[0] - 1, False)):
        monkeypatch.setattr(certificate, "LARGEST_PROOF", most)
        assert (plan_proof(piece) is not None) == is_provable


def test_long_proofs_are_made_where_they_are_asked_for(monkeypatch):
    problem = direction_problem(torus(around=24, across=12), 4)
    short = solve(problem)
    monkeypatch.setattr(certificate, "LONGEST_ELIMINATION", 10)
    assert solve(problem).certificate is Certificate.ESTIMATED
    long = solve(problem, Options(long_proofs=True))
    assert long.certificate is Certificate.PROVED and long.lower_bound == short.lower_bound


@pytest.mark.parametrize("build", PROBLEMS)
def test_the_spectral_bound_is_the_same_without_a_factorization(build, monkeypatch):
    problem = build()
    factorized = solve(problem, Options(method="spectral"))
    monkeypatch.setattr(spectral, "LONGEST_FACTORIZATION", 0)
    by_multigrid = solve(problem, Options(method="spectral"))
    assert by_multigrid.spectral_bound == pytest.approx(factorized.spectral_bound, rel=1e-6, abs=1e-9)
