# SPDX-License-Identifier: GPL-3.0-or-later
"""Keep Blender's own chatter off stdout and stderr, at the level of the file descriptor: Cycles alone prints a line a
step."""

import ctypes
import os
import sys
from contextlib import contextmanager, redirect_stdout, suppress


@contextmanager
def quiet_stdout():
    """Drop everything that is printed; yields a stream to the real stdout. Errors still go to stderr."""
    try:
        sys.stdout.flush()
        kept = os.dup(1)
    except (OSError, AttributeError):  # a process without a stdout
        yield sys.stdout
        return
    out = os.fdopen(os.dup(kept), "w", errors="backslashreplace")
    with open(os.devnull, "w") as nowhere, redirect_stdout(nowhere):
        os.dup2(nowhere.fileno(), 1)
        try:
            yield out
        finally:
            _flush_c_streams()
            os.dup2(kept, 1)
            os.close(kept)
            with suppress(OSError):  # an error has been reported by then
                out.close()


@contextmanager
def quiet_stderr():
    """Drop what Blender's importers print about lines of a file; errors are raised all the same."""
    sys.stderr.flush()
    kept = os.dup(2)
    with open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), 2)
        try:
            yield
        finally:
            _flush_c_streams()
            os.dup2(kept, 2)
            os.close(kept)


def _flush_c_streams():
    """Into a pipe Blender's C code prints through a buffer, which must not outlive the redirection."""
    ctypes.CDLL("ucrtbase" if os.name == "nt" else None).fflush(None)
