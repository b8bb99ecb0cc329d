# SPDX-License-Identifier: GPL-3.0-or-later
"""A batch, from its rows to what became of each: what is done is skipped, what fails is tried again."""

import json
import os
from collections import deque
from dataclasses import dataclass

from ..errors import SettingError, one_line
from ..files.declared import FileOwners
from .rows import Keys

# Seconds between two looks at whether the batch is interrupted.
_LOOK = 0.2
# Owner of the batch's own files; those of rows have their numbers, from 1 on.
_BATCH = 0


@dataclass(frozen=True, slots=True)
class Planned:
    """What is kept of a row while a batch runs.

    Attributes
    ----------
    label : what a person calls it, in one line
    key : of its record; None where it cannot be a row
    told : JSON of its arguments; the reason why it cannot be a row
    """

    label: str
    key: str | None
    told: str


def plan(command_lines, understood, versions, own=()):
    """The :class:`Planned` rows of a batch.

    Parameters
    ----------
    command_lines : of texts, or of the error of a row that is none, as :func:`.rows.read_rows` gives them
    understood : callable(arguments) -> Row; raises SettingError
    versions : of everything that a result depends on
    own : :class:`DeclaredFile` of the batch itself

    Raises
    ------
    SettingError
        where a row writes what another one, or the batch, reads or writes
    """
    keys, owners = Keys(versions), FileOwners()
    rows: list[Planned] = []
    for file in own:
        owners.add(file, _BATCH)
    for line in command_lines:
        try:
            if isinstance(line, SettingError):
                raise line
            row = understood(line)
        except SettingError as error:
            label = "" if isinstance(line, SettingError) else " ".join(line[:2])
            rows.append(Planned(one_line(label), None, str(error)))
            continue
        rows.append(Planned(one_line(row.label), keys.of(row), json.dumps(row.arguments)))
        for file in row.files:
            found = owners.add(file, len(rows))
            if found is not None:
                raise _clash(file, len(rows), *found)
    if not rows:
        raise SettingError("there are no rows: write one JSON object a line")
    return rows


def _clash(file, row, other, writes):
    """The error of a file that a row shares with another one, which writes or reads it, or with the batch."""
    if other == _BATCH:
        does = "writes" if file.is_written else "reads"
        return SettingError(f"row {row} {does} {file.path}, a file of the batch itself: name another one")
    if file.is_written and writes:
        return SettingError(
            f"rows {other} and {row} both write {file.path}: give each a name of its own, "
            "with {stem} for the input's name, {first} and {last} for a chunk's frames"
        )
    writer, reader = (row, other) if file.is_written else (other, row)
    return SettingError(
        f"row {reader} reads {file.path}, which row {writer} writes: rows run in any order, so make two batches of them"
    )


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
