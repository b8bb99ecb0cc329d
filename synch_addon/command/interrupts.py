# SPDX-License-Identifier: GPL-3.0-or-later
"""Ctrl-C and SIGTERM on the command line: both end a command in one line, with nothing half written left behind."""

import signal
import sys
from contextlib import ExitStack, contextmanager

# The exit status is this and the signal's number, as shells have it.
SIGNALLED = 128
# What is said of a signal.
_WORDS = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}


class Interrupted(KeyboardInterrupt):
    """A signal has asked for the end of the command; its one argument is the signal's number."""


@contextmanager
def catch_interrupts():
    """Hear signals inside; yields a function that raises :class:`Interrupted` once one was heard.

    Blender prints and forgets what is raised in functions that it calls: an interrupt that comes there has to be asked
    for afterwards.
    """
    heard = []

    def hear(number, _frame):
        heard.append(number)
        raise Interrupted(number)

    def check():
        if heard:
            raise Interrupted(heard[0])

    with ExitStack() as before:
        for number in _WORDS:
            older = signal.signal(number, hear)
            before.callback(signal.signal, number, older if older is not None else signal.SIG_DFL)
        yield check


def report_signal(what, number):
    """Print that something has been ended by a signal; the exit status."""
    print(f"{what}: {_WORDS[number]}", file=sys.stderr)
    return SIGNALLED + number
