# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress, cancellation and time limit, asked at every iteration."""

import math
import time
from collections.abc import Callable
from copy import copy

from .errors import Cancelled
from .threads import start_thread

POLL_SECONDS = 0.05
# Told a stage and a fraction of the work; a false answer other than None cancels.
Callback = Callable[[str, float], bool | None]


class OutOfTime(Exception):
    """The time limit has passed; the best result so far is still good."""


class Monitor:
    """Reports progress and stops the computation.

    Parameters
    ----------
    callback : callable(stage: str, fraction: float) -> bool, optional
        Called often; a false answer other than None cancels.
    time_limit : seconds, optional

    Attributes
    ----------
    stage, fraction : where the work is
    on_found : called with the energy of each field that is found and with the field, or None
    """

    def __init__(self, callback=None, time_limit=None):
        self._callback = callback
        self._deadline = None if time_limit is None else time.perf_counter() + time_limit
        self.stage, self.fraction = "", 0.0
        self._bound, self._expected, self._note = None, -math.inf, ""
        self._start, self._share = 0.0, 1.0
        self.on_found = None

    def portion(self, start, share):
        """A monitor for one part of the work: its fractions are a part of the whole."""
        part = copy(self)
        part.fraction, part._start, part._share = float(start), start, share
        return part

    def without_found(self):
        """The same monitor, but for ``on_found``: for fields that are not those of the problem itself."""
        quiet = copy(self)
        quiet.on_found = None
        return quiet

    def at(self, stage, fraction):
        """Enter a stage at a fraction of the whole work, 0..1."""
        self.stage, self.fraction = stage, float(self._start + fraction * self._share)
        self.check()

    def expect(self, seconds):
        """A bound may be there in so many seconds: until then the stage says how many are left."""
        self._expected = time.perf_counter() + seconds

    def proved(self, bound):
        """There is a bound: from now on the stage says how far above it fields are."""
        self._bound, self._expected = bound, -math.inf

    def found(self, energy, column):
        """There is a field of an energy."""
        if self._bound is not None and energy > 0:
            self._note = f", gap {max(1 - self._bound / energy, 0):.0%}"
        if self.on_found is not None:
            self.on_found(energy, column)

    def _said(self):
        left = self._expected - time.perf_counter()
        return f"{self.stage}, proof in {left:.0f} s" if left >= 1 else self.stage + self._note

    def check(self):
        """Raise :class:`Cancelled` or :class:`OutOfTime` where the computation has to stop."""
        if self._callback is not None:
            answer = self._callback(self._said(), self.fraction)
            if answer is not None and not answer:
                raise Cancelled("cancelled: nothing was changed")
        if self._deadline is not None and time.perf_counter() > self._deadline:
            raise OutOfTime

    def during(self, work):
        """Result of ``work()``, which cannot be interrupted: a thread does it, left behind when it must stop.

        Without a callback and a limit it is done at once, which is faster: only Ctrl-C could stop it, and has to wait.
        """
        if self._callback is None and self._deadline is None:
            return work()
        results: list = []
        errors: list = []

        def run():
            try:
                results.append(work())
            except BaseException as error:  # raised again where it was asked for
                errors.append(error)

        thread = start_thread(run)
        while thread.is_alive():
            thread.join(POLL_SECONDS)
            self.check()
        for error in errors:
            raise error
        return results[0]


SILENT = Monitor()


def portion(callback, start, share):
    """A callback for a part of the whole work, None for None."""
    if callback is None:
        return None
    return lambda stage, fraction: callback(stage, start + share * fraction)
