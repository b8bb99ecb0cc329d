# SPDX-License-Identifier: GPL-3.0-or-later
"""Threads: all of the program's are begun here, and no other module imports what begins them.

None runs beside Blender while somebody works in it. They run

- in a child process, which is no Blender: that of a solve for the window (``core.process.child``);
- in a Blender that is blocked, by a solve that a script, the redo panel or the command line waits for: they share its
  work and are joined before the call returns. Only where a script's callback or Ctrl-C stops it, a factorization, which
  cannot be interrupted, is left behind until it is done; the command line ends its process then;
- in the processes of a batch (``core.batch``), which have no window: the one that hands out rows waits in a thread for
  each process that does them, and is blocked until all are joined; in each of those a thread reads what it is asked,
  so that it ends with its pipe.

What they do is NumPy's, SciPy's and pipes': ``core`` does not know Blender.
"""

from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from threading import Event, Lock, Thread, local

__all__ = ["FIRST_EXCEPTION", "Event", "Lock", "Thread", "ThreadPoolExecutor", "local", "start_thread", "wait"]


def start_thread(work, *arguments, is_daemon=True):
    """A thread that does ``work(*arguments)``; the process does not wait for a daemon at its end."""
    thread = Thread(target=work, args=arguments, daemon=is_daemon)
    thread.start()
    return thread
