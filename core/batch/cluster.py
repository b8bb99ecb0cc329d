# SPDX-License-Identifier: GPL-3.0-or-later
"""Warm processes on a Dask cluster, one for every thread of its workers.

The processes are children of the workers, so that neither Blender nor a crash ever happens inside a worker. Dask is
imported where it is used: the Python package has it by the extra ``batch``, the extension does not.
"""

import queue
import secrets
import sys
from collections import defaultdict
from collections.abc import Sequence
from typing import Any

from ..errors import SettingError
from ..threads import Lock
from .child_loop import Answer, Task, WarmProcess

# Seconds in which a scheduler has to answer.
_TIMEOUT = 15
# Name of the batch, arguments of Python that start a process, and threads of each solve.
_PoolKey = tuple[str, tuple[str, ...], int]


class Cluster:
    """The workers of a Dask scheduler; used like a :class:`.child_loop.ProcessPool`.

    Raises SettingError if Dask is missing, or no scheduler answers at the address.

    Parameters
    ----------
    address : of the scheduler, such as tcp://10.0.0.1:8786
    arguments : for each worker's Python, to start a warm process
    threads : that each solve may use
    """

    def __init__(self, address: str, arguments: Sequence[str], threads: int) -> None:
        try:
            from distributed import Client
        except ImportError:
            raise SettingError("Dask is not installed: pip install distributed, or leave --scheduler out") from None
        try:
            self._client = Client(address, timeout=_TIMEOUT, set_as_default=False)
        except (OSError, ValueError) as error:
            raise SettingError(
                f"no Dask scheduler answers at {address} ({error}): start one with dask scheduler"
            ) from None
        self._pool_key = secrets.token_hex(8), tuple(arguments), threads
        self._answers: queue.SimpleQueue[tuple[Task, Any]] = queue.SimpleQueue()
        self._number = 0

    @property
    def capacity(self) -> int:
        """Number of tasks to start at a time: one running and one waiting for each thread of the present workers."""
        return 2 * max(sum(self._client.nthreads().values()), 1)

    def start(self, task: Task) -> None:
        self._number += 1
        name = f"synch-{task['key']}-{self._number}"
        future = self._client.submit(_do, self._pool_key, task, key=name, pure=False)
        future.add_done_callback(lambda done: self._answers.put((task, done)))

    def answer(self, seconds: float) -> tuple[Task, Answer] | None:
        """The next finished task and its answer, or None after these seconds without one."""
        try:
            task, future = self._answers.get(timeout=seconds)
        except queue.Empty:
            return None
        try:
            return task, future.result()
        except Exception as error:  # of Dask: every worker that took the task has ended, or the scheduler has
            return task, {"failed": f"Dask: {' '.join(str(error).split()) or type(error).__name__}"}

    def end(self) -> None:
        """End the processes of all workers, and disconnect from the scheduler."""
        try:
            self._client.run(_end, self._pool_key)
        finally:
            self._client.close(_TIMEOUT)


class _WarmProcesses:
    """The warm processes of a worker, all and those without a task, by the batch that they were started for."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._free: defaultdict[_PoolKey, list[WarmProcess]] = defaultdict(list)
        self._all: defaultdict[_PoolKey, list[WarmProcess]] = defaultdict(list)

    def ask(self, key: _PoolKey, task: Task) -> Answer:
        """Solve a task in a free process of its batch, or in a new one."""
        with self._lock:
            free = self._free[key]
            if not free:
                _, arguments, threads = key
                free.append(WarmProcess([sys.executable, *arguments], threads))
                self._all[key].append(free[0])
            process = free.pop()
        try:
            return process.ask(task)
        finally:
            with self._lock:
                self._free[key].append(process)

    def end(self, key: _PoolKey) -> None:
        with self._lock:
            self._free.pop(key, None)
            ended = self._all.pop(key, [])
        for process in ended:
            process.end()


_processes = _WarmProcesses()


def _do(key: _PoolKey, task: Task) -> Answer:
    return _processes.ask(key, task)


def _end(key: _PoolKey) -> None:
    _processes.end(key)
