# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What farms call: the command lines that job types make are such as Blender's command takes."""

import importlib.util
from pathlib import Path

import bpy
import pytest

from synch_fields.synch_addon.command import main

from ..moving_meshes import stored_frames, swaying
from ..run_commands import run
from ..scenes import sphere


@pytest.fixture(scope="module")
def flamenco():
    """The tests of the job types, as a module."""
    path = Path(__file__).parents[2] / "farm" / "test_flamenco.py"
    spec = importlib.util.spec_from_file_location("test_flamenco", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    if module.NODE is None:
        pytest.skip("Node.js is not installed")
    return module


def test_a_task_solves_its_frames(flamenco, tmp_path, capfd):
    obj = swaying(sphere())
    settings = flamenco.ANIMATE | {"frames": "2-4", "chunk_size": 2, "object": obj.name, "spacing": 0.5}
    settings |= {"flags": "--hold 0.2", "output_folder": str(tmp_path), "blendfile": str(tmp_path / "walk.blend")}
    _, tasks = flamenco.compiled("synch_animate.js", settings)
    status, _, err = run(capfd, *flamenco.synch(tasks[0]["commands"][0]), loaded=True)
    assert status == 0, err
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "walk.0002-0003.blend"))
    assert stored_frames(bpy.data.objects[settings["object"]]) == [2, 3]
    assert (tmp_path / "walk.0002-0003.json").exists()


def test_the_lines_of_a_batch_are_understood(flamenco):
    _, tasks = flamenco.compiled("synch_batch.js", flamenco.BATCH)
    options = main._parser(True).parse_args(flamenco.synch(tasks[1]["commands"][0]))
    assert (options.rows, options.share, options.jobs) == ("/shared/rows.jsonl", "2/3", 4)
    assert (options.working_folder, options.folder) == ("/shared", "/shared/out")
