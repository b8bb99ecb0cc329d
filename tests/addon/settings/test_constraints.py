# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every row of the constraint list on shapes whose pattern is known in closed form."""

from itertools import product

import bpy
import numpy as np
import pytest

from synch_fields.synch_addon import api

from ..constrained_sheet import EVERY_PLACE, MARKS, SPACING, line_upright, pattern, sheet, wave
from ..scenes import add_group, attribute, directions, grid, mark_edges, places, set_numbers, set_vectors, tube

# Directions


WISHES = [("along", 0), ("across", 90), ("angle", -70)]


@pytest.mark.parametrize(
    ("place", "wish", "degrees"),
    [(place, "angle", 30) for place in EVERY_PLACE]
    + [(place, *wish) for place in ("seams", "curve") for wish in WISHES],
)
def test_directions_meet_a_line_at_the_angle_that_is_asked(place, wish, degrees):
    obj = sheet()
    row, _, _ = line_upright(obj, place)
    turn = {"degrees": degrees} if wish == "angle" else {}
    report = api.directions(obj, constraints=[row | {"what": wish} | turn])
    expected = np.array([-np.sin(np.radians(degrees)), np.cos(np.radians(degrees)), 0])  # counterclockwise from y
    np.testing.assert_allclose(np.abs(directions(obj) @ expected), 1, atol=1e-6)
    assert report["energy"] < 1e-9


@pytest.mark.parametrize("wish, sign", [("along", 1), ("across", 1)])
@pytest.mark.parametrize("place", ["seams", "curve"])
def test_vectors_run_with_the_line(place, wish, sign):
    obj = sheet()
    row, _, up = line_upright(obj, place)
    api.directions(obj, symmetry="vector", constraints=[row | {"what": wish}])
    expected = np.array([0, up, 0]) if wish == "along" else np.array([-up, 0, 0])
    np.testing.assert_allclose(directions(obj) @ expected, sign, atol=1e-6)


LINES = [*product(["ring", "chain"], ["seams", "sharp", "creases", "group"]), ("ring", "boundary")]


@pytest.mark.parametrize(
    ("line", "place", "wish", "degrees"),
    [(*line, "angle", 25) for line in LINES] + [(line, "seams", *w) for line in ("ring", "chain") for w in WISHES[:2]],
)
def test_on_a_tube_rings_and_chains_are_lines(line, place, wish, degrees):
    obj = tube()
    chosen = np.arange(24 * 9) // 24 == (0 if place == "boundary" else 4)
    if line == "chain":
        chosen = np.arange(24 * 9) % 24 == 7
    if place in MARKS:
        mark_edges(obj, place, chosen)
        row = {"where": place}
    else:
        add_group(obj, "some", np.flatnonzero(chosen))
        row = {"where": place, "name": "some"}
    api.directions(obj, constraints=[row | {"what": wish, "degrees": degrees if wish == "angle" else 0}])
    upright = np.degrees(np.arccos(np.clip(np.abs(directions(obj)[:, 2]), 0, 1)))
    expected = abs(90 * (line == "ring") - degrees)
    np.testing.assert_allclose(upright, expected, atol=0.1)  # what a tangent plane of a corner is off


def test_an_attribute_gives_directions_where_it_is_not_zero():
    obj = sheet()
    vectors = np.zeros((len(obj.data.vertices), 3))
    vectors[[20, 90, 133]] = (3.0, 1.0, 7.0)  # of any length, not tangential
    set_vectors(obj, "combed", vectors)
    for wish, degrees in (("along", 0), ("across", 90), ("angle", 40)):
        turn = np.arctan2(1, 3) + np.radians(degrees)
        api.directions(
            obj, constraints=[{"where": "attribute", "what": wish, "name": "combed", "degrees": degrees % 90}]
        )
        np.testing.assert_allclose(np.abs(directions(obj) @ [np.cos(turn), np.sin(turn), 0]), 1, atol=1e-6)


# Phases


@pytest.mark.parametrize(
    ("place", "degrees", "symmetry"),
    [*((place, 50, "line") for place in EVERY_PLACE), ("seams", 180, "vector"), ("curve", 0, "vector")],
)
def test_a_stripe_lies_on_a_line_at_its_phase(place, degrees, symmetry):
    obj = sheet()
    row, at, up = line_upright(obj, place)
    api.stripes(obj, spacing=SPACING, symmetry=symmetry, constraints=[row | {"what": "phase", "degrees": degrees}])
    left = up * (at - places(obj)[:, 0])  # the phase grows to the left of the line
    np.testing.assert_allclose(pattern(obj), wave(left, phase=np.radians(degrees)), atol=1e-5)


@pytest.mark.parametrize(
    "scale, turn", [((1, 1, 1), 0.4), ((2, 0.5, 3), 0.0), ((1.5, 1.5, 1.5), -1.0), ((-1, 2, 1), 0.3)]
)
@pytest.mark.parametrize("place", ["seams", "curve"])
def test_lengths_and_lines_are_those_of_the_world(place, scale, turn):
    obj = sheet()
    obj.scale, obj.rotation_euler, obj.location = scale, (0.3, turn, 0.7), (5, 6, 7)
    bpy.context.view_layer.update()
    row, at, up = line_upright(obj, place)
    if place == "curve":  # lies in the world where the object's own line x = 0.04 is
        bpy.data.objects[row["name"]].matrix_world = obj.matrix_world
    api.stripes(obj, spacing=SPACING, constraints=[row | {"what": "phase", "degrees": 90}])
    left = up * (at - places(obj)[:, 0]) * abs(scale[0])
    np.testing.assert_allclose(np.abs(directions(obj)[:, 1]), 1, atol=1e-6)
    np.testing.assert_allclose(np.abs(pattern(obj)), np.abs(wave(left, phase=np.pi / 2)), atol=1e-4)


def test_groups_fix_phases_at_both_ends():
    obj = sheet()
    x = places(obj)[:, 0]
    add_group(obj, "left", np.flatnonzero(x < -0.99))
    add_group(obj, "right", np.flatnonzero(x > 0.99))
    rows = [
        {"where": "group", "what": "phase", "name": "left"},
        {"where": "group", "what": "phase", "name": "right", "degrees": 180},
    ]
    report = api.stripes(obj, spacing=0.8, constraints=rows)  # two and a half periods between them
    np.testing.assert_allclose(pattern(obj), wave(x + 1, 0.8), atol=1e-5)
    assert report["energy"] < 1e-9
    report = api.stripes(obj, spacing=0.8, constraints=rows[:1] + [rows[1] | {"degrees": 0}])
    np.testing.assert_allclose(pattern(obj)[np.abs(x) > 0.99], 1, atol=1e-6)
    assert report["energy"] > 0.1  # the half period that is missing is stretched over the sheet


@pytest.mark.parametrize("degrees", [0, 180])
def test_an_area_and_a_point_get_one_phase(degrees):
    obj = sheet()
    x, y, _ = places(obj).T
    area = np.flatnonzero((np.abs(x) < 0.3) & (np.abs(y) < 0.3))
    for name, chosen in (("area", area), ("point", [3])):
        add_group(obj, name, chosen)
        api.stripes(
            obj, constraints=[{"where": "group", "what": "phase", "name": name, "degrees": degrees}], spacing=0.4
        )
        np.testing.assert_allclose(pattern(obj)[chosen], np.cos(np.radians(degrees)), atol=1e-6)


def test_an_attribute_and_the_weights_of_a_group_give_phases():
    obj = sheet()
    x = places(obj)[:, 0]
    left = np.flatnonzero(x < -0.99)
    along = {"where": "boundary", "what": "along"}
    add_group(obj, "left", left)
    phases = np.full(len(x), np.nan)
    phases[left] = 1.2
    set_numbers(obj, "phases", phases)
    row = {"where": "attribute", "what": "phase", "name": "phases"}
    api.stripes(obj, spacing=SPACING, constraints=[along | {"name": "left"}, row | {"degrees": 30}])
    np.testing.assert_allclose(pattern(obj)[left], np.cos(1.2 + np.pi / 6), atol=1e-6)
    assert np.ptp(pattern(obj)) > 1.5
    obj.vertex_groups.new(name="weights")
    for vertex, weight in enumerate((x + 1) / 2):
        obj.vertex_groups["weights"].add([vertex], weight, "REPLACE")
    api.stripes(obj, spacing=SPACING, constraints=[along | {"name": "left"}, row | {"name": "weights"}])
    np.testing.assert_allclose(pattern(obj), np.cos((x + 1) / 2), atol=1e-5)


def test_a_line_of_the_same_phase_keeps_it_against_the_directions():
    obj = sheet()
    set_vectors(obj, "slanted", np.tile((np.sin(0.3), np.cos(0.3), 0), (len(obj.data.vertices), 1)))
    row, _, _ = line_upright(obj, "seams")
    on = np.abs(places(obj)[:, 0]) < 1e-6
    for rows, spread in (([], 0.5), ([row | {"what": "constant"}], 1e-6)):
        api.stripes(obj, spacing=SPACING, guidance="attribute:slanted", constraints=rows)
        assert (np.ptp(pattern(obj)[on]) < spread) == bool(rows)


@pytest.mark.parametrize("wish", ["along", "constant"])
def test_rows_may_cross_and_meet(wish):
    obj = grid(8)
    x, y, _ = places(obj).T
    mark_edges(obj, "seams", np.abs(x) < 1e-6)
    add_group(obj, "lower", np.flatnonzero(y < -0.99))
    rows = [{"where": "seams", "what": wish}, {"where": "group", "what": "across", "name": "lower"}]
    report = api.stripes(obj, spacing=0.6, constraints=rows)
    np.testing.assert_allclose(np.abs(directions(obj)[:, 1]), 1, atol=1e-6)
    assert report["energy"] < 1e-9


# Boundaries


@pytest.mark.parametrize("boundary", ["along", "across", "phase"])
def test_the_setting_boundary_is_a_row(boundary):
    obj = tube()
    add_group(obj, "lower", range(24))
    row = {"where": "boundary", "what": boundary, "name": "lower"}
    results = []
    for settings in ({"boundary": boundary, "vertex_group": "lower"}, {"constraints": [row]}):
        api.stripes(obj, spacing=0.45, **settings)
        results.append(attribute(obj, "synch_phase"))
    np.testing.assert_array_equal(*results)
