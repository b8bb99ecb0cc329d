# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Warm processes without Blender: each task notes that it was begun, and writes what its arguments ask for."""

import json
import sys

from synch_fields.core.batch.run import Planned

CODE = """
import os, signal, time
from pathlib import Path
from synch_fields.core.batch import child_loop
from synch_fields.core.batch.records import Records
from synch_fields.core.files.whole import write_text

def answer(task):
    os.chdir(task["working_folder"])
    records = Records(task["folder"])
    if records.done(task["key"]):
        return {}
    word, path = task["arguments"]
    with open("begun.txt", "a") as file:
        file.write(f"{task['key']} {os.getpid()}\\n")
    if word == "refuse":
        return {"failed": "this row is refused"}
    if word == "die" or word == "die once" and not Path(path).exists():
        Path(path).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    if word == "hang" or word == "hang once" and not Path(path).exists():
        Path(path).touch()
        time.sleep(600)
    asked = {name: os.environ.get(name) for name in ("SYNCH_THREADS", "MALLOC_TRIM_THRESHOLD_")}
    time.sleep({"slow": 0.1}.get(word, 0))
    write_text(path, word)
    records.keep_done(task["key"], {"energy": 2.0, "gap": 0.25, "seconds": 0.5, "pid": os.getpid()} | asked, [path])
    return {}

print("Blender says something")
child_loop.serve(answer)
"""
ARGUMENTS = ["-c", CODE]
COMMAND = [sys.executable, *ARGUMENTS]


def rows(*words):
    """A planned row for each word."""
    return [
        Planned(f"{word} {number}", f"{number:032x}", json.dumps([word, f"{number}.txt"]))
        for number, word in enumerate(words)
    ]


def begun(folder):
    """Keys of the rows that were begun, once for each time."""
    return [line.split()[0] for line in (folder / "begun.txt").read_text().splitlines()]


def told(*_):
    """A progress that nobody reads."""
