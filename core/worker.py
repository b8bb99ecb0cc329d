# SPDX-License-Identifier: GPL-3.0-or-later
"""The loop of a process that solves for another one: requests come in by a pipe, what is found goes out by one.

This process ends when the pipe from its parent is closed, whatever it is doing, so that none outlives Blender. Its
threads are its own: none of them runs beside Blender.

Messages are tuples that begin with a word. In: ("solve", request). Out: ("ready", versions), ("progress", stage,
fraction), ("early", picture), ("done", result, peak in MB), ("failed", SynchError), ("broken", traceback).
"""

import os
import queue
import time
import traceback
from functools import partial

from .parcels import BrokenParcel, Unpacker, packed
from .threads import begun

# Exit status of a process that took more memory than it may, or could not get what it needed.
TOO_MUCH_MEMORY = 77
# And of one that was asked what it cannot read.
UNREADABLE = 78
# Seconds between two looks at the memory, and between two words on how far the work is.
_LOOK, _WORD = 0.03, 0.05
# Steps by which the window, and all else, goes first.
_NICE = 5
# Share of the work that a first result takes.
_EARLY = 0.25


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
    begun(_read, into, chunks)
    # Only now: reading has begun, so that the parent can write while all this is loaded.
    from . import tasks

    watch = _Watch(limit)
    begun(watch.run)
    tasks.load()
    send = partial(_send, out)
    send(("ready", tasks.versions()))
    for request in _requests(chunks):
        watch.peak = 0
        send(_answer(request, send, watch), request.shared)
        request = None  # nothing is kept of it until the next


def _read(into, chunks):
    """Put what comes into a queue; the end of the pipe is the end of the process."""
    try:
        while data := os.read(into, 1 << 20):
            chunks.put(data)
    finally:  # without a thread that reads, the process would wait for ever
        os._exit(0)


def _requests(chunks):
    """What is asked, as it comes; what cannot be read is the end of the process.

    Not for the thread that reads: a request imports modules, and two threads that do so may wait for one another.
    """
    unpacker = Unpacker()
    while True:
        try:
            messages = unpacker.feed(chunks.get())
        except MemoryError:
            os._exit(TOO_MUCH_MEMORY)
        except BrokenParcel:
            os._exit(UNREADABLE)
        while messages:
            yield messages.pop(0)[1]


class _Watch:
    """Looks at the memory that the process takes, and ends it where that is too much.

    Attributes
    ----------
    peak : bytes, the most that was seen since it was set to 0
    """

    def __init__(self, limit):
        from .memory import used_bytes

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
    for part in packed(message, shared):
        rest = memoryview(part).cast("B")
        while len(rest):
            rest = rest[os.write(out, rest) :]


def _answer(request, send, watch):
    """The last message about a request."""
    from .errors import SynchError

    try:
        progress = _Progress(send)
        picture = _first(request, progress.part(0.0, _EARLY))
        if picture is not None:
            send(("early", picture))
            progress = progress.part(_EARLY, 1 - _EARLY)
        found = request.solve(progress)
        watch.look()
        return "done", found, watch.peak / 2**20
    except SynchError as error:
        return "failed", error
    except MemoryError:
        return "failed", SynchError("there is not enough memory for this: use a coarser mesh, or close other programs")
    except Exception:
        return "broken", traceback.format_exc()


def _first(request, progress):
    """The picture of a first result, None where there is none: what is wrong is told by the solve itself."""
    from .errors import SynchError

    if not hasattr(request, "solve_early"):
        return None
    try:
        return request.solve_early(progress)
    except SynchError:
        return None


class _Progress:
    """Says how far the work is, not too often."""

    def __init__(self, send, start=0.0, share=1.0):
        self._send, self._start, self._share = send, start, share
        self._stage, self._time = None, 0.0

    def part(self, start, share):
        return _Progress(self._send, start, share)

    def __call__(self, stage, fraction):
        now = time.monotonic()
        if stage != self._stage or now > self._time + _WORD:
            self._stage, self._time = stage, now
            self._send(("progress", stage, self._start + self._share * fraction))
        return True
