# SPDX-License-Identifier: GPL-3.0-or-later
"""The rows of a batch: each is a command line, from a line of JSON or from a file that a pattern matches."""

import glob
import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from ..errors import SettingError, quote_value
from ..files.declared import DeclaredFile
from ..validation import are_frames

# Keys of a row that are not flags: the command, its positional argument, and the number of frames per chunk.
_COMMAND, _INPUT, _CHUNK = "command", "input", "chunk"
_T = TypeVar("_T")


@dataclass(frozen=True)
class Row:
    """A command after parsing.

    Attributes
    ----------
    arguments : the command line, its command first
    options : the value of every flag, ready for JSON
    files : all that are read and written, except links of a .blend file
    """

    arguments: tuple[str, ...]
    options: dict[str, Any]
    files: tuple[DeclaredFile, ...]

    @property
    def label(self) -> str:
        """Its command, input and frames, for people."""
        name = Path(str(self.options.get("input") or "")).name
        frames = self.options.get("frames")
        return " ".join([self.arguments[0], name, *([f"{frames[0]}-{frames[1]}"] if frames else [])])


def read_rows(jobs: str, shared: Sequence[str] = ()) -> Iterator[list[str] | SettingError]:
    """The command lines of a batch, and a :class:`SettingError` for each row that is not valid.

    Raises SettingError for a missing file, or a pattern without matches or command.

    Parameters
    ----------
    jobs : path of a JSON Lines file, or a pattern such as "meshes/*.obj"
    shared : for a pattern, the command and its flags for each matching file, with ``{stem}`` for its name without
        suffix; empty for a JSON Lines file
    """
    if shared:
        return _match_folder(jobs, list(shared))
    path = Path(jobs)
    if not path.is_file():
        raise SettingError(
            f"{jobs}: no such file of rows; a pattern needs its command after two dashes: "
            f"synch batch '{jobs}' -- stripes --render 'out/{{stem}}.png'"
        )
    return _lines(path)


def _match_folder(pattern: str, shared: list[str]) -> Iterator[list[str]]:
    if shared[0].startswith("-"):
        raise SettingError(f"{shared[0]} stands where a command is needed: write -- stripes --spacing 0.05")
    paths = sorted(path for path in glob.glob(pattern, recursive=True) if Path(path).is_file())
    if not paths:
        raise SettingError(f"{pattern}: no file matches, quote the pattern so that the shell leaves it alone")
    command, *flags = shared
    for path in paths:
        yield [command, path, *(flag.replace("{stem}", Path(path).stem) for flag in flags)]


def _lines(path: Path) -> Iterator[list[str] | SettingError]:
    """Rows of a file with one JSON object a line; in place of a row that cannot be read, its error."""
    with path.open("rb") as file:
        for number, line in enumerate(file, 1):
            if not line.strip():
                continue
            try:
                yield from _from_line(_decode_row(line))
            except SettingError as error:
                yield SettingError(f"{path}, line {number}: {error}")


def _decode_row(line: bytes) -> str:
    try:
        return line.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise SettingError(f"this is not UTF-8 ({error}): save the file as UTF-8") from None


def _from_line(line: str) -> Iterator[list[str]]:
    """The command lines of a row in JSON, one for each chunk of frames."""
    try:
        row = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise SettingError(f"this is not JSON ({error}): write one object a line") from None
    if not isinstance(row, dict) or not isinstance(row.get(_COMMAND), str):
        raise SettingError('this is not a row: write {"command": "stripes", "input": "mesh.obj", "spacing": 0.05}')
    for part in _ranges(row):
        yield _arguments(part)


def _ranges(row: dict[str, Any]) -> list[dict[str, Any]]:
    """A row for each chunk of frames; the row itself without a chunk."""
    if _CHUNK not in row:
        return [row]
    row = dict(row)
    chunk, frames = row.pop(_CHUNK), row.get("frames")
    is_range = isinstance(frames, list) and len(frames) == 2 and are_frames(*frames)
    if not isinstance(frames, list) or not is_range or type(chunk) is not int or chunk < 1:
        raise SettingError(
            f"the frames are {quote_value(frames)}, the chunk {quote_value(chunk)}: "
            'write "frames": [1, 240], "chunk": 60'
        )
    if row[_COMMAND] == "animate" and not row.get("spacing") and frames[1] - frames[0] >= chunk:
        raise SettingError("each chunk would find a spacing of its own: give one")
    parts = []
    for first in range(frames[0], frames[1] + 1, chunk):
        last = min(first + chunk - 1, frames[1])
        names = {"{first}": f"{first:04d}", "{last}": f"{last:04d}"}
        parts.append({key: _fill_names(value, names) for key, value in row.items()} | {"frames": [first, last]})
    return parts


def _fill_names(value: Any, names: dict[str, str]) -> Any:
    if isinstance(value, str):
        for name, text in names.items():
            value = value.replace(name, text)
    return value


def _arguments(row: dict[str, Any]) -> list[str]:
    """The command line of a row: a flag for each key whose value is not false or null."""
    given: list[str] = []
    stem = Path(str(row.get(_INPUT) or "")).stem
    for key, value in row.items():
        if key in (_COMMAND, _INPUT) or value is None or value is False:
            continue
        flag = f"--{key.replace('_', '-')}"
        values = value if isinstance(value, list) else [value]
        if any(isinstance(item, dict | list) for item in values):
            raise SettingError(f"{key} is {quote_value(value)}: write a text, a number, true, or a list of these")
        texts = [_fill_names(str(item), {"{stem}": stem}) for item in values if item is not True]
        given += [f"{flag}={texts[0]}"] if len(texts) == 1 else [flag, *texts]
    named = [str(row[_INPUT])] if row.get(_INPUT) else []
    return [row[_COMMAND], *named, *given]


class Keys:
    """Keys of rows, equal if command, options, contents of inputs, and versions of all programs are equal."""

    def __init__(self, versions: object) -> None:
        self._versions = versions
        self._digests: dict[str, str | None] = {}

    def of(self, row: Row) -> str:
        """32 hexadecimal digits."""
        contents = {file.path: self._digest(file.path) for file in row.files if not file.is_written}
        text = json.dumps([row.arguments[0], row.options, contents, self._versions], sort_keys=True)
        return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()[:32]

    def _digest(self, path: str) -> str | None:
        """Digest of a file, which is read once; None if it cannot be read, which the row itself will report."""
        if path not in self._digests:
            try:
                with open(path, "rb") as file:
                    self._digests[path] = hashlib.file_digest(file, "sha256").hexdigest()
            except (OSError, ValueError):
                self._digests[path] = None
        return self._digests[path]


def share_of(rows: Sequence[_T], text: str) -> Sequence[_T]:
    """The contiguous part "K/N" of a sequence, K from 1 on; SettingError for other texts."""
    part, _, parts = text.partition("/")
    if not (part.isdecimal() and parts.isdecimal() and 1 <= int(part) <= int(parts)):
        raise SettingError(f"the share is {quote_value(text)}: write 3/40 for the third of forty")
    ends = [len(rows) * number // int(parts) for number in (int(part) - 1, int(part))]
    return rows[ends[0] : ends[1]]
