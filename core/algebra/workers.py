# SPDX-License-Identifier: GPL-3.0-or-later
"""All cores for one solve: NumPy and SciPy release the interpreter's lock, so that threads may share the work."""

import math
import os
from contextlib import contextmanager

from ..monitor import POLL_SECONDS, OutOfTime
from ..threads import FIRST_EXCEPTION, Event, Lock, ThreadPoolExecutor, local, wait
from .blas import one_blas_thread

MOST_WORKERS = 8
# Roundings differ with their number: a batch sets one that holds on all its machines.
WORKERS = min(int(os.environ.get("SYNCH_THREADS") or os.cpu_count() or 1), MOST_WORKERS)

_thread = local()


def idle_workers():
    """How many threads may share a piece of work begun here: one inside of work that is shared already."""
    return 1 if getattr(_thread, "is_shared", False) else WORKERS


class _Pool:
    """Threads for short work that never waits; they end with the last solve that is inside."""

    def __init__(self):
        self.forget()

    def forget(self):
        """Nobody is inside: a forked process has none of the threads."""
        self._lock, self._inside, self._executor = Lock(), 0, None

    def __enter__(self):
        with self._lock:
            self._inside += 1

    def __exit__(self, *_error):
        with self._lock:
            self._inside -= 1
            ended = None if self._inside else self._executor
            self._executor = self._executor if self._inside else None
        if ended is not None:
            ended.shutdown()

    def map(self, work, parts):
        """[work(part) for part in parts], by threads where a solve is inside that they end with."""
        with self._lock:
            if self._inside and self._executor is None:
                self._executor = ThreadPoolExecutor(WORKERS, thread_name_prefix="synch_fields")
            executor = self._executor
        return list((map if executor is None else executor.map)(work, parts))


pool = _Pool()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=pool.forget)


@contextmanager
def solving():
    """Context of a solve: BLAS has one thread, and what threads share the work end with it."""
    with one_blas_thread(), pool:
        yield


class _Follower:
    """What stands for a monitor in the threads that work while it is asked elsewhere."""

    def __init__(self):
        self._stopped = Event()

    def stop(self):
        self._stopped.set()

    def check(self):
        if self._stopped.is_set():
            raise OutOfTime


def share_out(work, parts, monitor, at_once=math.inf):
    """[work(part, monitor) for part in parts] by all cores, at most ``at_once`` parts at a time.

    Only the calling thread asks the callback of the given monitor. ``work`` has to ask its own often, which stops
    it with :class:`OutOfTime` when the caller is stopped or another part fails. When the time limit passes, work may
    return what it has reached instead.
    """
    threads = min(idle_workers(), len(parts), at_once)
    if threads == 1:
        return [work(part, monitor) for part in parts]
    follower = _Follower()

    def alone(part):
        _thread.is_shared = True
        return work(part, follower)

    executor = ThreadPoolExecutor(threads)
    running = [executor.submit(alone, part) for part in parts]
    try:
        while not _wait_for_all(running):
            monitor.check()
    except OutOfTime:
        follower.stop()
        wait(running)
    finally:
        follower.stop()
        executor.shutdown(cancel_futures=True)
    return [future.result() for future in running]


def _wait_for_all(running):
    """Whether all are done, after a while; the error of one that failed comes out here."""
    done, waiting = wait(running, POLL_SECONDS, FIRST_EXCEPTION)
    for future in done:
        future.result()
    return not waiting
