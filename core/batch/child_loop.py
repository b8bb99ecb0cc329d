# SPDX-License-Identifier: GPL-3.0-or-later
"""Both sides of a batch's warm processes, which do many tasks without being restarted (see :mod:`..process.ipc`)."""

import os
import queue
import signal
import subprocess
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, NoReturn

from ..process.ipc import CHUNK, BrokenParcel, Unpacker, read_chunks, send, start_child, take_pipes
from ..threads import Event, Lock, start_thread

# A process is replaced after this many tasks: Blender keeps some kilobytes of each file that it opens.
_TASKS = 1000
# Set by Dask for its workers; larger arrays would be freed and allocated again each time, which doubles solve times.
_NOT_FOR_SOLVES = "MALLOC_TRIM_THRESHOLD_"
# Seconds for a process to end after its pipe has broken, and to clean up when it is dismissed.
_ENDING, _CLEANING = 10, 2

# Plain values by name.
Task = dict[str, Any]
Answer = dict[str, Any]
_Child = subprocess.Popen[bytes]


def serve(answer: Callable[[Task], Answer], leave: Callable[[int], object] = os._exit) -> NoReturn:
    """Answer tasks until standard input is closed, which ends this process whatever it is doing.

    ``leave(status)`` ends this process from any of its threads.
    """
    into, out = take_pipes()
    chunks: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    start_thread(read_chunks, into, chunks, leave)
    unpacker = Unpacker()
    while True:
        for task in unpacker.feed(chunks.get()):
            send(out, answer(task))


class WarmProcess:
    """A warm process, started by a command when it is first needed; each solve may use ``threads`` threads."""

    def __init__(self, command: Sequence[str], threads: int) -> None:
        self._command, self._threads = command, threads
        self._child: _Child | None = None
        self._left, self._lock, self._is_ended = 0, Lock(), False

    def ask(self, task: Task) -> Answer:
        """The answer to a task; ``{"failed": reason}`` if the process ended, or was ended after ``limit`` seconds."""
        try:
            child = self._ready()
        except OSError as error:
            return {"failed": f"its process cannot be started: {self._command[0]}: {error.strerror}"}
        if child is None:
            return {"failed": "the batch has ended"}
        self._left -= 1
        answered, late = Event(), Event()
        watch = None if task.get("limit") is None else start_thread(_end_late, child, task["limit"], answered, late)
        answer = _answer(child, task)
        answered.set()
        if watch is not None:
            watch.join()
        if answer is None or late.is_set():  # an answer at the last moment counts, but its process has been ended
            self._left = 0
        if answer is None and late.is_set():
            return {"failed": f"it took longer than {task['limit']:g} s"}
        return {"failed": _describe_end(child)} if answer is None else answer

    def dismiss(self) -> None:
        """Tell the process to end, and do not start another."""
        with self._lock:
            self._is_ended = True
            _dismiss(self._child)

    def end(self) -> None:
        """End the process, and do not start another."""
        self.dismiss()
        _end(self._child)

    def _ready(self) -> _Child | None:
        """The process for the next task, a new one after :data:`_TASKS` tasks; None once the batch has ended."""
        with self._lock:
            if self._is_ended:
                return None
            if self._left == 0:
                _end(self._child)
                kept = {name: value for name, value in os.environ.items() if name != _NOT_FOR_SOLVES}
                self._child = start_child(self._command, kept | {"SYNCH_THREADS": str(self._threads)})
                self._left = _TASKS
            return self._child


def _answer(child: _Child, task: Task) -> Answer | None:
    """The child's answer; None if it ends before."""
    if child.stdin is None or child.stdout is None:
        return None
    with suppress(OSError, ValueError, BrokenParcel):  # the caller reports that the child has ended
        send(child.stdin.fileno(), task)
        unpacker = Unpacker(after_noise=True)
        while data := os.read(child.stdout.fileno(), CHUNK):
            for answer in unpacker.feed(data):
                return answer
    return None


def _end_late(child: _Child, seconds: float, answered: Event, late: Event) -> None:
    """Kill a child that has not answered after some seconds, and set ``late``."""
    if not answered.wait(seconds):
        late.set()
        child.kill()


def _dismiss(child: _Child | None) -> None:
    """Close a child's standard input, whereupon it cleans up and ends."""
    if child is not None and child.stdin is not None:
        with suppress(OSError, ValueError):  # something is unread, or being written
            child.stdin.close()


def _end(child: _Child | None) -> None:
    """Let a child end by itself, kill it if it takes long, and close its output."""
    if child is not None:
        _dismiss(child)
        try:
            child.wait(_CLEANING)
        except subprocess.TimeoutExpired:
            child.kill()
            child.wait()
        if child.stdout is not None:
            with suppress(OSError):
                child.stdout.close()


def _describe_end(child: _Child) -> str:
    """Why a child that closed its output has ended, for a message."""
    try:
        status = child.wait(_ENDING)
    except subprocess.TimeoutExpired:
        return "its process has closed its pipe"
    if status >= 0:
        return f"its process ended (status {status})"
    return f"its process ended (signal {-status}, {signal.strsignal(-status)})"


class ProcessPool:
    """Warm processes, started by a command, that take tasks from one queue; each solve may use ``threads`` threads.

    ``capacity``: number of tasks to start at a time: one running and one waiting for each process.
    """

    def __init__(self, command: Sequence[str], count: int, threads: int) -> None:
        self.capacity = 2 * count
        self._tasks: queue.SimpleQueue[Task | None] = queue.SimpleQueue()
        self._answers: queue.SimpleQueue[tuple[Task, Answer]] = queue.SimpleQueue()
        self._processes = [WarmProcess(command, threads) for _ in range(count)]
        self._threads = [start_thread(self._work, process, is_daemon=False) for process in self._processes]

    def start(self, task: Task) -> None:
        self._tasks.put(task)

    def answer(self, seconds: float) -> tuple[Task, Answer] | None:
        """The next finished task and its answer, or None after these seconds without one."""
        try:
            return self._answers.get(timeout=seconds)
        except queue.Empty:
            return None

    def end(self) -> None:
        """End all processes at once."""
        for process in self._processes:
            process.dismiss()
        for process in self._processes:
            self._tasks.put(None)
            process.end()
        for thread in self._threads:
            thread.join()

    def _work(self, process: WarmProcess) -> None:
        while (task := self._tasks.get()) is not None:
            self._answers.put((task, process.ask(task)))
