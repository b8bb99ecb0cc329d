# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Conditions that loops close against sums step by step and a dense least squares, and patterns that are changed."""

import numpy as np
import pytest
from scipy.linalg import null_space

from synch_fields.core.extract.quads.trace.quad_mesh import quad_mesh
from synch_fields.core.fields import given_directions
from synch_fields.core.fields.curl_removal import SMALLEST_WEIGHT, surface_circulation
from synch_fields.core.fields.loop_closing import LoopClosing, MeshWalks, _ChangeMirror, cosines
from synch_fields.core.fields.mirror import Mirror
from synch_fields.core.fields.patterns import change_pattern, quad_pattern
from synch_fields.core.geometry import TriangleMesh
from synch_fields.core.geometry.mirror import mirrored_vertices
from synch_fields.core.geometry.polygons import Polygons
from synch_fields.core.matchings import after_turns

from ..flat_crosses import turned_crosses
from ..meshes import bumpy_torus, grid_quads, torus, torus_points

AROUND, ACROSS = 20, 10
# Around the tube, and around the hole, of a torus of AROUND by ACROSS vertices.
TUBE = np.append(np.arange(ACROSS), 0)
HOLE = np.append(ACROSS * np.arange(AROUND), 0)


def slanting(mesh, degrees=16.0, spacing=0.7):
    """Quads along crosses that are turned against the torus's circles."""
    x, y, _ = mesh.vertices.T
    around = np.column_stack([-y, x, 0 * x])
    field = given_directions(mesh, 4, around).turned(np.radians(degrees))
    return quad_pattern(mesh, turned_crosses(field, np.arange(mesh.vertex_count) % 4), spacing, branching=0)


@pytest.fixture(scope="module")
def pattern():
    return slanting(torus(around=AROUND, across=ACROSS))


def added_up(mesh, changes, matchings, walk):
    """(2,) changes along a walk, for the phases of its first vertex, one step after the other."""
    numbers = {tuple(edge): number for number, edge in enumerate(mesh.edges.tolist())}
    total, turns = np.zeros(2), 0
    for tail, head in zip(walk[:-1].tolist(), walk[1:].tolist(), strict=True):
        number = numbers[min(tail, head), max(tail, head)]
        if tail < head:
            total += after_turns(changes[number], -turns)
            turns += matchings[number]
        else:
            turns -= matchings[number]
            total -= after_turns(changes[number], -turns)
    return total


def condition(pattern, walk):
    """The condition that a walk closes across itself, and its asked sums."""
    mesh, growth = pattern.mesh, pattern.one_form
    reached = np.abs(added_up(mesh, pattern.edge_phases.changes, growth.matchings, walk)) / np.pi
    np.testing.assert_allclose(reached, np.rint(reached), atol=1e-6)
    aside, steps = np.sort(np.rint(reached).astype(int))
    made = LoopClosing(pattern).condition(walk, pattern.edge_phases.changes, steps, aside)
    asked = added_up(mesh, growth.changes, growth.matchings, walk)
    return made, asked[int(np.argmin(reached))], steps, aside


@pytest.mark.parametrize("walk", [TUBE, HOLE], ids=["tube", "hole"])
def test_rows_sum_the_changes_of_a_walk(pattern, walk):
    made, asked, _, aside = condition(pattern, walk)
    assert aside >= 1, "the lines spiral"
    assert abs(made.row @ pattern.one_form.changes.ravel()) == pytest.approx(abs(asked))


def test_walks_that_pass_other_quads_are_refused(pattern):
    _, _, steps, aside = condition(pattern, TUBE)
    closing, reached = LoopClosing(pattern), pattern.edge_phases.changes
    assert closing.condition(TUBE, reached, steps + 1, aside) is None
    assert closing.condition(TUBE, reached, steps, aside + 1) is None


def test_corrections_are_the_least_changes_without_curl_that_close_the_walks(pattern):
    """Against the null space of all sums around faces, and a dense least squares there."""
    growth, closing = pattern.one_form, LoopClosing(pattern)
    conditions = [condition(pattern, walk)[0] for walk in (TUBE, HOLE)]
    correction, cost = closing.correction(conditions)
    circulation, _ = surface_circulation(growth.mesh, growth.matchings, 2)
    free = null_space(circulation.matrix.toarray())
    weights = np.maximum(np.repeat(growth.mesh.weights, 2), SMALLEST_WEIGHT)
    rows = np.array([made.row for made in conditions])
    # Of free coefficients z, least z^T (F^T W F) z with R F z = -R c.
    gram, conditions_on = free.T @ (weights[:, None] * free), rows @ free
    system = np.block([[gram, conditions_on.T], [conditions_on, np.zeros((2, 2))]])
    right = np.append(np.zeros(len(gram)), -rows @ growth.changes.ravel())
    expected = free @ np.linalg.solve(system, right)[: len(gram)]
    np.testing.assert_allclose(correction.ravel(), expected, atol=1e-7)
    assert cost == pytest.approx(weights @ expected**2)
    np.testing.assert_allclose(rows @ (growth.changes + correction).ravel(), 0, atol=1e-7)


def test_changed_patterns_close_and_their_problem_is_the_one_posed_anew(pattern):
    conditions = [condition(pattern, walk)[0] for walk in (TUBE, HOLE)]
    correction, _ = LoopClosing(pattern).correction(conditions)
    changed = change_pattern(pattern, correction)
    assert changed.energy == pytest.approx(changed.problem.energy(changed.phases))
    np.testing.assert_allclose(
        changed.problem.connection.transports, changed.one_form.connection.transports, atol=1e-12
    )
    for walk in (TUBE, HOLE):
        across = added_up(changed.mesh, changed.edge_phases.changes, changed.one_form.matchings, walk)
        assert np.abs(across).min() == pytest.approx(0, abs=1e-6)
    assert not changed.dislocations


def test_the_cheaper_condition_is_chosen_first_and_none_beyond_the_budget(pattern):
    closing = LoopClosing(pattern)
    conditions = [condition(pattern, walk)[0] for walk in (TUBE, HOLE)]
    costs = [closing.correction([made])[1] for made in conditions]
    cheap = int(np.argmin(costs))
    gains, price = np.ones(2), 0.1 / max(costs)
    assert closing.choose([], conditions, gains, price, np.inf)[0] == cheap
    assert closing.choose([], conditions, gains, price, 0.5 * (costs[0] + costs[1])) == [cheap]
    assert closing.choose([], conditions, gains, 1 / min(costs) * 1.01, np.inf) == []
    # What is held, or follows from it, is not chosen again.
    assert closing.choose(conditions[:1], conditions, gains, 0, np.inf) == [1]
    assert closing.choose(conditions, conditions, gains, 0, np.inf) == []
    assert closing.choose([], [], np.zeros(0), 0, np.inf) == []


def test_walks_on_the_mesh_follow_those_on_the_quads():
    pattern = slanting(bumpy_torus(24), spacing=0.4)
    mesh = pattern.mesh
    quads, walks = quad_mesh(pattern.edge_phases), MeshWalks(mesh)
    edges = {tuple(edge) for edge in mesh.edges.tolist()}
    ahead = quads.corner_vertices[:4]
    walk = walks.near(quads, np.append(ahead, ahead[0]))
    assert walk[0] == walk[-1]
    assert all(tuple(sorted(step)) in edges for step in zip(walk[:-1].tolist(), walk[1:].tolist(), strict=True))
    far = np.linalg.norm(mesh.vertices[walk][:, None] - quads.vertices[ahead], axis=2).min(axis=1)
    assert far.max() < 2 * mesh.edge_lengths.max() + 0.2


def test_alike_conditions_have_a_cosine_of_one(pattern):
    once, _, _, _ = condition(pattern, TUBE)
    other, _, _, _ = condition(pattern, TUBE + ACROSS)
    found = cosines([once, other, condition(pattern, HOLE)[0]])
    np.testing.assert_allclose(found.diagonal(), 1)
    assert abs(found[0, 1]) > 0.999 > 0.9 > abs(found[0, 2])
    assert cosines([]).shape == (0, 0)


def starred_torus():
    """A torus whose quads are four triangles around their middle: its own mirror image in all axes."""
    points, quads = torus_points(1.0, 0.4, AROUND, ACROSS), grid_quads(AROUND, ACROSS, True, True)
    quads = np.asarray(quads)
    middles = np.broadcast_to(len(points) + np.arange(len(quads))[:, None], quads.shape)
    triangles = np.stack([quads, np.roll(quads, -1, axis=1), middles], axis=2).reshape(-1, 3)
    return TriangleMesh(np.vstack([points, points[quads].mean(axis=1)]), triangles)


def mirror_of(mesh, axis):
    return Mirror.of(mesh, mirrored_vertices(mesh, Polygons.of_triangles(mesh), axis), axis)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_mirror_leaves_the_changes_of_a_symmetric_pattern_and_turns_others_round(axis):
    mesh = starred_torus()
    symmetric = slanting(mesh, degrees=0.0).one_form
    image = _ChangeMirror(symmetric, mirror_of(mesh, axis))
    np.testing.assert_allclose(image.reflect(symmetric.changes.ravel()), symmetric.changes.ravel(), atol=1e-9)
    other = np.random.default_rng(axis).normal(size=symmetric.changes.size)
    assert np.abs(image.reflect(other) - other).max() > 1
    np.testing.assert_allclose(image.reflect(image.reflect(other)), other, atol=1e-12)


@pytest.mark.parametrize("axes", [(0,), (0, 1)])
def test_with_mirrors_changes_are_symmetric_and_without_curl(axes):
    mesh = starred_torus()
    mirrors = [mirror_of(mesh, axis) for axis in axes]
    pattern = slanting(mesh, degrees=0.0)
    closing = LoopClosing(pattern, mirrors)
    row = np.zeros(pattern.one_form.changes.size)
    row[:40] = 1
    change = closing._project(row)
    for mirror in mirrors:
        np.testing.assert_allclose(_ChangeMirror(pattern.one_form, mirror).reflect(change), change, atol=1e-7)
    circulation, _ = surface_circulation(mesh, pattern.one_form.matchings, 2)
    np.testing.assert_allclose(circulation.matrix @ change, 0, atol=1e-7)
    assert np.abs(change).max() > 1e-3
