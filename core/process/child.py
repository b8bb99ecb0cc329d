# SPDX-License-Identifier: GPL-3.0-or-later
"""The loop of a process that solves for another one: requests come in by a pipe, what is found goes out by one.

This process ends when the pipe from its parent is closed, whatever it is doing, so that none outlives Blender. Its
threads are its own: none of them runs beside Blender.

Messages are tuples that begin with a word. In: ("solve", request), ("keep",): what was shown last is the result,
("end",): the present request is of no use any more. Out: ("ready", versions), ("progress", stage, fraction), ("shown",
picture), ("done", result, peak in MB), ("failed", SynchError), ("broken", traceback).
"""

import os
import queue
import time
import traceback
from functools import partial

from ..threads import start_thread
from .ipc import BrokenParcel, Unpacker, pack_parts

# Exit status of a process that took more memory than it may, or could not get what it needed.
TOO_MUCH_MEMORY = 77
# And of one that was asked what it cannot read.
UNREADABLE = 78
# Seconds between two looks at the memory, between two words on how far the work is, and between two pictures.
_LOOK, _WORD, _PICTURE = 0.03, 0.05, 0.2
# Steps by which the window, and all else, goes first.
_NICE = 5


def serve(limit):
    """Solve what is asked until the pipe is closed.

    Parameters
    ----------
    limit : bytes of memory that this process may take
    """
    if hasattr(os, "nice"):  # elsewhere the parent sees to it
        os.nice(_NICE)
    out, into = os.dup(1), os.dup(0)
    os.dup2(2, 1)  # what libraries print does not get among the messages
    # On Windows libraries that ask about standard input while they are loaded would wait for a thread that reads it.
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    chunks: queue.SimpleQueue = queue.SimpleQueue()
    start_thread(_read, into, chunks)
    # Only now: reading has begun, so that the parent can write while all this is loaded.
    from .. import tasks

    watch = _Watch(limit)
    start_thread(watch.run)
    tasks.load()
    send = partial(_send, out)
    send(("ready", tasks.versions()))
    inbox = _Inbox(chunks)
    while True:
        request = inbox.request()
        watch.peak = 0
        send(_answer(request, send, watch, inbox), request.shared)
        request = None  # nothing is kept of it until the next


def _read(into, chunks):
    """Put what comes into a queue; the end of the pipe is the end of the process."""
    try:
        while data := os.read(into, 1 << 20):
            chunks.put(data)
    finally:  # without a thread that reads, the process would wait for ever
        os._exit(0)


class _Inbox:
    """What the parent says, as it comes; what cannot be read is the end of the process.

    It is not the thread that reads that unpacks: a request imports modules, and two threads that do so may wait for
    one another.
    """

    def __init__(self, chunks):
        self._chunks, self._unpacker, self._messages = chunks, Unpacker(), []

    def request(self):
        """What is asked next; words about what is over are dropped."""
        while True:
            while self._messages:
                word, *rest = self._messages.pop(0)
                if word == "solve":
                    return rest[0]
            self._take()

    def word(self):
        """What the parent has said of the present request: "keep", "end", or "" for nothing."""
        while not self._chunks.empty():
            self._take()
        word = self._messages[0][0] if self._messages else ""
        return "" if word == "solve" else word

    def _take(self):
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
    """Looks at the memory that the process takes, and ends it where that is too much.

    Attributes
    ----------
    peak : bytes, the most that was seen since it was set to 0
    """

    def __init__(self, limit):
        from ..memory import used_bytes

        self._used, self._limit, self.peak = used_bytes, limit, 0

    def run(self):
        while True:
            self.look()
            time.sleep(_LOOK)

    def look(self):
        used = self._used()
        self.peak = max(self.peak, used)
        if used > self._limit:
            os._exit(TOO_MUCH_MEMORY)


def _send(out, message, shared=()):
    for part in pack_parts(message, shared):
        rest = memoryview(part).cast("B")
        while len(rest):
            rest = rest[os.write(out, rest) :]


def _answer(request, send, watch, inbox):
    """The last message about a request."""
    from ..errors import Cancelled, SynchError

    shown, progress = _Shown(request, send), _Progress(send)

    def goes_on(stage, fraction):
        shown.look()
        progress(stage, fraction)
        word = inbox.word()
        return not (word == "end" or (word == "keep" and shown.last is not None))

    try:
        try:
            showing = getattr(request, "solve_showing", None)
            found = request.solve(goes_on) if showing is None else showing(shown, goes_on)
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


class _Shown:
    """Results on the way, whose pictures are sent, not too often.

    Attributes
    ----------
    last : result whose picture was sent last, None before
    """

    def __init__(self, request, send):
        self._request, self._send = request, send
        self.last, self._waiting, self._time = None, None, -_PICTURE

    def __call__(self, result):
        self._waiting = result
        self.look()

    def look(self):
        """Send the picture of what waits, where it is time for one."""
        if self._waiting is not None and time.monotonic() >= self._time + _PICTURE:
            self.last, self._waiting = self._waiting, None
            self._send(("shown", self._request.picture(self.last)))
            self._time = time.monotonic()


class _Progress:
    """Says how far the work is, not too often."""

    def __init__(self, send):
        self._send, self._stage, self._time = send, None, 0.0

    def __call__(self, stage, fraction):
        now = time.monotonic()
        if stage != self._stage or now > self._time + _WORD:
            self._stage, self._time = stage, now
            self._send(("progress", stage, fraction))
