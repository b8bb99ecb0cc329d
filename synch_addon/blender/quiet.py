# SPDX-License-Identifier: GPL-3.0-or-later
"""Keep Blender's own chatter off stdout, at the level of the file descriptor."""

import ctypes
import os
import sys
from contextlib import contextmanager, redirect_stdout


@contextmanager
def quiet_stdout():
    """Send everything that is printed to stderr; yields a stream to the real stdout."""
    sys.stdout.flush()
    try:
        kept = os.dup(1)
    except OSError:  # a process without a stdout
        yield sys.stdout
        return
    try:
        os.dup2(2, 1)
        with os.fdopen(os.dup(kept), "w") as out, redirect_stdout(sys.stderr):
            yield out
    finally:
        sys.stdout.flush()
        _flush_c_streams()
        os.dup2(kept, 1)
        os.close(kept)


def _flush_c_streams():
    """Into a pipe Blender's C code prints through a buffer, which must not outlive the redirection."""
    ctypes.CDLL("ucrtbase" if os.name == "nt" else None).fflush(None)
