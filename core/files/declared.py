# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that a command declares before it runs: whether they clash, and the folders that they need."""

import os
import re
import stat
import sys
import unicodedata
from collections.abc import Hashable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from ..errors import SettingError, quote_value
from .whole import unwritten

# Names of a numbered set such as part_000.stl: what stands before and behind the number.
_NUMBERED = re.compile(r"(.*)_\d{3,}(\.[^.]*)", re.DOTALL)


@dataclass(frozen=True)
class DeclaredFile:
    """A file that a command reads or writes.

    Attributes
    ----------
    path : of the file
    flag : what names it: "the input", "--report"
    is_written : False for a file that is read, whose content counts
    is_numbered : the path part.stl stands for part_000.stl, part_001.stl ..., however many there will be
    """

    path: str
    flag: str
    is_written: bool = False
    is_numbered: bool = False


class FileOwners:
    """The files that were declared so far, and who reads or writes them.

    Files are equal as the file system has them: links, ``..`` and, where it is ignored, case make no difference.
    """

    def __init__(self) -> None:
        # Hashes are kept in place of the places themselves, since a batch may declare millions of files.
        self._readers: dict[int, int] = {}
        self._writers: dict[int, int] = {}

    def add(self, file: DeclaredFile, owner: int) -> tuple[int, bool] | None:
        """Add a file; where it clashes, another owner of it and whether that one writes it.

        An output clashes with the inputs and outputs of other owners, an input with their outputs.
        """
        own, others = _keys(file)
        for owners, writes in ((self._writers, True), (self._readers, False)):
            if not (writes or file.is_written):
                continue
            for key in others:
                if owners.get(key, owner) != owner:
                    return owners[key], writes
        kept = self._writers if file.is_written else self._readers
        for key in own:
            kept.setdefault(key, owner)
        return None


def check_clashes(files: Iterable[DeclaredFile]) -> None:
    """Refuse files of one command that would overwrite one another.

    Raises SettingError naming the two.
    """
    owners, listed = FileOwners(), list(files)
    for number, file in enumerate(listed):
        found = owners.add(file, number)
        if found is not None:
            other = listed[found[0]]
            raise SettingError(f"{file.path}: {file.flag} and {other.flag} are the same file, name another one")


def check_inputs(files: Iterable[DeclaredFile]) -> None:
    """Refuse devices and pipes as inputs, which may never end, and names that the system refuses.

    Missing files are reported where they are read.

    Raises SettingError naming the file.
    """
    for file in files:
        if file.is_written:
            continue
        try:
            mode = os.stat(file.path).st_mode
        except (FileNotFoundError, NotADirectoryError):
            continue
        except OSError as error:
            raise SettingError(
                f"{quote_value(file.path)}: {file.flag} cannot be read: {error.strerror or error}"
            ) from None
        if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):
            raise SettingError(f"{file.path}: {file.flag} is a device or a pipe: name a file")


@contextmanager
def make_folders(files: Iterable[DeclaredFile]) -> Iterator[None]:
    """Make the missing folders of outputs; those that are still empty go again where the work inside fails.

    Raises SettingError naming a file whose folder cannot be made.
    """
    made: list[Path] = []
    try:
        for file in files:
            if file.is_written:
                _make_folder(file, made)
        yield
    except BaseException:
        for folder in reversed(made):
            with suppress(OSError):  # it holds a file
                folder.rmdir()
        raise


def _make_folder(file: DeclaredFile, made: list[Path]) -> None:
    folder = Path(os.path.realpath(file.path)).parent
    missing = [parent for parent in (folder, *folder.parents) if not os.path.isdir(parent)]
    for parent in reversed(missing):
        try:
            parent.mkdir()
            made.append(parent)
        except OSError as error:
            if not os.path.isdir(parent):  # else another process was faster
                raise unwritten(file.path, f"no folder can be made: {error.strerror or error}") from None


def _keys(file: DeclaredFile) -> tuple[list[int], list[int]]:
    """Hashes of what a file is, and of what it clashes with.

    A file clashes with its place and with the numbered set that its name belongs to, a set with the same set, its
    members, and the places of those that are there already: they may be links to other files.
    """
    folder, name = os.path.split(file.path)
    folder = os.path.realpath(folder)
    if file.is_numbered:
        stem, suffix = os.path.splitext(name)
        group = _names_below(folder, [stem, suffix])
        own: list[Hashable] = [("set", group)]
        others: list[Hashable] = [*own, ("member", group), *_present(folder, stem, suffix)]
    else:
        place, found = _place(file.path), _NUMBERED.fullmatch(name)
        groups = [] if found is None else [_names_below(folder, list(found.groups()))]
        own = [place, *(("member", group) for group in groups)]
        others = [place, *(("set", group) for group in groups)]
    return list(map(hash, own)), list(map(hash, others))


def _present(folder: str, stem: str, suffix: str) -> list[tuple[Hashable, ...]]:
    """Places of the files of a numbered set that are there."""
    pattern = re.compile(rf"{re.escape(stem)}_\d{{3,}}{re.escape(suffix)}", re.IGNORECASE)
    try:
        return [_place(os.path.join(folder, name)) for name in os.listdir(folder) if pattern.fullmatch(name)]
    except OSError:
        return []


def _place(path: str) -> tuple[Hashable, ...]:
    """A key that all names of a file share: its inode if it exists, otherwise its resolved path."""
    with suppress(OSError):
        found = os.stat(path)
        return found.st_dev, found.st_ino
    folder, name = os.path.split(os.path.realpath(path))
    return _names_below(folder, [name])


def _names_below(folder: str, names: list[str]) -> tuple[Hashable, ...]:
    """The inode of the nearest folder that exists, and the path below it."""
    while not os.path.isdir(folder) and os.path.dirname(folder) != folder:
        folder, above = os.path.split(folder)
        names = [above, *names]
    try:
        found = os.stat(folder)
    except OSError:
        return folder, *names
    if _ignores_case(folder):
        names = [unicodedata.normalize("NFC", name).casefold() for name in names]
    return found.st_dev, found.st_ino, *names


@lru_cache(maxsize=1024)
def _ignores_case(folder: str) -> bool:
    """Whether A and a are one name in a folder, judged by its own name."""
    above, name = os.path.split(folder)
    if name.swapcase() == name:
        return sys.platform in ("win32", "darwin")
    try:
        return os.path.samefile(folder, os.path.join(above, name.swapcase()))
    except OSError:
        return False
