# SPDX-License-Identifier: GPL-3.0-or-later
"""Keep BLAS to one thread during a solve.

Sparse factorizations call BLAS many thousand times on tiny blocks. Waking a pool of threads for each
made solves up to ten times slower on a busy machine, and never faster.
"""

import os
from contextlib import contextmanager

from ..threads import Event, Lock, Thread, local, start_thread

try:
    from threadpoolctl import threadpool_limits
except ImportError:  # an extension built without its wheels, in a Blender that has SciPy only
    threadpool_limits = None

_here = local()


class _Everywhere:
    """The limit of a pool that all threads share, while anybody is inside.

    threadpoolctl (from 3.7 on) heeds one thread only, the first to ask, until that leaves; the others' limits are
    nothing. So it is a thread of its own that asks, whoever comes first and whoever leaves last.
    """

    def __init__(self):
        self.forget()

    def forget(self):
        """Nobody is inside: a forked process has none of the threads."""
        self._lock, self._inside = Lock(), 0
        self._ended, self._keeper = Event(), Thread()

    def __enter__(self):
        with self._lock:
            if self._inside == 0:
                self._begin()
            self._inside += 1

    def __exit__(self, *_error):
        with self._lock:
            is_last, self._inside = self._inside == 1, max(self._inside - 1, 0)  # 0 where it was forked inside
            if is_last:
                self._ended.set()
                self._keeper.join()

    def _begin(self):
        ended, limited = Event(), Event()
        keeper = start_thread(_keep, limited, ended)
        try:
            limited.wait()
        except BaseException:  # Ctrl-C
            ended.set()
            raise
        self._ended, self._keeper = ended, keeper


def _keep(limited, ended):
    try:
        with threadpool_limits(1, user_api="blas"):
            limited.set()
            ended.wait()
    finally:  # nobody waits for a limit that failed
        limited.set()


_everywhere = _Everywhere()


def _forget():
    """The thread that has forked is not inside in the other process, either."""
    _everywhere.forget()
    _here.is_inside = False


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)


@contextmanager
def one_blas_thread():
    """Context in which BLAS uses one thread, where threadpoolctl is there to say so.

    Some builds of BLAS (OpenMP) have a pool for each thread that calls: that of the calling thread is limited as well.
    """
    if threadpool_limits is None or getattr(_here, "is_inside", False):
        yield
        return
    _here.is_inside = True
    try:
        with _everywhere, threadpool_limits(1, user_api="blas"):
            yield
    finally:
        _here.is_inside = False
