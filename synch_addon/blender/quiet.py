# SPDX-License-Identifier: GPL-3.0-or-later
"""Keep Blender's own chatter off stdout, at the level of the file descriptor: Cycles alone prints a line a step."""

import ctypes
import os
import sys
from contextlib import contextmanager, redirect_stdout


@contextmanager
def quiet_stdout():
    """Drop everything that is printed; yields a stream to the real stdout. Errors still go to stderr."""
    sys.stdout.flush()
    try:
        kept = os.dup(1)
    except OSError:  # a process without a stdout
        yield sys.stdout
        return
    with open(os.devnull, "w") as nowhere, os.fdopen(os.dup(kept), "w") as out, redirect_stdout(nowhere):
        os.dup2(nowhere.fileno(), 1)
        try:
            yield out
        finally:
            _flush_c_streams()
            os.dup2(kept, 1)
            os.close(kept)


def _flush_c_streams():
    """Into a pipe Blender's C code prints through a buffer, which must not outlive the redirection."""
    ctypes.CDLL("ucrtbase" if os.name == "nt" else None).fflush(None)
