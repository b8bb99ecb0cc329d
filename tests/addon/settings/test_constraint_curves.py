# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows on curves, drawings and wires beside the surface."""

import bpy
import numpy as np
import pytest

from synch_fields.core.interpolate import evaluate
from synch_fields.synch_addon import api

from ..constrained_sheet import SOURCES, SPACING, pattern, sheet, wave
from ..rebuilt_pattern import phases_of, polygons_of
from ..scenes import add_drawing, directions, grid, make_active, places


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


@pytest.mark.parametrize(("source", "degrees"), tuple(zip(SOURCES, (0, 180, 0), strict=True)))
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


@pytest.mark.parametrize("away", [0.7, 1.0, 1.5])
def test_a_stripe_under_a_circle_off_a_ball_is_as_round_as_the_circle(away):
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5)
    obj, height, spacing = bpy.context.active_object, 0.6, 0.25  # seven edges
    bpy.ops.curve.primitive_bezier_circle_add(radius=0.8 * away, location=(0, 0, height * away))
    source = bpy.context.active_object
    source.data.resolution_u = 32
    make_active(obj)
    report = api.stripes(obj, spacing=spacing, constraints=[{"where": "curve", "what": "phase", "name": source.name}])
    latitude = np.arcsin(places(obj)[:, 2]) - np.arcsin(height)
    near = np.abs(latitude) < 0.03
    off = np.abs(np.arccos(np.clip(pattern(obj)[near], -1, 1)) / (2 * np.pi) - np.abs(latitude[near]) / spacing)
    assert np.quantile(off, 0.95) < 0.02, np.quantile(off, 0.95)
    defects = np.array([defect["position"] for defect in report["disclinations"]])
    assert np.abs(np.arcsin(np.clip(defects[:, 2], -1, 1)) - np.arcsin(height)).min() > spacing


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
