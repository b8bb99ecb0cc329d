# SPDX-License-Identifier: GPL-3.0-or-later
"""Warm processes on this machine: a thread waits for each of them."""

import queue

from ..threads import start_thread
from .child_loop import Hand


class ProcessPool:
    """Some warm processes that take tasks from one row.

    Parameters
    ----------
    command : what starts a process
    count : of processes
    threads : that each solve may use

    Attributes
    ----------
    capacity : tasks that are to be given at once: one ahead for each process, so that none waits
    """

    def __init__(self, command, count, threads):
        self.capacity = 2 * count
        self._tasks: queue.SimpleQueue = queue.SimpleQueue()
        self._answers: queue.SimpleQueue = queue.SimpleQueue()
        self._hands = [Hand(command, threads) for _ in range(count)]
        self._threads = [start_thread(self._work, hand, is_daemon=False) for hand in self._hands]

    def start(self, task):
        """Give a task."""
        self._tasks.put(task)

    def answer(self, seconds):
        """A task that is answered, and the answer; None where there is none in some seconds."""
        try:
            return self._answers.get(timeout=seconds)
        except queue.Empty:
            return None

    def end(self):
        """End all processes at once."""
        for hand in self._hands:
            hand.dismiss()
        for hand in self._hands:
            self._tasks.put(None)
            hand.end()
        for thread in self._threads:
            thread.join()

    def _work(self, hand):
        while (task := self._tasks.get()) is not None:
            self._answers.put((task, hand.ask(task)))
