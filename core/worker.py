# SPDX-License-Identifier: GPL-3.0-or-later
"""The loop of a process that solves for another one: requests come in by a pipe, what is found goes out by one.

This process ends when the pipe from its parent is closed, whatever it is doing, so that none outlives Blender. Its
threads are its own: none of them runs beside Blender.

Messages are tuples that begin with a word. In: ("solve", request). Out: ("ready", versions), ("progress", stage,
fraction), ("early", picture), ("done", result, peak in MB), ("failed", SynchError), ("broken", traceback).
"""

import os
import queue
import threading
import time
import traceback
from functools import partial

from .parcels import Unpacker, packed

# Exit status of a process that took more memory than it may.
TOO_MUCH_MEMORY = 77
# Seconds between two looks at the memory, and between two words on how far the work is.
_LOOK, _WORD = 0.03, 0.05
# Share of the work that a first result takes.
_EARLY = 0.25


def serve(limit):
    """Solve what is asked until the pipe is closed.

    Parameters
    ----------
    limit : bytes of memory that this process may take
    """
    out = os.dup(1)
    os.dup2(2, 1)  # what libraries print does not get among the messages
    requests: queue.SimpleQueue = queue.SimpleQueue()
    threading.Thread(target=_read, args=(requests,), daemon=True).start()
    # Only now: reading has begun, so that the parent can write while all this is loaded.
    from . import tasks
    from .memory import peak_megabytes, used_bytes

    threading.Thread(target=_watch, args=(used_bytes, limit), daemon=True).start()
    tasks.load()
    send = partial(_send, out)
    send(("ready", tasks.versions()))
    while True:
        request = requests.get()
        send(_answer(request, send, peak_megabytes), request.shared)


def _read(requests):
    """Put what is asked into a queue; the end of the pipe is the end of the process."""
    unpacker = Unpacker()
    while data := os.read(0, 1 << 20):
        for _, request in unpacker.feed(data):
            requests.put(request)
    os._exit(0)


def _watch(used_bytes, limit):
    while True:
        if used_bytes() > limit:
            os._exit(TOO_MUCH_MEMORY)
        time.sleep(_LOOK)


def _send(out, message, shared=()):
    for part in packed(message, shared):
        rest = memoryview(part).cast("B")
        while len(rest):
            rest = rest[os.write(out, rest) :]


def _answer(request, send, peak_megabytes):
    """The last message about a request."""
    from .errors import SynchError

    try:
        progress = _Progress(send)
        picture = _first(request, progress.part(0.0, _EARLY))
        if picture is not None:
            send(("early", picture))
            progress = progress.part(_EARLY, 1 - _EARLY)
        return "done", request.solve(progress), peak_megabytes()
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
