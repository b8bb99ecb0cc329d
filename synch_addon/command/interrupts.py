# SPDX-License-Identifier: GPL-3.0-or-later
"""Ctrl-C on the command line."""

import signal
from contextlib import contextmanager


@contextmanager
def heard_interrupts():
    """Hear Ctrl-C inside; yields a function that raises KeyboardInterrupt once it was heard.

    Blender prints and forgets what is raised in functions that it calls: an interrupt that comes there has to be asked
    for afterwards.
    """
    heard = []

    def hear(_number, _frame):
        heard.append(True)
        raise KeyboardInterrupt

    def check():
        if heard:
            raise KeyboardInterrupt

    before = signal.signal(signal.SIGINT, hear)
    try:
        yield check
    finally:
        signal.signal(signal.SIGINT, before if before is not None else signal.SIG_DFL)
