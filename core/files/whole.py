# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that are written whole or not at all: what was there before stays until its successor is complete."""

import os
import secrets
import shutil
from contextlib import contextmanager, suppress
from pathlib import Path

from ..errors import SettingError


@contextmanager
def written_whole(path, is_whole=None):
    """Write a file beside its place, under a name of its own with the same suffix, and put it there at the end.

    Yields the path to write to. Two processes that write the same file leave one of the two, whole; a device is
    written to as it is, unless what arrives has to be looked at.

    Parameters
    ----------
    path : where the file goes; a link leads to what it names
    is_whole : callable(path) -> bool, optional; looks at what was written, since exporters report success where the
        disk was full

    Raises
    ------
    SettingError
        where the file cannot be written, or nothing or only a part of it arrived; nothing has changed then
    """
    target = Path(path).resolve()
    if target.is_dir():
        raise unwritten(path, "this is a folder")
    is_device = target.exists() and not target.is_file()
    if is_device and is_whole is not None:
        raise unwritten(path, "this is no file, and nobody could tell whether all of it arrived")
    made = Path(path).absolute() if is_device else _beside(target)
    try:
        try:
            yield made
            if is_device:
                return
            if not made.is_file() or not made.stat().st_size:
                raise unwritten(path, "nothing arrived")
            if is_whole is not None and not is_whole(made):
                raise unwritten(path, "only a part arrived")
            _finish(made, target)
        finally:
            if not is_device:
                with suppress(OSError):
                    made.unlink(missing_ok=True)
    except OSError as error:
        raise unwritten(path, error.strerror or error) from None


def write_text(path, text):
    """Write a text file whole or not at all; errors as :func:`written_whole`."""
    with written_whole(path) as made:
        made.write_text(text, encoding="utf-8")


def unwritten(path, reason):
    """The error of a file that could not be written."""
    return SettingError(f"{path}: cannot be written ({reason}): make room, or choose another place")


def check_writable(path):
    """Refuse a place where no file can be made, before there is anything to write; errors as :func:`written_whole`."""
    target = Path(path).resolve()
    if target.exists() and not target.is_file():
        return
    probe = _beside(target)
    try:
        probe.touch(exist_ok=False)
        probe.unlink()
    except OSError as error:
        raise unwritten(path, error.strerror or error) from None


def _beside(target):
    """A name that nobody else takes, in the same folder and with the same suffix."""
    return target.with_name(f".synch-{secrets.token_hex(8)}{target.suffix}")


def _finish(made, target):
    """Everything is on the disk before the older file goes, whose permissions are kept."""
    with made.open("r+b") as file:
        os.fsync(file.fileno())
    if target.exists():
        shutil.copymode(target, made)
    os.replace(made, target)
