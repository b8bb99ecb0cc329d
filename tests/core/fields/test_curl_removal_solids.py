# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Calmed layers: the nearest changes without curl in solids, against a dense solution and a closed form."""

import numpy as np
import pytest
from scipy.linalg import null_space

from synch_fields.core.errors import SettingError
from synch_fields.core.extract.layers.defect_curves import defect_curves
from synch_fields.core.fields.curl_removal import close_changes
from synch_fields.core.fields.layers import SolidTargetOneForm, solve_layers
from synch_fields.core.geometry.tet_mesh import TetMesh

from ..layered_solids import bent_bar, group_of, layer_problem
from ..solids import ball, block, frame, grid_tets, notched, shell, together

SOLIDS = [
    pytest.param(lambda: block((3, 2, 2)), id="block"),
    pytest.param(frame, id="frame"),
    pytest.param(lambda: TetMesh(*grid_tets((5, 3, 1), lambda i, j, k: j != 1 or i % 2 == 0)), id="two-holes"),
    pytest.param(lambda: shell(subdivisions=0, layers=2), id="shell"),
    pytest.param(lambda: TetMesh(*notched_and_frame()), id="pieces"),
]


def notched_and_frame():
    pair = together(notched(), frame(), loose=1)
    return pair.vertices, pair.tets


def sums(mesh):
    """(f, e) dense: changes around every triangle, its vertices in increasing order."""
    a, b, c = mesh.faces.T
    matrix = np.zeros((len(mesh.faces), len(mesh.edges)))
    faces = np.arange(len(mesh.faces))
    for tail, head, sign in ((a, b, 1), (b, c, 1), (a, c, -1)):
        matrix[faces, mesh.edges_between(tail, head)] = sign
    return matrix


@pytest.mark.parametrize("held", [None, 2, 0])
@pytest.mark.parametrize("build", SOLIDS)
def test_no_other_changes_without_curl_are_nearer(build, held):
    """Also around handles; what is known on one side stays: the bottom knows of turns around them, an end does not."""
    mesh = build()
    random = np.random.default_rng(0)
    changes = random.standard_normal(len(mesh.edges))
    known = np.full(len(mesh.edges), np.nan)
    if held is not None:
        # A function's changes along the edges between some vertices.
        value = random.standard_normal(mesh.vertex_count)
        chosen = (mesh.vertices[:, held] < mesh.vertices[:, held].min() + 1e-9)[mesh.edges].all(axis=1)
        known[chosen] = np.diff(value[mesh.edges[chosen]], axis=1)[:, 0] - changes[chosen]
        assert 0 < chosen.sum() < len(chosen)
    closed = close_changes(mesh, changes, known)
    told = ~np.isnan(known)
    dense = sums(mesh)
    np.testing.assert_allclose(dense @ closed, 0, atol=1e-9)
    np.testing.assert_allclose(closed[told], (changes + known)[told], atol=1e-9)
    # Every other one differs by changes without curl that leave the known edges alone.
    kernel = null_space(np.vstack([dense, np.eye(len(told))[told]]))
    np.testing.assert_allclose(kernel.T @ (mesh.weights * (closed - changes)), 0, atol=1e-8)


def test_layers_that_fan_out_keep_one_number_at_every_radius():
    """A rate q around a bent bar with level ends: nearest is k / r with k = q (R - r) / ln(R / r)."""
    mesh, around = bent_bar((16, 48, 4), 1.0, 2.0, np.pi / 2, 0.2)
    spacing = 0.1
    x, y, _ = mesh.vertices.T
    groups = [group_of(mesh, end < 1e-9) for end in (x, y)]
    problem = layer_problem(mesh, around, spacing, groups, branching=0.0)
    k = 2 * np.pi / spacing / np.log(2)
    angles = np.arctan2(y, x)
    asked = k * np.diff(angles[mesh.edges], axis=1)[:, 0]
    off = np.angle(problem.connection.transports * np.exp(-1j * asked))
    assert np.abs(off).max() < 0.02 and np.abs(asked).max() > 0.5


@pytest.mark.parametrize("counts", [(8, 27, 4)])
def test_layers_branch_less_and_at_last_not_at_all(counts):
    mesh, around = bent_bar(counts, 1, 2, np.pi / 2, 0.2)
    groups = [group_of(mesh, end < 1e-9, 0.0) for end in mesh.vertices.T[:2]]
    lengths = []
    for branching in (1.0, 0.6, 0.0):
        pattern = solve_layers(mesh, around, 0.12, groups, branching=branching)
        curves = defect_curves(mesh, pattern.face_numbers)
        lengths.append(len(curves))
        held = np.concatenate([group.vertices for group in groups])
        np.testing.assert_allclose(pattern.solution.phases[held], 1, atol=1e-9)
    assert lengths[0] > lengths[1] > lengths[2] == 0


def test_what_is_asked_stays_to_the_last_bit_with_all_branching():
    mesh = ball(1, 3)
    growth = SolidTargetOneForm.of(mesh, np.tile([0.0, 0, 1], (mesh.vertex_count, 1)), 0.3)
    asked = layer_problem(mesh, growth.rates / np.linalg.norm(growth.rates, axis=1, keepdims=True), 0.3)
    np.testing.assert_array_equal(asked.connection.transports, growth.connection.transports)


def test_a_share_out_of_range_is_refused():
    mesh = TetMesh(*grid_tets((2, 2, 2)))
    with pytest.raises(SettingError, match=r"branching is 2: give a share from 0 to 1"):
        layer_problem(mesh, np.tile([0.0, 0, 1], (mesh.vertex_count, 1)), 0.5, branching=2)
