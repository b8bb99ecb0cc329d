# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Seams and groups that carry nothing across."""

from itertools import product

import numpy as np
import pytest

from synch_fields.core.interpolate import evaluate
from synch_fields.synch_addon import api

from ..constrained_sheet import MARKS, SPACING, cosines, sheet, wave
from ..rebuilt_pattern import phases_of, polygons_of
from ..scenes import add_group, add_object, hexagon_sphere, mark_edges, places, sphere


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
