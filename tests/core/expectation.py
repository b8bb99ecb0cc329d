# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a request tells its callback about the time that it takes."""


class _Told:
    """A callback that keeps what it is told."""

    def __init__(self):
        self.expected, self.fractions = [], []

    def __call__(self, stage, fraction):
        self.fractions.append(fraction)
        return True

    def expect(self, seconds):
        self.expected.append((seconds, max(self.fractions, default=0.0)))


def told_at_once(request):
    """The seconds that a request tells before the work proper begins; it tells them once, and goes on without a step
    back."""
    told = _Told()
    request.solve(told)
    ((seconds, fraction),) = told.expected
    assert seconds > 0 and fraction < 0.05 and told.fractions == sorted(told.fractions)
    return seconds
