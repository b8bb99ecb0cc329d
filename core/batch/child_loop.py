# SPDX-License-Identifier: GPL-3.0-or-later
"""Both sides of a batch's warm process, which does many tasks without being restarted, and the pool of such processes.

A task is a JSON object on a line of its standard input; the answer is one on a line of its standard output that begins
with a mark, because Blender prints there, too.
"""

import json
import os
import queue
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import IO, Any, NoReturn

from ..threads import Event, Lock, start_thread

_MARK = "synch-row "
# A process is replaced after this many tasks: Blender keeps some kilobytes of each file that it opens.
_TASKS = 1000
# Set by Dask for its workers; larger arrays would be freed and allocated again each time, which doubles solve times.
_NOT_FOR_SOLVES = "MALLOC_TRIM_THRESHOLD_"
# Seconds for a process to end after its pipe has broken, and to clean up when it is dismissed.
_FAREWELL, _CLEANING = 10, 2

# JSON objects.
Task = dict[str, Any]
Answer = dict[str, Any]
_Child = subprocess.Popen[str]


def serve(answer: Callable[[Task], Answer], leave: Callable[[int], object] = os._exit) -> NoReturn:
    """Answer tasks until standard input is closed, which ends this process whatever it is doing.

    ``leave(status)`` ends this process from any of its threads.
    """
    out = os.fdopen(os.dup(1), "w", encoding="utf-8")
    into = os.fdopen(os.dup(0), "r", encoding="utf-8")
    os.dup2(2, 1)  # keep what Blender prints out of the answers
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    tasks: queue.SimpleQueue[str] = queue.SimpleQueue()
    start_thread(_read, into, tasks, leave)
    while True:
        print(_MARK + json.dumps(answer(json.loads(tasks.get()))), file=out, flush=True)


def _read(into: IO[str], tasks: queue.SimpleQueue[str], leave: Callable[[int], object]) -> None:
    try:
        for line in into:
            tasks.put(line)
    finally:
        leave(0)


class Hand:
    """A warm process, started by a command when it is first needed; each solve may use so many threads."""

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
        with self._lock:
            if self._is_ended:
                return None
            if self._left == 0:
                _end(self._child)
                self._child = _start_child(self._command, {"SYNCH_THREADS": str(self._threads)})
                self._left = _TASKS
            return self._child


def _start_child(command: Sequence[str], variables: dict[str, str]) -> _Child:
    """A child with pipes, which does not receive Ctrl-C: its parent ends it."""
    kind: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "encoding": "utf-8"}
    kind["errors"] = "replace"
    if sys.platform == "win32":
        kind["creationflags"] = subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.CREATE_NO_WINDOW
    else:
        kind["process_group"] = 0
    kept = {name: value for name, value in os.environ.items() if name != _NOT_FOR_SOLVES}
    return subprocess.Popen(command, env=kept | variables, **kind)


def _answer(child: _Child, task: Task) -> Answer | None:
    """The child's answer; None if it ends before."""
    if child.stdin is None or child.stdout is None:
        return None
    with suppress(OSError, ValueError):  # the caller reports that the child has ended
        child.stdin.write(json.dumps(task) + "\n")
        child.stdin.flush()
        for line in child.stdout:
            if line.startswith(_MARK):
                answer: Answer = json.loads(line.removeprefix(_MARK))
                return answer
    return None


def _end_late(child: _Child, seconds: float, answered: Event, late: Event) -> None:
    if not answered.wait(seconds):
        late.set()
        child.kill()


def _dismiss(child: _Child | None) -> None:
    """Close a child's standard input, whereupon it cleans up and ends."""
    if child is not None and child.stdin is not None:
        with suppress(OSError, ValueError):  # something is unread, or being written
            child.stdin.close()


def _end(child: _Child | None) -> None:
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
    try:
        status = child.wait(_FAREWELL)
    except subprocess.TimeoutExpired:
        return "its process has closed its pipe"
    if status >= 0:
        return f"its process ended (status {status})"
    return f"its process ended (signal {-status}, {signal.strsignal(-status)})"


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
