# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How many seconds work still takes, from what is expected and from its progress."""

import pytest

from synch_fields.core.monitor import seconds_left


@pytest.mark.parametrize(
    ("passed", "fraction", "expected", "left"),
    [
        (0.0, 0.0, 40.0, 40.0),
        (10.0, 0.0, 40.0, 30.0),
        (50.0, 0.0, 40.0, 0.0),  # more than expected has passed
        (10.0, 0.25, 40.0, 30.0),  # as expected
        (10.0, 0.25, 160.0, 70.0),  # 40 s by its progress: the geometric mean, 80, counts
        (40.0, 0.1, 40.0, 360.0),  # a busy machine
        (9.0, 0.01, 10.0, 10**0.9 * 900**0.1 - 9),  # a hundredth tells hardly anything
        (30.0, 0.01, 10.0, 2970.0),  # but is all there is when the expected time is over
        (30.0, 0.5, 600.0, 30.0),
        (30.0, 0.75, 600.0, 10.0),
        (10.0, 0.5, None, 10.0),
        (10.0, 0.1, None, None),
    ],
)
def test_what_is_expected_counts_at_first_and_progress_from_the_middle_on(passed, fraction, expected, left):
    found = seconds_left(passed, fraction, expected)
    assert found is None if left is None else found == pytest.approx(left)
