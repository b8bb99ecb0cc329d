# SPDX-License-Identifier: GPL-3.0-or-later
"""How much memory this process takes, and how much it may take."""

import math
import os
import sys
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from .errors import SynchError

try:
    import resource
except ImportError:  # Windows
    resource = None  # type: ignore[assignment]

# Estimates may be too high by a third: what takes less than is left by so much is never refused.
_SURE = 0.75
# Address space that threads and allocators reserve in a solve for each byte that it takes.
RESERVED = 2.5
# Where Linux says in which control groups a process is, and where it has them, by their version: the folder, and the
# file with a group's limit.
_OWN_GROUPS = Path("/proc/self/cgroup")
_GROUPS = {True: ("/sys/fs/cgroup", "memory.max"), False: ("/sys/fs/cgroup/memory", "memory.limit_in_bytes")}


class Room(NamedTuple):
    """Memory that this process may take beyond what it has.

    Attributes
    ----------
    bytes : how much
    reserved : how much of it each byte takes that is used
    name, remedy : what it is, and how to have more
    """

    bytes: float
    reserved: float
    name: str
    remedy: str

    @property
    def usable(self):
        """Bytes that can be used."""
        return self.bytes / self.reserved


def room(reserved=RESERVED):
    """The :class:`Room` that ends first: of the machine, of the container, or of address space, of which each byte that
    is used takes ``reserved``."""
    used = used_bytes()
    rooms = (
        Room(machine_bytes() - used, 1.0, "memory", "use a machine with more"),
        Room(_container_bytes() - used, 1.0, "the container's memory", "allow it more"),
        Room(_space_left(), reserved, "address space", "raise its limit (ulimit -v)"),
    )
    return min(rooms, key=lambda left: left.usable)


def check_memory(needed, what, reserved=RESERVED):
    """Refuse work that takes more memory than there is, before it begins.

    Parameters
    ----------
    needed : bytes at its peak, beyond what this process has now; it may be a third too high
    what : begins the message, such as "a solve of 9 phases"
    reserved : address space for each of them

    Raises
    ------
    SynchError
        naming what is needed, what is there, and the remedy
    """
    left = room(reserved)
    if _SURE * needed > left.usable:
        needs, has = (f"{max(size, 0) / 2**30:.2g} GB" for size in (needed * left.reserved, left.bytes))
        raise SynchError(
            f"{what} takes about {needs} of {left.name} and {has} are left: use a coarser mesh, or {left.remedy}"
        )


@contextmanager
def at_most(size):
    """Let this process take at most so many bytes of address space more inside, where the system holds it to that.

    A library that a damaged file leads astray ends with an error then, not with the machine's memory.
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


def _space_left():
    """Bytes of address space that this process may add."""
    limit = resource.getrlimit(resource.RLIMIT_AS)[0] if sys.platform == "linux" else -1
    return math.inf if limit < 0 else limit - _pages(0)


def _container_bytes():
    """Bytes of the least of this process's control groups."""
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
            except OSError:  # a group that cannot be seen from inside the container
                continue
            least = min(least, int(text) if text.isdigit() else math.inf)
    return least


def _pages(column):
    """Bytes of a column of /proc/self/statm: 0 the address space, 1 the memory."""
    with open("/proc/self/statm", "rb") as file:
        return int(file.read().split()[column]) * os.sysconf("SC_PAGE_SIZE")


def used_bytes():
    """Bytes of memory that this process has now; on macOS the most it has had."""
    if sys.platform == "win32":
        return _windows_process().WorkingSetSize
    if sys.platform == "darwin":
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return _pages(1)


def peak_megabytes():
    """The most memory that this process has had, in MB."""
    if sys.platform == "win32":
        return _windows_process().PeakWorkingSetSize / 2**20
    unit = 2**20 if sys.platform == "darwin" else 2**10
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit


def machine_bytes():
    """Bytes of memory that the machine has."""
    if sys.platform == "win32":
        return _windows_machine()
    return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def _windows_process():
    import ctypes
    from ctypes import wintypes

    class Counters(ctypes.Structure):
        _fields_ = [("cb", wintypes.DWORD), ("PageFaultCount", wintypes.DWORD)] + [
            (name, ctypes.c_size_t)
            for name in (
                "PeakWorkingSetSize",
                "WorkingSetSize",
                "QuotaPeakPagedPoolUsage",
                "QuotaPagedPoolUsage",
                "QuotaPeakNonPagedPoolUsage",
                "QuotaNonPagedPoolUsage",
                "PagefileUsage",
                "PeakPagefileUsage",
            )
        ]

    counters = Counters(cb=ctypes.sizeof(Counters))
    kernel = ctypes.WinDLL("kernel32")  # type: ignore[attr-defined]
    kernel.GetCurrentProcess.restype = wintypes.HANDLE
    asked = kernel.K32GetProcessMemoryInfo
    asked.argtypes = wintypes.HANDLE, ctypes.POINTER(Counters), wintypes.DWORD
    asked(kernel.GetCurrentProcess(), ctypes.byref(counters), counters.cb)
    return counters


def _windows_machine():
    import ctypes
    from ctypes import wintypes

    class Status(ctypes.Structure):
        _fields_ = [("dwLength", wintypes.DWORD), ("dwMemoryLoad", wintypes.DWORD)] + [
            (name, ctypes.c_uint64) for name in "total free pages free_pages space free_space extended".split()
        ]

    status = Status(dwLength=ctypes.sizeof(Status))
    ctypes.WinDLL("kernel32").GlobalMemoryStatusEx(ctypes.byref(status))  # type: ignore[attr-defined]
    return status.total
