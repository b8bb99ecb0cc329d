# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Outputs of the command line on a full disk: the status is not 0, one line says why, and older files stay.

A limit on the size of files stands for the full disk: what goes beyond it is refused by the system in the same way.
"""

import json
import os
import re
import socket
import struct
import subprocess
import sys
from pathlib import Path

import bpy
import pytest

import synch_fields
from synch_fields.core.errors import SynchError
from synch_fields.core.files.json_text import json_text
from synch_fields.core.tasks.surfaces import SurfaceRequest
from synch_fields.synch_addon.blender import files
from synch_fields.synch_addon.command.main import main

from .. import scenes
from ..run_commands import run

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="there are no limits on files there")

# The folder that this package is in, for processes that import it, too.
ROOT = Path(synch_fields.__file__).parents[1]
# The command line with a limit on the bytes of its address space.
LIMITED = """
import resource, runpy, sys
sys.dont_write_bytecode = True
resource.setrlimit(resource.RLIMIT_AS, (int(sys.argv.pop(1)), resource.RLIM_INFINITY))
runpy.run_module("synch_fields", run_name="__main__")
"""


@pytest.fixture
def limited(capfd):
    """Runs a command line in this process none of whose files may become longer: exit status, stdout and stderr."""
    resource = pytest.importorskip("resource")

    def call(bytes_, *arguments):
        allowed = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (bytes_, allowed[1]))
        try:
            return run(capfd, *arguments)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, allowed)

    return call


def process(*arguments, program=("-m", "synch_fields"), **options):
    """A finished process of Python."""
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | options
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    command = [sys.executable, *program, *map(str, arguments)]
    return subprocess.run(command, text=True, env=environment, check=False, **options)


@pytest.fixture
def sphere(tmp_path):
    obj = scenes.sphere()
    path = tmp_path / "sphere.obj"
    files.export_mesh(obj, path)
    return path


OUTPUTS = {
    "--output": "out.blend",
    "--render": "out.png",
    "--report": "out.json",
    "--export-mesh": "out.ply",
    "--export-field": "out.rawfield",
}


@pytest.mark.parametrize(
    ("flag", "name"),
    [pytest.param(*item, marks=[pytest.mark.slow] if item[0] == "--render" else []) for item in OUTPUTS.items()],
)
def test_a_full_disk_loses_no_file(limited, sphere, tmp_path, flag, name):
    command = "quad_mesh" if flag == "--export-mesh" else "directions"
    (tmp_path / name).write_text("old")
    status, _, errors = limited(700, command, sphere, "--quiet", flag, tmp_path / name)
    lines = errors.strip().splitlines()
    assert status == 1, errors
    assert "cannot be written" in lines[-1] and str(tmp_path / name) in lines[-1]
    assert (tmp_path / name).read_text() == "old" and len(list(tmp_path.iterdir())) == 2


def test_a_full_disk_that_has_room_for_a_failure_keeps_the_older_report(limited, sphere, tmp_path):
    """The report that cannot be written is longer than one that says so."""
    report = tmp_path / "out.json"
    report.write_text("old")
    arguments = ["stripes", sphere, "--spacing", 0.2, "--method", "spectral", "--quiet", "--report", report]
    status, _, errors = limited(3000, *arguments)
    assert status == 1 and "out.json: cannot be written" in errors, errors
    assert report.read_text() == "old" and len(list(tmp_path.iterdir())) == 2
    assert limited(10**6, *arguments)[0] == 0
    assert report.stat().st_size > 3000


def test_layers_that_cannot_all_be_written_leave_none(limited, tmp_path):
    """Of a cone, whose layers have files of other lengths."""
    bpy.ops.mesh.primitive_cone_add(vertices=48)
    cone = tmp_path / "cone.obj"
    files.export_mesh(bpy.context.object, cone)
    arguments = ["layers", cone, "--spacing", 0.6, "--size", 0.3, "--quiet", "--export-layers", tmp_path / "part.stl"]
    assert limited(10**9, *arguments)[0] == 0
    before = {path.name: path.read_bytes() for path in tmp_path.glob("part_*")}
    sizes = sorted(map(len, before.values()))
    assert sizes[0] < sizes[-1], "all layers are of one length"
    (tmp_path / "part_000.stl").write_bytes(b"old")
    status, _, errors = limited(sizes[-1] - 1, *arguments)
    assert status == 1 and "cannot be written" in errors and ".synch-" not in errors
    assert (tmp_path / "part_000.stl").read_bytes() == b"old"
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([*before, "cone.obj"])
    for path in tmp_path.glob("part_*"):
        path.unlink()
    assert limited(sizes[-1] - 1, *arguments)[0] == 1
    assert [path.name for path in tmp_path.iterdir()] == ["cone.obj"]


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["ball.obj", "--export-mesh", "./ball.obj"], "./ball.obj: --export-mesh and the input are the same file"),
        (["ball.obj", "--report", "rows.json", "--constraints", "rows.json"], "rows.json: --report and --constraints"),
        (["ball.blend", "--output", "link.blend"], "link.blend: --output and the input are the same"),
    ],
)
def test_an_output_that_is_an_input_is_refused_before_anything_runs(tmp_path, monkeypatch, capsys, arguments, line):
    monkeypatch.chdir(tmp_path)
    for name in ("ball.obj", "ball.blend", "rows.json"):
        (tmp_path / name).write_text(name)
    (tmp_path / "link.blend").symlink_to("ball.blend")
    assert main(["quad_mesh", *arguments]) == 1
    assert capsys.readouterr().err.startswith(f"synch quad_mesh: {line}")
    assert [(tmp_path / name).read_text() for name in ("ball.obj", "rows.json")] == ["ball.obj", "rows.json"]


@pytest.mark.parametrize(("flag", "name"), OUTPUTS.items())
def test_every_place_is_tried_before_the_solve(sphere, tmp_path, monkeypatch, capsys, flag, name):
    def solve(*_arguments):
        raise AssertionError("solved")

    monkeypatch.setattr(SurfaceRequest, "solve", solve)
    command = "quad_mesh" if flag == "--export-mesh" else "directions"
    with pytest.raises(AssertionError, match="solved"):
        main([command, str(sphere), "--quiet", flag, str(tmp_path / name)])
    with pytest.raises(AssertionError, match="solved"):
        main([command, str(sphere), "--quiet", flag, str(tmp_path / "new" / name)])
    assert not (tmp_path / "new").exists(), "the folder was made for nothing"
    place = sphere / name
    assert main([command, str(sphere), "--quiet", flag, str(place)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"synch {command}: {place}: cannot be written (no folder can be made: File exists)")


def test_reports_are_json_that_every_reader_takes():
    report = {"settings": {"spacing": float("nan"), "angle": 1.5}, "gaps": [float("inf"), -float("inf"), 0.0, None]}
    text = json_text(report)

    def refuse(word):
        raise AssertionError(word)

    read = json.loads(text, parse_constant=refuse)
    assert read == {"settings": {"spacing": None, "angle": 1.5}, "gaps": [None, None, 0.0, None]}
    assert report["gaps"][0] == float("inf")


# The command line, interrupted when Blender is about to be imported.
INTERRUPTED = """
import importlib.abc, os, runpy, signal, sys

class Interrupting(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name == "bpy":
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Interrupting())
runpy.run_module("synch_fields", run_name="__main__")
"""


def test_an_interrupt_while_blender_is_imported_ends_the_command_in_one_line(sphere):
    found = process("info", sphere, program=("-c", INTERRUPTED))
    assert found.returncode == 130 and found.stderr.strip() == "synch: interrupted"


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere address space has no limit")
def test_too_little_memory_is_told_in_one_line(sphere, tmp_path, capsys, monkeypatch):
    """Too little for Blender before it is loaded, and too little for the solve when it ends."""
    found = process(10**9, "info", sphere, program=("-c", LIMITED))
    assert found.returncode == 1 and found.stderr.count("\n") == 1
    assert found.stderr.startswith("synch: the address space is limited to 0.93 GB and Blender needs")

    large = tmp_path / "large.obj"
    large.write_bytes(sphere.read_bytes() + b"# nothing but a comment\n" * 6_000_000)
    found = process(2 * 10**9, "info", large, program=("-c", LIMITED))
    assert found.returncode == 1 and found.stderr.count("\n") == 1
    assert re.search(r"large\.obj takes about 1\.\d GB of address space and 0\.\d+ GB are left", found.stderr)
    large.unlink()

    def without_memory(*_):
        raise MemoryError

    monkeypatch.setattr(SurfaceRequest, "solve", without_memory)
    output = tmp_path / "out.blend"
    assert main(["stripes", str(sphere), "--quiet", "--output", str(output)]) == 1
    assert "too little memory" in capsys.readouterr().err and not output.exists()


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="there is no device without room")
def test_a_result_that_cannot_be_printed_is_told(sphere):
    with open("/dev/full", "w") as full:
        found = process("info", sphere, stdout=full)
    assert found.returncode == 1
    assert found.stderr.strip() == "synch info: the result cannot be printed (No space left on device)"


def test_without_a_stdout_the_command_runs(sphere):
    found = process("info", sphere, stdout=None, preexec_fn=lambda: os.close(1))
    assert (found.returncode, found.stderr) == (0, "")


def test_names_that_are_no_text_are_refused_in_one_line(tmp_path, capsys):
    assert main(["info", str(tmp_path / "b\udcff.obj")]) == 1
    line = capsys.readouterr().err.strip()
    assert line.startswith("synch info: the input is ") and line.endswith("which is not text: write it as UTF-8")


@pytest.mark.parametrize("name", ["bad.blend", "bad.glb", "bad.stl", "bad.ply"])
def test_a_damaged_input_is_told_in_one_line_with_its_name(tmp_path, name, capfd):
    path = tmp_path / name
    path.write_text("nothing of the kind")
    assert main(["info", str(path)]) == 1
    out, err = capfd.readouterr()
    assert out == "" and len(err.splitlines()) == 1
    assert err.startswith(f"synch info: {path}") and err.rstrip().endswith("export it again")


def test_what_the_importer_says_of_each_line_is_not_repeated(tmp_path, capfd):
    path = tmp_path / "many.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n" + "f 1 x 99999\n" * 2000)
    assert main(["info", str(path)]) == 0
    assert capfd.readouterr().err == ""


def test_a_volume_on_a_full_disk_is_told_in_one_line_and_the_older_one_stays(limited, tmp_path):
    bpy.ops.mesh.primitive_cube_add(size=1)
    cube, volume = tmp_path / "cube.obj", tmp_path / "v.vdb"
    files.export_mesh(bpy.context.object, cube)
    volume.write_bytes(b"old")
    arguments = ["layers", cube, "--spacing", 0.6, "--size", 0.3, "--quiet", "--export-volume", volume]
    status, _, errors = limited(2000, *arguments, "--resolution", 32)
    assert status == 1 and errors.count("\n") == 1, errors
    assert errors.startswith(f"synch layers: {volume}: cannot be written (")
    assert volume.read_bytes() == b"old" and len(list(tmp_path.iterdir())) == 2
    assert limited(10**8, *arguments, "--resolution", 32)[0] == 0
    assert len(volume.read_bytes()) > 2000


def damaged_glb(text):
    return struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text), len(text), b"JSON") + text


DAMAGED = [
    damaged_glb(b'{"asset": {"version": "2.0"}, "scenes": [{"nodes": [5]}], "nodes": []}'),
    damaged_glb(b"[1, 2]"),
]
# A command for each file that is named, in one process.
EACH = """
import sys
from synch_fields.synch_addon.command.main import main
print([main(["info", path]) for path in sys.argv[1:]])
"""


def test_the_reason_of_a_damaged_glb_is_one_line_without_the_importers_traceback(tmp_path):
    """In a process of its own, where nothing else catches what the importer writes."""
    paths = [tmp_path / f"bad{number}.glb" for number in range(len(DAMAGED))]
    for path, content in zip(paths, DAMAGED, strict=True):
        path.write_bytes(content)
    found = process(*paths, program=("-c", EACH))
    assert found.stdout == "[1, 1]\n", found.stderr
    lines = found.stderr.splitlines()
    assert len(lines) == 2, found.stderr
    assert all(line.startswith(f"synch info: {path}") for line, path in zip(lines, paths, strict=True))


@pytest.mark.parametrize("kind", ["device", "socket"])
def test_a_blend_file_replaces_no_device_and_no_socket(tmp_path, monkeypatch, kind):
    monkeypatch.chdir(tmp_path)  # names of sockets are short
    path = Path("given.blend")
    with socket.socket(socket.AF_UNIX) as bound:
        if kind == "device":
            path.symlink_to("/dev/null")
        else:
            bound.bind(str(path))
        with pytest.raises(SynchError, match="this is not a file"):
            files.save_blend(path)
        assert path.exists() and not path.is_file()
