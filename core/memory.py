# SPDX-License-Identifier: GPL-3.0-or-later
"""Memory that this process uses, and how much more it may use."""

import math
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from .errors import SynchError

try:
    import resource
except ImportError:  # Windows
    resource = None  # type: ignore[assignment]

# Estimates may be too high by a third: work is refused only if this share of the estimate does not fit.
_SURE = 0.75
# Bytes of address space that threads and allocators reserve in a solve for each byte that it uses.
RESERVED = 2.5
# Linux: the list of a process's control groups; for version 2 and version 1, their folder and the file with the limit.
_OWN_GROUPS = Path("/proc/self/cgroup")
# Linux: the file of this process's figures.
_STATUS = Path("/proc/self/status")
_GROUPS = {True: ("/sys/fs/cgroup", "memory.max"), False: ("/sys/fs/cgroup/memory", "memory.limit_in_bytes")}


class Room(NamedTuple):
    """Memory that this process may still take.

    Attributes
    ----------
    bytes : what is left
    reserved : how many of them are taken by each byte that is used
    name, remedy : the kind of memory, and how to get more, for messages
    """

    bytes: float
    reserved: float
    name: str
    remedy: str

    @property
    def usable(self) -> float:
        """Number of bytes that can be used."""
        return self.bytes / self.reserved


def room(reserved: float = RESERVED) -> Room:
    """Find the tightest :class:`Room`: the machine's memory, the container's, or the address space.

    ``reserved`` is the number of bytes of address space that each used byte takes.
    """
    used = used_bytes()
    rooms = (
        Room(machine_bytes() - used, 1.0, "memory", "use a machine with more"),
        Room(_container_bytes() - used, 1.0, "the container's memory", "allow it more"),
        Room(_space_left(), reserved, "address space", "raise its limit (ulimit -v)"),
    )
    return min(rooms, key=lambda left: left.usable)


def check_memory(needed: float, what: str, reserved: float = RESERVED) -> None:
    """Refuse work that needs more memory than is left, before it begins.

    Raises SynchError naming the need, what is left, and the remedy.

    Parameters
    ----------
    needed : bytes at its peak, beyond the present use; may be a third too high
    what : begins the message, such as "a solve of 9 phases"
    reserved : bytes of address space that each used byte takes
    """
    left = room(reserved)
    if _SURE * needed > left.usable:
        needs, has = (f"{max(size, 0) / 2**30:.2g} GB" for size in (needed * left.reserved, left.bytes))
        raise SynchError(
            f"{what} takes about {needs} of {left.name} and {has} are left: use a coarser mesh, or {left.remedy}"
        )


@contextmanager
def at_most(size: float) -> Iterator[None]:
    """Context in which this process may add at most ``size`` bytes of address space (on Linux; elsewhere no limit).

    A library that reads a damaged file then ends with an error before it uses up the machine's memory.
    """
    if sys.platform != "linux":
        yield
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    wanted = _pages(0) + int(size)
    resource.setrlimit(resource.RLIMIT_AS, (wanted if soft < 0 else min(soft, wanted), hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def _space_left() -> float:
    """Compute the bytes of address space that this process may add."""
    limit = resource.getrlimit(resource.RLIMIT_AS)[0] if sys.platform == "linux" else -1
    return math.inf if limit < 0 else limit - _pages(0)


@cache  # a solve asks some twenty times
def _container_bytes() -> float:
    """Read the smallest limit of this process's control groups, bytes, once."""
    try:
        lines = _OWN_GROUPS.read_text().splitlines()
    except OSError:
        return math.inf
    least = math.inf
    for line in lines:
        _, kinds, path = line.split(":", 2)
        if kinds and "memory" not in kinds.split(","):
            continue
        folder, name = _GROUPS[not kinds]
        for group in (PurePosixPath(path), *PurePosixPath(path).parents):
            try:
                text = Path(f"{folder}{group}", name).read_text().strip()
            except OSError:  # a group that is hidden from inside the container
                continue
            least = min(least, int(text) if text.isdigit() else math.inf)
    return least


def _pages(column: int) -> int:
    """Read a column of /proc/self/statm in bytes: 0 is the address space, 1 the memory."""
    with open("/proc/self/statm", "rb") as file:
        return int(file.read().split()[column]) * os.sysconf("SC_PAGE_SIZE")


def used_bytes() -> int:
    """Measure the memory of this process, bytes; on macOS its peak."""
    if sys.platform == "win32":
        return _windows_process()[0]
    if sys.platform == "darwin":
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return _pages(1)


def peak_megabytes() -> float:
    """Measure the peak memory of this process, MB."""
    if sys.platform == "win32":
        return _windows_process()[1] / 2**20
    if sys.platform == "darwin":
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    # On Linux, ru_maxrss is at least what the parent had when it started this process; some containers have no VmHWM.
    with suppress(OSError):
        for line in _STATUS.read_text().splitlines():
            if line.startswith("VmHWM:"):
                return float(line.split()[1]) / 2**10
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**10


def machine_bytes() -> int:
    """Measure the memory of the machine, bytes."""
    if sys.platform == "win32":
        return _windows_machine()
    return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def _windows_process() -> tuple[int, int]:
    """Measure the memory of this process and its peak, bytes."""
    import ctypes
    from ctypes import wintypes

    class Counters(ctypes.Structure):
        _fields_ = [("cb", wintypes.DWORD), ("PageFaultCount", wintypes.DWORD)] + [
            (name, ctypes.c_size_t)
            for name in "peak now paged_peak paged nonpaged_peak nonpaged page_file page_file_peak".split()
        ]

    counters = Counters(cb=ctypes.sizeof(Counters))
    kernel = ctypes.WinDLL("kernel32")  # type: ignore[attr-defined]
    kernel.GetCurrentProcess.restype = wintypes.HANDLE
    get_info = kernel.K32GetProcessMemoryInfo
    get_info.argtypes = wintypes.HANDLE, ctypes.POINTER(Counters), wintypes.DWORD
    get_info(kernel.GetCurrentProcess(), ctypes.byref(counters), counters.cb)
    return counters.now, counters.peak


def _windows_machine() -> int:
    import ctypes
    from ctypes import wintypes

    class Status(ctypes.Structure):
        _fields_ = [("dwLength", wintypes.DWORD), ("dwMemoryLoad", wintypes.DWORD)] + [
            (name, ctypes.c_uint64) for name in "total free pages free_pages space free_space extended".split()
        ]

    status = Status(dwLength=ctypes.sizeof(Status))
    ctypes.WinDLL("kernel32").GlobalMemoryStatusEx(ctypes.byref(status))  # type: ignore[attr-defined]
    return int(status.total)
