# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""MAX-CUT: the reader of graphs, and cuts against exact ones."""

from itertools import product

import numpy as np
import pytest

from synch_fields.bench import max_cut as bench
from synch_fields.bench.max_cut import best_cut, cut_of, cylinder, triangulation
from synch_fields.core.errors import SynchError
from synch_fields.core.problem import SynchronizationProblem, Targets
from synch_fields.core.solve import Certificate, Options, solve
from synch_fields.core.solve.methods.signs import Flips
from synch_fields.examples import max_cut

from ..core.graphs import only_piece

pytestmark = pytest.mark.full_search
RING = range(5)
PETERSEN = [*((k, (k + 1) % 5) for k in RING), *((k, k + 5) for k in RING), *((5 + k, 5 + (k + 2) % 5) for k in RING)]


def write(path, count, edges, weights=None):
    rows = [f"{i + 1} {j + 1}" for i, j in edges]
    rows = rows if weights is None else [f"{row} {weight:g}" for row, weight in zip(rows, weights, strict=True)]
    path.write_text("\n".join([f"{count} {len(edges)}", *rows, ""]))
    return path


def test_graphs_are_read_and_cut(tmp_path, capsys):
    path = write(tmp_path / "petersen.txt", 10, PETERSEN)
    count, edges, weights = max_cut.read_graph(path)
    assert count == 10 and (edges == PETERSEN).all() and (weights == 1).all()
    cut, at_most = max_cut.main(path)
    assert cut == 12 and at_most == pytest.approx(12.5, rel=1e-3)  # of 15; the relaxation's is 12.5
    assert "10 nodes, 15 edges: a cut of 12; none is above 12.5" in capsys.readouterr().out
    count, edges, weights = cylinder(4, 5, 0)
    _, again, read = max_cut.read_graph(write(tmp_path / "signed.txt", count, edges, weights))
    assert (again == edges).all() and (read == weights).all()
    path.write_text(path.read_text().rsplit("\n", 2)[0])
    with pytest.raises(SynchError, match="tells of 15 edges and has 14"):
        max_cut.read_graph(path)


def test_the_program_of_exact_cuts_is_right():
    count, edges, weights = cylinder(3, 4, 5)
    signs = np.array(list(product((-1, 1), repeat=count)))
    cuts = ((signs[:, edges[:, 0]] != signs[:, edges[:, 1]]) * weights).sum(axis=1)
    assert best_cut(3, 4, weights) == cuts.max()


def test_the_bench_reads_files_and_makes_graphs_whose_best_cuts_it_knows(tmp_path, monkeypatch):
    path = write(tmp_path / "petersen.txt", 10, PETERSEN)
    ((label, graph, best),) = bench.subjects([path])
    found = bench.row(label, graph, best, 1e-3)
    assert (found["label"], found["nodes"], found["edges"], found["cut"]) == ("petersen", 10, 15, 12)
    assert found["short"] is None and found["bound"] == pytest.approx(12.5, rel=1e-3)
    monkeypatch.setattr(bench, "GRIDS", ((4, 6),))
    monkeypatch.setattr(bench, "SPHERES", (20,))
    monkeypatch.setattr(bench, "TORI", ((4, 6),))
    small, planar, torus = (bench.row(*subject, 1e-2) for subject in bench.subjects([]))
    _, edges, weights = cylinder(4, 6, 0)
    assert small["best"] == best_cut(4, 6, weights) and 0 <= small["short"] <= 0.1 and small["edges"] == len(edges)
    assert planar["cut"] == planar["best"] == 36
    assert torus["cut"] == torus["best"] == torus["edges"] == 48 and torus["bound"] == pytest.approx(48)


@pytest.mark.parametrize(("around", "length", "seed"), [(8, 60, 0), (10, 60, 1)])
def test_cuts_are_within_a_percent_of_the_best(around, length, seed):
    count, edges, weights = cylinder(around, length, seed)
    best = best_cut(around, length, weights)
    solution = solve(max_cut.cut_problem(count, edges, weights))
    assert 0.99 * best <= cut_of(solution, edges, weights) <= best
    assert np.maximum(weights, 0).sum() - solution.lower_bound / 4 >= best


def test_bipartite_tori_of_3000_nodes_are_cut_completely_and_proved():
    count, edges, _ = cylinder(60, 50, 0, closed=True)
    solution = solve(max_cut.cut_problem(count, edges, np.ones(len(edges))))
    assert solution.energy == 0 and solution.lower_bound == 0 and solution.certificate is Certificate.PROVED
    assert cut_of(solution, edges, np.ones(len(edges))) == 6000


def test_flips_and_crossings_never_raise_the_energy():
    count, edges, weights = cylinder(12, 15, 3)
    piece = only_piece(max_cut.cut_problem(count, edges, weights))
    flips, random = Flips(piece.matrix), np.random.default_rng(0)
    signs = np.sign(random.standard_normal((count, 12)))
    settled = flips.descend(signs)
    assert (piece.energy(settled) < piece.energy(signs)).all()
    for node in range(count):  # no flip of one sign is better
        other = settled.copy()
        other[node] *= -1
        assert (piece.energy(other) >= piece.energy(settled) - 1e-9).all()
    first, second = settled[:, :6], settled[:, 6:]
    crossed = flips.cross(first, second)
    assert (piece.energy(crossed) <= np.minimum(piece.energy(first), piece.energy(second)) + 1e-9).all()
    assert piece.energy(crossed).mean() < 0.97 * piece.energy(settled).mean()


def test_sweeps_of_one_heat_lead_to_the_boltzmann_distribution(monkeypatch):
    heat = 0.7
    monkeypatch.setattr("synch_fields.core.solve.methods.signs.HEATS", np.full(60, heat))
    count, edges, weights = cylinder(3, 3, 1)
    piece = only_piece(max_cut.cut_problem(count, edges, weights))
    shaken = Flips(piece.matrix).shake(np.ones((count, 60_000)), np.random.default_rng(0))
    states = np.array(list(product((-1.0, 1.0), repeat=count))).T
    energies = piece.energy(states)
    chances = np.exp(-energies / (4 * heat))
    mean = chances @ energies / chances.sum()
    spread = np.sqrt(chances @ (energies - mean) ** 2 / chances.sum())
    found = piece.energy(shaken)
    assert abs(found.mean() - mean) < 5 * spread / np.sqrt(found.size)
    assert found.std() == pytest.approx(spread, rel=0.02)


def test_planar_triangulations_are_cut_as_the_formula_says():
    for count in (6, 9, 12):  # against all cuts
        size, edges, _ = triangulation(count)
        states = np.array(list(product((-1, 1), repeat=count)))
        cuts = (states[:, edges[:, 0]] != states[:, edges[:, 1]]).sum(axis=1)
        assert size == count and cuts.max() == 2 * count - 4
    graph = triangulation(1000)
    assert cut_of(solve(max_cut.cut_problem(*graph)), *graph[1:]) >= 0.999 * (2 * 1000 - 4)


def test_fixed_signs_stay():
    count, edges, weights = cylinder(8, 20, 2)
    free = solve(max_cut.cut_problem(count, edges, weights))
    problem = max_cut.cut_problem(count, edges, weights)
    values = -free.phases[[0, 9, 40]] * [[1], [-1], [1]]
    fixed = SynchronizationProblem(problem.connection, fixed=Targets(np.array([0, 9, 40]), values))
    solution = solve(fixed, Options())
    np.testing.assert_array_equal(solution.phases[[0, 9, 40]], values)
    assert solution.lower_bound <= solution.energy and solution.energy >= free.energy
