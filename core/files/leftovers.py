# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of temporary files that identify their process, so that another can remove those of a killed one."""

import os
import platform
import re
import secrets
import shutil
import sys
import zlib
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path

# The machine, the process, its start, and a random part.
_NAME = re.compile(r"\.synch-([0-9a-f]{8})-(\d+)-(\d+)-[0-9a-f]{16}")
_SINCE_UNKNOWN = "0"
# Windows' exit code of a process that runs, and the right to ask for it.
_STILL_ACTIVE, _QUERY_LIMITED = 259, 0x1000


def own_name(suffix: str = "") -> str:
    """A unique file name that identifies this process."""
    return f".synch-{_machine()}-{os.getpid()}-{_since(os.getpid())}-{secrets.token_hex(8)}{suffix}"


class _Swept:
    """The folders that this process has swept, which are all in which it makes files with such names."""

    def __init__(self) -> None:
        self.folders: set[Path] = set()

    def sweep(self, folder: Path) -> None:
        """Remove leftovers of killed processes of this user and machine from a folder, once for each folder."""
        if folder not in self.folders:
            self.folders.add(folder)
            _remove_all(folder, _is_left_behind)

    def remove_own(self) -> None:
        """Remove what this process has begun in these folders, before it ends in the middle of writing."""
        own = own_name().rpartition("-")[0]
        for folder in tuple(self.folders):
            _remove_all(folder, lambda entry: entry.name.startswith(own))


swept = _Swept()
sweep, remove_own = swept.sweep, swept.remove_own


def _remove_all(folder: Path, is_chosen: Callable[[os.DirEntry[str]], bool]) -> None:
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if is_chosen(entry):
                _remove(entry)


def mark(folder: Path) -> None:
    """Mark a folder of another program as this process's, by a file in it; see :func:`sweep_marked`."""
    with suppress(OSError):
        (folder / own_name()).touch()


def sweep_marked(folder: Path, prefix: str) -> None:
    """Remove the subfolders with a prefix that killed processes have marked."""
    _remove_all(
        folder,
        lambda entry: entry.name.startswith(prefix) and entry.is_dir(follow_symlinks=False) and _has_ended_mark(entry),
    )


def _has_ended_mark(folder: os.DirEntry[str]) -> bool:
    with suppress(OSError), os.scandir(folder) as entries:
        return any(map(_is_left_behind, entries))
    return False


def _is_left_behind(entry: os.DirEntry[str]) -> bool:
    """Whether a file or folder is of an ended process of this user on this machine."""
    found = _NAME.match(entry.name)
    if found is None or found[1] != _machine():
        return False
    try:
        is_own = not hasattr(os, "getuid") or entry.stat(follow_symlinks=False).st_uid == os.getuid()
    except OSError:  # another process was faster
        return False
    return is_own and _since(int(found[2])) != found[3]


def _remove(entry: os.DirEntry[str]) -> None:
    with suppress(OSError):
        if entry.is_dir(follow_symlinks=False):
            shutil.rmtree(entry, ignore_errors=True)
        else:
            os.unlink(entry)


@cache
def _machine() -> str:
    """Eight digits that identify where process numbers are unique: a machine since its start, or a container."""
    try:
        identity = Path("/proc/sys/kernel/random/boot_id").read_text() + os.readlink("/proc/self/ns/pid")
    except OSError:  # not Linux
        identity = platform.node()
    return f"{zlib.crc32(identity.encode()):08x}"


def _since(process: int) -> str | None:
    """The start of a process, "0" where it is unknown; None if the process has ended."""
    if sys.platform == "win32":
        return _SINCE_UNKNOWN if _runs_on_windows(process) else None
    try:
        text = Path(f"/proc/{process}/stat").read_text(errors="replace")
    except OSError:
        if Path("/proc/self/stat").exists():
            return None
    else:
        state, *more = text.rpartition(")")[2].split()
        return None if state in "ZX" else more[18]
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return None
    except (OSError, OverflowError):  # another user's
        pass
    return _SINCE_UNKNOWN


def _runs_on_windows(process: int) -> bool:
    import ctypes

    kernel = ctypes.windll.kernel32  # type: ignore[attr-defined]
    handle = kernel.OpenProcess(_QUERY_LIMITED, False, process)
    if not handle:
        return False
    code = ctypes.c_ulong()
    answered = kernel.GetExitCodeProcess(handle, ctypes.byref(code))
    kernel.CloseHandle(handle)
    return not answered or code.value == _STILL_ACTIVE
