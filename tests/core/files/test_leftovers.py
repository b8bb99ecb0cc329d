# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a killed process has left behind is removed by the next one; nothing of a living process or of others is."""

import os
import signal
import subprocess
import sys

import pytest

from synch_fields.core.files import leftovers, whole
from synch_fields.core.files.leftovers import mark, own_name, remove_own, sweep, sweep_marked
from synch_fields.core.files.whole import check_writable, write_text, write_whole

# A process that is in the middle of writing a file and has marked a folder.
WRITING = """
import sys, time
from pathlib import Path
from synch_fields.core.files.leftovers import mark
from synch_fields.core.files.whole import write_whole
here = Path(sys.argv[1])
marked = here / f"blender_{sys.argv[2]}"
marked.mkdir()
mark(marked)
with write_whole(here / "out.txt") as made:
    made.write_text("half")
    print("writing", flush=True)
    time.sleep(600)
"""


@pytest.fixture(autouse=True)
def unswept():
    leftovers.swept.folders.clear()


@pytest.fixture
def writing(tmp_path):
    """Starts processes that write in a folder, and ends them."""
    children = []

    def start():
        command = [sys.executable, "-c", WRITING, str(tmp_path), str(len(children))]
        children.append(subprocess.Popen(command, stdout=subprocess.PIPE, text=True))
        assert children[-1].stdout.readline() == "writing\n"
        return children[-1]

    yield start
    for child in children:
        child.kill()
        child.wait()
        child.stdout.close()


@pytest.mark.skipif(sys.platform == "win32", reason="a number of a process may be another one's there")
def test_the_next_run_removes_what_a_killed_one_has_left_and_nothing_of_a_living_one(tmp_path, writing):
    killed, living = writing(), writing()
    killed.send_signal(signal.SIGKILL)
    killed.wait()
    write_text(tmp_path / "other.txt", "new")
    left = [path.name for path in tmp_path.iterdir() if path.name.startswith(".synch-")]
    assert len(left) == 1 and f"-{living.pid}-" in left[0]
    sweep_marked(tmp_path, "blender_")
    assert sorted(path.name for path in tmp_path.glob("blender_*")) == ["blender_1"]


def test_a_file_of_another_machine_of_another_name_or_of_this_process_stays(tmp_path):
    names = [own_name(".txt"), own_name().replace(leftovers._machine(), "00000000"), ".synch-notes", ".synch_old"]
    for name in names:
        (tmp_path / name).touch()
    (tmp_path / "blender_1").mkdir()
    sweep(tmp_path)
    sweep_marked(tmp_path, "blender_")
    assert sorted(os.listdir(tmp_path)) == sorted([*names, "blender_1"])


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere the system does not tell when a process began")
def test_a_number_of_a_process_that_another_one_has_now_is_no_life(tmp_path):
    since = leftovers._since(os.getpid())
    earlier = own_name(".txt").replace(f"-{since}-", f"-{int(since) - 1}-")
    (tmp_path / earlier).touch()
    (tmp_path / f"{earlier}.folder").mkdir()
    (tmp_path / f"{earlier}.folder" / "file").touch()
    sweep(tmp_path)
    assert os.listdir(tmp_path) == []


def test_a_process_that_ends_while_it_writes_removes_what_it_has_begun(tmp_path, writing):
    writing()
    with write_whole(tmp_path / "own.txt") as made:
        made.write_text("half")
        others = {name for name in os.listdir(tmp_path) if name != made.name}
        remove_own()
        assert not made.exists() and set(os.listdir(tmp_path)) == others and len(others) == 2
        made.write_text("whole")
    assert (tmp_path / "own.txt").read_text() == "whole"


def test_a_check_that_a_file_can_be_made_makes_none(tmp_path, monkeypatch):
    """Also where the process is killed in the middle of it."""
    named = []
    monkeypatch.setattr(whole, "place_beside", lambda path: named.append(path) or path)
    check_writable(tmp_path / "out.json")
    assert not named and os.listdir(tmp_path) == []


def test_a_marked_folder_of_this_process_stays(tmp_path):
    (tmp_path / "blender_1").mkdir()
    mark(tmp_path / "blender_1")
    sweep_marked(tmp_path, "blender_")
    assert len(os.listdir(tmp_path / "blender_1")) == 1
