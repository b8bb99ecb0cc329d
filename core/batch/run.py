# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the rows of a batch: finished rows are skipped, failed ones are tried again."""

import json
import os
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..errors import SettingError, one_line
from ..files.declared import DeclaredFile, FileOwners
from .child_loop import ProcessPool, Task
from .records import Records
from .rows import Keys, Row

if TYPE_CHECKING:
    from .cluster import Cluster  # not in the extension

# Seconds between two checks for an interruption.
_LOOK = 0.2
# Owner of the batch's own files; those of rows have the rows' numbers, from 1 on.
_BATCH = 0


@dataclass(frozen=True, slots=True)
class Planned:
    """The part of a row that is kept while a batch runs.

    Attributes
    ----------
    label : for people, in one line
    key : of its record; None for a row that is not valid
    content : JSON of its arguments, or why it is not valid
    """

    label: str
    key: str | None
    content: str


def plan(
    command_lines: Iterable[list[str] | SettingError],
    understood: Callable[[list[str]], Row],
    versions: object,
    own: Iterable[DeclaredFile] = (),
) -> list[Planned]:
    """The rows of a batch. Raises SettingError if a row writes a file that another row, or the batch, reads or writes.

    Parameters
    ----------
    command_lines : from :func:`.rows.read_rows`
    understood : parses a command line, or raises SettingError
    versions : of everything that a result depends on
    own : files of the batch itself
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


def _clash(file: DeclaredFile, row: int, other: int, writes: bool) -> SettingError:
    """The error for a file that a row shares with another one, which writes or reads it, or with the batch."""
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


def run_rows(
    rows: Iterable[Planned],
    records: Records,
    pool: "ProcessPool | Cluster",
    retries: int,
    versions: object,
    progress: Callable[[str, float], object],
    limit: float | None = None,
) -> tuple[int, int]:
    """Do the rows that are not done; returns the numbers of rows done before, and now.

    Parameters
    ----------
    retries : how often a row that fails is tried again
    versions : that the processes must have
    progress : called with a stage and a fraction; raises if the batch is interrupted
    limit : seconds for a row, including the start of its process; None for no limit
    """
    tries: dict[str, int] = {}
    ended: set[str] = set()
    waiting: deque[tuple[str, Planned]] = deque()
    for row in rows:
        if row.key is None or row.key in tries or row.key in ended:
            continue
        if records.done(row.key) is not None:
            ended.add(row.key)
            continue
        tries[row.key] = (records.failed(row.key) or {"tries": 0})["tries"]
        if tries[row.key] <= retries:
            waiting.append((row.key, row))
    before, made, failed, total = len(ended), 0, 0, len(waiting)
    running: dict[str, Planned] = {}
    while waiting or running:
        progress(f"rows ({failed} failed)" if failed else "rows", (made + failed) / total)
        while waiting and len(running) < pool.capacity:
            key, row = waiting.popleft()
            running[key] = row
            pool.start(_task(row, records, versions) | {"limit": limit})
        answered = pool.answer(_LOOK)
        if answered is None:
            continue
        task, answer = answered
        key = task["key"]
        row = running.pop(key)
        if "failed" not in answer:
            made += 1
            continue
        tries[key] += 1
        records.keep_failed(key, tries[key], answer["failed"])
        if tries[key] <= retries:
            waiting.append((key, row))
        else:
            failed += 1
    return before, made


def _task(row: Planned, records: Records, versions: object) -> Task:
    return {
        "key": row.key,
        "arguments": json.loads(row.content),
        "working_folder": os.getcwd(),
        "folder": str(records.folder.absolute()),
        "versions": versions,
    }
