# SPDX-License-Identifier: GPL-3.0-or-later
"""What is done of a batch: a small file for each row, by its key, which any process on any machine may look up."""

import json
from pathlib import Path

from ..errors import SettingError, one_line
from ..files.json_text import json_text
from ..files.whole import write_text

# Types of the optional figures of a record, and of the entries that it must have.
NUMBERS = "energy", "lower_bound", "gap", "nodes", "disclinations", "dislocations", "warnings", "memory_mb"
_DONE = {"files": dict, "seconds": float | int}
_FAILED = {"tries": int, "reason": str}


class Records:
    """The records in a folder.

    A row that is done has a record in ``done``, written by the process that did it once all its files are there; one
    that has failed has one in ``failed``, written by the batch, with how often it was tried and why it failed last.

    Parameters
    ----------
    folder : of the batch
    """

    def __init__(self, folder):
        self.folder = Path(folder)

    def done(self, key):
        """The record of a row that is done and whose files are as they were written, or None."""
        record = _read(self._path("done", key), _DONE)
        return record if record is not None and all(map(_is_there, record["files"].items())) else None

    def failed(self, key):
        """The record of a row that has failed, or None."""
        return _read(self._path("failed", key), _FAILED)

    def keep_done(self, key, record, files):
        """Keep that a row is done; returns the record with the sizes of its files, relative to the working folder."""
        record = record | {"files": {str(path): Path(path).stat().st_size for path in files}}
        self._write("done", key, record)
        self._path("failed", key).unlink(missing_ok=True)
        return record

    def keep_failed(self, key, tries, reason):
        """Keep how often a row was tried, and why it failed last."""
        self._write("failed", key, {"tries": tries, "reason": one_line(reason)})

    def thumbnail(self, key):
        """Where the small picture of a row goes."""
        return self.folder / "thumbnails" / f"{key}.jpg"

    def make_folders(self):
        """Make the folders that records and pictures go to.

        Raises
        ------
        SettingError
            where they cannot be made
        """
        try:
            for kind in ("done", "failed"):
                for number in range(256):
                    (self.folder / kind / f"{number:02x}").mkdir(parents=True, exist_ok=True)
            (self.folder / "thumbnails").mkdir(exist_ok=True)
        except OSError as error:
            raise SettingError(f"{self.folder}: cannot be made ({error.strerror}): name another --folder") from None

    def _path(self, kind, key):
        return self.folder / kind / key[:2] / f"{key}.json"

    def _write(self, kind, key, record):
        write_text(self._path(kind, key), json_text(record) + "\n")


def _read(path, kinds):
    """A record whose entries have the kinds that they should; None where it is missing or spoiled."""
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None
    if not isinstance(record, dict) or not kinds.keys() <= record.keys():
        return None
    kinds = dict.fromkeys(NUMBERS, float | int | None) | kinds
    return record if all(isinstance(record[name], kind) for name, kind in kinds.items() if name in record) else None


def _is_there(named):
    path, size = named
    try:
        return Path(path).stat().st_size == size
    except (OSError, ValueError):  # it is gone, or the record has a name that no file can have
        return False
