# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every process of the command line ends, with its status, whatever ran in it, and leaves nothing behind."""

import json
import os
import signal
import subprocess
import sys
import textwrap
import time
from contextlib import suppress
from pathlib import Path

import bpy
import pytest

import synch_fields
from synch_fields.core.batch import child_loop
from synch_fields.synch_addon.blender import files

from .. import scenes

# The folder that this package is in, for processes that import it, too.
ROOT = Path(synch_fields.__file__).parents[1]
COMMAND = [sys.executable, "-m", "synch_fields"]
# Seconds in which a command ends; one that does not end waits for ever.
LONG = 120
# And in which one ends that a signal has asked to, long before its work is done.
SOON = 30


@pytest.fixture
def temporary(tmp_path):
    """A folder for temporary files that the test's processes have alone."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    return folder


@pytest.fixture
def place(temporary):
    return {
        "env": {name: value for name, value in os.environ.items() if name != "OCIO"}
        | {"PYTHONPATH": str(ROOT), "TMPDIR": str(temporary), "TMP": str(temporary), "TEMP": str(temporary)},
        "stdout": subprocess.PIPE,
        "stderr": subprocess.PIPE,
        "text": True,
    }


@pytest.fixture
def ball(tmp_path):
    path = tmp_path / "ball.obj"
    files.export_mesh(scenes.sphere(), path)
    return path


def test_a_command_ends_after_a_python_driver_and_removes_the_temporary_folder_of_a_killed_one(
    ball, tmp_path, temporary, place
):
    other = temporary / "blender_other"
    other.mkdir()
    process = subprocess.Popen([*COMMAND, "stripes", str(ball), "--spacing", "0.1"], **place)
    process.stderr.readline()
    process.kill()
    process.communicate()
    (left,) = set(temporary.iterdir()) - {other}
    assert left.name.startswith("blender_")
    obj = scenes.sphere(2)
    obj.driver_add("location", 0).driver.expression = "len(str(frame))"
    path, report = tmp_path / "driver.blend", tmp_path / "out.json"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    arguments = ["stripes", path, "--method", "spectral", "--report", report, "--quiet"]
    done = subprocess.run([*COMMAND, *map(str, arguments)], timeout=LONG, check=False, **place)
    assert done.returncode == 0, done.stderr
    assert json.loads(report.read_text())["status"] and "Traceback" not in done.stderr
    if sys.platform == "linux":  # elsewhere the system does not tell when a process began
        assert list(temporary.iterdir()) == [other]


@pytest.mark.parametrize(
    ("last", "status"), [("s.unregister(); s.register(); s.unregister(); sys.exit(3)", 3), ("raise ValueError", 1)]
)
def test_a_script_that_has_registered_ends_with_its_own_status(place, last, status):
    code = f"import sys, bpy, synch_fields as s\ns.register()\nprint('done', flush=True)\n{last}"
    done = subprocess.run([sys.executable, "-c", code], timeout=LONG, check=False, **place)
    assert (done.returncode, done.stdout.splitlines()[-1]) == (status, "done"), done.stderr  # Blender may warn before


def test_an_extension_that_is_on_when_blender_ends_is_taken_out_without_an_error(place):
    """As a module, Blender disables it at its end, after what this process does at its own."""
    code = "import bpy, addon_utils\naddon_utils.enable('synch_fields')\nbpy.ops.synch.stripes.poll()"
    done = subprocess.run([sys.executable, "-c", code], timeout=LONG, check=False, **place)
    assert (done.returncode, "Traceback" in done.stderr + done.stdout) == (0, False), done.stderr


def test_a_fault_of_ours_is_shown_and_what_other_modules_do_at_the_end_is_done(tmp_path, temporary, place):
    """Such as saving what tests have covered."""
    code = """
        import atexit, pathlib, runpy, sys
        from synch_fields.synch_addon.command import main
        atexit.register(pathlib.Path(sys.argv.pop(1)).touch)
        main.main = lambda arguments: 1 / 0
        runpy.run_module("synch_fields", run_name="__main__")
    """
    command = [sys.executable, "-c", textwrap.dedent(code), str(tmp_path / "saved")]
    done = subprocess.run(command, timeout=LONG, check=False, **place)
    assert done.returncode == 1 and "ZeroDivisionError" in done.stderr and list(temporary.iterdir()) == []
    assert (tmp_path / "saved").exists()


SIGNALS = [("SIGTERM", 143, "terminated"), ("SIGINT", 130, "interrupted")]


@pytest.mark.skipif(sys.platform == "win32", reason="processes are ended at once there")
@pytest.mark.parametrize(("number", "status", "word", "moment"), [(*SIGNALS[0], ""), (*SIGNALS[1], "polish")])
def test_a_signal_ends_a_command_in_one_line_and_leaves_nothing(
    ball, tmp_path, temporary, place, number, status, word, moment
):
    """At the first progress of a kind, which is that of the directions: the stripes are still to be solved."""
    arguments = ["stripes", ball, "--spacing", 0.1, "--output", tmp_path / "new" / "out.blend"]
    process = subprocess.Popen([*COMMAND, *map(str, arguments), "--report", str(tmp_path / "out.json")], **place)
    next(line for line in process.stderr if moment in line)
    process.send_signal(getattr(signal, number))
    _, errors = process.communicate(timeout=SOON)
    assert process.returncode == status, errors
    assert "Traceback" not in errors and errors.splitlines()[-1] == f"synch stripes: {word}"
    assert sorted(os.listdir(tmp_path)) == ["ball.obj", "temporary"] and list(temporary.iterdir()) == []


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere the system does not tell whose a process is")
def test_a_signal_ends_a_batch_and_the_processes_of_its_rows(ball, tmp_path, temporary, place):
    rows = [{"command": "stripes", "input": ball.name, "spacing": 0.02, "report": f"{row}.json"} for row in range(3)]
    (tmp_path / "rows.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
    process = subprocess.Popen([*COMMAND, "batch", "rows.jsonl", "--jobs", "2"], cwd=tmp_path, **place)
    end = time.monotonic() + LONG
    while len(processes_with(temporary)) < 3 and time.monotonic() < end:  # itself and two rows
        time.sleep(0.05)
    time.sleep(1)  # in which the rows begin
    process.send_signal(signal.SIGTERM)
    _, errors = process.communicate(timeout=SOON)
    assert process.returncode == 143 and errors.splitlines()[-1] == "synch batch: terminated", errors
    assert "Traceback" not in errors
    while (left := processes_with(temporary)) and time.monotonic() < end:
        time.sleep(0.05)
    assert not left
    assert not list(tmp_path.glob(".synch*"))  # a row may have been done before


def processes_with(temporary):
    """Numbers of the running processes that have this folder for their temporary files."""
    found, mark = [], f"TMPDIR={temporary}\0".encode()
    for entry in Path("/proc").iterdir():
        with suppress(OSError):  # it has ended
            if entry.name.isdigit() and mark in (entry / "environ").read_bytes():
                found.append(int(entry.name))
    return found


def test_a_warm_process_that_is_not_needed_leaves_nothing(temporary, place, monkeypatch):
    for name, value in place["env"].items():
        monkeypatch.setenv(name, value)
    process = child_loop.WarmProcess([*COMMAND, "batch", "-"], 1)
    task = {"key": "0" * 32, "arguments": ["info"], "working_folder": ".", "folder": ".", "versions": {"numpy": "0"}}
    assert "numpy is " in process.ask(task)["failed"]
    process.end()
    assert process._child.returncode == 0 and list(temporary.iterdir()) == []
