# SPDX-License-Identifier: GPL-3.0-or-later
"""The warm process of a batch, from both sides: it does one task after the other, without being started again.

A task is a JSON object on a line of its standard input; the answer is one on a line of its standard output that begins
with a mark, since Blender prints there, too.
"""

import json
import os
import queue
import signal
import subprocess
import sys
from contextlib import suppress

from ..threads import Event, Lock, start_thread

_MARK = "synch-row "
# Tasks after which a process is followed by a fresh one: Blender keeps some kilobytes of each file that it opens.
_TASKS = 1000
# What Dask tells its workers' memory: each array of some size would be given back and asked for again, which doubles
# the time of a solve.
_NOT_FOR_SOLVES = "MALLOC_TRIM_THRESHOLD_"
# Seconds that a process has to end after its pipe has broken, and that it may take to clean up when it is not needed.
_FAREWELL, _CLEANING = 10, 2


def serve(answer, leave=os._exit):
    """Answer tasks until standard input is closed, which ends this process whatever it is doing.

    Parameters
    ----------
    answer : callable(task) -> dict that JSON takes
    leave : callable(status) that ends this process from any of its threads
    """
    out = os.fdopen(os.dup(1), "w", encoding="utf-8")
    into = os.fdopen(os.dup(0), "r", encoding="utf-8")
    os.dup2(2, 1)  # what Blender prints does not get among the answers
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    tasks: queue.SimpleQueue = queue.SimpleQueue()
    start_thread(_read, into, tasks, leave)
    while True:
        print(_MARK + json.dumps(answer(json.loads(tasks.get()))), file=out, flush=True)


def _read(into, tasks, leave):
    try:
        for line in into:
            tasks.put(line)
    finally:
        leave(0)


class Hand:
    """A warm process, started when it is needed.

    Parameters
    ----------
    command : what starts it
    threads : that each of its solves may use
    """

    def __init__(self, command, threads):
        self._command, self._threads = command, threads
        self._child, self._left, self._lock, self._is_ended = None, 0, Lock(), False

    def ask(self, task):
        """The answer to a task; ``{"failed": reason}`` where the process ended over it.

        A task's ``limit`` are the seconds after which its process is ended, None for no limit.
        """
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
        if answer is None or late.is_set():  # an answer in the last moment counts, but its process has ended
            self._left = 0
        if answer is None and late.is_set():
            return {"failed": f"it took longer than {task['limit']:g} s"}
        return {"failed": _last_words(child)} if answer is None else answer

    def dismiss(self):
        """Tell the process to end, and start none again."""
        with self._lock:
            self._is_ended = True
            _dismiss(self._child)

    def end(self):
        """End the process, and start none again."""
        self.dismiss()
        _end(self._child)

    def _ready(self):
        with self._lock:
            if self._is_ended:
                return None
            if self._left == 0:
                _end(self._child)
                self._child = _start_child(self._command, {"SYNCH_THREADS": str(self._threads)})
                self._left = _TASKS
            return self._child


def _start_child(command, variables):
    """A child with pipes; Ctrl-C is for its parent, which ends it."""
    kind: dict = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "encoding": "utf-8", "errors": "replace"}
    if sys.platform == "win32":
        kind["creationflags"] = subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.CREATE_NO_WINDOW
    else:
        kind["process_group"] = 0
    kept = {name: value for name, value in os.environ.items() if name != _NOT_FOR_SOLVES}
    return subprocess.Popen(command, env=kept | variables, **kind)


def _answer(child, task):
    """What a child answers; None where it ends before."""
    try:
        child.stdin.write(json.dumps(task) + "\n")
        child.stdin.flush()
        for line in child.stdout:
            if line.startswith(_MARK):
                return json.loads(line.removeprefix(_MARK))
    except (OSError, ValueError):  # its end is told by who asks
        pass
    return None


def _end_late(child, seconds, answered, late):
    if not answered.wait(seconds):
        late.set()
        child.kill()


def _dismiss(child):
    """Close a child's standard input, upon which it cleans up and ends."""
    if child is not None:
        with suppress(OSError, ValueError):  # what was not read, or is being written
            child.stdin.close()


def _end(child):
    if child is not None:
        _dismiss(child)
        try:
            child.wait(_CLEANING)
        except subprocess.TimeoutExpired:
            child.kill()
            child.wait()
        with suppress(OSError):
            child.stdout.close()


def _last_words(child):
    try:
        status = child.wait(_FAREWELL)
    except subprocess.TimeoutExpired:
        return "its process has closed its pipe"
    if status >= 0:
        return f"its process ended (status {status})"
    return f"its process ended (signal {-status}, {signal.strsignal(-status)})"
