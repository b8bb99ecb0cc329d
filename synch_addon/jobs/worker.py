# SPDX-License-Identifier: GPL-3.0-or-later
"""The parent's side of the process that solves: a child of Blender's own Python, see :mod:`core.process.child`.

There is no thread here: :meth:`Worker.exchange` writes pending messages to the child's pipe and reads its answers, for
some hundredths of a second at a time. (On Windows a write waits for the child, which reads from the start.)
"""

import os
import select
import subprocess
import sys
import time
from collections import deque
from pathlib import Path

import bpy

from ...core.errors import SynchError
from ...core.process.child import TOO_MUCH_MEMORY, UNREADABLE
from ...core.process.ipc import CHUNK, BrokenParcel, Unpacker, pack_parts, start_child
from ...core.tasks import versions

# Longest time of one exchange, in seconds.
_SLICE = 0.02
# Seconds that a child may take to end after it has closed its pipe.
_FAREWELL = 0.5
# The package that holds ``core`` and ``synch_addon``, and where it is.
_PACKAGE, _FOLDER = __package__.removesuffix(".synch_addon.jobs"), Path(__file__).parents[2]
# The child imports the package under the same name, so that each side can unpickle the other's objects, but without
# running the parent packages' __init__ (the add-on's registration).
_BEGIN = """
import importlib, sys, types
name, folder, limit = sys.argv[-3:]
parts = name.split(".")
for count in range(1, len(parts) + 1):
    package = types.ModuleType(".".join(parts[:count]))
    package.__path__ = [folder] if count == len(parts) else []
    sys.modules[package.__name__] = package
importlib.import_module(name + ".core.process.child").serve(int(limit))
"""


class WorkerGone(SynchError):
    """The child has ended or cannot be used any more: a new one must be started."""


class Worker:
    """A child process that solves one request after the other. Raises WorkerGone if it cannot be started.

    ``limit``: bytes of memory that it may take. ``is_ready``: whether it has loaded its modules.
    """

    def __init__(self, limit):
        self.limit = limit
        self.is_ready, self._unpacker, self._gone = False, Unpacker(after_noise=True), None
        self._outgoing: deque = deque()
        self._kept = ()
        command = [*_python(), _PACKAGE, str(_FOLDER), str(limit)]
        try:
            self._child = start_child(command, _environment(), is_low=True)
        except OSError as error:
            raise WorkerGone(f"the process that solves cannot be started: {command[0]}: {error.strerror}") from None
        self._input, self._output = self._child.stdin.fileno(), self._child.stdout.fileno()
        if sys.platform != "win32":
            os.set_blocking(self._input, False)
            os.set_blocking(self._output, False)

    @property
    def number(self):
        """The child's process number."""
        return self._child.pid

    def ask(self, request):
        """Queue a request for it."""
        self._unpacker.shared = getattr(request, "shared", ())
        self.tell(("solve", request), self._kept)
        self._kept = getattr(request, "kept", ())

    def tell(self, message, shared=()):
        """Queue a message for it, see :mod:`core.process.child`."""
        self._outgoing.extend(memoryview(part).cast("B") for part in pack_parts(message, shared))

    def exchange(self):
        """Write queued messages, then read; returns the child's messages, see :mod:`core.process.child`.

        Raises WorkerGone with one line that says why.
        """
        if self._gone is not None:
            raise self._gone
        end, messages = time.monotonic() + _SLICE, []
        try:
            while self._write(end) + self._read(messages) or self._goes_on(end):
                if time.monotonic() > end:
                    break
        except WorkerGone as gone:  # messages from before its end count
            self._gone = gone
        except BrokenParcel as error:
            self.end()
            self._gone = WorkerGone(f"the process that solves sent a broken message ({error}): run again")
        if self._gone is not None and not messages:
            raise self._gone
        return [message for message in messages if not self._is_greeting(message)]

    @property
    def is_alive(self):
        """Whether the child runs."""
        return self._gone is None and self._child.poll() is None

    def end(self):
        """Kill the child."""
        self._child.kill()
        self._child.wait()
        self._child.stdin.close()
        self._child.stdout.close()

    def _goes_on(self, end):
        """Wait until ``end`` for the pipe of a message that has begun; returns whether it can be read or written."""
        if sys.platform == "win32" or not (self._outgoing or self._unpacker.is_amid):
            return False
        outgoing = [self._input] if self._outgoing else []
        ready = select.select([self._output], outgoing, [], max(end - time.monotonic(), 0))
        return bool(ready[0] or ready[1])

    def _write(self, end):
        """Write what the pipe takes now; returns the number of bytes."""
        written = 0
        try:
            while self._outgoing and time.monotonic() < end:
                count = os.write(self._input, self._outgoing[0][:CHUNK])
                self._outgoing[0] = self._outgoing[0][count:]
                if not len(self._outgoing[0]):
                    self._outgoing.popleft()
                written += count
        except BlockingIOError:
            pass
        except OSError:  # the child has ended, which reading will report
            self._outgoing.clear()
        return written

    def _read(self, messages):
        """Read what is in the pipe; returns the number of bytes."""
        try:
            data = os.read(self._output, CHUNK) if _has_data(self._output) else None
        except BlockingIOError:
            data = None
        if data is None:
            return 0
        if not data:
            raise WorkerGone(self._last_words())
        messages += self._unpacker.feed(data)
        return len(data)

    def _is_greeting(self, message):
        if message[0] != "ready":
            return False
        for name, here in versions().items():
            there = message[1].get(name)
            if there != here:
                self.end()
                raise WorkerGone(f"the process that solves has another {name} than Blender ({there}, not {here})")
        self.is_ready = True
        return True

    def _last_words(self):
        """Why the child has ended, for the user."""
        try:
            status = self._child.wait(_FAREWELL)
        except subprocess.TimeoutExpired:
            status = "none: its pipe is closed"
        self.end()
        if status == UNREADABLE:
            return "the process that solves could not read what it was asked: nothing was changed"
        if status == TOO_MUCH_MEMORY:
            return (
                f"this takes more than {self.limit / 2**20:,.0f} MB of memory: use a coarser mesh, or raise the limit "
                "in Preferences > Add-ons > Synch Fields"
            )
        how = f"status {status}" if isinstance(status, str) or status >= 0 else f"signal {-status}"
        return f"the process that solves has ended ({how}): nothing was changed, run again"


def _python():
    """Command that starts Blender's own Python with the program above, or Blender itself if that is missing."""
    if Path(sys.executable).stem.lower().startswith("python"):
        return [sys.executable, "-c", _BEGIN]
    options = ["--background", "--factory-startup", "--python-use-system-env", "--python-expr", _BEGIN, "--"]
    return [bpy.app.binary_path, *options]


def _environment():
    """Environment of the child, which finds the modules of this process and no others."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    folders = [folder for folder in sys.path if folder and Path(folder).exists()]
    return kept | {"PYTHONPATH": os.pathsep.join(folders), "PYTHONNOUSERSITE": "1", "PYTHONSAFEPATH": "1"}


def _has_data(pipe):
    """Whether reading from a pipe would not wait. Elsewhere than on Windows, pipes tell that themselves."""
    if sys.platform != "win32":
        return True
    import ctypes
    import msvcrt

    count = ctypes.c_ulong()
    handle = ctypes.c_void_p(msvcrt.get_osfhandle(pipe))
    is_open = ctypes.windll.kernel32.PeekNamedPipe(handle, None, 0, None, ctypes.byref(count), None)
    return not is_open or count.value > 0  # a closed one is read to its end
