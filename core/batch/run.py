# SPDX-License-Identifier: GPL-3.0-or-later
"""A batch, from its rows to what became of each: what is done is skipped, what fails is tried again."""

import json
import os
from collections import deque
from dataclasses import dataclass
from pathlib import Path

from ..errors import SettingError
from .rows import Keys

# Seconds between two looks at whether the batch is interrupted.
_LOOK = 0.2


@dataclass(frozen=True, slots=True)
class Planned:
    """What is kept of a row while a batch runs.

    Attributes
    ----------
    label : what a person calls it
    key : of its record; None where it cannot be a row
    told : JSON of its arguments; the reason why it cannot be a row
    """

    label: str
    key: str | None
    told: str


def plan(command_lines, understood, versions):
    """The :class:`Planned` rows of a batch; folders of their files are made.

    Parameters
    ----------
    command_lines : of texts, or of the error of a row that is none, as :func:`.rows.read_rows` gives them
    understood : callable(arguments) -> Row; raises SettingError
    versions : of everything that a result depends on

    Raises
    ------
    SettingError
        where two rows write the same file
    """
    keys, folders = Keys(versions), set()
    rows: list[Planned] = []
    writers: dict[int, int] = {}
    for line in command_lines:
        try:
            if isinstance(line, SettingError):
                raise line
            row = understood(line)
        except SettingError as error:
            rows.append(Planned("" if isinstance(line, SettingError) else " ".join(line[:2]), None, str(error)))
            continue
        rows.append(Planned(row.label, keys.of(row), json.dumps(row.arguments)))
        for path in row.outputs:
            whole = os.path.abspath(path)
            other = writers.setdefault(hash(whole), len(rows))
            if other != len(rows):
                raise SettingError(
                    f"rows {other} and {len(rows)} both write {path}: give each a name of its own, "
                    "with {stem} for the input's name, {first} and {last} for a chunk's frames"
                )
            folders.add(os.path.dirname(whole))
    if not rows:
        raise SettingError("there are no rows: write one JSON object a line")
    for folder in folders:
        _make(folder)
    return rows


def _make(folder):
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise SettingError(f"{folder}: cannot be made ({error.strerror}): choose another place") from None


def run_rows(rows, records, crew, retries, versions, progress, limit=None):
    """Do what is not done of the rows; returns how many were done before, and now.

    Parameters
    ----------
    rows : sequence of :class:`Planned`
    records : Records
    crew : Crew or Cluster
    retries : how often a row that fails is tried again
    versions : that the processes must have
    progress : callable(stage, fraction); raises where the batch is interrupted
    limit : seconds after which a row is ended, its process's start included; None for no limit
    """
    tries, ended = {}, set()
    waiting: deque = deque()
    for row in rows:
        if row.key is None or row.key in tries or row.key in ended:
            continue
        if records.done(row.key) is not None:
            ended.add(row.key)
            continue
        tries[row.key] = (records.failed(row.key) or {"tries": 0})["tries"]
        if tries[row.key] <= retries:
            waiting.append(row)
    before, made, failed, total = len(ended), 0, 0, len(waiting)
    running: dict = {}
    while waiting or running:
        progress(f"rows ({failed} failed)" if failed else "rows", (made + failed) / total)
        while waiting and len(running) < crew.capacity:
            row = waiting.popleft()
            running[row.key] = row
            crew.start(_task(row, records, versions) | {"limit": limit})
        answered = crew.answer(_LOOK)
        if answered is None:
            continue
        task, answer = answered
        row = running.pop(task["key"])
        if "failed" not in answer:
            made += 1
            continue
        tries[row.key] += 1
        records.keep_failed(row.key, tries[row.key], answer["failed"])
        if tries[row.key] <= retries:
            waiting.append(row)
        else:
            failed += 1
    return before, made


def _task(row, records, versions):
    """What a process is told of a row."""
    return {
        "key": row.key,
        "arguments": json.loads(row.told),
        "working_folder": os.getcwd(),
        "folder": str(records.folder.absolute()),
        "versions": versions,
    }
