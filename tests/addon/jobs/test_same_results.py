# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The window, a script and the command line give the same to the last bit."""

import subprocess
import sys

import bpy
import numpy as np
import pytest

from synch_fields.core.settings.layers import LayerSettings
from synch_fields.core.settings.surface import SurfaceSettings
from synch_fields.synch_addon import api
from synch_fields.synch_addon.command import main
from synch_fields.synch_addon.jobs.queue import queue
from synch_fields.synch_addon.patterns.job import FieldJob

from ..event_loop import by_the_worker
from ..scenes import attribute, quad_sphere

COMMANDS = {
    "stripes": {"spacing": 0.9},
    "quad_mesh": {"spacing": 0.9},
    "layers": {"spacing": 0.6, "size": 0.3},
}


def from_the_window(command, obj):
    """As the window does it: by the worker."""
    if command == "layers":
        job = api.layer_job(obj, LayerSettings(**COMMANDS[command]))
    else:
        job = FieldJob(command, obj, SurfaceSettings(**COMMANDS[command]))
    work = by_the_worker(job)
    assert work.error is None, work.error
    job.write(work.result)


def from_a_script(command, obj):
    getattr(api, command)(obj, **COMMANDS[command])


def from_the_command_line(command, path, output):
    """In a process of its own for one command: the others differ in the solve, which the worker's process makes too."""
    flags = [f"--{name}={value}" for name, value in COMMANDS[command].items()]
    words = [command, str(path), "--quiet", "--output", str(output), *flags]
    if command == "quad_mesh":
        subprocess.run([sys.executable, "-m", "synch_fields", *words], check=True, capture_output=True)
    else:
        assert main.main(words) == 0


def made():
    """All values of ours in the scene, by object and name, and the places of what was made."""
    found = {}
    for obj in bpy.data.objects:
        if obj.type == "MESH":
            for layer in obj.data.attributes:
                if layer.name.startswith("synch_") or layer.name == "position":
                    found[obj.name, layer.name] = attribute(obj, layer.name).copy()
    return found


@pytest.mark.any_surface
@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.full_search
def test_window_script_and_command_line_give_the_same(command, tmp_path):
    quad_sphere(6).name = "Ball"
    path, output = tmp_path / "in.blend", tmp_path / "out.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    results = []
    for way in (from_the_window, from_a_script):
        bpy.ops.wm.open_mainfile(filepath=str(path))
        way(command, bpy.data.objects["Ball"])
        results.append(made())
    queue.stop()
    from_the_command_line(command, path, output)
    bpy.ops.wm.open_mainfile(filepath=str(output))
    results.append(made())
    assert any(name.startswith("synch_") for _, name in results[0]) or command == "quad_mesh"
    for other in results[1:]:
        assert results[0].keys() == other.keys()
        for key, values in results[0].items():
            np.testing.assert_array_equal(values, other[key], err_msg=str(key))
