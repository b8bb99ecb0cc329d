# SPDX-License-Identifier: GPL-3.0-or-later
"""Keep BLAS to one thread during a solve.

Sparse factorizations call BLAS many thousand times on tiny blocks. Waking a pool of threads for each
made solves up to ten times slower on a busy machine, and never faster.
"""

from contextlib import nullcontext

try:
    from threadpoolctl import threadpool_limits
except ImportError:  # an extension built without its wheels, in a Blender that has SciPy only
    threadpool_limits = None


def one_blas_thread():
    """Context in which BLAS uses one thread, where threadpoolctl is there to say so."""
    return nullcontext() if threadpool_limits is None else threadpool_limits(1, user_api="blas")
