# SPDX-License-Identifier: GPL-3.0-or-later
"""Weights and graphs at the edge of what numbers hold: bounds stay below the truth, and nothing breaks."""

import os
import sys
from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import csr_matrix

from synch_fields.core.algebra.metric import Hierarchy
from synch_fields.core.algebra.products import WORTH_SHARING, SharedRows
from synch_fields.core.connection import Connection, circle_transports
from synch_fields.core.errors import Cancelled, MeshError, SettingError
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.problem import Merged, SynchronizationProblem, Targets
from synch_fields.core.solve import METHODS, Options, Status, solve
from synch_fields.core.solve.methods import staircase

from ..graphs import random_connection


def star(leaves, flux):
    """A hub whose leaves cost nothing, but for one loop (0, 1, 2) with a flux."""
    edges = np.array([(0, leaf) for leaf in range(1, leaves + 1)] + [(1, 2)])
    angles = np.zeros(len(edges))
    angles[-1] = flux
    return Connection(leaves + 1, edges, np.full(len(edges), 0.1), circle_transports(angles))


def test_a_proof_counts_the_rounding_of_long_sums():
    flux = 1e-3
    solution = solve(SynchronizationProblem(star(5_000, flux)), Options(target_gap=1e-4, rounding="polish"))
    optimum = 0.1 * 3 * 4 * np.sin(flux / 6) ** 2
    assert solution.energy == pytest.approx(optimum, rel=1e-3)
    assert solution.lower_bound <= optimum
    assert 0 <= solution.gap <= 1


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "constraints",
    [
        {"merged": Merged(np.array([1]), np.array([0]), np.ones(1, complex))},
        {"fixed": Targets(np.array([0, 1]), np.ones(2, complex))},
    ],
)
def test_nothing_left_to_ask_is_a_perfect_fit(method, constraints):
    connection = Connection(2, np.array([[0, 1]]), np.ones(1), np.ones(1, complex))
    solution = solve(SynchronizationProblem(connection, **constraints), Options(method=method))
    assert solution.energy == solution.lower_bound == solution.gap == 0
    assert solution.status is (Status.CERTIFIED if method == "sdp" else Status.UNCERTIFIED)


@pytest.mark.parametrize("scale", [1e-30, 1e37])
@pytest.mark.parametrize("kind", ["circle", "flips", "signs", "rotations"])
def test_the_unit_of_weights_and_masses_is_free(kind, scale):
    connection = random_connection(kind, 12, extra=12, seed=3)
    fixed = None if kind != "flips" else Targets(np.array([0]), np.ones(1, complex))
    plain = solve(SynchronizationProblem(connection, fixed=fixed))
    scaled = replace(connection, weights=scale * connection.weights)
    other = solve(SynchronizationProblem(scaled, mass=np.full(12, scale), fixed=fixed))
    assert other.energy == pytest.approx(scale * plain.energy, rel=1e-6)
    assert other.lower_bound == pytest.approx(scale * plain.lower_bound, rel=2e-2)
    assert other.lower_bound <= other.sdp_value <= other.energy * (1 + 1e-9)
    assert other.status is plain.status is Status.CERTIFIED


def test_energy_that_drowns_in_the_weights_is_not_called_perfect():
    connection = random_connection("circle", 100, extra=150, seed=1)
    spread = 10 ** np.random.default_rng(0).uniform(-7, 7, len(connection.weights))
    solution = solve(SynchronizationProblem(replace(connection, weights=spread)))
    assert solution.energy > 1
    assert solution.lower_bound <= solution.energy
    assert solution.gap > 0 and (solution.status is not Status.CERTIFIED or solution.sdp_gap <= 1e-2)


def pattern(count, edges):
    edges = np.concatenate([edges, edges[:, ::-1], np.column_stack([np.arange(count)] * 2)])
    return csr_matrix((np.ones(len(edges)), edges.T), shape=(count, count))


def test_graphs_of_many_neighbours_have_coarse_levels():
    random = np.random.default_rng(0)
    places = random.random((3000, 3))
    from scipy.spatial import cKDTree

    edges = cKDTree(places).query_pairs(0.15, output_type="ndarray")
    assert len(edges) > 15 * len(places)
    connection = Connection(
        3000, edges, np.ones(len(edges)), circle_transports(0.1 * random.standard_normal(len(edges)))
    )
    (piece, *_) = SynchronizationProblem(connection).pieces
    hierarchy = Hierarchy(piece.matrix, piece.row_mass, 1)
    assert hierarchy.levels[-1].matrix.shape[0] <= 600 and hierarchy.complexity < 1.6


@pytest.mark.skipif(not hasattr(os, "fork") or sys.platform == "darwin", reason="needs a safe fork")
def test_a_forked_process_has_threads_of_its_own():
    size = WORTH_SHARING // 4
    matrix = SharedRows(csr_matrix((np.ones(size), (np.arange(size), np.arange(size)))))
    columns = np.ones((size, 8))
    matrix @ columns
    child = os.fork()
    if child == 0:
        os._exit(int(not ((matrix @ columns) == 1).all()))
    assert os.waitpid(child, 0)[1] == 0


@pytest.mark.parametrize("method", METHODS)
def test_every_method_hears_the_time_limit(method):
    connection = random_connection("circle", 3000, extra=6000, seed=2)
    solution = solve(SynchronizationProblem(connection), Options(method=method, time_limit=1e-6))
    assert solution.status is Status.TIME_LIMIT
    assert np.isfinite(solution.energy) and solution.lower_bound <= solution.energy


@pytest.mark.parametrize(
    "options", [Options(seed=-1), Options(seed=1.5), Options(samples=1.5), Options(target_gap="small"), {"seed": 1}]
)
def test_options_of_the_wrong_kind_are_named(options):
    with pytest.raises(SettingError, match=r"seed|samples|target_gap|Options"):
        solve(SynchronizationProblem(random_connection("circle", 5, extra=3, seed=0)), options)


@pytest.mark.parametrize("answer", [False, np.bool_(False), 0])
def test_any_false_answer_cancels_and_none_does_not(answer):
    problem = SynchronizationProblem(random_connection("circle", 30, extra=30, seed=0))
    with pytest.raises(Cancelled):
        solve(problem, callback=lambda stage, fraction: answer)
    assert solve(problem, callback=lambda stage, fraction: None).energy > 0


@pytest.mark.parametrize(
    ("triangles", "words"),
    [([[0, 1, 2, 3]], "split polygons"), ([[0, 1, 9]], "triangle 0"), ([[0, 1, -1]], "triangle 0")],
)
def test_arrays_that_are_no_triangles_are_named(triangles, words):
    with pytest.raises(MeshError, match=words):
        TriangleMesh(np.eye(4, 3), np.array(triangles))


def test_a_target_out_of_reach_leaves_a_weaker_proof(monkeypatch):
    monkeypatch.setattr(staircase, "ATTEMPTS", 2)
    monkeypatch.setattr(staircase, "DESCENT_STEPS", 4)
    problem = SynchronizationProblem(random_connection("circle", 40, extra=60, seed=4))
    solution = solve(problem, Options(target_gap=1e-6, rounding="svd"))
    assert solution.status is Status.TARGET_GAP_NOT_REACHED and solution.certificate == "proved"
    assert 1e-6 < solution.sdp_gap < 1e-1
