# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Vortices of flows in Blender: files, volumes and curves go in, curves and meshes come out."""

import json
import re
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SettingError, SynchError
from synch_fields.core.fields.biot_savart import filament_velocity
from synch_fields.core.fields.clebsch import edge_integrals, faces_of_filament
from synch_fields.core.files.flows import flow_file
from synch_fields.core.geometry.grid import Grid
from synch_fields.core.tasks.flows import extract_vortices
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import openvdb
from synch_fields.synch_addon.command.main import main
from synch_fields.synch_addon.flows import sources
from synch_fields.synch_addon.flows.chosen import expected_solve
from synch_fields.synch_addon.flows.files import SUFFIXES
from synch_fields.synch_addon.flows.job import clebsch

from ..vortex_scenes import write_vdb


def circle(radius=1.0, location=(0, 0, 0), strength=1.0, segments=100):
    """A curve object, a circle about its local z axis, counterclockwise."""
    data = bpy.data.curves.new("Circle", "CURVE")
    data.dimensions = "3D"
    spline = data.splines.new("POLY")
    spline.points.add(segments - 1)
    turn = np.arange(segments) * 2 * np.pi / segments
    points = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), 0 * turn, np.ones(segments)])
    spline.points.foreach_set("co", points.ravel())
    spline.use_cyclic_u = True
    obj = bpy.data.objects.new("Circle", data)
    obj.location = location
    obj[sources.STRENGTH] = strength
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.update()
    return obj


def ring_grid():
    grid = Grid((24, 24, 14), spacing=0.1, origin=(-1.15, -1.15, -0.65))
    turn = np.linspace(0, 2 * np.pi, 201)
    ring = np.column_stack([0.7 * np.cos(turn), 0.7 * np.sin(turn), 0.02 + 0 * turn])
    return grid, filament_velocity(grid.places, [(ring, 2.0)], 0.1)


def spline_points(obj, number=0):
    points = obj.data.splines[number].points
    places = np.empty(4 * len(points), np.float32)
    points.foreach_get("co", places)
    return places.reshape(-1, 4)[:, :3]


def test_a_curve_comes_back_as_a_filament():
    obj = circle(location=(0.3, 0, 1.0), strength=2.5)
    report = clebsch(obj, quantum=2.5, resolution=28, smoothing=0)
    made = bpy.data.objects[report["object"]]
    assert made.type == "CURVE" and made[sources.STRENGTH] == 2.5 and bpy.context.active_object == made
    (spline,) = made.data.splines
    assert spline.use_cyclic_u and report["filaments"][0]["closed"] and report["filaments"][0]["strength"] == 2.5
    away = spline_points(made) - [0.3, 0, 1.0]
    cell = 3.4 / 27
    assert np.abs(np.hypot(away[:, 0], away[:, 1]) - 1).max() < cell and np.abs(away[:, 2]).max() < 0.5 * cell
    turn = np.cross(away[:-1], away[1:])[:, 2]
    assert turn.sum() > 0  # in its direction
    assert report["lower_bound"] <= report["energy"] and report["status"] != "failed"
    # One filament of the same circulation: loops miss only those parts of the core that they cut.
    assert 0 < report["circulation_error"] < 0.1


def test_arrays_and_a_volume_give_the_same_vortex(tmp_path):
    grid, velocity = ring_grid()
    np.savez(tmp_path / "ring.npz", velocity=velocity.reshape(*grid.shape, 3), spacing=0.1, origin=grid.origin)
    vdb = openvdb.openvdb_module()
    volume = vdb.Vec3SGrid()
    volume.name = "velocity"
    volume.copyFromArray(velocity.reshape(*grid.shape, 3).astype(np.float32))
    volume.transform = vdb.createLinearTransform([[0.1, 0, 0, 0], [0, 0.1, 0, 0], [0, 0, 0.1, 0], [*grid.origin, 1]])
    vdb.write(str(tmp_path / "ring.vdb"), grids=[volume])
    bpy.ops.object.volume_import(filepath=str(tmp_path / "ring.vdb"))
    found = bpy.context.active_object
    found.location.z = 3.0
    bpy.context.view_layer.update()
    for source, height in ((tmp_path / "ring.npz", 0.02), (tmp_path / "ring.vdb", 0.02), (found, 3.02)):
        report = clebsch(source, quantum=2.0, resolution=24)
        points = spline_points(bpy.data.objects[report["object"]])
        assert [line["closed"] for line in report["filaments"]] == [True]
        assert np.abs(points[:, 2] - height).max() < 0.1
        assert np.linalg.norm(points[:, :2], axis=1) == pytest.approx(0.65, abs=0.12)


def test_tubes_are_a_closed_surface_in_the_colours_of_the_sphere(tmp_path):
    grid, velocity = ring_grid()
    np.savez(tmp_path / "ring.npz", velocity=3 * velocity.reshape(*grid.shape, 3), spacing=0.1, origin=grid.origin)
    report = clebsch(tmp_path / "ring.npz", show="tubes", quantum=2.0, opening=80)
    made = bpy.data.objects[report["object"]]
    assert (
        made.type == "MESH" and not made.data.validate() and report["tubes"]["faces"] == len(made.data.polygons) > 100
    )
    shown = np.empty(3 * len(made.data.vertices), np.float32)
    made.data.attributes["synch_sphere"].data.foreach_get("vector", shown)
    shown = shown.reshape(-1, 3)
    np.testing.assert_allclose(np.linalg.norm(shown, axis=1), 1, atol=1e-3)
    assert (shown[:, 2] < -np.cos(np.radians(80)) + 0.1).all()  # around the antipode of the point
    assert report["lower_bound"] <= report["sphere_energy"] <= report["energy"]


@pytest.mark.parametrize("radius", [0.65, 0.71, 0.75])
def test_tubes_have_no_faces_that_fold(radius):
    """A ball that nearly touches nodes of the grid, where slivers would turn inwards and show as dark specks."""
    grid = Grid((21, 22, 23), spacing=0.1, origin=(-1, -1.05, -1.1))
    distance = np.linalg.norm(grid.places, axis=1)
    turn = np.arctan2(grid.places[:, 1], grid.places[:, 0])
    sphere = np.column_stack([np.sin(distance) * np.cos(turn), np.sin(distance) * np.sin(turn), -np.cos(distance)])
    found = SimpleNamespace(grid=grid, regular_grid=grid, quantum=1.0)
    settings = SimpleNamespace(show="tubes", point=None, opening=np.degrees(radius), smoothing=4, unwrapped=False)
    tubes = extract_vortices(found, SimpleNamespace(found=found, sphere=sphere), settings).tubes
    corners = tubes.vertices[tubes.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1) * np.linalg.norm(corners.mean(axis=1), axis=1)
    assert (np.einsum("ij,ij->i", normals, corners.mean(axis=1)) > 0.8 * lengths).all()


def test_the_command_line(tmp_path, capfd):
    grid, velocity = ring_grid()
    np.savez(tmp_path / "ring.npz", velocity=velocity.reshape(*grid.shape, 3), spacing=0.1, origin=grid.origin)
    out, report = tmp_path / "out.blend", tmp_path / "report.json"
    arguments = ["clebsch", str(tmp_path / "ring.npz"), "--quantum", "2", "--quiet"]
    assert main([*arguments, "--output", str(out), "--report", str(report)]) == 0
    facts = json.loads(report.read_text())
    assert facts["command"] == "clebsch" and len(facts["filaments"]) == 1 and out.is_file()
    assert re.search(r"1 filament, 1 of them closed, with \d+% of the vorticity", capfd.readouterr().out)
    circle()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "curves.blend"))
    assert main(["clebsch", str(tmp_path / "curves.blend"), "--quantum", "1", "--resolution", "20", "--quiet"]) == 0
    assert main(["clebsch", str(tmp_path / "none.npz"), "--quiet"]) == 1
    assert "no such file" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"show": "smoke"}, "show 'smoke' is unknown"),
        ({"count": 0}, "the count is 0"),
        ({"quantum": 0}, "the quantum is 0.0: give a positive"),
        ({"quantum": "a"}, "the quantum is 'a': give a number"),
        ({"frames": (1,)}, r"the frames are \(1,\): give the first and the last"),
        ({"frames": 3}, "the frames are 3: give the first and the last"),
        ({"point": "abc"}, "the point of the sphere is 'abc': give three numbers"),
        ({"point": (float("inf"), 0, 0)}, "the point of the sphere is .* give three numbers"),
        ({"resolution": 4000}, r"the grid has 4000 x 4000 x 1\d+ nodes, which take about \d+ GB"),
        ({"resolution": "fine"}, "the resolution is 'fine'"),
        ({"core": -1}, "the core is -1.0: give a positive"),
        ({"opening": 200}, "to 179.9"),
        ({"point": (0, 0, 0)}, "three numbers that are not all 0"),
        ({"show": "tubes", "method": "spectral"}, "use the method sdp"),
        ({"resolution": 3}, "a resolution of 3 nodes"),
        ({"colour": 1}, "'colour' is unknown"),
    ],
)
def test_settings_out_of_range_are_refused(settings, message):
    obj = circle()
    with pytest.raises(SettingError, match=message):
        clebsch(obj, **settings)
    assert len(bpy.data.objects) == 1


@pytest.mark.parametrize("far", [2**30, -(2**31)])
def test_voxels_too_far_for_the_library_are_refused(tmp_path, far):
    """It ends the process when it copies them."""
    vdb = openvdb.openvdb_module()
    volume = vdb.Vec3SGrid()
    volume.name = "velocity"
    volume.fill((far, 0, 0), (far + 9, 9, 9), (0.5, 0.2, 0.1))
    vdb.write(str(tmp_path / "far.vdb"), [volume])
    with pytest.raises(SettingError, match="velocity has voxels too far from its origin: move them nearer"):
        flow_file(tmp_path / "far.vdb", module=openvdb.module_file()).read()


def test_of_several_grids_of_vectors_the_velocity_is_solved(tmp_path):
    mine = {name: write_vdb(tmp_path / f"{name}.vdb", name=name, before=["Cd"]) for name in ("vel", "v", "wind")}
    rough = {"resolution": 18, "quantum": 1.0, "method": "spectral"}
    ring = clebsch(write_vdb(tmp_path / "alone.vdb", name="anything"), **rough)
    assert ring["shape"] == [18, 18, 14] and not ring["warnings"]
    for path, attribute in ((mine["vel"], "velocity"), (mine["v"], "velocity"), (mine["wind"], "wind")):
        report = clebsch(path, attribute=attribute, **rough)
        assert report["filaments"] == ring["filaments"] and not report["warnings"]
        stored = bpy.context.scene.synch_vortices
        stored.filepath, stored.resolution, stored.attribute = str(path), 18, attribute
        assert expected_solve(bpy.context, stored).shape == (18, 18, 14)
    with pytest.raises(SettingError, match="no vorticity"):  # of the colours
        clebsch(mine["vel"], attribute="Cd", resolution=18)
    with pytest.raises(SettingError, match=r"has no vectors 'speed' \(it has Cd \(vec3s\), vel \(vec3s\)\)"):
        clebsch(mine["vel"], attribute="speed")
    flow = sources.flow_source(mine["wind"], None).read()
    assert flow.warnings[0].startswith("Cd is taken for the velocity (there are Cd (vec3s), wind (vec3s))")


def test_filaments_that_were_shown_induce_the_flow_that_they_carry():
    obj = circle(strength=2.0)
    rough = {"resolution": 20, "method": "spectral", "quantum": 1.0}
    lines = bpy.data.objects[clebsch(obj, **rough, smoothing=0)["object"]]
    points = np.ones((100, 4), np.float32)
    points[:, :3] = spline_points(obj)
    lines.data.splines.clear()
    spline = lines.data.splines.new("POLY")
    spline.points.add(99)
    spline.points.foreach_set("co", points.ravel())
    spline.points.foreach_set("radius", np.full(100, np.sqrt(2), np.float32))  # two quanta
    spline.use_cyclic_u = True
    one, other = (sources.flow_source(found, 0.5) for found in (obj, lines))
    grid = one.grid(20)
    np.testing.assert_allclose(other.integrals(grid), one.integrals(grid), atol=1e-6)


def test_the_command_finds_the_only_flow_of_a_file(tmp_path, capfd):
    def run(name, *more):
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / name))
        arguments = [str(tmp_path / name), "--quantum", "1", "--resolution", "16", "--method", "spectral", "--quiet"]
        capfd.readouterr()
        return main(["clebsch", *arguments, *more]), capfd.readouterr()

    circle()
    clebsch(circle(location=(0, 0, 0.4)), resolution=16, quantum=1.0, method="spectral")
    both = run("shown.blend")[1].out.splitlines()[0]
    assert both == run("same.blend", "--object", "Circle", "Circle.001")[1].out.splitlines()[0]
    assert both != run("first.blend", "--object", "Circle")[1].out.splitlines()[0]
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3)
    ball = bpy.context.active_object
    turning = np.cross([0, 0, 1], [vertex.co for vertex in ball.data.vertices]).astype(np.float32)
    ball.data.attributes.new("velocity", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", turning.ravel())
    name = ball.name  # in the user's language
    status, said = run("several.blend")
    assert status == 1 and f"several flows ({name}, Circle, Circle.001)" in said.err
    for other in ("Circle", "Circle.001"):
        bpy.data.objects.remove(bpy.data.objects[other])
    status, said = run("ball.blend")
    assert status == 0 and said.out.startswith(f"clebsch on {name}")
    bpy.data.objects.remove(bpy.data.objects[name])
    status, said = run("none.blend")
    assert status == 1 and "nothing in the file is a flow (it has Circle.001 Filaments" in said.err


def test_what_gives_no_flow_is_refused_in_one_line(tmp_path):
    obj = circle()
    for source in (None, 3, [], [obj, "Circle"]):
        with pytest.raises(SettingError, match="is no flow: give a file"):
            clebsch(source)
    obj[sources.STRENGTH] = "strong"
    with pytest.raises(SettingError, match="Circle: its synch_strength is 'strong': give the circulation"):
        clebsch(obj)
    bpy.ops.object.volume_import(filepath=str(write_vdb(tmp_path / "ring.vdb")))
    volume = bpy.context.active_object
    volume.scale.y, volume.rotation_euler.x = 0.0, 0.3
    bpy.context.view_layer.update()
    with pytest.raises(SettingError, match="scaled to nothing along an axis"):
        clebsch(volume)


def test_the_operator_takes_the_selected_curves():
    obj = circle()
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj
    assert bpy.ops.synch.clebsch(resolution=20, count=1) == {"FINISHED"}
    assert bpy.context.active_object.type == "CURVE" and bpy.context.active_object != obj
    for other in bpy.data.objects:
        other.select_set(False)
    bpy.context.view_layer.objects.active = None  # beside a result, what it was made of is solved again
    with pytest.raises(RuntimeError, match="nothing has a flow"):
        bpy.ops.synch.clebsch()


def test_a_map_that_shows_nothing_says_what_to_do(tmp_path, capfd):
    grid, velocity = ring_grid()
    np.savez(tmp_path / "ring.npz", velocity=velocity.reshape(*grid.shape, 3), spacing=0.1, origin=grid.origin)
    assert main(["clebsch", str(tmp_path / "ring.npz"), "--quantum", "50", "--show", "both", "--quiet"]) == 0
    out = capfd.readouterr().out
    for words in ("has no filaments: ", "with a circulation of", "make the tubes wider", "0 filaments"):
        assert words in out


def test_curves_have_a_core_that_tubes_can_be_seen_in():
    obj = circle()
    report = clebsch(obj, show="both", quantum=0.34, opening=100, resolution=24, target_gap=0.05)
    assert report["tubes"]["pieces"] == 1 and report["tubes"]["faces"] > 1000
    tubes = bpy.data.objects[report["objects"][0]]
    places = np.array([vertex.co for vertex in tubes.data.vertices])
    off = np.hypot(np.hypot(places[:, 0], places[:, 1]) - 1, places[:, 2])  # from the circle
    cell = 3.4 / 2 / 11.5
    assert 0.5 * cell < np.median(off) < 3 * cell
    thin = clebsch(obj, show="tubes", quantum=0.34, opening=100, resolution=24, target_gap=0.05, core=0.5)
    area = lambda made: sum(face.area for face in bpy.data.objects[made].data.polygons)  # noqa: E731
    assert area(thin["object"]) < area(report["objects"][0])


def test_filaments_go_out_with_what_they_are(tmp_path, capfd):
    """Two linked rings: files, linking, helicity; and what is no such file or object is refused."""
    rings = [circle(1.0), circle(1.0, (1, 0, 0), strength=1.0)]
    rings[1].rotation_euler = (np.pi / 2, 0, 0)
    bpy.context.view_layer.update()
    report = clebsch(rings, quantum=1.0, resolution=22, target_gap=0.1)
    assert report["loops"] == [0, 1] and abs(report["linking"][0][1]) == 1 and report["windings"] == 0
    expected = 2 * report["linking"][0][1] + sum(report["writhe"])
    assert report["helicity"] == pytest.approx(expected)
    obj = bpy.data.objects[report["object"]]
    for suffix, words in (
        (".csv", "filament,x,y,z"),
        (".vtp", "PolyData"),
        (".vtk", "DATASET UNSTRUCTURED_GRID"),
        (".ply", "ply"),
        (".obj", "\nl 1 2 3 "),
    ):
        told = api.filament_export(obj, tmp_path / f"rings{suffix}")
        assert told["filaments"] == 2 and words in (tmp_path / f"rings{suffix}").read_text()
    assert bpy.ops.synch.filament_export(filepath=str(tmp_path / "again.vtp")) == {"FINISHED"}
    assert (tmp_path / "again.vtp").read_text() == (tmp_path / "rings.vtp").read_text()
    assert (".abc" in SUFFIXES) == bpy.app.build_options.alembic
    for suffix in {".txt", ".abc"} - {*SUFFIXES}:
        with pytest.raises(SettingError, match=re.escape(" or ".join(SUFFIXES))):
            api.filament_export(obj, tmp_path / f"rings{suffix}")
    with pytest.raises(SynchError, match="has no solve in memory"):
        api.filament_export(rings[0], tmp_path / "rings.csv")
    assert sum(line["vorticity_share"] for line in report["filaments"]) == pytest.approx(report["vorticity_share"])


def test_tubes_go_out_and_come_back_by_blender(tmp_path):
    report = clebsch(circle(), show="both", quantum=0.34, opening=100, resolution=20, target_gap=0.1)
    tubes, lines = (bpy.data.objects[name] for name in report["objects"])
    chosen = [obj for obj in bpy.data.objects if obj.select_get()]
    for suffix in SUFFIXES[1:]:
        told = api.filament_export(tubes, tmp_path / f"tubes{suffix}")
        assert told["tubes"] >= 1 and (tmp_path / f"tubes{suffix}").stat().st_size > 1000
    if ".abc" in SUFFIXES:
        api.filament_export(lines, tmp_path / "lines.abc")
    assert [obj for obj in bpy.data.objects if obj.select_get()] == chosen
    with pytest.raises(SettingError, match="a table has filaments: write tubes as"):
        api.filament_export(tubes, tmp_path / "tubes.csv")
    places = np.array([vertex.co for vertex in tubes.data.vertices])
    for suffix in {".ply", ".abc"} & {*SUFFIXES}:
        read = bpy.ops.wm.ply_import if suffix == ".ply" else bpy.ops.wm.alembic_import
        assert read(filepath=str(tmp_path / f"tubes{suffix}")) == {"FINISHED"}
        again = bpy.context.selected_objects[0]
        found = np.array([again.matrix_world @ vertex.co for vertex in again.data.vertices])
        assert len(again.data.polygons) == len(tubes.data.polygons)
        assert np.abs(np.sort(found, axis=0) - np.sort(places, axis=0)).max() < 1e-4


def test_thin_cores_and_many_quanta_are_warned_of():
    obj = circle()
    thin = clebsch(obj, show="tubes", quantum=0.5, resolution=16, target_gap=0.1, core=1.0)
    assert any("from a core of 2 cells on, and it is 1: increase" in line for line in thin["warnings"])
    thick = clebsch(obj, show="tubes", quantum=0.5, resolution=16, target_gap=0.1)
    assert not any("core of" in line for line in thick["warnings"])


@pytest.mark.parametrize("core, is_thin", [(1.0, True), (2.0, False)])
def test_thin_cores_in_files_are_found_and_warned_of(tmp_path, core, is_thin):
    """A quantum of a core that is a cells wide has 3 pi a^2 faces: the circulation squared over the integral of
    (a^2 / (pi (r^2 + a^2)^2))^2, and a little more between nodes."""
    grid = Grid((28, 28, 12), 0.1, [-1.35, -1.35, -0.55])
    turn = np.linspace(0, 2 * np.pi, 121)
    ring = np.column_stack([0.9 * np.cos(turn), 0.9 * np.sin(turn), 0 * turn])
    velocity = filament_velocity(grid.places, [(ring, 1.0)], core * 0.1)
    faces = faces_of_filament(grid, edge_integrals(grid, velocity), 1.0)
    assert 1 < faces / (3 * np.pi * core**2) < 1.6
    np.savez(tmp_path / "ring.npz", velocity=velocity.reshape(*grid.shape, 3), spacing=0.1, origin=grid.origin)
    report = clebsch(tmp_path / "ring.npz", show="tubes", quantum=1.0, target_gap=0.1)
    assert any("faces of the grid" in line for line in report["warnings"]) == is_thin
    assert (report["tubes"]["pieces"] > 3) == is_thin


def test_the_command_writes_filaments(tmp_path, capfd):
    grid, velocity = ring_grid()
    np.savez(tmp_path / "ring.npz", velocity=velocity.reshape(*grid.shape, 3), spacing=0.1, origin=grid.origin)
    run = ["clebsch", str(tmp_path / "ring.npz"), "--quiet", "--method", "spectral", "--export-filaments"]
    assert main([*run, str(tmp_path / "ring.vtp")]) == 0
    assert "wrote" in capfd.readouterr().out and "<Piece" in (tmp_path / "ring.vtp").read_text()
    assert main([*run, str(tmp_path / "ring.stl")]) == 1 and ".vtp" in capfd.readouterr().err


def test_where_there_is_no_filament_a_circulation_is_named_that_gives_one(tmp_path):
    grid, velocity = ring_grid()
    np.savez(tmp_path / "ring.npz", velocity=velocity.reshape(*grid.shape, 3), spacing=0.1, origin=grid.origin)
    report = clebsch(tmp_path / "ring.npz", quantum=50.0)
    assert any("has no filaments" in line for line in report["warnings"])
    (line,) = [line for line in report["warnings"] if "carry 0% of the vorticity: with" in line]
    remedy = float(line.split("a circulation of ")[1].split()[0])
    assert len(clebsch(tmp_path / "ring.npz", quantum=remedy)["filaments"]) >= 1


def test_filaments_around_a_periodic_box_close(tmp_path):
    """A shear flow, sin(z) along x: its vorticity runs along y, both ways, around the box."""
    count = 12
    z = 2 * np.pi * np.arange(count) / count
    velocity = np.zeros((count, count, count, 3))
    velocity[..., 0] = np.sin(z)
    np.savez(tmp_path / "shear.npz", velocity=velocity, spacing=2 * np.pi / count, periodic=True)
    report = clebsch(tmp_path / "shear.npz", count=4, target_gap=0.1)
    around = [line for line in report["filaments"] if any(line["winding"])]
    assert report["windings"] == len(around) > 0 and all(line["closed"] for line in report["filaments"])
    assert all(line["winding"][2] == 0 for line in around)
    obj = bpy.data.objects[report["object"]]
    inside = np.array([point.co[:3] for spline in obj.data.splines for point in spline.points])
    assert inside.max() < 2 * np.pi + 0.6
    unwrapped = clebsch(tmp_path / "shear.npz", count=4, target_gap=0.1, unwrapped=True)
    splines = bpy.data.objects[unwrapped["object"]].data.splines
    assert len(splines) == len(unwrapped["filaments"])
    longest = max(np.ptp([point.co[1] for point in spline.points]) for spline in splines)
    assert longest == pytest.approx(2 * np.pi, rel=0.2)
