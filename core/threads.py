# SPDX-License-Identifier: GPL-3.0-or-later
"""Threads: the only module that imports and starts them.

No thread runs beside Blender while somebody works in it. Threads run

- in a child process without Blender, which solves for the window (``core.process.child``);
- in a Blender that is blocked by a solve of a script, the redo panel or the command line: they share its work and are
  joined before the call returns. Only a factorization, which cannot be interrupted, outlives a call that a callback or
  Ctrl-C stops; the command line then ends its process;
- in the processes of a batch (``core.batch``), which have no window: one thread of the parent waits for each child, and
  all are joined before it returns; in each child a thread reads the requests, so that it ends with its pipe.

They run NumPy, SciPy and pipes: ``core`` does not know Blender.
"""

from collections.abc import Callable
from concurrent.futures import FIRST_EXCEPTION, Future, ThreadPoolExecutor, wait
from threading import Event, Lock, Thread, local

__all__ = [
    "FIRST_EXCEPTION",
    "Event",
    "Future",
    "Lock",
    "Thread",
    "ThreadPoolExecutor",
    "local",
    "start_thread",
    "wait",
]


def start_thread(
    work: Callable[..., object], *arguments: object, is_daemon: bool = True, name: str | None = None
) -> Thread:
    """Start a thread for ``work(*arguments)``; a process ends without waiting for its daemons."""
    thread = Thread(target=work, args=arguments, daemon=is_daemon, name=name)
    thread.start()
    return thread
