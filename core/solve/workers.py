# SPDX-License-Identifier: GPL-3.0-or-later
"""All cores for one solve: NumPy and SciPy release the interpreter's lock, so that threads may share the work."""

import os
import threading
from concurrent.futures import ThreadPoolExecutor
from functools import cache, partial

from .monitor import OutOfTime

WORKERS = min(os.cpu_count() or 1, 8)

_thread = threading.local()


def idle_workers():
    """How many threads may share a piece of work begun here: one inside of work that is shared already."""
    return 1 if getattr(_thread, "is_shared", False) else WORKERS


@cache
def pool():
    """Threads for short work that never waits."""
    return ThreadPoolExecutor(WORKERS, thread_name_prefix="synch_fields")


if hasattr(os, "register_at_fork"):
    # A forked process has none of the threads.
    os.register_at_fork(after_in_child=pool.cache_clear)


class _Follower:
    """What stands for a monitor in the threads that work while it is asked elsewhere."""

    def __init__(self):
        self._stopped = threading.Event()

    def stop(self):
        self._stopped.set()

    def check(self):
        if self._stopped.is_set():
            raise OutOfTime


def share_out(work, parts, monitor):
    """[work(part, monitor) for part in parts] by all cores; ``work`` asks its monitor often.

    Only the calling thread asks the callback of the monitor that is given, and the others stop when it has to.
    """
    if len(parts) == 1 or idle_workers() == 1:
        return [work(part, monitor) for part in parts]
    follower = _Follower()
    try:
        return monitor.during(partial(_by_threads, work, parts, follower))
    finally:
        follower.stop()


def _by_threads(work, parts, follower):
    def alone(part):
        _thread.is_shared = True
        return work(part, follower)

    with ThreadPoolExecutor(min(WORKERS, len(parts))) as threads:
        return list(threads.map(alone, parts))
