# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Signals to a Blender in the background that runs `--command synch`: it ends in one line, with all its children."""

import json
import os
import shlex
import signal
import subprocess
import time

import pytest

from ..addon.command.test_process_exit import LONG, SIGNALS, SOON, processes_with
from .conftest import blender_command, build_extension

INSTALL = """
import bpy
bpy.ops.extensions.package_install_files(filepath={archive!r}, repo="user_default", enable_on_install=True)
bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5)
bpy.context.active_object.name = "Ball"
bpy.ops.wm.save_as_mainfile(filepath={file!r})
"""


@pytest.fixture(scope="module")
def started(tmp_path_factory):
    """Starts a Blender with the extension in the background; the folder that it works in, and another one for its
    temporary files."""
    folder, own = tmp_path_factory.mktemp("work"), tmp_path_factory.mktemp("own")
    (own / "temporary").mkdir()
    variables = {"BLENDER_USER_RESOURCES": str(own / "user"), "TMPDIR": str(own / "temporary")}
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"} | variables

    def start(*arguments):
        return subprocess.Popen(
            [*shlex.split(blender_command()), "--background", *map(str, arguments)],
            cwd=folder,
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )

    start.folder, start.temporary = folder, own / "temporary"
    install = INSTALL.format(archive=build_extension(own), file=str(folder / "ball.blend"))
    assert start("--factory-startup", "--python-expr", install).wait(LONG) == 0
    return start


def synch(started, *arguments):
    return started("ball.blend", "--addons", "bl_ext.user_default.synch_fields", "--command", "synch", *arguments)


@pytest.mark.parametrize(("number", "status", "word"), SIGNALS)
@pytest.mark.parametrize("command", ["stripes", "batch"])
def test_a_signal_ends_blender_and_leaves_neither_files_nor_processes(started, command, number, status, word):
    folder, temporary = started.folder, started.temporary
    rows = [{"command": "stripes", "input": "ball.blend", "spacing": 0.02, "output": f"{row}.blend"} for row in "abc"]
    (folder / "rows.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
    before = sorted(os.listdir(folder))
    if command == "batch":
        process = synch(started, "batch", "rows.jsonl", "--jobs", 2, "--folder", "out")
        end = time.monotonic() + LONG
        while len(processes_with(temporary)) < 3 and time.monotonic() < end:  # itself and two rows
            time.sleep(0.05)
    else:
        process = synch(started, "stripes", "--spacing", 0.05, "--output", "out.blend", "--report", "out.json")
        while "relax" not in process.stderr.readline():
            assert process.poll() is None
    time.sleep(1)
    process.send_signal(getattr(signal, number))
    _, errors = process.communicate(timeout=SOON)
    assert process.returncode == status, errors
    assert "Traceback" not in errors, errors
    assert errors.splitlines()[-1] == f"synch {command}: {word}"
    end = time.monotonic() + SOON
    while (left := processes_with(temporary)) and time.monotonic() < end:
        time.sleep(0.05)
    assert not left
    assert [name for name in sorted(os.listdir(folder)) if name not in ("out", *before)] == []  # records of rows
    assert not list(folder.rglob("[abc].blend"))
