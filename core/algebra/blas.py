# SPDX-License-Identifier: GPL-3.0-or-later
"""Limit BLAS to one thread during a solve.

Sparse factorizations call BLAS thousands of times on tiny blocks. Waking a pool of threads for each call makes solves
up to ten times slower on a busy machine, and never faster.
"""

import os
import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from functools import lru_cache

from ..threads import Event, Lock, Thread, local, start_thread

try:
    from threadpoolctl import ThreadpoolController
except ImportError:  # an extension without wheels, in a Blender that has only SciPy
    ThreadpoolController = None

_here = local()


@lru_cache(maxsize=1)
def _controller(_modules: int) -> ThreadpoolController:
    """Find the libraries that this process has loaded, which takes 2 ms: once for each number of loaded modules."""
    return ThreadpoolController()


def _limit() -> AbstractContextManager[object]:
    """Limit every BLAS that is loaded to one thread, until the context ends."""
    return _controller(len(sys.modules)).limit(limits=1, user_api="blas")


class _Everywhere:
    """Limit of the pool that all threads share, while any thread is inside.

    threadpoolctl (from 3.7 on) obeys only the first thread that sets a limit, until this thread ends it. So a separate
    thread sets the limit, whichever thread enters first and leaves last.
    """

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Reset in a forked process, which does not inherit threads."""
        self._lock, self._inside = Lock(), 0
        self._ended, self._keeper = Event(), Thread()

    def __enter__(self) -> None:
        with self._lock:
            if self._inside == 0:
                self._begin()
            self._inside += 1

    def __exit__(self, *_error: object) -> None:
        with self._lock:
            is_last, self._inside = self._inside == 1, max(self._inside - 1, 0)  # 0 if forked inside
            if is_last:
                self._ended.set()
                self._keeper.join()

    def _begin(self) -> None:
        """Start the thread that limits BLAS, and wait until it has; it ends the limit when ``_ended`` is set."""
        ended, limited = Event(), Event()
        keeper = start_thread(_keep, limited, ended)
        try:
            limited.wait()
        except BaseException:  # Ctrl-C
            ended.set()
            raise
        self._ended, self._keeper = ended, keeper


def _keep(limited: Event, ended: Event) -> None:
    """Limit BLAS until ``ended`` is set; set ``limited`` once the limit holds."""
    try:
        with _limit():
            limited.set()
            ended.wait()
    finally:  # also end the wait for a limit that failed
        limited.set()


_everywhere = _Everywhere()


def _forget() -> None:
    """Reset in a forked process, in which the forking thread is not inside either."""
    _everywhere.forget()
    _here.is_inside = False


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Context in which BLAS uses one thread, if threadpoolctl is installed.

    Some builds of BLAS (OpenMP) have a pool for each calling thread, which is limited as well.
    """
    if ThreadpoolController is None or getattr(_here, "is_inside", False):
        yield
        return
    _here.is_inside = True
    try:
        with _everywhere, _limit():
            yield
    finally:
        _here.is_inside = False
