# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: every kind of input, outputs, exit status, and what goes to which stream."""

import importlib
import json
import os
import re
import subprocess
import sys

import bpy
import numpy as np
import pytest

from synch_fields.synch_addon.looks import render

from ..run_commands import run
from ..scenes import attribute, empties, sphere

addon_utils = importlib.import_module("addon_utils")  # on the path once bpy is loaded, as isort cannot know

REPORT_KEYS = set(
    "status command object nodes edges energy lower_bound gap sdp_value sdp_gap certificate rank disclinations "
    "dislocations times peak_memory_mb seed settings warnings versions".split()
)
TIMES = set("read build relax certify round write total".split())


def command_line(*arguments):
    """Run `python -m synch_fields` as a user does."""
    # This process's bpy has set OCIO, which makes the next one print a line while it is imported.
    environment = {name: value for name, value in os.environ.items() if name != "OCIO"}
    return subprocess.run(
        [sys.executable, "-m", "synch_fields", *map(str, arguments)], capture_output=True, text=True, env=environment
    )


@pytest.fixture(scope="module")
def files(tmp_path_factory, extension):
    """A UV sphere of 266 vertices in every input format, flat shaded and with a UV map: the formats' own seams."""
    folder = tmp_path_factory.mktemp("inputs")
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12)
    bpy.context.active_object.name = "Ball"
    addon_utils.enable("io_scene_gltf2")
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "ball.blend"))
    bpy.ops.wm.obj_export(filepath=str(folder / "ball.obj"))
    bpy.ops.wm.ply_export(filepath=str(folder / "ball.ply"))
    bpy.ops.wm.stl_export(filepath=str(folder / "ball.stl"))
    bpy.ops.export_scene.gltf(filepath=str(folder / "ball.glb"))
    return {path.suffix: path for path in folder.iterdir() if path.stem == "ball"}


def test_stripes_from_obj_to_blend_and_report(files, tmp_path):
    blend, report_file = tmp_path / "out.blend", tmp_path / "out.json"
    done = command_line(
        "stripes",
        files[".obj"],
        "--spacing",
        0.4,
        "--seed",
        3,
        "--surface",
        "faces",
        "--output",
        blend,
        "--report",
        report_file,
    )
    assert done.returncode == 0, done.stderr
    report = json.loads(report_file.read_text())
    assert REPORT_KEYS <= set(report)
    assert TIMES <= set(report["times"]) and all(t >= 0 for t in report["times"].values())
    assert report["status"] == "certified" and report["command"] == "stripes" and report["seed"] == 3
    assert report["settings"]["spacing"] == 0.4 and report["settings"]["symmetry"] == "line"
    assert report["lower_bound"] <= report["sdp_value"] <= report["energy"]
    assert report["nodes"] == 266 and report["certificate"] == "proved"
    assert sum(d["index"] for d in report["disclinations"]) == 2
    for defect in report["disclinations"] + report["dislocations"]:
        assert {"face", "index", "position"} <= set(defect)
        assert np.linalg.norm(defect["position"]) == pytest.approx(1, abs=0.1)
    assert done.stdout.lower().startswith("stripes on ball") and str(blend) in done.stdout
    assert "OBJ import" not in done.stdout
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    (obj,) = [o for o in bpy.context.scene.objects if o.type == "MESH"]
    assert np.ptp(attribute(obj, "synch_phase")) > 1
    assert len(empties(obj)) == len(report["disclinations"]) + len(report["dislocations"])


def test_nothing_but_progress_and_the_result_is_printed(files, tmp_path, capfd, monkeypatch):
    """Neither what the importer and Cycles print, nor that a file has been saved."""
    set_up = render._set_up_render
    monkeypatch.setattr(render, "_set_up_render", lambda scene, path, *_: set_up(scene, path, (32, 24), 1))
    outputs = [tmp_path / "out.blend", tmp_path / "out.png"]
    status, out, err = run(capfd, "stripes", files[".obj"], "--output", outputs[0], "--render", outputs[1])
    assert status == 0
    assert out.lower().startswith("stripes on ball") and out.splitlines()[-2:] == [f"wrote {path}" for path in outputs]
    assert all(re.fullmatch(r"[a-z].* \d+%", line) for line in err.splitlines()), err
    assert err.splitlines()[-1] == "rendering 0%"


def test_picture_is_asked_of_the_renderer(files, tmp_path, capfd, monkeypatch):
    """What the picture looks like is tested where it is made."""

    def render_picture(obj, path, *, view, edges):
        assert "synch_phase" in obj.data.attributes and view == [40.0, -5.0]
        (tmp_path / "asked").write_text(str(path))
        return path

    monkeypatch.setattr(render, "render_picture", render_picture)
    status, out, _ = run(capfd, "stripes", files[".blend"], "--render", tmp_path / "out.png", "--view", 40, -5)
    assert status == 0
    assert (tmp_path / "asked").read_text() == str(tmp_path / "out.png")
    assert f"wrote {tmp_path / 'out.png'}" in out


@pytest.mark.parametrize("suffix", [".blend", ".obj", ".ply", ".stl", ".glb"])
def test_every_format_gives_one_closed_surface(files, suffix, tmp_path, capfd):
    report_file = tmp_path / "out.json"
    status, out, err = run(capfd, "directions", files[suffix], "--report", report_file)
    assert status == 0, err
    report = json.loads(report_file.read_text())
    assert (report["nodes"], report["euler_characteristic"]) == (266, 2)
    assert REPORT_KEYS <= set(report)
    assert sum(d["index"] for d in report["disclinations"]) == 2
    assert report["dislocations"] == []
    assert out.startswith("directions on ")


@pytest.mark.parametrize("suffix", [".blend", ".glb"])
def test_info_describes_the_mesh(files, suffix, tmp_path, capfd):
    report_file = tmp_path / "out.json"
    status, out, _ = run(capfd, "info", files[suffix], "--report", report_file)
    facts = json.loads(report_file.read_text())
    assert status == 0
    assert (facts["vertices"], facts["pieces"], facts["boundary_loops"]) == (266, 1, 0)
    assert facts["status"] == "ready" and "266 vertices" in out


def test_flat_shading_survives_the_welding_of_torn_imports(files, capfd):
    run(capfd, "info", files[".glb"])
    (mesh,) = bpy.data.meshes
    normals = np.array([n.vector for n in mesh.corner_normals])
    faces = np.array([p.normal for p in mesh.polygons for _ in range(p.loop_total)])
    assert np.einsum("ij,ij->i", normals, faces).min() > 0.999


def test_touching_pieces_of_a_glb_stay_apart(tmp_path, capfd):
    """Two closed balls that share a point are two balls."""
    for x in (-1, 1):
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, location=(0, 0, x))
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.join()
    bpy.ops.object.shade_smooth()
    while bpy.context.active_object.data.uv_layers:
        bpy.context.active_object.data.uv_layers.remove(bpy.context.active_object.data.uv_layers[0])
    addon_utils.enable("io_scene_gltf2")
    bpy.ops.export_scene.gltf(filepath=str(tmp_path / "two.glb"))
    status, out, _ = run(capfd, "info", tmp_path / "two.glb")
    assert status == 0 and "pieces 2" in out


def test_blender_command_works_on_the_open_file(tmp_path, capfd):
    """`blender -b file.blend --command synch ...` calls with the file loaded already."""
    obj = sphere()
    status, out, _ = run(
        capfd, "stripes", "--object", obj.name, "--spacing", 0.5, "--output", tmp_path / "x.blend", loaded=True
    )
    assert status == 0
    assert "synch_phase" in obj.data.attributes
    assert (tmp_path / "x.blend").stat().st_size > 0 and f"stripes on {obj.name}" in out


def test_command_is_registered_with_blender(extension):
    assert extension.synch_addon.main.blender_command._handle is not None


def test_the_chosen_object_gets_the_field(tmp_path, capfd):
    first, second = sphere(), sphere()
    first.name, second.name = "First", "Second"
    bpy.context.view_layer.objects.active = None
    status, _, err = run(capfd, "directions", loaded=True)
    assert status == 1 and "--object (First, Second)" in err
    status, _, err = run(capfd, "directions", "--object", "Third", loaded=True)
    assert status == 1 and "no mesh object 'Third'" in err and "First, Second" in err
    assert run(capfd, "directions", "--object", "Second", loaded=True)[0] == 0
    assert "synch_direction" in second.data.attributes and "synch_direction" not in first.data.attributes


def test_file_saved_in_edit_mode(tmp_path, capfd):
    sphere()
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "edit.blend"))
    assert run(capfd, "stripes", tmp_path / "edit.blend", "--output", tmp_path / "out.blend")[0] == 0


def test_linked_object_is_refused(tmp_path, capfd):
    name = sphere().name
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, wanted):
        wanted.objects = [name]
    bpy.context.scene.collection.objects.link(bpy.data.objects[name])
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    status, out, err = run(capfd, "stripes", tmp_path / "scene.blend", "--output", tmp_path / "out.blend")
    assert status == 1 and out == "" and "is linked: make it local" in err
    assert not (tmp_path / "out.blend").exists()


FAILURES = {
    "no input": (["stripes"], "no input"),
    "missing file": (["stripes", "absent.obj"], "absent.obj: no such file"),
    "unknown kind": (["stripes", "model.fbx"], "cannot be read: use .blend, .obj, .ply, .stl, .glb"),
    "wrong output": (["stripes", "BALL", "--output", "out.obj"], "must end in .blend"),
    "output in a file": (["stripes", "BALL", "--output", "/dev/null/out.blend"], "cannot be written"),
    "wrong picture": (["stripes", "BALL", "--render", "out.jpg"], "must end in .png"),
    "unknown guidance": (["stripes", "BALL", "--guidance", "wind"], "use one of automatic, smooth"),
    "negative seed": (["directions", "BALL", "--seed", "-4"], "the seed is -4"),
    "target gap": (["directions", "BALL", "--target-gap", "2"], "target gap is 2"),
    "time limit": (["directions", "BALL", "--time-limit", "0"], "time limit is 0"),
}


@pytest.mark.parametrize("name", FAILURES)
def test_failures_are_one_line_and_in_the_report(name, files, tmp_path, capfd, monkeypatch):
    monkeypatch.chdir(tmp_path)
    arguments, reason = FAILURES[name]
    arguments = [files[".blend"] if a == "BALL" else a for a in arguments]
    status, out, err = run(capfd, *arguments, "--quiet", "--report", "report.json")
    assert status == 1 and out == ""
    (line,) = [line for line in err.splitlines() if line.startswith("synch ")]
    assert reason in line
    report = json.loads((tmp_path / "report.json").read_text())
    assert report["status"] == "failed" and report["error"] in line
    assert [p.name for p in tmp_path.iterdir()] == ["report.json"]


@pytest.mark.parametrize(
    "arguments, reason",
    [
        ([], "command"),
        (["stripe", "x.obj"], "stripe"),
        (["stripes", "x.obj", "--spacing", "wide"], "--spacing"),
        (["stripes", "x.obj", "--symmetry", "hexagonal"], "hexagonal"),
        (["directions", "x.obj", "--spacing", "1"], "--spacing"),
    ],
)
def test_usage_errors_are_one_line(arguments, reason, capfd):
    status, out, err = run(capfd, *arguments)
    assert status == 2 and out == ""
    assert err.count("\n") == 1 and reason in err and "--help" in err


def test_failing_process_has_its_status(tmp_path):
    done = command_line("stripes", tmp_path / "absent.obj", "--report", tmp_path / "out.json")
    assert done.returncode == 1 and done.stdout == ""
    assert "Traceback" not in done.stderr and "no such file" in done.stderr
    assert json.loads((tmp_path / "out.json").read_text())["status"] == "failed"


def test_a_report_never_overwrites_another_kind_of_file(files, tmp_path, capfd):
    model = tmp_path / "model.obj"
    model.write_bytes(files[".obj"].read_bytes())
    for command in ("stripes", "info"):
        status, _, err = run(capfd, command, model, "--report", model)
        assert status == 1 and "--report and the input are the same file" in err
        assert model.read_bytes() == files[".obj"].read_bytes()


def test_report_that_cannot_be_written_is_a_failure(files, tmp_path, capfd):
    (tmp_path / "taken.json").mkdir()
    status, out, err = run(capfd, "info", files[".blend"], "--report", tmp_path / "taken.json")
    assert status == 1 and out == ""
    (line,) = [line for line in err.splitlines() if line.startswith("synch ")]
    assert "taken.json" in line and "folder" in line


def test_damaged_files_are_one_line(tmp_path, capfd):
    for suffix in (".blend", ".obj", ".ply", ".stl", ".glb"):
        path = tmp_path / f"damaged{suffix}"
        path.write_bytes(b"\x07not a model\n" * 9)
        status, out, err = run(capfd, "stripes", path, "--quiet")
        assert status == 1 and out == "", suffix
        assert len([line for line in err.splitlines() if line.startswith("synch stripes: ")]) == 1
        assert "Traceback" not in err, suffix


def test_writing_over_an_older_file_leaves_no_backup(files, tmp_path, capfd):
    for _ in range(2):
        assert run(capfd, "directions", files[".obj"], "--output", tmp_path / "out.blend")[0] == 0
    assert [path.name for path in tmp_path.iterdir()] == ["out.blend"]
