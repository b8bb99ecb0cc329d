# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Job types of Flamenco in Node.js, against a stand-in of its author API (that of its own scripts, 3.8 and 3.9)."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
NODE = shutil.which("node")
pytestmark = pytest.mark.skipif(NODE is None, reason="Node.js is not installed")
# What Flamenco's manager knows of a setting.
KNOWN = set(
    "key type subtype choices propargs description default eval evalInfo visible required editable label".split()
)

ANIMATE = {
    "frames": "1-5, 8-9, 20",
    "chunk_size": 3,
    "object": "Body",
    "spacing": 0.05,
    "flags": '--guidance "axis:Y=2" --hold 0.2',
    "blendfile": "/shared/walk.blend",
    "output_folder": "/shared/out",
    "format": "PNG",
}
BATCH = {"rows": "/shared/rows.jsonl", "working_folder": "/shared", "output_folder": "/shared/out", "parts": 3}


def run(script, settings):
    return subprocess.run(
        [NODE, Path(__file__).with_name("flamenco.mjs"), ROOT / "farm" / "flamenco" / script],
        input=json.dumps({"settings": settings}),
        capture_output=True,
        text=True,
    )


def compiled(script, settings):
    """The job type and the tasks that a script makes."""
    done = run(script, settings)
    assert done.returncode == 0, done.stderr
    made = json.loads(done.stdout)
    return made["type"], made["tasks"]


def synch(command):
    """The command line after ``--command synch`` of a command, which nothing may follow."""
    arguments = command["parameters"]["args"]
    place = arguments.index("--command")
    assert arguments[place + 1] == "synch"
    return arguments[place + 2 :]


@pytest.mark.parametrize("script, settings", [("synch_animate.js", ANIMATE), ("synch_batch.js", BATCH)])
def test_settings_are_such_as_flamenco_knows(script, settings):
    kind, _ = compiled(script, settings)
    assert kind["label"].startswith("Synch Fields") and kind["description"]
    for setting in kind["settings"]:
        assert KNOWN >= set(setting) and setting["description"]
        assert setting["type"] in ("string", "int32", "float", "bool")


def test_tasks_are_contiguous_ranges_that_cover_all_frames_once():
    _, tasks = compiled("synch_animate.js", ANIMATE)
    lines = [synch(task["commands"][0]) for task in tasks]
    ranges = [[int(line[line.index("--frames") + k]) for k in (1, 2)] for line in lines]
    assert ranges == [[1, 3], [4, 5], [8, 9], [20, 20]]
    assert [task["name"] for task in tasks][:2] == ["solve-0001-0003", "solve-0004-0005"]
    assert {task["type"] for task in tasks} == {"blender"} and not any(task["dependencies"] for task in tasks)
    first = tasks[0]["commands"][0]
    assert first["name"] == "blender-render" and first["parameters"]["blendfile"] == "/shared/walk.blend"
    assert (first["parameters"]["exe"], first["parameters"]["exeArgs"]) == ("{blender}", "{blenderArgs}")


def test_each_range_is_rendered_from_its_own_file():
    _, tasks = compiled("synch_animate.js", ANIMATE | {"render_output_path": "/shared/render/######"})
    solve, render = tasks[1]["commands"]
    line = synch(solve)
    assert render["parameters"]["blendfile"] == line[line.index("--output") + 1] == "/shared/out/walk.0004-0005.blend"
    assert render["parameters"]["args"][-2:] == ["--render-frame", "4..5"]


def test_ranges_need_a_spacing_that_they_share():
    done = run("synch_animate.js", ANIMATE | {"spacing": 0})
    assert done.returncode != 0 and "give a spacing" in done.stderr
    assert len(compiled("synch_animate.js", ANIMATE | {"spacing": 0, "frames": "1-3"})[1]) == 1


def test_parts_of_a_batch_come_before_its_table():
    _, tasks = compiled("synch_batch.js", BATCH)
    *parts, last = tasks
    assert last["dependencies"] == [part["name"] for part in parts] == ["part-1", "part-2", "part-3"]
    lines = [synch(task["commands"][0]) for task in tasks]
    assert [line[-2:] for line in lines[:3]] == [["--share", f"{part}/3"] for part in (1, 2, 3)]
    assert "--share" not in lines[3] and all(line[:2] == ["batch", "/shared/rows.jsonl"] for line in lines)


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")
@pytest.mark.parametrize("count, share", [(40, "--share 7/40"), (1, "")])
def test_slurm_runs_a_part_in_each_job_of_an_array(count, share, tmp_path):
    srun = tmp_path / "srun"
    srun.write_text('#!/usr/bin/env bash\necho "$OPENBLAS_NUM_THREADS: $*"\n')
    srun.chmod(0o755)
    given = {"SLURM_ARRAY_TASK_ID": "7", "SLURM_ARRAY_TASK_COUNT": str(count), "SLURM_CPUS_PER_TASK": "8"}
    given |= {"SYNCH_PYTHON": "/shared/python", "PATH": f"{tmp_path}:/usr/bin:/bin"}
    done = subprocess.run(
        ["bash", ROOT / "farm" / "slurm.sh", "rows.jsonl", "/out dir"], env=given, capture_output=True, text=True
    )
    expected = f"1: /shared/python -m synch_fields batch rows.jsonl --folder /out dir --jobs 8 --quiet {share}"
    assert done.returncode == 0 and done.stdout.strip() == expected.strip(), done.stderr
