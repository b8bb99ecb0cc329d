# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""No job and no child is left by a test of jobs."""

import pytest

from synch_fields.synch_addon.jobs.queue import queue


@pytest.fixture(autouse=True)
def nothing_left():
    yield
    assert queue.running is None
    queue.stop()
