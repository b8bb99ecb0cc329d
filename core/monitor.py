# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress, cancellation and time limit, checked at every iteration."""

import math
import time
from collections.abc import Callable
from copy import copy
from functools import partial
from typing import Generic, TypeVar

import numpy as np

from .errors import Cancelled
from .threads import start_thread

POLL_SECONDS = 0.05
# Share of the work after which its time can be estimated without an expected total.
_TELLING = 0.15
# Most weight of the share that is done in an estimate, as a multiple of it: a hundredth says little.
_TELLS_TOTAL = 10
# Called with a stage and a fraction of the work; a false answer other than None cancels.
Callback = Callable[[str, float], bool | None]
Result = TypeVar("Result")


class OutOfTime(Exception):
    """The time limit has passed; the best result so far can be used."""


class Running(Generic[Result]):
    """Work in its own thread, which is abandoned when the computation has to stop."""

    def __init__(self, work: Callable[[], Result]) -> None:
        self._results: list[Result] = []
        self._errors: list[BaseException] = []
        self._thread = start_thread(self._run, work)

    def _run(self, work: Callable[[], Result]) -> None:
        try:
            self._results.append(work())
        except BaseException as error:  # raised again by the thread that asks for the result
            self._errors.append(error)

    def wait(self, seconds: float) -> bool:
        """Wait for the end of the work, at most for these seconds, and return whether it has ended."""
        self._thread.join(seconds)
        return not self._thread.is_alive()

    def result(self) -> Result:
        """Return the result of work that has ended, or raise its error."""
        for error in self._errors:
            raise error
        return self._results[0]


class Monitor:
    """Reports progress and stops the computation.

    Parameters
    ----------
    callback : called often
    time_limit : seconds

    Attributes
    ----------
    stage, fraction : the current stage, and the share of the work that is done
    on_found : called with the energy and the column of each field that is found
    """

    def __init__(self, callback: Callback | None = None, time_limit: float | None = None) -> None:
        self._callback = callback
        self._deadline = None if time_limit is None else time.perf_counter() + time_limit
        self.stage, self.fraction = "", 0.0
        self._bound: float | None = None
        self._expected, self._note = -math.inf, ""
        self._start, self._share = 0.0, 1.0
        self.on_found: Callable[[float, np.ndarray], object] | None = None
        # Work of :meth:`awaiting` and what is called with its result, until then; shared by derived monitors.
        self._awaited: list[tuple[Running[bool], Callable[[bool], None]]] = []
        # The largest fraction that the callback was given, in a list that all derived monitors share.
        self._shown = [0.0]

    def portion(self, start: float, share: float) -> "Monitor":
        """Derive a monitor for one part of the work."""
        part = copy(self)
        part.fraction, part._start, part._share = float(start), start, share
        return part

    def without_found(self) -> "Monitor":
        """Derive a monitor without ``on_found``, for fields of other problems."""
        quiet = copy(self)
        quiet.on_found = None
        return quiet

    def awaiting(self, running: Running[bool], react: Callable[["Monitor", bool], None]) -> "Monitor":
        """Derive a monitor whose next check after the end of running work calls ``react(monitor, result)``, once."""
        derived = copy(self)
        derived._awaited = [(running, partial(react, derived))]
        return derived

    def at(self, stage: str, fraction: float) -> None:
        """Enter a stage at a fraction of the whole work, 0..1."""
        self.stage, self.fraction = stage, float(self._start + fraction * self._share)
        self.check()

    def expect(self, seconds: float) -> None:
        """Show in the stage how many of ``seconds`` are left until a bound may be proved."""
        self._expected = time.perf_counter() + seconds

    def proved(self, bound: float) -> None:
        """Show in the stage from now on how far fields are above a bound."""
        self._bound, self._expected = bound, -math.inf

    def found(self, energy: float, column: np.ndarray) -> None:
        """Report a field that was found."""
        if self._bound is not None and energy > 0:
            self._note = f", gap {max(1 - self._bound / energy, 0):.0%}"
        if self.on_found is not None:
            self.on_found(energy, column)

    def _describe_stage(self) -> str:
        left = self._expected - time.perf_counter()
        return f"{self.stage}, proof in {left:.0f} s" if left >= 1 else self.stage + self._note

    def check(self) -> None:
        """Call the callback; raise :class:`Cancelled` or :class:`OutOfTime` where the computation has to stop.

        Also reacts to the end of the work of :meth:`awaiting`.
        """
        if self._callback is not None:
            self._shown[0] = max(self._shown[0], self.fraction)  # monitors of other parts may be further
            answer = self._callback(self._describe_stage(), self._shown[0])
            if answer is not None and not answer:
                raise Cancelled("cancelled: nothing was changed")
        if self._deadline is not None and time.perf_counter() > self._deadline:
            raise OutOfTime
        if self._awaited and self._awaited[0][0].wait(0):
            running, react = self._awaited.pop()
            react(running.result())

    def during(self, work: Callable[[], Result]) -> Result:
        """Run ``work()``, which cannot be interrupted, in a thread that is abandoned when the computation has to stop.

        Without a callback and a time limit it runs here, which is faster; Ctrl-C then waits for its end.
        """
        if self._callback is None and self._deadline is None:
            return work()
        return self.wait_for(Running(work))

    def wait_for(self, running: Running[Result]) -> Result:
        """Return the result of running work; a check that stops the computation abandons it."""
        while not running.wait(POLL_SECONDS):
            self.check()
        return running.result()


SILENT = Monitor()


def portion(callback: Callback | None, start: float, share: float) -> Callback | None:
    """Derive a callback for a part of the whole work."""
    if callback is None:
        return None
    return lambda stage, fraction: callback(stage, start + share * fraction)


def expect(callback: Callback | None, seconds: float) -> None:
    """Tell a callback with a method ``expect`` how many seconds of one core the work usually takes from now on."""
    tell = getattr(callback, "expect", None)
    if tell is not None:
        tell(seconds)


def seconds_left(passed: float, fraction: float, expected: float | None = None) -> float | None:
    """Estimate the seconds that work still takes; None if that is unknown.

    At first the ``expected`` total counts; from the middle of the work on, or when so much time has passed, only the
    share of the work that is done. Before the expected time is over, a small share of the work counts little.
    """
    if expected is None:
        return passed * (1 / fraction - 1) if fraction > _TELLING else None
    weight = min(max(2 * fraction, passed / expected), 1)
    if passed < expected:
        weight = min(weight, _TELLS_TOTAL * fraction)
    total = expected ** (1 - weight) * (passed / fraction) ** weight if fraction > 0 else expected
    return max(total - passed, 0.0)
