# SPDX-License-Identifier: GPL-3.0-or-later
"""The main loop of a child process that solves requests: they are read from one pipe, results are written to another.

The process ends when the pipe from its parent is closed, even in the middle of a solve, so that it never outlives
Blender. Its threads do not run beside Blender.

Messages are tuples that begin with a word. In: ("solve", request), ("keep",): take the result shown last, ("end",):
cancel the present request. Out: ("ready", versions), ("expect", seconds), ("progress", stage, fraction), ("shown",
picture), ("done", result, peak in MB), ("failed", SynchError), ("broken", traceback).
"""

import os
import queue
import time
import traceback
from collections.abc import Callable
from functools import partial
from typing import Any, NoReturn

from ..threads import start_thread
from .ipc import BrokenParcel, Unpacker, read_chunks, send, take_pipes

# Exit status of a process that exceeded its memory limit or could not allocate memory.
TOO_MUCH_MEMORY = 77
# Exit status after a message that cannot be read.
UNREADABLE = 78
# Seconds between two checks of the memory, two progress messages, and two pictures.
_LOOK, _WORD, _PICTURE = 0.03, 0.05, 0.2
# Priority is lowered by this, so that the window goes first.
_NICE = 5
_Send = Callable[[tuple[object, ...]], None]


def serve(limit: int) -> NoReturn:
    """Solve requests until the pipe is closed; the process may use ``limit`` bytes of memory."""
    if hasattr(os, "nice"):  # elsewhere the parent sets the priority
        os.nice(_NICE)
    into, out = take_pipes()
    chunks: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    start_thread(read_chunks, into, chunks)
    # Imported only now, while the parent can already write.
    from .. import tasks

    watch = _Watch(limit)
    start_thread(watch.run)
    tasks.load()
    tell = partial(send, out)
    tell(("ready", tasks.versions()))
    inbox = _Inbox(chunks)
    while True:
        request = inbox.request()
        watch.peak = 0
        tell(_answer(request, tell, watch, inbox), getattr(request, "shared", ()))
        del request  # frees it before the next one comes


class _Inbox:
    """Messages from the parent, in order; one that cannot be read ends the process.

    They are not unpacked in the reading thread: unpickling a request imports modules, and two threads that import may
    wait for each other.
    """

    def __init__(self, chunks: queue.SimpleQueue[bytes]) -> None:
        self._chunks, self._unpacker = chunks, Unpacker()
        self._messages: list[tuple[Any, ...]] = []

    def request(self) -> Any:
        """Wait for the next request (:mod:`..tasks`); messages about earlier ones are dropped."""
        while True:
            while self._messages:
                word, *rest = self._messages.pop(0)
                if word == "solve":
                    return rest[0]
            self._take()

    def word(self) -> str:
        """The parent's message about the present request: "keep", "end", or ""."""
        while not self._chunks.empty():
            self._take()
        word = self._messages[0][0] if self._messages else ""
        return "" if word == "solve" else word

    def _take(self) -> None:
        """Wait for bytes of the parent, and add the messages that they complete."""
        try:
            for message in self._unpacker.feed(self._chunks.get()):
                self._messages.append(message)
                if message[0] == "solve":
                    self._unpacker.shared = getattr(message[1], "kept", ())
        except MemoryError:
            os._exit(TOO_MUCH_MEMORY)
        except BrokenParcel:
            os._exit(UNREADABLE)


class _Watch:
    """Ends the process when it uses too much memory; ``peak`` is the largest use seen since it was set to 0, bytes."""

    def __init__(self, limit: int) -> None:
        from ..memory import used_bytes

        self._used, self._limit, self.peak = used_bytes, limit, 0

    def run(self) -> NoReturn:
        while True:
            self.look()
            time.sleep(_LOOK)

    def look(self) -> None:
        used = self._used()
        self.peak = max(self.peak, used)
        if used > self._limit:
            os._exit(TOO_MUCH_MEMORY)


def _answer(request: Any, send: _Send, watch: _Watch, inbox: _Inbox) -> tuple[object, ...]:
    """Solve a request; the last message about it."""
    from ..errors import Cancelled, SynchError

    shown = _PictureSender(request, send)
    progress = _ProgressSender(send, shown, inbox)
    try:
        try:
            showing = getattr(request, "solve_showing", None)
            found = request.solve(progress) if showing is None else showing(shown, progress)
        except Cancelled as stop:
            if inbox.word() != "keep":
                return "failed", stop
            found = shown.last
        watch.look()
        return "done", found, watch.peak / 2**20
    except SynchError as error:
        return "failed", error
    except MemoryError:
        return "failed", SynchError("there is not enough memory for this: use a coarser mesh, or close other programs")
    except Exception:
        return "broken", traceback.format_exc()


class _PictureSender:
    """Sends pictures of intermediate results at limited intervals; ``last`` is the result that was sent last.

    A glimpse is a picture without a result."""

    def __init__(self, request: Any, send: _Send) -> None:
        self._request, self._send, self._time = request, send, -_PICTURE
        self.last: object = None
        self._waiting: object = None

    def __call__(self, result: object) -> None:
        self._waiting = result
        self.look()

    def look(self) -> None:
        """Send the picture of the waiting result if the interval has passed."""
        if self._waiting is not None and time.monotonic() >= self._time + _PICTURE:
            waiting, self._waiting = self._waiting, None
            picture = self._request.picture(waiting)
            if getattr(picture, "is_result", True):
                self.last = waiting
            self._send(("shown", picture))
            self._time = time.monotonic()


class _ProgressSender:
    """Sends progress messages, at limited intervals within a stage; a false answer ends the solve."""

    def __init__(self, send: _Send, shown: _PictureSender, inbox: _Inbox) -> None:
        self._send, self._shown, self._inbox = send, shown, inbox
        self._stage, self._time = "", 0.0

    def __call__(self, stage: str, fraction: float) -> bool:
        self._shown.look()
        now = time.monotonic()
        if stage != self._stage or now > self._time + _WORD:
            self._stage, self._time = stage, now
            self._send(("progress", stage, fraction))
        word = self._inbox.word()
        return not (word == "end" or (word == "keep" and self._shown.last is not None))

    def expect(self, seconds: float) -> None:
        """Send how long the work usually takes."""
        self._send(("expect", seconds))
