# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every row of the constraint list on shapes whose pattern is known in closed form."""

from itertools import pairwise, product

import bpy
import numpy as np
import pytest

from synch_fields.core.interpolate import evaluate
from synch_fields.synch_addon import api

from .continuity import phases_of, polygons_of
from .scenes import (
    add_curve,
    add_drawing,
    add_group,
    add_object,
    add_wire,
    attribute,
    grid,
    hexagon_sphere,
    make_active,
    mark_edges,
    panel,
    set_numbers,
    set_vectors,
    sphere,
    tube,
)

MARKS = ("seams", "sharp", "creases")
SOURCES = {"curve": add_curve, "drawing": add_drawing, "wire": add_wire}
SPACING = 0.35


def sheet():
    """A rectangle, 2 by 1.2, around the origin, with a column of vertices at x = 0."""
    return panel((2, 1.2), (16, 10), (-1, -0.6))


def places(obj):
    return attribute(obj, "position").astype(float)


def line_upright(obj, place):
    """A line in the direction of y: the row's place, its x, and whether it runs up (1) or down (-1)."""
    x = places(obj)[:, 0]
    if place in MARKS:
        mark_edges(obj, place, np.abs(x) < 1e-6)
        return {"where": place}, 0.0, 1
    if place == "group":
        add_group(obj, "middle", np.flatnonzero(np.abs(x) < 1e-6))
        return {"where": "group", "name": "middle"}, 0.0, 1
    if place == "boundary":  # runs with the mesh on its left
        add_group(obj, "left", np.flatnonzero(x < -0.99))
        return {"where": "boundary", "name": "left"}, -1.0, -1
    source = SOURCES[place]([(0.04, -0.6, 0.2), (0.04, 0.6, 0.2)])  # above the sheet: it is projected
    make_active(obj)
    return {"where": "curve", "name": source.name}, 0.04, 1


EVERY_PLACE = (*MARKS, "group", "boundary", *SOURCES)


def directions(obj):
    return attribute(obj, "synch_direction").astype(float)


def pattern(obj):
    return attribute(obj, "synch_pattern").astype(float)


def cosines(obj):
    """The pattern at face corners, and their places."""
    vertices = np.array([loop.vertex_index for loop in obj.data.loops])
    return np.cos(attribute(obj, "synch_phase").astype(float)), places(obj)[vertices]


def wave(distance, spacing=SPACING, phase=0.0):
    return np.cos(2 * np.pi * np.asarray(distance) / spacing + phase)


# Directions


@pytest.mark.parametrize("wish, degrees", [("along", 0), ("across", 90), ("angle", 30), ("angle", -70)])
@pytest.mark.parametrize("place", EVERY_PLACE)
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


@pytest.mark.parametrize(
    "line, place", [*product(["ring", "chain"], ["seams", "sharp", "creases", "group"]), ("ring", "boundary")]
)
@pytest.mark.parametrize("wish, degrees", [("along", 0), ("across", 90), ("angle", 25)])
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


@pytest.mark.parametrize("symmetry", ["line", "vector"])
@pytest.mark.parametrize("degrees", [0, 180, 50])
@pytest.mark.parametrize("place", EVERY_PLACE)
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


def test_both_rims_of_a_tube_keep_a_phase_each_that_fits_best():
    obj = tube()
    report = api.stripes(obj, spacing=0.45, constraints=[{"where": "boundary", "what": "constant"}])
    values = pattern(obj).reshape(9, 24)
    np.testing.assert_allclose(np.ptp(values, axis=1), 0, atol=1e-5)
    assert report["energy"] < 1e-6  # 2.0 is no multiple of the spacing: the same phase on both rims would cost
    assert abs(values[0, 0] - values[-1, 0]) > 0.01 or np.cos(2 * np.pi * 2 / 0.45) > 0.99


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


# Curves


def _area(u, v):
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]


def on_curve(obj, points):
    """cos(theta) at points of a flat mesh."""
    polygons, phases = polygons_of(obj), phases_of(obj)
    corners = places(obj)[polygons.triangles][:, :, :2]
    a, b, c = np.moveaxis(corners, 1, 0)
    values = []
    for point in np.asarray(points)[:, :2]:
        weights = np.column_stack([_area(b - point, c - point), _area(c - point, a - point)])
        weights /= _area(b - a, c - a)[:, None]
        weights = np.column_stack([weights, 1 - weights.sum(axis=1)])
        inside = np.argmax(weights.min(axis=1))
        values.append(np.cos(evaluate(phases, polygons, np.array([inside]), weights[[inside]]))[0])
    return np.array(values)


@pytest.mark.parametrize("source", SOURCES)
@pytest.mark.parametrize("degrees", [0, 180])
def test_a_slanted_stroke_carries_a_stripe_between_the_vertices(source, degrees):
    obj = sheet()
    ends = np.array([(-0.5, -0.6, 0), (0.3, 0.6, 0)])
    SOURCES[source](ends, "Slant")
    make_active(obj)
    api.stripes(
        obj, spacing=SPACING, constraints=[{"where": "curve", "what": "phase", "name": "Slant", "degrees": degrees}]
    )
    along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    left = (places(obj) - ends[0]) @ [-along[1], along[0], 0]
    np.testing.assert_allclose(pattern(obj), wave(left, phase=np.radians(degrees)), atol=1e-5)


def circle(radius, **settings):
    bpy.ops.curve.primitive_bezier_circle_add(radius=radius)
    source = bpy.context.active_object
    for name, value in settings.items():
        setattr(source.data, name, value)
    return source


@pytest.mark.parametrize("settings", [{}, {"bevel_depth": 0.05}, {"dimensions": "2D", "fill_mode": "BOTH"}], ids=str)
def test_a_stripe_lies_on_a_circle_to_a_part_of_an_edge(settings):
    obj = grid(24)  # edges of 1/12
    source = circle(0.6, **settings)
    make_active(obj)
    before = set(bpy.data.objects), set(bpy.data.curves)
    api.stripes(obj, spacing=0.4, constraints=[{"where": "curve", "what": "phase", "name": source.name}])
    assert before == (set(bpy.data.objects) - set(obj.children), set(bpy.data.curves))
    turn = np.linspace(0, 2 * np.pi, 100)
    values = on_curve(obj, 0.6 * np.column_stack([np.cos(turn), np.sin(turn)]))
    away = np.arccos(np.clip(values, -1, 1)) / (2 * np.pi) * 0.4
    assert away.max() < 0.1 / 12, away.max() * 12
    x, y, _ = places(obj).T
    radius = np.hypot(x, y)
    near = np.abs(radius - 0.6) < 1 / 24
    np.testing.assert_allclose(pattern(obj)[near], wave(radius[near] - 0.6, 0.4), atol=0.03)


def test_directions_run_along_a_circle():
    obj = grid(24)
    source = circle(0.6)
    make_active(obj)
    for wish, component in (("along", 0), ("across", 1)):
        api.directions(obj, constraints=[{"where": "curve", "what": wish, "name": source.name}])
        radius = np.linalg.norm(places(obj), axis=1)
        near = np.abs(radius - 0.6) < 0.04
        outwards = np.abs(np.einsum("ij,ij->i", directions(obj), places(obj)))[near] / radius[near]
        np.testing.assert_allclose(outwards, component, atol=0.12)


def test_a_drawing_counts_where_its_layers_are_and_are_seen():
    obj = sheet()
    drawing = add_drawing([(0, -0.6, 0), (0, 0.6, 0)])
    drawing.data.layers["Lines"].translation = (0.05, 0, 0)
    hidden = drawing.data.layers.new("Hidden")
    hidden.frames.new(1).drawing.add_strokes([2])
    for point, place in zip(hidden.frames[0].drawing.strokes[0].points, [(-1, 0, 0), (1, 0, 0)], strict=True):
        point.position = place
    hidden.hide = True
    drawing.location.x = 0.07
    make_active(obj)
    api.stripes(obj, spacing=SPACING, constraints=[{"where": "curve", "what": "phase", "name": drawing.name}])
    np.testing.assert_allclose(pattern(obj), wave(places(obj)[:, 0] - 0.12), atol=1e-5)


# Cuts


def panels_apart(mark):
    """A sheet cut at x = 0, with upright stripes left and level stripes right; the row that cuts and the others."""
    obj = sheet()
    x, y, _ = places(obj).T
    middle = np.abs(x) < 1e-6
    add_group(obj, "left", np.flatnonzero(x < -0.99))
    add_group(obj, "lower right", np.flatnonzero((y < -0.59) & (x > -1e-6)))
    cut = {"where": mark, "what": "cut"}
    if mark == "group":
        add_group(obj, "middle", np.flatnonzero(middle))
        cut["name"] = "middle"
    else:
        mark_edges(obj, mark, middle)
    return obj, cut, [{"where": "boundary", "what": "phase", "name": name} for name in ("left", "lower right")]


@pytest.mark.parametrize("mark", [*MARKS, "group"])
def test_each_side_of_a_cut_has_its_own_corner_values(mark):
    obj, cut, rows = panels_apart(mark)
    report = api.stripes(obj, spacing=SPACING, constraints=[cut, *rows])
    values, at = cosines(obj)
    left = np.repeat([face.center.x < 0 for face in obj.data.polygons], 4)
    np.testing.assert_allclose(values[left], wave(at[left, 0] + 1), atol=1e-5)
    np.testing.assert_allclose(values[~left], wave(at[~left, 1] + 0.6), atol=1e-5)
    assert report["energy"] < 1e-9 and report["dislocations"] == report["disclinations"] == []
    uncut = api.stripes(obj, spacing=SPACING, constraints=rows)
    assert uncut["energy"] > 1


def test_a_cut_panel_is_solved_as_if_it_were_alone():
    """The bound of a sphere cut into halves is the sum of both halves' bounds."""
    whole = sphere(3)
    height = places(whole)[:, 2]
    order = np.argsort(height)
    below = np.zeros(len(height), bool)
    below[order[: len(order) // 2]] = True
    triangles = np.array([face.vertices[:] for face in whole.data.polygons])
    lower = below[triangles].any(axis=1)
    # Edges between a face of the one half and one of the other.
    sides = {}
    for face, is_lower in zip(triangles.tolist(), lower, strict=True):
        for pair in product(face, face):
            sides.setdefault(pair, set()).add(is_lower)
    marks = whole.data.attributes.new("uv_seam", "BOOLEAN", "EDGE")
    marks.data.foreach_set("value", [len(sides[tuple(edge.vertices)]) == 2 for edge in whole.data.edges])
    cut = api.directions(whole, constraints=[{"where": "seams", "what": "cut"}], target_gap=1e-4)
    vertices = places(whole)
    alone = [
        api.directions(add_object(vertices[np.unique(part)], np.searchsorted(np.unique(part), part)), target_gap=1e-4)
        for part in (triangles[lower], triangles[~lower])
    ]
    assert cut["sdp_value"] == pytest.approx(sum(report["sdp_value"] for report in alone), rel=1e-3)
    assert cut["nodes"] == sum(report["nodes"] for report in alone)


def test_rows_hold_on_both_sides_of_a_cut():
    obj, cut, _ = panels_apart("seams")
    api.stripes(obj, spacing=SPACING, constraints=[cut, {"where": "seams", "what": "phase", "degrees": 90}])
    values, at = cosines(obj)
    # Both sides are boundaries with their panel on the left.
    np.testing.assert_allclose(values, wave(np.abs(at[:, 0]), phase=np.pi / 2), atol=1e-5)


def test_faces_of_many_corners_are_split_on_a_cut_mesh_where_they_hold_a_defect():
    obj = hexagon_sphere()
    count = len(obj.data.polygons)
    centres = np.array([face.center[:] for face in obj.data.polygons])
    sides = {}
    for face, centre in zip(obj.data.polygons, centres, strict=True):
        for key in face.edge_keys:
            sides.setdefault(key, set()).add(centre[2] + 0.1 * centre[0] > 0)
    is_cut = np.array([len(sides[edge.key]) == 2 for edge in obj.data.edges])
    obj.data.attributes.new("uv_seam", "BOOLEAN", "EDGE").data.foreach_set("value", is_cut)
    cut_keys = {edge.key for edge, marked in zip(obj.data.edges, is_cut, strict=True) if marked}
    report = api.stripes(obj, spacing=0.3, constraints=[{"where": "seams", "what": "cut"}])
    assert len(obj.data.polygons) > count and any("split" in line for line in report["warnings"])
    assert len(report["disclinations"]) + len(report["dislocations"]) > 0
    jumps = jumps_over_edges(obj)
    assert max(jump for key, jump in jumps.items() if key not in cut_keys) < 1e-4
    assert max(jumps[key] for key in cut_keys) > 0.5  # nothing is carried across


def jumps_over_edges(obj, samples=6):
    """Largest jump of cos(theta) over each edge of the drawn triangles, by its pair of vertices."""
    polygons, phases = polygons_of(obj), phases_of(obj)
    seen = {}
    for k in range(3):
        tails, heads = polygons.triangles[:, k], polygons.triangles[:, (k + 1) % 3]
        wave = []
        for x in np.linspace(0, 1, samples):
            weights = np.zeros((len(tails), 3))
            weights[:, k] = np.where(tails < heads, 1 - x, x)
            weights[:, (k + 1) % 3] = 1 - weights[:, k]
            wave.append(np.cos(evaluate(phases, polygons, np.arange(len(tails)), weights)))
        for i, j, values in zip(tails.tolist(), heads.tolist(), np.transpose(wave), strict=True):
            seen.setdefault((min(i, j), max(i, j)), []).append(values)
    return {key: np.abs(values[0] - values[1]).max() for key, values in seen.items() if len(values) == 2}


# Soft rows


def balance(weight, wanted, length, area):
    """Turn of a field, held at 0, that is drawn to `wanted` at a distance: turn / length = weight / sqrt(area) sin."""
    low, high = 0.0, wanted
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (
            (middle, high) if middle / length < weight / np.sqrt(area) * np.sin(wanted - middle) else (low, middle)
        )
    return low


WEIGHTS = (0.0, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 1000.0)


@pytest.mark.parametrize("place", ["seams", "curve"])
def test_a_soft_angle_goes_from_free_to_fixed(place):
    """Held upright on the left, drawn by 50 degrees at a line a unit away: in one dimension a closed form."""
    obj = sheet()
    x = places(obj)[:, 0]
    hold, _, _ = line_upright(obj, "boundary")
    drawn, at, _ = line_upright(obj, place)
    angles = []
    for weight in WEIGHTS:
        soft = drawn | {"what": "angle", "degrees": 50, "weight": weight}
        api.directions(obj, target_gap=1e-4, constraints=[hold | {"what": "along"}, soft])
        there = directions(obj)[np.abs(x) < 1e-6]
        angle = (np.degrees(np.arctan2(-there[:, 0], there[:, 1])) + 90) % 180 - 90
        assert np.ptp(angle) < 1
        angles.append(angle.mean())
        expected = np.degrees(balance(weight, np.radians(100), 1.0 + at, 2 * 1.2)) / 2
        assert angles[-1] == pytest.approx(expected, abs=2.0 if place == "curve" else 0.5)
    assert angles[0] < 1e-3 and (np.diff(angles) > 0).all()
    if place == "seams":
        assert angles[-1] == pytest.approx(50, abs=0.1)


def test_a_soft_phase_goes_from_free_to_fixed():
    obj = sheet()
    x = places(obj)[:, 0]
    hold, _, _ = line_upright(obj, "boundary")
    add_group(obj, "right", np.flatnonzero(x > 0.99))
    free = 2 * np.pi * 2.0 / 0.4  # five periods
    turns = []
    for weight in WEIGHTS:
        # The right side runs up with the sheet on its left, where the phase falls from its value on.
        soft = {"where": "boundary", "what": "phase", "name": "right", "degrees": -110, "weight": weight}
        api.stripes(obj, spacing=0.4, target_gap=1e-4, constraints=[hold | {"what": "phase"}, soft])
        vertices = np.array([loop.vertex_index for loop in obj.data.loops])
        phase = attribute(obj, "synch_phase").astype(float)[np.isin(vertices, np.flatnonzero(x > 0.99))]
        turn = np.degrees(np.arccos(np.clip(np.cos(phase - free), -1, 1)))
        assert np.ptp(turn) < 0.1
        turns.append(turn.mean())
        assert turns[-1] == pytest.approx(np.degrees(balance(weight, np.radians(110), 2.0, 2 * 1.2)), abs=1.0)
    assert turns[0] < 0.01 and (np.diff(turns) > 0).all()
    assert turns[-1] == pytest.approx(110, abs=0.2)


# Boundaries


def ring(inner, outer, count=12, segments=72):
    """A flat ring of quads around the origin."""
    turn = np.arange(segments) * 2 * np.pi / segments
    vertices = [(r * np.cos(a), r * np.sin(a), 0) for r in np.linspace(inner, outer, count + 1) for a in turn]
    faces = []
    for k, i in product(range(count), range(segments)):
        here, there = k * segments + i, k * segments + (i + 1) % segments
        faces.append((here, here + segments, there + segments, there))
    return add_object(vertices, faces, "Ring")


def disk(count=24):
    """A unit disk of triangles of about the same size, k * 6 of its vertices on the k-th circle."""
    circles = [[0]]
    vertices = [(0.0, 0.0, 0.0)]
    for k in range(1, count + 1):
        turn = np.arange(6 * k) * 2 * np.pi / (6 * k)
        circles.append(list(range(len(vertices), len(vertices) + 6 * k)))
        vertices += [(k / count * np.cos(a), k / count * np.sin(a), 0.0) for a in turn]
    faces = []
    for k, (inner, outer) in enumerate(pairwise(circles)):
        for sector in range(6):
            for i in range(k + 1):
                out = sector * (k + 1) + i
                into = sector * k + i
                a, b = outer[out], outer[(out + 1) % len(outer)]
                faces.append((inner[into % len(inner)], a, b))
                if i < k:
                    faces.append((inner[into], b, inner[(into + 1) % len(inner)]))
    return add_object(vertices, faces, "Disk")


def test_a_flat_ring_with_stripes_on_its_boundary_has_concentric_rings():
    obj = ring(0.5, 1.5)
    report = api.stripes(obj, spacing=0.25, constraints=[{"where": "boundary", "what": "phase"}])
    radius = np.linalg.norm(places(obj), axis=1)
    np.testing.assert_allclose(pattern(obj), wave(radius - 0.5, 0.25), atol=0.01)
    assert report["dislocations"] == report["disclinations"] == []


def test_a_disk_with_a_stripe_on_its_boundary_has_concentric_rings():
    obj = disk()
    set_vectors(obj, "circles", np.cross([0, 0, 1], places(obj)))  # zero in the centre, where nothing is asked
    rows = [
        {"where": "boundary", "what": "phase", "degrees": 180},
        {"where": "attribute", "what": "along", "name": "circles"},
    ]
    report = api.stripes(obj, spacing=0.25, symmetry="vector", constraints=rows)
    distance = 1 - np.linalg.norm(places(obj), axis=1)
    outside = distance < 0.9
    np.testing.assert_allclose(pattern(obj)[outside], -wave(distance, 0.25)[outside], atol=0.05)
    assert [d["index"] for d in report["disclinations"]] == [1] and report["dislocations"] == []


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
