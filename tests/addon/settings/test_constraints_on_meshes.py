# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every kind of constraint on real meshes: it holds where it was asked for, and the bound stays a bound."""

import bpy
import numpy as np
import pytest

from synch_fields.synch_addon import api

from ..quad_meshes import ends
from ..rebuilt_pattern import largest_jump
from ..scenes import attribute, make_active, save_and_reopen
from ..shared_meshes import MARKS, opened

pytestmark = MARKS


def boundary_vertices(obj):
    counts = {}
    for polygon in obj.data.polygons:
        for key in polygon.edge_keys:
            counts[key] = counts.get(key, 0) + 1
    return np.unique([key for key, count in counts.items() if count == 1])


def mark_around(obj, axis, share):
    """Mark as seams, sharp and creased the edges between the faces on both sides of a plane."""
    centres = np.array([p.center[axis] for p in obj.data.polygons])
    above = centres > np.quantile(centres, share)
    sides = {}
    for polygon, side in zip(obj.data.polygons, above, strict=True):
        for key in polygon.edge_keys:
            sides.setdefault(key, set()).add(bool(side))
    between = np.array([len(sides[edge.key]) == 2 for edge in obj.data.edges])
    obj.data.edges.foreach_set("use_seam", between)
    obj.data.edges.foreach_set("use_edge_sharp", between)
    obj.data.attributes.new("crease_edge", "FLOAT", "EDGE").data.foreach_set("value", between.astype(np.float32))
    vertices = np.unique(ends(obj)[between])
    obj.vertex_groups.new(name="ring").add(vertices.tolist(), 1.0, "REPLACE")
    return vertices


def solved(obj, constraints, tmp_path, **settings):
    """Stripes, checked for what holds of every result."""
    report = api.stripes(obj, constraints=constraints, **settings)
    assert report["certificate"] == "proved" and report["lower_bound"] <= report["energy"]
    for part in (report, report["directions"]):
        assert part["lower_bound"] <= part["energy"] * (1 + 1e-9)
    copy = save_and_reopen(tmp_path / "constrained.blend", obj.name)
    return report, copy


@pytest.mark.parametrize("name", ["Concerthall", "train-station", "inspired_mesh", "stanford-bunny"])
def test_phases_on_real_boundaries(name, tmp_path):
    obj = opened(name)
    rim = boundary_vertices(obj)
    _, obj = solved(obj, [{"where": "boundary", "what": "phase", "degrees": 60}], tmp_path)
    np.testing.assert_allclose(attribute(obj, "synch_pattern")[rim], 0.5, atol=1e-6)


@pytest.mark.parametrize("where", ["seams", "sharp", "creases", "group"])
@pytest.mark.parametrize("what", ["phase", "constant"])
@pytest.mark.parametrize("name", ["spot", "fertility"])
def test_phases_on_rings(name, what, where, tmp_path):
    obj = opened(name)
    ring = mark_around(obj, 1, 0.5)
    row = {"where": where, "what": what, "degrees": 0} | ({"name": "ring"} if where == "group" else {})
    _, obj = solved(obj, [row], tmp_path)
    values = attribute(obj, "synch_pattern")[ring]
    if what == "phase":
        np.testing.assert_allclose(values, 1, atol=1e-6)
    else:
        assert len(np.unique(values.round(5))) <= 6  # one value on each of a few rings
    assert largest_jump(obj)[0] < 1e-4


@pytest.mark.parametrize("name", ["spot", "rocker-arm"])
def test_panels_of_a_cut_are_solved_apart(name, tmp_path):
    obj = opened(name)
    mark_around(obj, 1, 0.5)
    whole = api.stripes(obj, constraints=[])
    report, obj = solved(obj, [{"where": "seams", "what": "cut"}], tmp_path)
    assert report["nodes"] > whole["nodes"] and report["energy"] < whole["energy"]


def add_level_cut(obj, places, height):
    """An object "Ring" of the edges in which a level plane cuts the object's triangles."""
    obj.data.calc_loop_triangles()
    corners = places[[triangle.vertices[:] for triangle in obj.data.loop_triangles]]
    above = corners[:, :, 2] > height
    crossed = corners[above.any(axis=1) & ~above.all(axis=1)]
    first, second = crossed, np.roll(crossed, -1, axis=1)
    is_cut = (first[:, :, 2] > height) != (second[:, :, 2] > height)
    shares = (height - first[is_cut][:, 2]) / (second[is_cut] - first[is_cut])[:, 2]
    points = first[is_cut] + shares[:, None] * (second[is_cut] - first[is_cut])
    data = bpy.data.meshes.new("Ring")
    data.from_pydata(points.tolist(), np.arange(len(points)).reshape(-1, 2).tolist(), [])
    bpy.context.collection.objects.link(bpy.data.objects.new("Ring", data))


@pytest.mark.parametrize(("what", "degrees"), [("along", 0), ("across", 90), ("angle", 45)])
@pytest.mark.parametrize("name", ["spot", "cheburashka"])
def test_directions_at_a_curve(name, what, degrees, tmp_path):
    """A level cut through the object: beside it directions have their angle to the level line."""
    obj = opened(name)
    turn = np.array(obj.matrix_world.to_3x3())
    places = attribute(obj, "position") @ turn.T
    centre, size = (places.max(axis=0) + places.min(axis=0)) / 2, np.ptp(places, axis=0).max()
    add_level_cut(obj, places, centre[2])
    make_active(obj)
    row = {"where": "curve", "name": "Ring", "what": what} | ({"degrees": degrees} if what == "angle" else {})
    _, obj = solved(obj, [row], tmp_path)
    normals = np.array([v.normal for v in obj.data.vertices]) @ turn.T
    level = np.cross(normals, [0, 0, 1])
    steep = np.linalg.norm(level, axis=1) > 0.9
    near = steep & (np.abs(places[:, 2] - centre[2]) < 0.02 * size)
    level = level[near] / np.linalg.norm(level[near], axis=1)[:, None]
    cosines = np.abs(np.einsum("ij,ij->i", attribute(obj, "synch_direction")[near] @ turn.T, level))
    assert near.sum() > 10
    assert np.degrees(np.arccos(np.median(cosines).clip(0, 1))) == pytest.approx(degrees, abs=2)


@pytest.mark.parametrize("what", ["along", "across"])
def test_an_attribute_holds_where_it_is_not_zero(what, tmp_path):
    obj = opened("spot")
    places = attribute(obj, "position").astype(float)
    around = np.cross([0, 1, 0], places)
    asked = places[:, 1] > np.median(places[:, 1])
    around[~asked] = 0
    obj.data.attributes.new("around", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", np.float32(around).ravel())
    _, obj = solved(obj, [{"where": "attribute", "name": "around", "what": what}], tmp_path)
    directions = attribute(obj, "synch_direction").astype(float)
    normals = np.array([v.normal for v in obj.data.vertices])
    tangent = around - np.einsum("ij,ij->i", around, normals)[:, None] * normals
    tangent = tangent[asked] / np.linalg.norm(tangent[asked], axis=1)[:, None]
    cosines = np.abs(np.einsum("ij,ij->i", directions[asked], tangent))
    assert np.quantile(cosines, 0.05 if what == "along" else 0.95) == pytest.approx(
        1 if what == "along" else 0, abs=0.03
    )
