# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress, cancellation and time limit, asked at every iteration."""

import time

from ..errors import Cancelled


class OutOfTime(Exception):
    """The time limit has passed; the best result so far is still good."""


class Monitor:
    """Reports progress and stops the computation.

    Parameters
    ----------
    callback : callable(stage: str, fraction: float) -> bool, optional
        Called often; returning False cancels.
    time_limit : seconds, optional
    """

    def __init__(self, callback=None, time_limit=None):
        self._callback = callback
        self._deadline = None if time_limit is None else time.perf_counter() + time_limit
        self.stage, self.fraction = "", 0.0

    def at(self, stage, fraction):
        """Enter a stage at a fraction of the whole work, 0..1."""
        self.stage, self.fraction = stage, fraction
        self.check()

    def check(self):
        """Raise :class:`Cancelled` or :class:`OutOfTime` where the computation has to stop."""
        if self._callback is not None and self._callback(self.stage, self.fraction) is False:
            raise Cancelled("cancelled: nothing was changed")
        if self._deadline is not None and time.perf_counter() > self._deadline:
            raise OutOfTime


SILENT = Monitor()
