# SPDX-License-Identifier: GPL-3.0-or-later
"""Records of a batch: a small file for each finished row, by its key, which processes on any machine can read."""

import json
from collections.abc import Iterable
from os import PathLike
from pathlib import Path
from types import UnionType
from typing import Any

from ..errors import SettingError, one_line
from ..files.json_text import json_text
from ..files.whole import write_text

# Optional numbers of a record, and types of the entries that it must have.
NUMBERS = "energy", "lower_bound", "gap", "nodes", "disclinations", "dislocations", "warnings", "memory_mb"
_DONE: dict[str, type | UnionType] = {"files": dict, "seconds": float | int}
_FAILED: dict[str, type | UnionType] = {"tries": int, "reason": str}

# A JSON object.
Record = dict[str, Any]


class Records:
    """The records in the folder of a batch.

    A row that is done has a record in ``done``, written by the process that did it after all its files; a row that has
    failed has one in ``failed``, written by the batch, with the number of tries and the last reason.
    """

    def __init__(self, folder: str | PathLike[str]) -> None:
        self.folder = Path(folder)

    def done(self, key: str) -> Record | None:
        """The record of a row that is done and whose files have their sizes, or None."""
        record = _read(self._path("done", key), _DONE)
        return record if record is not None and all(map(_is_there, record["files"].items())) else None

    def failed(self, key: str) -> Record | None:
        """The record of a row that has failed, or None."""
        return _read(self._path("failed", key), _FAILED)

    def keep_done(self, key: str, record: Record, files: Iterable[str | PathLike[str]]) -> Record:
        """Store that a row is done; returns the record with the sizes of its files, relative to the working folder."""
        record = record | {"files": {str(path): Path(path).stat().st_size for path in files}}
        self._write("done", key, record)
        self._path("failed", key).unlink(missing_ok=True)
        return record

    def keep_failed(self, key: str, tries: int, reason: str) -> None:
        """Store the number of tries of a row, and the reason of its last failure."""
        self._write("failed", key, {"tries": tries, "reason": one_line(reason)})

    def thumbnail(self, key: str) -> Path:
        """Path of a row's small picture."""
        return self.folder / "thumbnails" / f"{key}.jpg"

    def make_folders(self) -> None:
        """Make the folders of records and pictures; SettingError if that fails."""
        try:
            for kind in ("done", "failed"):
                for number in range(256):
                    (self.folder / kind / f"{number:02x}").mkdir(parents=True, exist_ok=True)
            (self.folder / "thumbnails").mkdir(exist_ok=True)
        except OSError as error:
            raise SettingError(f"{self.folder}: cannot be made ({error.strerror}): name another --folder") from None

    def _path(self, kind: str, key: str) -> Path:
        return self.folder / kind / key[:2] / f"{key}.json"

    def _write(self, kind: str, key: str, record: Record) -> None:
        write_text(self._path(kind, key), json_text(record) + "\n")


def _read(path: Path, kinds: dict[str, type | UnionType]) -> Record | None:
    """A record whose entries have the right types; None if it is missing or damaged."""
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None
    if not isinstance(record, dict) or not kinds.keys() <= record.keys():
        return None
    kinds = dict.fromkeys(NUMBERS, float | int | None) | kinds
    return record if all(isinstance(record[name], kind) for name, kind in kinds.items() if name in record) else None


def _is_there(named: tuple[str, int]) -> bool:
    path, size = named
    try:
        return Path(path).stat().st_size == size
    except (OSError, ValueError):  # it is missing, or its name is impossible
        return False
