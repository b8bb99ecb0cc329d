# SPDX-License-Identifier: GPL-3.0-or-later
"""Ctrl-C and SIGTERM on the command line: both end a command in one line, with nothing half written left behind."""

import signal
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from types import FrameType

# The exit status is this and the signal's number, as shells have it.
SIGNALLED = 128
# How messages name a signal.
_WORDS = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}


class Interrupted(KeyboardInterrupt):
    """A signal has asked for the end of the command; its one argument is the signal's number."""


class _Signals:
    """The signals that have come and have not ended a command yet, and how many blocks hold them back."""

    def __init__(self) -> None:
        self.heard: list[int] = []
        self.held = 0

    def hear(self, number: int, _frame: FrameType | None) -> None:
        self.heard.append(number)
        if not self.held:
            raise Interrupted(number)

    def raise_first(self) -> None:
        if self.heard:
            raise Interrupted(self.heard[0])


_signals = _Signals()
# Raises Interrupted if a signal has come: the first exception may have been printed by Blender and lost.
raise_interrupts = _signals.raise_first


@contextmanager
def catch_interrupts() -> Iterator[None]:
    """Raise :class:`Interrupted` where a signal comes inside, at the latest at the end."""
    with ExitStack() as before:
        before.callback(_signals.heard.clear)
        for number in _WORDS:
            older = signal.signal(number, _signals.hear)
            before.callback(signal.signal, number, older if older is not None else signal.SIG_DFL)
        yield
        raise_interrupts()


@contextmanager
def hold_interrupts() -> Iterator[None]:
    """Raise what comes inside at the end.

    For Blender's operators: where they call Python functions, as Cycles does to render, Blender prints an exception and
    goes on.
    """
    _signals.held += 1
    try:
        yield
    finally:
        _signals.held -= 1
        raise_interrupts()


def report_signal(what: str, number: int) -> int:
    """Print that something has been ended by a signal; the exit status."""
    print(f"{what}: {_WORDS[signal.Signals(number)]}", file=sys.stderr)
    return SIGNALLED + number
