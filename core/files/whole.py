# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that are written whole or not at all: an older file stays until the new one is complete."""

import os
import shutil
import stat
import tempfile
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from functools import partial
from pathlib import Path

from ..errors import WriteError
from ..interrupts import raise_interrupts
from .leftovers import own_name, sweep

# A path as given, the file that it leads to, and the complete one beside it.
_Waiting = tuple[str | Path, Path, Path]
_Check = Callable[[Path], bool]
_IMAGE_ENDS = {".png": b"IEND\xaeB`\x82", ".jpg": b"\xff\xd9", ".jpeg": b"\xff\xd9"}


@contextmanager
def write_whole(path: str | Path, is_whole: _Check | None = None) -> Iterator[Path]:
    """Write a file under a temporary name with the same suffix, and move it to its place at the end.

    Yields the path to write to. Two processes that write the same file leave one of the two, whole. A device is written
    to directly.

    Parameters
    ----------
    path : where the file goes; links are followed
    is_whole : checks what was written, since exporters report success on a full disk; not for devices

    Raises WriteError where the file cannot be written, or only a part of it arrived; the older file stays.
    """
    with write_together() as written, written(path, is_whole) as made:
        yield made


@contextmanager
def write_together() -> Iterator[Callable[..., AbstractContextManager[Path]]]:
    """Write several files, which move to their places once all are complete, or none does.

    Yields a function that writes one of them, with the arguments and errors of :func:`write_whole`.
    """
    waiting: list[_Waiting] = []
    try:
        yield partial(_write_beside, waiting)
        _take_places(waiting)
    finally:
        for _, _, made in waiting:
            made.unlink(missing_ok=True)


@contextmanager
def _write_beside(waiting: list[_Waiting], path: str | Path, is_whole: _Check | None = None) -> Iterator[Path]:
    """Write a file beside its place, and add it to the waiting ones."""
    target = Path(path).resolve()
    if target.is_dir():
        raise unwritten(path, "this is a folder")
    is_device = target.exists() and not target.is_file()
    if is_device and is_whole is not None:
        raise unwritten(path, "this is not a file, so it cannot be checked for completeness")
    made = Path(path).absolute() if is_device else place_beside(target)
    try:
        if is_device:
            with _opened_pipe(made):
                yield made
            return
        yield made
        if not made.is_file() or not made.stat().st_size:
            raise unwritten(path, "nothing arrived")
        if is_whole is not None and not is_whole(made):
            raise unwritten(path, "only a part arrived")
        with made.open("r+b") as file:  # everything is on the disk before an older file goes
            os.fsync(file.fileno())
    except BaseException as error:
        if not is_device:
            with suppress(OSError):
                made.unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise unwritten(path, error.strerror or error) from None
        raise
    waiting.append((path, target, made))


@contextmanager
def _opened_pipe(path: Path) -> Iterator[None]:
    """Keep a named pipe open, so that its reader does not see its end; OSError if it has no reader, instead of waiting
    for one. Other devices are left alone."""
    if not stat.S_ISFIFO(path.stat().st_mode):
        yield
        return
    pipe = os.open(path, os.O_WRONLY | os.O_NONBLOCK)
    try:
        yield
    finally:
        os.close(pipe)


def _take_places(waiting: list[_Waiting]) -> None:
    """Move complete files to their places, or restore the older ones if that fails; none where a signal has come."""
    raise_interrupts()
    with ExitStack() as undo:
        for number, (path, target, made) in enumerate(waiting, 1):
            try:
                if target.exists():
                    shutil.copymode(target, made)
                if number < len(waiting):  # the last one is replaced or not
                    undo.enter_context(_restore_on_failure(target))
                os.replace(made, target)
            except OSError as error:
                raise unwritten(path, error.strerror or error) from None


@contextmanager
def _restore_on_failure(target: Path) -> Iterator[None]:
    """Restore a file if the work inside fails."""
    kept, was_there = place_beside(target), True
    try:
        os.link(target, kept)
    except FileNotFoundError:
        was_there = False
    except OSError:  # the file system has no links
        shutil.copy2(target, kept)
    try:
        yield
    except BaseException:
        with suppress(OSError):
            os.replace(kept, target) if was_there else target.unlink()
        raise
    finally:
        kept.unlink(missing_ok=True)


def write_text(path: str | Path, text: str) -> None:
    """Write a text file whole or not at all; errors as :func:`write_whole`."""
    with write_whole(path) as made:
        made.write_text(text, encoding="utf-8")


def unwritten(path: str | Path, reason: object) -> WriteError:
    """The error of a file that could not be written."""
    return WriteError(f"{path}: cannot be written ({reason}): make room, or choose another place")


def check_writable(path: str | Path) -> None:
    """Check that a file can be made at a place, before the work whose result it gets; errors as :func:`write_whole`."""
    target = Path(path).resolve()
    if target.exists() and not target.is_file():
        return
    try:
        # Without a name, where the system can: none is left if the process is killed.
        tempfile.TemporaryFile(dir=target.parent).close()
    except OSError as error:
        raise unwritten(path, error.strerror or error) from None


def place_beside(target: Path) -> Path:
    """A path of this process alone, in the same folder and with the same suffix; older leftovers there are removed."""
    sweep(target.parent)
    return target.with_name(own_name(target.suffix))


def is_whole_image(path: str | Path) -> bool:
    """Whether an image file ends as files of its kind do; the other kinds raise errors while they are written."""
    end = _IMAGE_ENDS.get(Path(path).suffix.lower(), b"")
    return Path(path).read_bytes().endswith(end)
