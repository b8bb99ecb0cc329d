# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Quads and quad meshes by operator, in the background and from the command line: modes, undo, files and refusals."""

import json

import bpy
import numpy as np
import pytest

from synch_fields.synch_addon import api
from synch_fields.synch_addon.jobs.report import summary
from synch_fields.synch_addon.looks import render

from ..quad_meshes import corner_vertices, half_edges, made_from
from ..run_commands import run
from ..scenes import attribute, empties, furnished, grid, make_active, places, snapshot, sphere

OPERATORS = ["quads", "quad_mesh"]
SPACING = 0.5


def call(operator, **settings):
    return getattr(bpy.ops.synch, operator)(**({"spacing": SPACING} | settings))


def shown():
    """Which objects are hidden, in the viewport and in renders."""
    return {obj.name: (obj.hide_get(), obj.hide_render) for obj in bpy.data.objects}


def everything():
    return snapshot() | {"shown": shown()}


# Operators


@pytest.mark.parametrize("operator", OPERATORS)
def test_the_operator_gives_what_the_api_gives(operator):
    sphere()
    assert call(operator, seed=2, smoothing=1) == {"FINISHED"}
    found = everything()
    bpy.ops.wm.read_homefile(use_empty=True)
    getattr(api, operator)(sphere(), spacing=SPACING, seed=2, smoothing=1)
    bpy.context.view_layer.update()
    assert everything() == found


@pytest.mark.parametrize("operator, change", [("quads", {"spacing": 0.8}), ("quad_mesh", {"smoothing": 0})])
def test_running_again_with_other_properties_replaces_the_first_result(operator, change):
    """As the redo panel does: undo, and run again."""
    sphere()
    call(operator, **change)
    expected = everything()
    bpy.ops.wm.read_homefile(use_empty=True)
    sphere()
    bpy.ops.ed.undo_push(message="before")
    call(operator)
    bpy.ops.ed.undo_push(message=operator)
    assert everything() != expected
    bpy.ops.ed.undo()
    call(operator, **change)
    assert everything() == expected


def test_quads_in_edit_mode_stay_there_and_see_the_edits():
    obj = grid()
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide()
    assert call("quads") == {"FINISHED"}
    assert obj.mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    assert len(attribute(obj, "synch_phase_x")) == len(obj.data.loops) == 4 * 4 * 144


def test_a_quad_mesh_from_edit_mode_is_shown_in_object_mode():
    obj = sphere()
    bpy.ops.ed.undo_push(message="add")
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.ed.undo_push(message="edit mode")
    assert call("quad_mesh") == {"FINISHED"}
    made = bpy.context.active_object
    assert made.name == f"{obj.name} Quads" and bpy.context.mode == "OBJECT" and obj.mode == "OBJECT"
    assert obj.hide_get() and made.select_get()
    bpy.ops.ed.undo_push(message="quad_mesh")
    bpy.ops.ed.undo()
    (obj,) = bpy.data.objects
    assert obj.mode == "EDIT" and not obj.hide_get() and not obj.hide_render
    with pytest.raises(RuntimeError, match="no grid lines cross"):
        call("quad_mesh", spacing=3.4)
    assert obj.mode == "EDIT" and len(bpy.data.objects) == 1


@pytest.mark.parametrize("operator", OPERATORS)
def test_the_greyed_button_says_why(operator, tmp_path):
    def reason():
        assert not getattr(bpy.ops.synch, operator).poll()
        with pytest.raises(RuntimeError) as refused:
            call(operator)
        return str(refused.value)

    assert "no active object" in reason()
    bpy.ops.object.light_add()
    assert "is not a mesh" in reason()
    obj = sphere()
    bpy.ops.object.mode_set(mode="SCULPT")
    assert "leave the present mode" in reason()
    bpy.ops.object.mode_set(mode="OBJECT")
    assert getattr(bpy.ops.synch, operator).poll()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    name = obj.name
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, wanted):
        wanted.objects = [name]
    bpy.context.scene.collection.objects.link(bpy.data.objects[name])
    make_active(bpy.data.objects[name])
    assert "is linked: make it local" in reason()


def test_warnings_of_a_quad_mesh_speak_of_what_it_does():
    obj = furnished()
    obj.modifiers.new("Rounder", "SUBSURF")
    _, report = made_from(obj, spacing=SPACING)
    said = " ".join(report["warnings"])
    assert "Rounder" in said and "stripes" not in said
    assert "get the pattern" not in said, "the mesh that others share is left alone"


# The command line


@pytest.fixture(scope="module")
def ball(tmp_path_factory, extension):
    """A unit sphere of triangles as a file that other programs wrote: its Y points up."""
    path = tmp_path_factory.mktemp("inputs") / "ball.obj"
    bpy.ops.wm.read_homefile(use_empty=True)
    obj = sphere(4)
    obj.name, obj.location = "ball", (3, 0, 1)
    bpy.ops.wm.obj_export(filepath=str(path))
    return path


def read_obj(path):
    """Vertices and faces of an .obj file."""
    lines = [line.split() for line in path.read_text().splitlines() if line.strip()]
    vertices = [[float(x) for x in words[1:4]] for words in lines if words[0] == "v"]
    faces = [[int(corner.split("/")[0]) - 1 for corner in words[1:]] for words in lines if words[0] == "f"]
    return np.array(vertices), faces


def test_quads_write_scene_report_picture_and_field(ball, tmp_path, capfd, monkeypatch):
    asked = []
    monkeypatch.setattr(render, "render_picture", lambda obj, path, **look: asked.append((obj.name, path, look)))
    blend, report_file, picture, field = (tmp_path / f"out.{kind}" for kind in ("blend", "json", "png", "rawfield"))
    outputs = ["--output", blend, "--report", report_file, "--render", picture, "--export-field", field]
    status, out, err = run(capfd, "quads", ball, "--spacing", 0.4, "--seed", 2, *outputs)
    assert status == 0, err
    report = json.loads(report_file.read_text())
    assert (report["command"], report["seed"], report["nodes"]) == ("quads", 2, 642)
    assert report["settings"]["symmetry"] == "cross" and report["settings"]["spacing"] == 0.4
    assert sum(d["index"] for d in report["disclinations"]) == 2 and "quad_mesh" not in report
    assert asked == [("ball", str(picture), {"view": (-25.0, 14.0), "edges": False})]
    assert out.startswith("quads on ball: 642 vertices") and "%" in err and "%" not in out.split("wrote")[1]
    for path in (blend, report_file, picture, field):
        assert f"wrote {path}" in out
    assert field.stat().st_size > 1000
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    obj = bpy.data.objects["ball"]
    assert "synch_phase_y" in obj.data.attributes
    assert len(empties(obj)) == len(report["disclinations"]) + len(report["dislocations"])


def test_a_quad_mesh_goes_to_a_scene_and_to_a_file_where_the_given_one_was(ball, tmp_path, capfd, monkeypatch):
    asked = []
    monkeypatch.setattr(render, "render_picture", lambda obj, path, *, view, edges: asked.append((obj.name, edges)))
    blend, report_file, picture, mesh = (tmp_path / f"out.{kind}" for kind in ("blend", "json", "png", "obj"))
    outputs = ["--output", blend, "--report", report_file, "--render", picture, "--export-mesh", mesh]
    status, out, err = run(capfd, "quad_mesh", ball, "--spacing", 0.4, "--smoothing", 5, *outputs)
    assert status == 0, err
    figures = json.loads(report_file.read_text())["quad_mesh"]
    assert json.loads(report_file.read_text())["settings"]["smoothing"] == 5
    assert f"ball Quads: {figures['faces']} faces" in out and asked == [("ball Quads", True)]
    vertices, faces = read_obj(mesh)
    assert (len(vertices), len(faces)) == (figures["vertices"], figures["faces"])
    assert np.mean([len(face) == 4 for face in faces]) == pytest.approx(figures["quad_share"]) and len(faces) > 200
    source, _ = read_obj(ball)
    np.testing.assert_allclose(np.ptp(vertices, axis=0), np.ptp(source, axis=0), rtol=0.05)
    np.testing.assert_allclose(vertices.mean(axis=0), source.mean(axis=0), atol=0.05)
    for path in (blend, report_file, picture, mesh):
        assert f"wrote {path}" in out
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    made = bpy.data.objects["ball Quads"]
    assert bpy.data.objects["ball"].hide_render and bpy.context.view_layer.objects.active == made
    assert len(corner_vertices(made)) == sum(map(len, faces)) and max(half_edges(made).values()) == 1


@pytest.mark.parametrize("suffix", ["ply", "stl"])
def test_other_kinds_of_mesh_files(suffix, ball, tmp_path, capfd):
    path = tmp_path / f"out.{suffix}"
    assert run(capfd, "quad_mesh", ball, "--spacing", 0.5, "--quiet", "--export-mesh", path)[0] == 0
    made = places(bpy.data.objects["ball Quads"])
    bpy.ops.wm.read_homefile(use_empty=True)
    getattr(bpy.ops.wm, f"{suffix}_import")(filepath=str(path))
    (obj,) = bpy.context.scene.objects
    assert len(obj.data.vertices) == len(made)


def test_the_field_of_quads_is_exported(ball, tmp_path, capfd):
    """A quad mesh has none: the mesh that it comes from stays as it was."""
    path = tmp_path / "a.rawfield"
    status, _, err = run(capfd, "quads", ball, "--quiet", "--spacing", 0.5, "--export-field", path)
    assert status == 0 and path.is_file(), err
    status, _, err = run(capfd, "quad_mesh", ball, "--quiet", "--spacing", 0.5, "--export-field", path)
    assert status == 2 and "unrecognized arguments: --export-field" in err


FAILURES = {
    "unknown kind of mesh": (["quad_mesh", "--export-mesh", "out.fbx"], "must end in .obj or .ply or .stl"),
    "unknown kind before any work": (["quad_mesh", "--object", "X", "--export-mesh", "a.fbx"], "must end in .obj"),
    "mesh in a file": (["quad_mesh", "--export-mesh", "/dev/null/out.obj"], "cannot be written"),
    "scene of another kind": (["quads", "--output", "out.obj"], "must end in .blend"),
    "picture of another kind": (["quad_mesh", "--render", "out.jpg"], "must end in .png"),
    "aspect of zero": (["quads", "--aspect", "0"], "the aspect is 0"),
    "negative smoothing": (["quad_mesh", "--smoothing", "-2"], "the smoothing is -2"),
    "range without a map": (["quads", "--spacing-range", "3"], "add --spacing-map"),
    "axes change places": (["quads", "--aspect", "2"], "never change places"),
    "nothing crosses": (["quad_mesh", "--spacing", "3.4"], "no grid lines cross"),
}


@pytest.mark.parametrize("name", FAILURES)
def test_failures_are_one_line_and_leave_no_file_but_the_report(name, ball, tmp_path, capfd, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (command, *flags), reason = FAILURES[name]
    status, out, err = run(capfd, command, ball, "--quiet", "--report", "report.json", *flags)
    assert status == 1 and out == ""
    (line,) = [line for line in err.splitlines() if line.startswith("synch ")]
    assert reason in line
    report = json.loads((tmp_path / "report.json").read_text())
    assert (report["status"], report["command"]) == ("failed", command) and report["error"] in line
    assert [p.name for p in tmp_path.iterdir()] == ["report.json"]


@pytest.mark.parametrize(
    "arguments",
    [
        ["quads", "x.obj", "--symmetry", "line"],
        ["quads", "x.obj", "--smoothing", "3"],
        ["quads", "x.obj", "--export-mesh", "out.obj"],
        ["stripes", "x.obj", "--aspect", "2"],
        ["directions", "x.obj", "--aspect", "2"],
        ["quad_mesh", "x.obj", "--smoothing", "much"],
    ],
)
def test_flags_of_other_commands_are_usage_errors(arguments, capfd):
    status, out, err = run(capfd, *arguments)
    assert status == 2 and out == ""
    assert err.count("\n") == 1 and arguments[2] in err and "--help" in err


def test_help_says_what_quads_are_set_by(capfd):
    def said(*arguments):
        status, out, _ = run(capfd, *arguments)
        assert status == 0
        return " ".join(out.split())

    assert "quads a pattern of quads along a cross field" in said("--help")
    assert "quad_mesh a mesh of quads along a cross field" in said("--help")
    quads, quad_mesh = said("quads", "--help"), said("quad_mesh", "--help")
    for text in (quads, quad_mesh):
        assert "--aspect X spacing of quads along their second direction over that along the first" in text
        assert (
            "--spacing LENGTH distance from one stripe to the next, or length of two quads" in text
            and "--symmetry" not in text
        )
    assert "--smoothing N" in quad_mesh and "--smoothing" not in quads
    assert "--export-mesh FILE.obj write the quads as a file (.obj, .ply, .stl)" in quad_mesh
    assert "--aspect" not in said("stripes", "--help")


def test_a_pattern_without_a_bound_shows_that_of_its_directions():
    obj = sphere()
    report = api.quad_mesh(obj, spacing=SPACING)
    lines = summary(report)
    assert report["certificate"] == "none" and report["directions"]["certificate"] == "proved"
    assert any(line.endswith("no bound asked") for line in lines) and not any("gap 100" in line for line in lines)
    assert any(line.startswith("directions: energy") and "no field saves more than" in line for line in lines)
