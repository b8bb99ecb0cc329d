# SPDX-License-Identifier: GPL-3.0-or-later
"""Keep BLAS to one thread during a solve.

Sparse factorizations call BLAS many thousand times on tiny blocks. Waking a pool of threads for each
made solves up to ten times slower on a busy machine, and never faster.
"""

import threading
from contextlib import contextmanager

try:
    from threadpoolctl import threadpool_limits
except ImportError:  # an extension built without its wheels, in a Blender that has SciPy only
    threadpool_limits = None

_lock = threading.Lock()
_inside: list = []


@contextmanager
def one_blas_thread():
    """Context in which BLAS uses one thread, where threadpoolctl is there to say so; the last to leave ends it."""
    with _lock:
        _inside.append(threadpool_limits(1, user_api="blas") if threadpool_limits and not _inside else None)
    try:
        yield
    finally:
        with _lock:
            _leave()


def _leave():
    """Hand the limits of the first to enter on to those that stay."""
    if len(_inside) > 1:
        _inside.pop(1)
        return
    limits = _inside.pop()
    if limits is not None:
        limits.restore_original_limits()
