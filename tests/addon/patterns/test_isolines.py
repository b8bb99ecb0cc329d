# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines of a pattern as curves: where they lie in the scene, that tubes are round and ribbons lie on the surface."""

import json

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SynchError
from synch_fields.synch_addon import api
from synch_fields.synch_addon.command import main

from ..run_commands import undo_and_redo
from ..scenes import attribute, grid, hexagon_sphere, mark_edges, snapshot, sphere, torus, tube

SPACING = 0.25


def striped_grid(**settings):
    """A flat square, 2 by 2, with straight stripes along X."""
    obj = grid(16)
    api.stripes(obj, spacing=SPACING, guidance="axis:X", **settings)
    return obj


def curve(report):
    return bpy.data.objects[report["object"]]


def splines(obj):
    """Points of each spline in the world."""
    matrix = np.array(obj.matrix_world)
    found = []
    for spline in obj.data.splines:
        points = spline.bezier_points if spline.type == "BEZIER" else spline.points
        local = np.array([point.co[:3] for point in points])
        found.append(local @ matrix[:3, :3].T + matrix[:3, 3])
    return found


def evaluated(obj):
    """(n, 3) vertices of what an object looks like, in the world."""
    graph = bpy.context.evaluated_depsgraph_get()
    mesh = obj.evaluated_get(graph).to_mesh()
    points = np.array([vertex.co[:] for vertex in mesh.vertices])
    matrix = np.array(obj.matrix_world)
    return points @ matrix[:3, :3].T + matrix[:3, 3]


@pytest.mark.parametrize(
    ("width", "gaps", "distance"), [(0, [0.25], 0), (0.5, [0.125], 0.3), (0.3, [0.075, 0.175], 0), (1, [0.25], 0.3)]
)
def test_lines_lie_where_the_stripes_are(width, gaps, distance):
    obj = striped_grid()
    report = api.isolines(obj, width=width, distance=distance)
    lines = splines(curve(report))
    heights = np.sort([points[:, 1].mean() for points in lines])
    assert report["lines"] == len(lines) and report["closed"] == 0
    assert report["ends"] == {"boundary": 2 * len(lines), "dislocation": 0, "disclination": 0}
    found = np.diff(heights)
    assert np.abs(found[:, None] - gaps).min(axis=1).max() < 1e-4 and np.ptp(heights) > 2 - 2 * SPACING
    for points in lines:
        assert np.abs(points[:, 1] - points[:, 1].mean()).max() < 1e-4 and np.abs(points[:, 2]).max() < 1e-6
        np.testing.assert_allclose(np.sort(points[[0, -1], 0]), [-1, 1], atol=1e-5)
    assert report["length"] == pytest.approx(2 * len(lines), rel=1e-5)


def test_middles_are_where_the_attributes_have_their_crests_and_gaps_where_they_are_low():
    obj = striped_grid()
    y, pattern = attribute(obj, "position")[:, 1], attribute(obj, "synch_pattern")
    for width, sign in ((0, 1), (1, -1)):
        heights = np.array([points[0, 1] for points in splines(curve(api.isolines(obj, width=width)))])
        away = np.abs(y[:, None] - heights).min(axis=1)
        np.testing.assert_allclose(pattern, sign * np.cos(2 * np.pi * away / SPACING), atol=1e-3)


def test_tubes_are_round_and_of_scene_units_whatever_the_scale():
    obj = grid(16)
    obj.location, obj.rotation_euler, obj.scale = (3, -1, 2), (0.3, 0.5, 0.7), (2, 1, 1)
    bpy.context.view_layer.update()
    api.stripes(obj, spacing=SPACING, guidance="axis:X")
    made = curve(api.isolines(obj, radius=0.2, distance=0, smoothing=0))
    assert made.data.bevel_depth == pytest.approx(0.2 * SPACING)
    inverse = np.linalg.inv(np.array(made.matrix_world)[:3, :3])
    np.testing.assert_allclose(inverse @ inverse.T, np.eye(3), atol=1e-6)
    axes = np.array(obj.matrix_world)[:3, :3]
    along, across, normal = (axes / np.linalg.norm(axes, axis=0)).T
    lines = splines(made)
    places = np.sort([points[0] @ across for points in lines])
    np.testing.assert_allclose(np.diff(places), SPACING, atol=1e-4)
    surface = evaluated(made)
    y, z = surface @ across, (surface - np.array(obj.location)) @ normal
    from_line = np.hypot(np.abs(y[:, None] - places).min(axis=1), z)
    on_rim = from_line > 1e-3  # all but the middles of the caps
    np.testing.assert_allclose(from_line[on_rim], 0.2 * SPACING, atol=1e-4)
    assert on_rim.mean() > 0.9
    assert np.ptp(surface @ along) == pytest.approx(4, abs=1e-4)


def test_a_curve_beside_an_object_without_scale_has_its_matrix_and_collection():
    obj = sphere()
    other = bpy.data.collections.new("Balls")
    bpy.context.scene.collection.children.link(other)
    bpy.context.scene.collection.objects.unlink(obj)
    other.objects.link(obj)
    obj.location, obj.rotation_euler = (1, 2, 3), (0.1, 0.2, 0.3)
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    bpy.context.view_layer.update()
    api.stripes(obj)
    made = curve(api.isolines(obj))
    np.testing.assert_allclose(np.array(made.matrix_world), np.array(obj.matrix_world), atol=1e-6)
    assert list(made.users_collection) == [other] and made.name == "Icosphere Lines"
    assert bpy.context.active_object == obj and obj.select_get() and not made.select_get()
    distances = [np.linalg.norm(points - np.array(obj.location), axis=1) for points in splines(made)]
    assert 0.95 < min(map(np.min, distances)) and max(map(np.max, distances)) < 1 + 1e-5


@pytest.mark.parametrize("spline", ["POLY", "BEZIER", "NURBS"])
def test_every_kind_of_spline_is_a_tube_along_the_surface(spline):
    obj = torus()
    api.stripes(obj, spacing=0.3)
    report = api.isolines(obj, spline=spline.lower(), radius=0.1, width=0.5)
    made = curve(report)
    assert {s.type for s in made.data.splines} == {spline}
    assert [s.use_cyclic_u for s in made.data.splines].count(True) == report["closed"]
    points = evaluated(made)
    from_core = np.abs(np.hypot(np.hypot(points[:, 0], points[:, 1]) - 1, points[:, 2]) - 0.4)
    assert from_core.max() < 0.1 * 0.3 + 0.04 and len(points) > 1000  # the torus has flat faces


@pytest.mark.parametrize("build", [torus, lambda: tube(24, 9)])
def test_ribbons_lie_on_the_surface(build):
    """Extruded poly lines reach sideways along the surface, also where they run upright."""
    obj = build()
    settings = {"guidance": "axis:Z"} if obj.name == "Tube" else {}
    api.stripes(obj, spacing=0.3, **settings)
    made = curve(api.isolines(obj, radius=0, distance=0.2))
    made.data.extrude = 0.01
    centres = np.concatenate(splines(made))
    ribbon = evaluated(made)
    pairs = np.argsort(np.linalg.norm(ribbon[None] - centres[:, None], axis=2), axis=1)[:, :2]
    sideways = ribbon[pairs[:, 1]] - ribbon[pairs[:, 0]]
    np.testing.assert_allclose(ribbon[pairs].mean(axis=1), centres, atol=1e-5)
    normal = {
        "Icosphere": lambda p: p,
        "Tube": lambda p: p * [1, 1, 0],
        "Torus": lambda p: p - p * [1, 1, 0] / np.hypot(p[:, 0], p[:, 1])[:, None],
    }[obj.name](centres)
    cosines = np.einsum("ij,ij->i", sideways, normal / np.linalg.norm(normal, axis=1)[:, None]) / 0.02
    assert np.abs(cosines).max() < 0.1  # normals of faceted surfaces, interpolated


def test_points_are_as_far_apart_as_asked_and_smoothing_leaves_them_on_the_surface():
    obj = sphere(4)
    api.stripes(obj, spacing=0.4)
    rough, smooth = (splines(curve(api.isolines(obj, distance=0.2, smoothing=n))) for n in (0, 12))

    def roughness(lines):
        """Along the sphere: the way over its flat faces is as rough as they are."""
        around = [points / np.linalg.norm(points, axis=1)[:, None] for points in lines if len(points) > 4]
        return np.sqrt(np.mean(np.concatenate([np.diff(points, 3, axis=0) for points in around]) ** 2))

    steps = np.concatenate([np.linalg.norm(np.diff(points, axis=0), axis=1) for points in rough])
    assert np.median(steps) == pytest.approx(0.2 * 0.4, rel=0.02)
    assert roughness(smooth) < 0.5 * roughness(rough)
    for before, after in zip(rough, smooth, strict=True):
        if np.linalg.norm(before[0] - before[-1]) < 0.1:  # a closed line has no ends
            continue
        np.testing.assert_allclose(after[[0, -1]], before[[0, -1]], atol=1e-6)
    radii = np.linalg.norm(np.concatenate(smooth), axis=1)
    assert radii.min() > 0.99 and radii.max() < 1 + 1e-6


@pytest.mark.parametrize("build", [sphere, hexagon_sphere])
def test_as_many_lines_end_as_the_report_has_dislocations(build):
    obj = build()
    solved = api.stripes(obj, spacing=0.25)
    expected = sum(abs(defect["index"]) for defect in solved["dislocations"])
    assert expected > 0
    for width, levels in ((0, 1), (0.4, 2), (1, 1)):
        assert api.isolines(obj, width=width)["ends"]["dislocation"] == levels * expected


def test_lines_are_those_of_the_variation_that_is_shown():
    obj = sphere()
    api.stripes(obj, spacing=0.3)
    first = api.isolines(obj, width=0.5)
    shown = api.vary(obj, 1000)
    again = api.isolines(obj, width=0.5)
    assert again["ends"]["dislocation"] == 2 * sum(abs(d["index"]) for d in shown["dislocations"])
    assert again["length"] != first["length"]


def test_quads_have_both_families_of_lines():
    obj = grid(16)
    api.quads(obj, spacing=0.5, guidance="axis:X")
    lines = splines(curve(api.isolines(obj)))
    upright = [np.ptp(points[:, 0]) < 1e-3 for points in lines]
    level = [np.ptp(points[:, 1]) < 1e-3 for points in lines]
    assert all(a or b for a, b in zip(upright, level, strict=True))
    assert 7 <= sum(upright) <= 9 and 7 <= sum(level) <= 9
    for along, chosen in ((0, upright), (1, level)):
        places = np.sort([points[0, along] for points, it_is in zip(lines, chosen, strict=True) if it_is])
        np.testing.assert_allclose(np.diff(places), 0.25, atol=1e-3)


def test_lines_end_at_cuts():
    obj = grid(16)
    mark_edges(obj, "seams", np.abs(attribute(obj, "position")[:, 0]) < 1e-6)
    api.stripes(obj, spacing=SPACING, guidance="axis:X", constraints=[{"where": "seams", "what": "cut"}])
    lines = splines(curve(api.isolines(obj)))
    assert all((points[:, 0] < 1e-6).all() or (points[:, 0] > -1e-6).all() for points in lines)
    assert len(lines) >= 14


# Errors, undo


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ({"width": 1.5}, "width"),
        ({"width": "wide"}, "width"),
        ({"distance": -1}, "distance"),
        ({"radius": float("nan")}, "radius"),
        ({"smoothing": 0.5}, "smoothing"),
        ({"spline": "spiral"}, "poly"),
        ({"spice": 1}, "spice"),
    ],
    ids=str,
)
def test_refused_settings_change_nothing(settings, says):
    obj = striped_grid()
    before = snapshot()
    with pytest.raises(SynchError, match=says) as refusal:
        api.isolines(obj, **settings)
    assert "\n" not in str(refusal.value) and ":" in str(refusal.value)
    assert snapshot() == before


def unsolved():
    return sphere()


def with_directions_alone():
    obj = sphere()
    api.directions(obj)
    return obj


def changed():
    obj = sphere()
    api.stripes(obj)
    obj.data.vertices[0].co *= 1.1
    return obj


def with_quads():
    obj = sphere()
    api.quads(obj)
    return obj


def with_one_stripe():
    """A quad smaller than a period, whose phase is nowhere that of a middle."""
    obj = grid(3, 0.5)
    x = attribute(obj, "position")[:, 0]
    obj.data.attributes.new("phase", "FLOAT", "POINT").data.foreach_set("value", np.float32(1.0 + 0.2 * x))
    rows = [{"where": "attribute", "name": "phase", "what": "phase"}]
    api.stripes(obj, spacing=0.5, symmetry="vector", guidance="axis:Y", constraints=rows)
    return obj


@pytest.mark.parametrize(
    ("build", "settings", "says"),
    [
        (unsolved, {}, "solve stripes or quads on it first"),
        (with_directions_alone, {}, "stripes (and|or) quads"),
        (changed, {}, "solve it again"),
        (with_quads, {"width": 0.5}, "grid lines"),
        (with_one_stripe, {}, "reduce the spacing"),
    ],
)
def test_what_has_no_lines_is_refused_in_one_line(build, settings, says):
    obj = build()
    bpy.context.view_layer.update()
    before = snapshot()
    with pytest.raises(SynchError, match=says) as refusal:
        api.isolines(obj, **settings)
    assert "\n" not in str(refusal.value)
    assert snapshot() == before
    if build is not unsolved:
        with pytest.raises(RuntimeError, match=says):
            bpy.ops.synch.isolines(**settings)
        assert snapshot() == before
    else:
        assert not bpy.ops.synch.isolines.poll()


def test_undo_removes_the_curve_and_redo_brings_it_back():
    striped_grid()
    assert not bpy.data.curves
    undo_and_redo(lambda: bpy.ops.synch.isolines(width=0.5, radius=0.2), lambda: (snapshot(), len(bpy.data.curves)))
    assert len(bpy.data.curves) == 1


def test_operator_and_function_make_the_same_curve():
    obj = striped_grid()
    assert bpy.ops.synch.isolines(width=0.5, distance=0.3, smoothing=2, radius=0.15, spline="NURBS") == {"FINISHED"}
    by_operator = bpy.data.objects["Grid Lines"]
    by_function = curve(api.isolines(obj, width=0.5, distance=0.3, smoothing=2, radius=0.15, spline="nurbs"))
    assert by_function != by_operator
    for a, b in zip(splines(by_operator), splines(by_function), strict=True):
        np.testing.assert_array_equal(a, b)
    assert by_operator.data.bevel_depth == by_function.data.bevel_depth


def test_in_edit_mode_it_works_and_stays_there():
    obj = striped_grid()
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.synch.isolines() == {"FINISHED"}
    assert obj.mode == "EDIT" and bpy.context.active_object == obj
    bpy.ops.object.mode_set(mode="OBJECT")
    assert "Grid Lines" in bpy.data.objects


# Command line


@pytest.mark.parametrize(("pattern", "suffix"), [("stripes", ".stl"), ("quads", ".obj")])
def test_command_writes_tubes_to_files(tmp_path, capfd, pattern, suffix):
    obj = sphere()
    obj.name = "Ball"
    mesh, report_file = tmp_path / f"tubes{suffix}", tmp_path / "lines.json"
    flags = ["--spacing", "0.4", "--radius", "0.1", "--quiet", "--pattern", pattern]
    flags += ["--export-mesh", mesh, "--report", report_file, "--output", tmp_path / "lines.blend"]
    assert main.main(["isolines", *map(str, flags)], loaded=True) == 0
    printed = capfd.readouterr().out
    report = json.loads(report_file.read_text())
    assert report["command"] == "isolines" and report["pattern"] == pattern and report["settings"]["spacing"] == 0.4
    assert report["isolines"]["object"] == "Ball Lines" and f"{report['isolines']['lines']} lines" in printed
    assert all(f"wrote {path}" in printed for path in (mesh, report_file, tmp_path / "lines.blend"))
    expected = evaluated(bpy.data.objects["Ball Lines"])
    bpy.ops.wm.read_homefile(use_empty=True)
    importer = bpy.ops.wm.stl_import if suffix == ".stl" else bpy.ops.wm.obj_import
    importer(filepath=str(mesh))
    (read,) = bpy.data.objects
    found = evaluated(read)
    np.testing.assert_allclose(np.sort(np.ptp(found, axis=0)), np.sort(np.ptp(expected, axis=0)), rtol=1e-3)
    assert len(read.data.polygons) > 1000


@pytest.mark.parametrize(
    ("flags", "says"),
    [
        (["--width", "2"], "width"),
        (["--pattern", "quads", "--width", "0.5"], "grid lines"),
        (["--radius", "0", "--export-mesh", "x.stl"], "--radius"),
        (["--export-mesh", "x.xyz"], ".stl"),
        (["--smoothing", "-1"], "smoothing"),
    ],
    ids=str,
)
def test_command_refuses_in_one_line_before_it_solves(capfd, flags, says):
    sphere()
    before = snapshot()
    assert main.main(["isolines", "--quiet", *flags], loaded=True) == 1
    error = capfd.readouterr().err
    assert says in error and error.startswith("synch isolines: ") and error.count("\n") == 1
    assert snapshot() == before


def test_lines_lie_where_a_script_has_just_put_the_object():
    obj = sphere()
    api.stripes(obj, spacing=0.4)
    obj.location = (5, 0, 0)
    made = bpy.data.objects[api.isolines(obj)["object"]]
    bpy.context.view_layer.update()
    assert made.matrix_world.translation == obj.matrix_world.translation
    obj.scale = (2, 2, 2)
    with pytest.raises(SynchError, match="has changed since it was solved"):
        api.isolines(obj)
