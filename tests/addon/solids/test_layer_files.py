# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What leaves Blender of layers: files that hold them as they are, paths that lie on them, a volume of the pattern."""

import re
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from synch_fields.core.errors import SettingError, SynchError
from synch_fields.core.interpolate_solid import evaluate_in_tets
from synch_fields.synch_addon import api
from synch_fields.synch_addon.blender import files
from synch_fields.synch_addon.blender.openvdb import openvdb_module
from synch_fields.synch_addon.command import main
from synch_fields.synch_addon.operators.layer_files import SYNCH_OT_layer_path_export
from synch_fields.synch_addon.solids import memory

from ..scenes import attribute, snapshot
from ..solid_objects import SPACING, bent_bar, block, in_world, triangles_of


def inward(obj, points):
    """World points in the solid's space."""
    matrix = np.linalg.inv(memory.recall_layers(obj).matrix)
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def read_back(path):
    """Vertices, triangles and area of the mesh in a file, in the world."""
    files.open_input(str(path))
    obj = files.choose_object()
    matrix, triangles = np.array(obj.matrix_world), triangles_of(obj)
    places = attribute(obj, "position").astype(float) @ matrix[:3, :3].T + matrix[:3, 3]
    a, b, c = np.moveaxis(places[triangles], 1, 0)
    return places, triangles, np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


@pytest.mark.parametrize("suffix", [".stl", ".ply"])
def test_each_layer_is_a_file_that_holds_it(layered, tmp_path, suffix):
    layering = memory.recall_layers(layered)
    surfaces = layering.surfaces
    before = snapshot()
    report = api.layer_export(layered, tmp_path / f"part{suffix}")
    assert snapshot() == before
    names = [f"part_{k:03d}{suffix}" for k in range(surfaces.count)]
    assert report["files"] == [str(tmp_path / name) for name in names]
    assert sorted(path.name for path in tmp_path.iterdir()) == names
    areas = surfaces.areas
    world = in_world(layered, surfaces.vertices)
    for number, path in enumerate(report["files"]):
        places, triangles, area = read_back(path)
        assert area == pytest.approx(areas[number], rel=1e-4)
        edges, counts = np.unique(np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)), axis=0, return_counts=True)
        assert counts.max() == 2 and len(edges) > 0
        # A sheet: one rim around it, V - E + F = 1.
        assert len(np.unique(triangles)) - len(edges) + len(triangles) == 1
        given = world[np.unique(surfaces.triangles[surfaces.layers == number])]
        for axis in range(3):
            np.testing.assert_allclose(
                [places[:, axis].min(), places[:, axis].max()], [given[:, axis].min(), given[:, axis].max()], atol=1e-4
            )


def test_files_that_an_earlier_run_left_are_named(layered, tmp_path):
    """Three layers are written here; those of others, and other names, are no matter."""
    for name in ("part_002.stl", "part_003.stl", "part_004.stl", "part_003.ply", "apart_005.stl", "part_old.stl"):
        (tmp_path / name).write_text("")
    report = api.layer_export(layered, tmp_path / "part.stl")
    assert len(report["files"]) == 3
    (line,) = report["warnings"]
    assert line.startswith("part_003.stl to part_004.stl: of an earlier run") and "delete" in line
    (tmp_path / "part_004.stl").unlink()
    assert api.layer_export(layered, tmp_path / "part.stl")["warnings"][0].startswith("part_003.stl: of an")
    (tmp_path / "part_003.stl").unlink()
    assert api.layer_export(layered, tmp_path / "part.stl")["warnings"] == []
    assert (tmp_path / "part_003.ply").exists()


def test_all_layers_fit_in_one_file(layered, tmp_path):
    surfaces = memory.recall_layers(layered).surfaces
    report = api.layer_export(bpy.data.objects["Block Layers"], tmp_path / "all.stl", together=True)
    assert report["files"] == [str(tmp_path / "all.stl")]
    assert read_back(report["files"][0])[2] == pytest.approx(surfaces.areas.sum(), rel=1e-4)


def test_meshes_and_paths_in_obj_files_lie_on_each_other(layered, tmp_path):
    """Both have the coordinates of the world, Z up, which a slicer expects of all of them."""
    layering = memory.recall_layers(layered)
    world = in_world(layered, layering.surfaces.vertices)
    layered.hide_set(False)
    files.export_mesh(layered, tmp_path / "given.obj")
    mesh = api.layer_export(layered, tmp_path / "all.obj", together=True)["files"][0]
    api.layer_toolpaths(layered, 0.2, path=tmp_path / "paths.obj")
    read = points_of(mesh)
    np.testing.assert_allclose([read.min(0), read.max(0)], [world.min(0), world.max(0)], atol=1e-5)
    up = layering.matrix[:3, 2]
    heights = np.unique(np.round(read @ up, 3))
    assert len(heights) == layering.surfaces.count
    np.testing.assert_allclose(np.abs(np.subtract.outer(points_of(tmp_path / "paths.obj") @ up, heights)).min(1), 0,
                               atol=2e-3)  # fmt: skip
    # Blender's own .obj files have Y up.
    turned = points_of(tmp_path / "given.obj")[:, [0, 2, 1]] * [1, -1, 1]
    assert (turned.min(0) < read.min(0) + 1e-5).all() and (turned.max(0) > read.max(0) - 1e-5).all()


def points_of(path):
    """(n, 3) vertices as an .obj file has them."""
    rows = [line.split()[1:4] for line in Path(path).read_text().splitlines() if line.startswith("v ")]
    return np.array(rows, float)


@pytest.mark.parametrize("fill", ["contour", "across-x"])
def test_paths_lie_on_their_layers_evenly_spaced(layered, tmp_path, fill):
    step = 0.11
    layering = memory.recall_layers(layered)
    report = api.layer_toolpaths(layered, step, fill, tmp_path / "paths.csv")
    rows = np.loadtxt(tmp_path / "paths.csv", delimiter=",", skiprows=1)
    layers, points = rows[:, 0].astype(int), inward(layered, rows[:, 2:5])
    np.testing.assert_array_equal(np.unique(layers), np.arange(layering.surfaces.count))
    assert (np.diff(layers) >= 0).all() and report["paths"] == len(np.unique(rows[:, 1]))
    # Layers are planes across Z, and normals point upwards.
    heights = np.array([layering.surfaces.vertices[layering.surfaces.triangles[layering.surfaces.layers == k], 2].mean()
                        for k in range(layering.surfaces.count)])  # fmt: skip
    np.testing.assert_allclose(points[:, 2], heights[layers], atol=1e-5)
    up = inward(layered, rows[:, 2:5] + rows[:, 5:8]) - points
    np.testing.assert_allclose(up, np.tile([0, 0, 1], (len(up), 1)), atol=1e-5)
    size = np.array([1.2, 1, 0.9]) / 2
    assert (np.abs(points) < size + 1e-5).all()
    if fill == "across-x":
        steps = points[:, 0] / step
        np.testing.assert_allclose(steps, np.rint(steps), atol=1e-4)
        assert len(np.unique(np.rint(steps[layers == 0]))) == 11
    else:
        away = (size[:2] - np.abs(points[:, :2])).min(axis=1)
        outermost = min(away[rows[:, 1] == path].mean() for path in np.unique(rows[:, 1]))
        assert outermost == pytest.approx(step / 2, rel=0.15)
    collection = bpy.data.collections[report["collection"]]
    made = sorted((one for one in collection.objects if "synch_layer" in one), key=lambda curve: curve.name)
    assert [curve["synch_layer"] for curve in made] == list(range(layering.surfaces.count))
    assert sum(len(curve.data.splines) for curve in made) == report["paths"]
    shown = np.array([point.co[:3] for spline in made[0].data.splines for point in spline.points])
    np.testing.assert_allclose(shown[:, 2], heights[0], atol=1e-5)


def test_paths_again_take_the_place_of_those_before(layered):
    first = api.layer_toolpaths(layered, 0.2)
    count = len(bpy.data.objects)
    second = api.layer_toolpaths(layered, 0.1)
    assert second["collection"] == first["collection"] and len(bpy.data.objects) == count
    assert second["length"] > 1.5 * first["length"]


def test_copies_of_paths_stay_and_a_collection_that_was_unlinked_comes_back(layered):
    collection = bpy.data.collections[api.layer_toolpaths(layered, 0.4)["collection"]]
    first = collection.objects["Block Paths 000"]
    linked, whole = first.copy(), first.copy()
    whole.data = first.data.copy()
    for copy in (linked, whole):
        collection.objects.link(copy)
    kept = {copy.name: len(copy.data.splines) for copy in (linked, whole)}
    bpy.data.curves.remove(collection.objects["Block Paths 001"].data)
    bpy.context.scene.collection.children.unlink(collection)
    again = api.layer_toolpaths(layered, 0.2)
    assert again["collection"] == collection.name
    assert collection in bpy.context.scene.collection.children_recursive
    assert {name: len(bpy.data.objects[name].data.splines) for name in kept} == kept
    made = [curve for curve in collection.objects if curve.name not in kept and "synch_layer" in curve]
    assert sorted(curve["synch_layer"] for curve in made) == [0, 1, 2]
    assert sum(len(curve.data.splines) for curve in made) == again["paths"]
    # Theirs, the linked copy's old one and the whole copy's.
    assert len([data for data in bpy.data.curves if "Paths" in data.name]) == 5


def test_polylines_are_those_of_the_table(layered, tmp_path):
    report = api.layer_toolpaths(layered, 0.2, path=tmp_path / "paths.obj")
    lines = (tmp_path / "paths.obj").read_text().splitlines()
    points = points_of(tmp_path / "paths.obj")
    runs = [np.array(line.split()[1:], int) - 1 for line in lines if line.startswith("l ")]
    assert len(runs) == report["paths"]
    length = sum(np.linalg.norm(np.diff(points[run], axis=0), axis=1).sum() for run in runs)
    assert length == pytest.approx(report["length"], rel=1e-4)
    assert [line for line in lines if line.startswith("o ")] == [f"o layer_{k:03d}" for k in range(3)]


def test_the_volume_holds_the_cosine_of_the_phase(layered, tmp_path):
    layering = memory.recall_layers(layered)
    report = api.layer_volume(layered, tmp_path / "pattern.vdb", resolution=24)
    vdb = openvdb_module()
    grid = vdb.read(str(tmp_path / "pattern.vdb"), "pattern")
    assert grid.background == -1 and grid.activeVoxelCount() == report["voxels"]
    low, high = grid.evalActiveVoxelBoundingBox()
    values = np.empty(np.array(high) - low + 1, np.float32)
    grid.copyToArray(values, ijk=low)
    index = np.argwhere(values > -1)
    places = np.array([grid.transform.indexToWorld(tuple(map(float, at))) for at in index + low])
    assert (np.abs(places) < np.array([0.6, 0.5, 0.45]) + 1e-6).all()
    assert report["voxels"] * 0.05**3 == pytest.approx(1.2 * 0.9, rel=0.1)
    # The layers are planes: the phase is that of any vertex, plus 2 pi for each spacing of height.
    solid, phase = layering.solid, layering.pattern.vertex_phases[0]
    expected = np.cos(phase + 2 * np.pi / SPACING * (places[:, 2] - solid.vertices[0, 2]))
    np.testing.assert_allclose(values[tuple(index.T)], expected, atol=1e-4)
    volume = bpy.data.objects[report["volume_object"]]
    assert volume.type == "VOLUME" and volume.data.materials[0].name.startswith("Synch Volume")
    np.testing.assert_allclose(np.array(volume.matrix_world), layering.matrix, atol=1e-6)
    assert volume.data.grids.load() and [grid.name for grid in volume.data.grids] == ["pattern"]


def test_a_volume_again_takes_the_place_of_the_one_before(layered, tmp_path):
    volume = bpy.data.objects[api.layer_volume(layered, tmp_path / "one.vdb", 8)["volume_object"]]
    density = volume.data.materials[0].node_tree.nodes["Density"].inputs["To Max"]
    density.default_value *= 3  # by hand
    before = density.default_value
    api.layers(layered, guidance="axis:Z", spacing=2 * SPACING, size=0.15)
    report = api.layer_volume(layered, tmp_path / "two.vdb", 8)
    assert report["volume_object"] == volume.name and report["files"] == [str(tmp_path / "two.vdb")]
    assert len(bpy.data.volumes) == 1 and [o for o in bpy.data.objects if o.type == "VOLUME"] == [volume]
    assert len([m for m in bpy.data.materials if m.name.startswith("Synch Volume")]) == 1
    assert density.default_value == pytest.approx(before / 2, rel=1e-3)
    other = block()
    other.name = "Other"
    api.layers(other, guidance="axis:Z", spacing=0.5, size=0.25)
    assert api.layer_volume(other, tmp_path / "other.vdb", 8)["volume_object"] != volume.name
    assert density.default_value == pytest.approx(before / 2, rel=1e-3)


def test_voxels_beside_dislocations_hold_the_interpolant(tmp_path):
    """A bent bar: every voxel has the value of the tetrahedron that it lies in."""
    obj = bent_bar()
    api.layers(obj, guidance="harmonic:Begin:End", spacing=0.25, size=0.12, seed=1)
    layering = memory.recall_layers(obj)
    solid, phases = layering.solid, layering.pattern.tet_phases
    assert phases.punctured.any()
    api.layer_volume(obj, tmp_path / "bar.vdb", resolution=40)
    grid = openvdb_module().read(str(tmp_path / "bar.vdb"), "pattern")
    read = grid.getConstAccessor()
    # Around the middle of a tetrahedron, values at the nearest voxel differ by a slope times half a voxel's diagonal.
    tets = np.flatnonzero(phases.punctured)
    middles = solid.vertices[solid.tets[tets]].mean(axis=1)
    index = np.rint([grid.transform.worldToIndex(tuple(place)) for place in middles]).astype(int)
    found = np.array([read.getValue(tuple(map(int, at))) for at in index])
    assert (found > -1).mean() > 0.9 and (np.abs(found) <= 1).all()
    for at, value in zip(index, found, strict=True):
        if value > -1:
            weights = barycentric_of(solid, np.array(grid.transform.indexToWorld(tuple(map(float, at)))))
            tet = np.argmax(weights.min(axis=1))
            expected = evaluate_in_tets(phases, np.array([tet]), weights[[tet]])
            assert np.cos(expected[0]) == pytest.approx(value, abs=1e-4)


def barycentric_of(solid, point):
    """(m, 4) weights of a point in all tetrahedra."""
    others = np.einsum("tix,tx->ti", solid.hat_gradients[:, 1:], point - solid.vertices[solid.tets[:, 0]])
    return np.column_stack([1 - others.sum(axis=1), others])


def test_what_cannot_be_written_is_refused_and_changes_nothing(layered, tmp_path):
    before = snapshot()
    for call, words in (
        (lambda: api.layer_export(layered, tmp_path / "part.fbx"), r"must end in \.obj or"),
        (lambda: api.layer_export(layered, tmp_path / "none" / "part.stl"), "folder does not exist"),
        (lambda: api.layer_export(layered, "//part.stl"), "not saved: save it first"),
        (lambda: api.layer_toolpaths(layered, -1), "positive"),
        (lambda: api.layer_toolpaths(layered, fill="spiral"), "contour"),
        (lambda: api.layer_toolpaths(layered, 50.0), "reduce it"),
        (lambda: api.layer_toolpaths(layered, path=tmp_path / "paths.txt"), r"\.csv or \.obj or \.gcode"),
        (lambda: api.layer_toolpaths(layered, machine=tmp_path / "none.toml"), r"none\.toml cannot be read"),
        (lambda: api.layer_volume(layered, tmp_path / "pattern.npz"), r"\.vdb"),
        (lambda: api.layer_volume(layered, tmp_path / "pattern.vdb", 1), "2 or more"),
        (lambda: api.layer_volume(layered, tmp_path / "pattern.vdb", 10_000), r"6.3e.11 voxels.*reduce it to 4[0-3]\d"),
        (lambda: api.layer_toolpaths(layered, 1e-9), "is the most: give a step of"),
    ):
        with pytest.raises(SettingError, match=words):
            call()
        assert snapshot() == before and not list(tmp_path.iterdir())


def test_folders_and_full_disks_are_told_in_one_line(layered, tmp_path):
    writers = {
        "part.stl": lambda path: api.layer_export(layered, path, together=True),
        "part.ply": lambda path: api.layer_export(layered, path, together=True),
        "part.obj": lambda path: api.layer_export(layered, path, together=True),
        "paths.csv": lambda path: api.layer_toolpaths(layered, 0.4, path=path),
        "paths.obj": lambda path: api.layer_toolpaths(layered, 0.4, path=path),
        "pattern.vdb": lambda path: api.layer_volume(layered, path, 8),
    }
    (tmp_path / "full").mkdir()
    before = snapshot()
    for name, write in writers.items():
        (tmp_path / name).mkdir()
        places = [(tmp_path / name, "this is a folder, choose another name")]
        if Path("/dev/full").exists():  # a file on a disk without room
            (tmp_path / "full" / name).symlink_to("/dev/full")
            places.append((tmp_path / "full" / name, "cannot be written .*: make room, or choose another place"))
        for path, words in places:
            with pytest.raises(SettingError, match=words) as caught:
                write(path)
            assert str(caught.value).startswith(str(path)) and "\n" not in str(caught.value)
            assert snapshot() == before


def test_a_numbered_file_that_is_a_folder_is_told_in_one_line(layered, tmp_path):
    (tmp_path / "part_001.stl").mkdir()
    with pytest.raises(SettingError, match=r"part_001\.stl: cannot be written \(.*\): make room, or choose another"):
        api.layer_export(layered, tmp_path / "part.stl")


def test_paths_may_begin_in_the_folder_of_the_blend(layered, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"), copy=False)
    (tmp_path / "parts").mkdir()
    written = api.layer_export(layered, "//parts/part.stl")["files"]
    written += api.layer_toolpaths(layered, 0.4, path="//parts/paths.csv")["files"]
    written += api.layer_volume(layered, "//parts/pattern.vdb", 8)["files"]
    assert sorted(written) == sorted(map(str, (tmp_path / "parts").iterdir())) and len(written) == 5


def test_without_layers_nothing_can_leave(tmp_path):
    obj = block()
    for call in (api.layer_export, api.layer_volume):
        with pytest.raises(SynchError, match="no layers of Block are in memory"):
            call(obj, tmp_path / "part.stl")
    assert not bpy.ops.synch.layer_export.poll() and not bpy.ops.synch.layer_toolpaths.poll()


def test_operators_do_the_same(layered, tmp_path):
    assert bpy.ops.synch.layer_export(filepath=str(tmp_path / "part.ply")) == {"FINISHED"}
    assert len(list(tmp_path.glob("part_*.ply"))) == 3
    assert bpy.ops.synch.layer_toolpaths(fill="across-y", step=0.2) == {"FINISHED"}
    with pytest.raises(RuntimeError, match="needs walls: choose the fill contour"):
        bpy.ops.synch.layer_toolpaths(fill="across-y", step=0.2, infill=0.3)
    assert bpy.ops.synch.layer_path_export(filepath=str(tmp_path / "paths.csv")) == {"FINISHED"}
    assert bpy.ops.synch.layer_volume(filepath=str(tmp_path / "pattern.vdb"), resolution=16) == {"FINISHED"}
    assert (tmp_path / "paths.csv").is_file() and (tmp_path / "pattern.vdb").is_file()
    with pytest.raises(RuntimeError, match="must end in"):
        bpy.ops.synch.layer_volume(filepath=str(tmp_path / "pattern.txt"))


def test_the_command_writes_them_all(tmp_path, capfd):
    obj = block()
    files.export_mesh(obj, tmp_path / "block.obj")
    (tmp_path / "part_007.stl").write_text("")
    status = main.main(
        ["layers", str(tmp_path / "block.obj"), "--spacing", "0.3", "--size", "0.14", "--quiet"]
        + ["--export-layers", str(tmp_path / "part.stl"), "--export-paths", str(tmp_path / "paths.csv")]
        + ["--export-gcode", str(tmp_path / "part.gcode")]
        + ["--export-volume", str(tmp_path / "pattern.vdb"), "--resolution", "16", "--path-step", "0.2"]
    )
    printed = capfd.readouterr()
    assert status == 0, printed.err
    names = {path.name for path in tmp_path.iterdir()}
    assert "warning: part_007.stl: of an earlier run" in printed.out
    assert {"part_000.stl", "part_001.stl", "paths.csv", "pattern.vdb"} <= names
    assert re.search(r"cover (9[5-9]|100)\.\d% of the layers; heights", printed.out)
    for name in ("part_000.stl", "paths.csv", "pattern.vdb", "part.gcode"):
        assert f"wrote {tmp_path / name}" in printed.out


def test_the_command_refuses_before_the_solve_what_it_could_not_write(tmp_path, capfd, monkeypatch):
    monkeypatch.setattr(api, "layer_job", None)
    files.export_mesh(block(), tmp_path / "block.obj")
    run = ["layers", str(tmp_path / "block.obj"), "--export-volume"]
    assert main.main([*run, str(tmp_path / "x.txt")]) == 1
    assert "must end in .vdb" in capfd.readouterr().err
    assert main.main([*run, str(tmp_path / "x.vdb"), "--resolution", "-4"]) == 1
    assert "a resolution of -4 voxels shows no layer" in capfd.readouterr().err


def test_the_command_saves_the_solve_before_an_export_can_fail(tmp_path, capfd):
    """The paths' step is wider than every layer, which shows once there are layers."""
    files.export_mesh(block(), tmp_path / "block.obj")
    run = ["layers", str(tmp_path / "block.obj"), "--spacing", "0.4", "--size", "0.19", "--quiet", "--output"]
    run += [str(tmp_path / "scene.blend"), "--export-paths", str(tmp_path / "paths.csv"), "--path-step"]
    assert main.main([*run, "50"]) == 1 and "reduce it" in capfd.readouterr().err
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene.blend"))
    assert len(bpy.data.objects["Block Layers"].data.polygons) > 0 and not bpy.data.curves
    assert main.main([*run, "0.2", "--infill", "2"]) == 1
    assert "the infill is 2: give a share from 0 to 1" in capfd.readouterr().err
    assert main.main([*run, "0.2", "--infill", "0.3"]) == 0
    printed = capfd.readouterr().out
    assert printed.count("wrote") == 2 and "30% between walls and skins" in printed
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene.blend"))
    assert len(bpy.data.curves) >= 2


def test_the_format_of_paths_and_the_suffix_of_the_file_follow_one_another():
    operator = SimpleNamespace(filepath="part.gcode", format=".gcode", _checked=".gcode")
    check = SYNCH_OT_layer_path_export.check
    assert not check(operator, None)
    operator.format = ".csv"  # chosen beside the files
    assert check(operator, None) and operator.filepath == "part.csv"
    operator.filepath = "part.OBJ"  # typed
    assert check(operator, None) and (operator.filepath, operator.format) == ("part.OBJ", ".obj")
    operator.filepath = "v1.2"
    assert check(operator, None) and operator.filepath == "v1.2.obj"
    assert not check(operator, None)
