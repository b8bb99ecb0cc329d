# SPDX-License-Identifier: GPL-3.0-or-later
"""Keep Blender's own chatter off stdout, at the level of the file descriptor."""

import os
import sys
from contextlib import contextmanager


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
        with os.fdopen(os.dup(kept), "w") as out:
            yield out
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(kept)
