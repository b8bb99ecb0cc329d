# SPDX-License-Identifier: GPL-3.0-or-later
"""Warm processes on a Dask cluster: every thread of its workers drives one.

The processes are children of the workers, so that neither Blender nor a row that ends its process is ever inside of
one. Dask is imported where it is used: plain Python has it by the extra ``dask``, the extension does not.
"""

import queue
import secrets
import sys
from collections import defaultdict

from ..errors import SettingError
from ..threads import Lock
from .child_loop import Hand

# Seconds in which a scheduler has to answer.
_PATIENCE = 15


class Cluster:
    """The workers of a Dask scheduler; used as a :class:`~.crew.Crew`.

    Parameters
    ----------
    address : of the scheduler, such as tcp://10.0.0.1:8786
    arguments : of each worker's own Python that start a warm process
    threads : that each solve may use

    Raises
    ------
    SettingError
        where Dask is missing, or nothing answers at the address
    """

    def __init__(self, address, arguments, threads):
        try:
            from distributed import Client
        except ImportError:
            raise SettingError("Dask is not installed: pip install distributed, or leave --scheduler out") from None
        try:
            self._client = Client(address, timeout=_PATIENCE, set_as_default=False)
        except (OSError, ValueError) as error:
            raise SettingError(
                f"no Dask scheduler answers at {address} ({error}): start one with dask scheduler"
            ) from None
        self._crew = secrets.token_hex(8), tuple(arguments), threads
        self._answers: queue.SimpleQueue = queue.SimpleQueue()
        self._number = 0

    @property
    def capacity(self):
        """Tasks that are to be given at once: one ahead for each thread of the workers that are there now."""
        return 2 * max(sum(self._client.nthreads().values()), 1)

    def start(self, task):
        """Give a task."""
        self._number += 1
        name = f"synch-{task['key']}-{self._number}"
        future = self._client.submit(_do, self._crew, task, key=name, pure=False)
        future.add_done_callback(lambda done: self._answers.put((task, done)))

    def answer(self, seconds):
        """A task that is answered, and the answer; None where there is none in some seconds."""
        try:
            task, future = self._answers.get(timeout=seconds)
        except queue.Empty:
            return None
        try:
            return task, future.result()
        except Exception as error:  # of Dask: every worker that took the task has ended, or the scheduler has
            return task, {"failed": f"Dask: {' '.join(str(error).split()) or type(error).__name__}"}

    def end(self):
        """End the processes of all workers, and let the scheduler go."""
        try:
            self._client.run(_end, self._crew)
        finally:
            self._client.close(_PATIENCE)


class _Hands:
    """The warm processes of a worker, those that have no task now, by the batch that they were started for."""

    def __init__(self):
        self._lock, self._free, self._all = Lock(), defaultdict(list), defaultdict(list)

    def ask(self, crew, task):
        with self._lock:
            free = self._free[crew]
            if not free:
                _, arguments, threads = crew
                free.append(Hand([sys.executable, *arguments], threads))
                self._all[crew].append(free[0])
            hand = free.pop()
        try:
            return hand.ask(task)
        finally:
            with self._lock:
                self._free[crew].append(hand)

    def end(self, crew):
        with self._lock:
            self._free.pop(crew, None)
            ended = self._all.pop(crew, [])
        for hand in ended:
            hand.end()


_hands = _Hands()


def _do(crew, task):
    """What a worker does with a task."""
    return _hands.ask(crew, task)


def _end(crew):
    _hands.end(crew)
