# SPDX-License-Identifier: GPL-3.0-or-later
"""Warm processes on this machine, with a thread that waits for each of them."""

import queue
from collections.abc import Sequence

from ..threads import start_thread
from .child_loop import Answer, Hand, Task


class ProcessPool:
    """Some warm processes, started by a command, that take tasks from one queue; solves may use so many threads.

    Attributes
    ----------
    capacity : number of tasks to start at a time: one running and one waiting for each process
    """

    def __init__(self, command: Sequence[str], count: int, threads: int) -> None:
        self.capacity = 2 * count
        self._tasks: queue.SimpleQueue[Task | None] = queue.SimpleQueue()
        self._answers: queue.SimpleQueue[tuple[Task, Answer]] = queue.SimpleQueue()
        self._hands = [Hand(command, threads) for _ in range(count)]
        self._threads = [start_thread(self._work, hand, is_daemon=False) for hand in self._hands]

    def start(self, task: Task) -> None:
        self._tasks.put(task)

    def answer(self, seconds: float) -> tuple[Task, Answer] | None:
        """A finished task and its answer; None if there is none within some seconds."""
        try:
            return self._answers.get(timeout=seconds)
        except queue.Empty:
            return None

    def end(self) -> None:
        """End all processes at once."""
        for hand in self._hands:
            hand.dismiss()
        for hand in self._hands:
            self._tasks.put(None)
            hand.end()
        for thread in self._threads:
            thread.join()

    def _work(self, hand: Hand) -> None:
        while (task := self._tasks.get()) is not None:
            self._answers.put((task, hand.ask(task)))
