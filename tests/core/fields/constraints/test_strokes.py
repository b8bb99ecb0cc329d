# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves that pass between the vertices, in closed form."""

import numpy as np
import pytest

from synch_fields.core.errors import ContradictionError, SettingError
from synch_fields.core.fields import DirectionWishes, Row, direction_field, stripe_pattern
from synch_fields.core.fields.constraints.lines import line_of_points, line_of_strokes
from synch_fields.core.fields.patterns import PatternWishes, pattern_problem
from synch_fields.core.solve import Options

from ...direction_wishes import SPACING, along, chain, cosines
from ...meshes import disk, square, subdivided


def stroke(mesh, points):
    """Points in the plane z = 0 with the triangles that they lie in."""
    corners = mesh.vertices[mesh.triangles][:, :, :2]
    a, b, c = np.moveaxis(corners, 1, 0)
    faces = []
    for p in points[:, :2]:
        x, y = np.stack([a - p, b - p, c - p]).transpose(2, 0, 1)
        sides = x * np.roll(y, -1, axis=0) - y * np.roll(x, -1, axis=0)
        faces.append(np.argmax(np.min(sides, axis=0)))
    return np.array(faces), points


def segment(mesh, start, end, count=400):
    share = np.linspace(0, 1, count)[:, None]
    return stroke(mesh, np.column_stack([(1 - share) * np.array(start) + share * np.array(end), np.zeros(count)]))


@pytest.mark.parametrize(("kind", "degrees"), [("along", 0), ("across", 90), ("angle", 20)])
def test_a_straight_stroke_sets_the_direction_of_a_plane(kind, degrees):
    mesh = square(9)
    start, end = np.array([0.11, 0.23]), np.array([0.83, 0.57])
    row = Row(line_of_strokes(mesh, [segment(mesh, start, end)]), kind, np.radians(20))
    field = direction_field(mesh, 1, DirectionWishes(rows=(row,)))
    assert field.solution.energy < 1e-12
    angle = np.arctan2(*(end - start)[::-1]) + np.radians(degrees)
    np.testing.assert_allclose(field.vectors[:, :2], np.tile([np.cos(angle), np.sin(angle)], (100, 1)), atol=1e-9)


@pytest.mark.parametrize("kind", ["phase", "constant"])
@pytest.mark.parametrize("seed", [None, 1, 2])
def test_a_stripe_lies_on_a_stroke_between_the_vertices(seed, kind):
    mesh = square(20)
    start, end = np.array([0.11, 0.23]), np.array([0.83, 0.57])
    way = (end - start) / np.linalg.norm(end - start)
    field = along(mesh, (*way, 0), 2, seed)
    row = Row(line_of_strokes(mesh, [segment(mesh, start, end)]), kind, 0.5)
    pattern = stripe_pattern(mesh, field, SPACING, [row])
    assert pattern.solution.energy < 1e-12
    left = (mesh.vertices[:, :2] - start) @ [-way[1], way[0]]
    if kind == "phase":
        np.testing.assert_allclose(cosines(pattern), np.cos(0.5 + 2 * np.pi * left / SPACING), atol=1e-9)
    else:
        # Held a third of a stripe off where it begins, the whole line follows.
        held = Row(line_of_strokes(mesh, [segment(mesh, start, start + 0.1 * (end - start))]), "phase", 2 * np.pi / 3)
        pattern = stripe_pattern(mesh, field, SPACING * 1.03, [row, held])
        problem = pattern_problem(mesh, field, PatternWishes(SPACING * 1.03, [row, held]))
        assert len(problem.merged.nodes) == 0 and np.isin(row.line.nodes, problem.fixed.nodes).all()
        expected = np.cos(2 * np.pi / 3 + 2 * np.pi * row.line.offsets / SPACING / 1.03)
        np.testing.assert_allclose(cosines(pattern)[row.line.nodes], expected, atol=1e-9)


def test_rings_around_a_stroke_that_closes():
    mesh = subdivided(disk(12, 48))
    turn = np.linspace(0, 2 * np.pi, 1500)
    circle = 0.6 * np.column_stack([np.cos(turn), np.sin(turn), np.zeros(1500)])
    row = Row(line_of_strokes(mesh, [stroke(mesh, circle)]), "phase")
    field = direction_field(mesh, 2, DirectionWishes(rows=(row,)))
    pattern = stripe_pattern(mesh, field, 0.3, [row])
    radius = np.linalg.norm(mesh.vertices, axis=1)
    # Beside the stroke the phase is that of the distance to it, but for the circle's bend over an edge.
    near = np.zeros(mesh.vertex_count, bool)
    near[row.line.nodes] = True
    expected = np.cos(2 * np.pi * (radius - 0.6) / 0.3)
    np.testing.assert_allclose(cosines(pattern)[near], expected[near], atol=0.01)


def test_a_soft_stroke_counts_as_the_edges_that_it_runs_along():
    """Held upright on the left, drawn by a stroke from side to side: each of its parts counts by its length."""
    mesh = square(10)
    x = mesh.vertices[:, 0]
    held = Row(chain(mesh, x == 0), "along")
    drawn = line_of_strokes(mesh, [segment(mesh, (0.999, 0.0), (0.999, 1.0))]), chain(mesh, x == 1)
    assert [line.lengths.sum() for line in drawn] == pytest.approx([1, 1])
    found = []
    for line in drawn:
        rows = held, Row(line, "angle", np.pi / 3, 2.0)
        vectors = direction_field(mesh, 2, DirectionWishes(rows=rows), Options(target_gap=1e-5)).vectors[x == 1]
        found.append(np.degrees(np.arctan2(vectors[:, 1], vectors[:, 0])).mean() % 180)
    assert found[0] == pytest.approx(found[1], abs=3) and 100 < found[1] < 150


def test_a_stroke_of_one_point_is_refused():
    mesh = square(3)
    with pytest.raises(SettingError, match="single point"):
        line_of_strokes(mesh, [(np.array([0]), np.zeros((1, 3)))])


def test_strokes_and_fields_that_contradict_are_named():
    mesh = square(9)
    line = line_of_strokes(mesh, [segment(mesh, np.array([0.11, 0.23]), np.array([0.83, 0.57]))])
    with pytest.raises(ContradictionError, match="row A and row B"):
        rows = (Row(line, "along", name="row A"), Row(line, "across", name="row B"))
        direction_field(mesh, 2, DirectionWishes(rows=rows))
    nodes = np.arange(mesh.vertex_count)
    fields = [line_of_points(mesh, nodes, np.full(len(nodes), angle)) for angle in (0.0, 1.0)]
    with pytest.raises(ContradictionError, match="row A and row B"):
        rows = (Row(fields[0], "along", name="row A"), Row(fields[1], "along", name="row B"))
        direction_field(mesh, 2, DirectionWishes(rows=rows))
    crossing = line_of_strokes(mesh, [segment(mesh, np.array([0.2, 0.8]), np.array([0.6, 0.1]))])
    direction_field(mesh, 2, DirectionWishes(rows=(Row(line, "along"), Row(crossing, "along"))))
