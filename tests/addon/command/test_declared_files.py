# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The files of each command: all are declared, none is lost, and what a row reads counts."""

import argparse
import json
import re
from pathlib import Path

import bpy
import pytest

from synch_fields.core.batch.rows import Keys
from synch_fields.synch_addon.blender import files
from synch_fields.synch_addon.command import batch, main
from synch_fields.synch_addon.command.declared_files import READ, WRITTEN, declared_files

from .. import scenes
from ..run_commands import run


def parsers():
    """The parser of each command."""
    (commands,) = (action for action in main._parser(False)._actions if isinstance(action, argparse._SubParsersAction))
    return commands.choices


def declared(*line):
    """Paths that a command line reads, and those that it writes."""
    found = declared_files(main._parser(False).parse_args(list(line)))
    return [file.path for file in found if not file.is_written], [file.path for file in found if file.is_written]


@pytest.mark.parametrize("command", sorted(parsers()))
def test_every_flag_of_a_file_is_declared(command):
    """Flags of files have metavars such as FILE.json; one more is an entry of the declaration, or this fails."""
    for action in parsers()[command]._actions:
        if re.match(r"(FILE|ROWS)\.", str(action.metavar)) or action.dest == "input":
            assert action.dest in READ or action.dest in WRITTEN, action.dest


@pytest.mark.parametrize(
    ("line", "reads", "writes"),
    [
        (
            "stripes a.obj --constraints rows.json --guidance file:a.rosy=2,axis:X,file:b.rosy --report r.json",
            ["a.obj", "rows.json", "a.rosy", "b.rosy"],
            ["r.json"],
        ),
        (
            "layers a.stl --machine m.toml --guidance lines:v.vtu:name --export-gcode p.gcode --export-layers p.stl",
            ["a.stl", "m.toml", "v.vtu"],
            ["p.stl", "p.gcode"],
        ),
        ("layers a.stl --guidance file:v.sol --export-volume v.vdb", ["a.stl", "v.sol"], ["v.vdb"]),
        (
            "stripes b/a.blend --guidance file://x.rosy --export-field //o.rosy --report //r.json",
            ["b/a.blend", "b/x.rosy"],
            ["//r.json", "b/o.rosy"],
        ),
        ("clebsch f.npz --export-filaments f.vtp", ["f.npz"], ["f.vtp"]),
        (
            "bake a.blend --object Ball --folder o --maps mask,height",
            ["a.blend"],
            ["o/Ball_mask.png", "o/Ball_height.png"],
        ),
        ("bake a.blend --folder o --name x --maps mask --format EXR", ["a.blend"], ["o/x.exr"]),
        ("bake a.blend --folder o --name {wrong", ["a.blend"], []),
        ("demo --folder o", [], ["o/demo.blend", "o/demo.png", "o/demo.json"]),
        ("stripes a.obj --guidance file:", ["a.obj"], []),
    ],
)
def test_what_a_command_reads_and_writes(line, reads, writes):
    assert declared(*line.split()) == (reads, writes)


def test_frames_of_a_sequence_are_those_that_are_asked_for(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("smoke_0001.vdb", "smoke_0002.vdb", "smoke_0010.vdb", "smoke_0001_old.vdb", "smoke_x.vdb"):
        Path(name).touch()
    assert declared("clebsch", "smoke_####.vdb")[0] == ["smoke_0001.vdb", "smoke_0002.vdb", "smoke_0010.vdb"]
    found, _ = declared("clebsch", "smoke_####.vdb", "--frames", "2", "10")
    assert found == ["smoke_0002.vdb", "smoke_0010.vdb"]


def test_names_of_the_only_object_of_one_file_are_the_same():
    one, other = (declared("bake", path, "--folder", "o")[1] for path in ("a.blend", "./a.blend"))
    assert one == other != declared("bake", "b.blend", "--folder", "o")[1]


@pytest.fixture
def cube(tmp_path, monkeypatch):
    """A cube as part_000.stl, and printers."""
    monkeypatch.chdir(tmp_path)
    bpy.ops.mesh.primitive_cube_add()
    files.export_mesh(bpy.context.object, tmp_path / "part_000.stl")
    (tmp_path / "m.toml").write_text("feed = 900\n")
    return tmp_path


@pytest.mark.parametrize(
    "flags",
    [
        ["--export-layers", "part.stl"],
        ["--export-layers", "./part.stl"],
        ["--export-layers", "q.stl", "--export-mesh", "q_001.stl"],
        ["--export-paths", "p.gcode", "--export-gcode", "p.gcode"],
        ["--machine", "p.gcode", "--export-gcode", "p.gcode"],
        ["--guidance", "file:v.csv", "--export-paths", "v.csv"],
    ],
)
def test_outputs_of_layers_replace_no_input_and_no_output(cube, flags, capfd):
    before = {path.name: path.read_bytes() for path in cube.iterdir()}
    status, out, err = run(capfd, "layers", "part_000.stl", "--size", 1, *flags)
    assert status == 1 and out == "" and "are the same file, name another one" in err and err.count("\n") == 1
    assert {path.name: path.read_bytes() for path in cube.iterdir()} == before


def test_a_changed_machine_or_guide_changes_the_key_of_a_row(cube):
    way = batch.Way(lambda line: main._parse_row(main._parser(False), line), declared_files, None)
    line = ["layers", "part_000.stl", "--machine", "m.toml", "--guidance", "file:v.vtu", "--export-gcode", "p.gcode"]

    def key():
        return Keys({}).of(batch._row_of(line, way))

    first = key()
    assert key() == first
    (cube / "m.toml").write_text("feed = 600\n")
    second = key()
    (cube / "v.vtu").write_text("a guide")
    assert len({first, second, key()}) == 3


def key_of(flag):
    """The key of a row that stands for a flag."""
    return flag.removeprefix("--").replace("-", "_")


@pytest.mark.parametrize(
    ("rows", "reason"),
    [
        (
            [["layers", "a.stl", "--export-gcode", "p.gcode"], ["layers", "b.stl", "--export-gcode", "./p.gcode"]],
            "both write",
        ),
        (
            [["layers", "a.stl", "--export-layers", "p.stl"], ["quad_mesh", "b.stl", "--export-mesh", "p_002.stl"]],
            "both write",
        ),
        (
            [["clebsch", "a.npz", "--export-filaments", "f.vtp"], ["clebsch", "b.npz", "--export-filaments", "f.vtp"]],
            "both write",
        ),
        ([["bake", "a.blend", "--folder", "o"], ["bake", "a.blend", "--folder", "./o", "--size", "64"]], "both write"),
        ([["info", "a.obj", "--report", "r.json"], ["stripes", "a.obj", "--constraints", "r.json"]], "row 2 reads"),
        ([["stripes", "a.obj", "--constraints", "r.json"], ["info", "a.obj", "--report", "r.json"]], "row 1 reads"),
        ([["info", "a.obj", "--report", "out/rows.batch/summary.json"]], "a file of the batch itself"),
        ([["info", "a.obj", "--report", "rows.json"]], "a file of the batch itself"),
    ],
)
def test_rows_whose_files_clash_are_refused_before_any_runs(rows, reason, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    lines = [
        {"command": row[0], "input": row[1]} | dict(zip(map(key_of, row[2::2]), row[3::2], strict=True)) for row in rows
    ]
    Path("rows.json").write_text("".join(json.dumps(line) + "\n" for line in lines))
    status, out, err = run(capfd, "batch", "rows.json")
    assert status == 1 and out == "" and reason in err and err.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["rows.json"]


def test_the_open_file_is_an_input(tmp_path, capfd):
    scenes.sphere()
    path = tmp_path / "open.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    before = path.read_bytes()
    status, _, err = run(capfd, "directions", "--output", path, loaded=True)
    assert status == 1 and "--output and the open file are the same file" in err and path.read_bytes() == before


def test_folders_of_outputs_are_made_by_a_command_as_by_a_batch(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    files.export_mesh(scenes.sphere(), tmp_path / "ball.obj")
    assert run(capfd, "info", "ball.obj", "--report", "new/er/r.json")[0] == 0
    assert json.loads(Path("new/er/r.json").read_text())["vertices"]
    status, _, err = run(capfd, "stripes", "ball.obj", "--output", "gone/o.blend", "--guidance", "wind")
    assert status == 1 and "unknown" in err and not Path("gone").exists()
    assert run(capfd, "stripes", "absent.obj", "--report", "told/r.json")[0] == 1
    assert json.loads(Path("told/r.json").read_text())["status"] == "failed"
