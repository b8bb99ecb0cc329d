# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The bench of Figure 9: its family of surfaces, the methods with fixed nodes, and what it says of its rows."""

import json
from functools import partial

import numpy as np
import pytest
from scipy.stats import linregress

from synch_fields.bench import peers, vector_fields
from synch_fields.bench.rows import KeptRows
from synch_fields.bench.surface_family import MEMBERS, SMALLEST, family, smallest
from synch_fields.bench.surface_shapes import SHAPES
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.solve import solve

from ..core.meshes import icosphere
from .test_surface_shapes import boundary_curves

FAMILY = family()
# Two of each kind: smooth, needles, spikes, both.
SOME = [0, 48, 25, 49, 14, 30, 27, 3, 37]


@pytest.mark.parametrize("number", SOME)
def test_a_member_is_a_surface_as_it_says(number):
    shape = FAMILY[number]
    mesh = shape.make()  # which checks it
    assert len(np.unique(mesh.pieces)) == 1 and len(mesh.loose_vertices) == 0
    assert mesh.euler_characteristic == shape.characteristic and boundary_curves(mesh) == shape.boundaries
    assert mesh.areas.sum() == pytest.approx(1, abs=1e-12)
    if "needles" in shape.name:
        assert mesh.areas.min() == pytest.approx(smallest(number), rel=1e-6)
    else:
        assert mesh.areas.min() > 1e-10
    steepest = np.abs(vector_fields.vertex_curvatures(mesh)).max()
    assert steepest > 1e6 if "spikes" in shape.name else steepest < 1e6
    np.testing.assert_array_equal(shape.make().vertices, mesh.vertices)


def test_there_are_a_hundred_surfaces_of_all_kinds():
    assert MEMBERS + len(SHAPES) >= 100 and len({shape.name for shape in FAMILY}) == MEMBERS
    for word in ("needles", "spikes", "hole"):
        assert MEMBERS / 4 < sum(word in shape.name for shape in FAMILY) < MEMBERS
    assert smallest(37) == SMALLEST == 1e-13
    assert {(2 - shape.characteristic - shape.boundaries) // 2 for shape in FAMILY} == set(range(5))


def test_curvatures_add_up_to_two_pi_times_the_euler_characteristic():
    mesh = FAMILY[25].make()
    total = vector_fields.vertex_curvatures(mesh) @ mesh.vertex_masses
    assert total == pytest.approx(2 * np.pi * mesh.euler_characteristic, abs=1e-6)


def bent_cap():
    """Half of a sphere without its symmetry."""
    sphere = icosphere(2)
    x, y, z = sphere.vertices.T
    bent = np.column_stack([x + 0.3 * z**2 + 0.2 * x * y, 0.8 * y, z + 0.2 * x])
    return TriangleMesh(bent, sphere.triangles[z[sphere.triangles].mean(axis=1) > 0])


def test_fields_with_fixed_values_are_those_of_dense_solves():
    problem = vector_fields.vector_problem(bent_cap())
    (piece,) = problem.pieces
    dense = piece.matrix.toarray()
    free = np.delete(np.arange(len(dense)), piece.ground)
    pull = dense[free, piece.ground]
    inside = dense[np.ix_(free, free)]
    harmonic = np.linalg.solve(inside, -pull)
    field = peers.linear_field(piece)[:, 0]
    np.testing.assert_allclose(field[free], harmonic / np.abs(harmonic), atol=1e-9)
    assert field[piece.ground] == 1

    time, mass = 0.1, np.diag(piece.mass[free])
    step = np.linalg.solve(mass + time * inside, mass @ field[free] - time * pull)
    one = peers.diffuse(piece, field[:, None], [time], 1, 0.0)[:, 0]
    np.testing.assert_allclose(one[free], step / np.abs(step), atol=2e-5)
    assert one[piece.ground] == 1
    still = peers.fixed_diffusion(piece, time, polished=False)
    again = peers.diffuse(piece, still, [time], 1, 0.0)
    assert np.abs(again - still).max() < 2 * peers.FIXED_TOLERANCE


def test_a_row_says_what_the_fields_are():
    mesh = bent_cap()
    row = vector_fields.row(mesh)
    problem = vector_fields.vector_problem(mesh)
    assert row["fixed"] == mesh.boundary_vertices.sum() and row["boundary off"] < 1e-15
    assert row["bound"] <= row["relaxation"] <= row["energy"] <= row["knoeppel energy"]
    assert row["bound"] > 0 and json.loads(json.dumps(row)) == row
    # The values of the ground's piece are those of the whole problem.
    (piece,) = problem.pieces
    solution = solve(problem)
    assert problem.energy(solution.phases) == pytest.approx(row["energy"], rel=1e-9)
    assert piece.energy(peers.linear_field(piece))[0] == pytest.approx(row["knoeppel energy"])


def test_a_correlation_without_a_third_is_that_of_residues():
    random = np.random.default_rng(0)
    given = random.standard_normal(30)
    first, second = given + random.standard_normal(30), 2 * given + random.standard_normal(30)
    residues = []
    for values in (first, second):
        line = linregress(given, values)
        residues.append(values - line.intercept - line.slope * given)
    found = vector_fields.partial_correlation(first, second, given)
    assert found == pytest.approx(linregress(*residues).rvalue) and abs(found) < np.corrcoef(first, second)[0, 1] - 0.2


def rows_of(seconds):
    figures = {"fixed": 0, "bound": 1.0, "certificate": "proved", "boundary off": 0.0, "svd seconds": 0.1}
    figures |= {"energy": 2.0, "svd energy": 3.0, "mbo energy": 2.5, "knoeppel energy": 2.0, "mbo seconds": 1.0}
    varied = ("least area", "greatest curvature", "mean curvature")
    return [
        figures | {"label": f"{k}", "nodes": 10 * (k + 1), "seconds": s} | dict.fromkeys(varied, 1.0 + k % 2)
        for k, s in enumerate(seconds)
    ]


def test_the_shares_are_counted():
    rows = rows_of([0.5, 0.9, 9.0, 80.0])
    rows[3] |= {"energy": 2.6, "fixed": 5, "boundary off": 1e-3, "certificate": "estimated"}
    told = {line["label"]: line["here"] for line in vector_fields.claims(rows)}
    assert told["surfaces"] == "4, 1 of them with boundaries" and told["bound proved"] == "3 of 4 (75%)"
    assert told["energy no more than Knöppel's"] == told["energy no more than MBO's"] == "3 of 4 (75%)"
    assert told["under 60 s"] == "3 of 4 (75%)" and told["faster than MBO"] == "2 of 4 (50%)"
    assert told["at least ten times as slow as MBO"] == "1 of 4 (25%)"
    assert told["slowest"] == "80.0 s (3)" and told["boundary values off by at most"] == "1e-03"
    assert told["energy over MBO's, median and largest"] == "0.800, 1.040"
    found = {line["label"]: line for line in vector_fields.correlations(rows_of([1.0, 2.0, 3.0]))}
    assert found["nodes"]["all"] == pytest.approx(1) and found["nodes"]["left"] is None
    assert found["smallest triangle"]["all"] == pytest.approx(np.corrcoef([0, 1, 0], np.log([1, 2, 3]))[0, 1])


def test_surfaces_that_are_done_are_not_done_again(tmp_path, monkeypatch):
    made = []
    subjects = [(name, partial(made.append, name)) for name in ("one", "two", "three")]
    monkeypatch.setattr(vector_fields, "subjects", lambda _: subjects)
    monkeypatch.setattr(vector_fields, "row", lambda mesh: {"nodes": len(made)})
    path = tmp_path / "kept" / "rows.jsonl"
    assert [row["label"] for row in vector_fields.measured(tmp_path, path, ["t"])] == ["two", "three"]
    assert [row["nodes"] for row in vector_fields.measured(tmp_path, path)] == [3, 1, 2]
    assert made == ["two", "three", "one"]
    kept = KeptRows(path, "label")
    kept.keep({"label": "two", "nodes": 9})
    assert KeptRows(path, "label")["two",] == {"label": "two", "nodes": 9} and len(kept) == 3
